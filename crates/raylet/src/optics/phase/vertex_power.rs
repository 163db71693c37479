//! The power of an element: how its phase bends light along its axis.

use crate::optics::phase::smooth_orders::smooth_orders;
use crate::optics::screen::{Screen, ScreenKind};

/// An order that turns light along the axis by less than this, in direction cosines, leaves it on the axis.
const STRAIGHT: f64 = 1e-9;

/// Second derivatives of a phase along two directions may differ by this share and count as one.
const ROUND: f64 = 1e-6;

/// The power in 1/mm that the phase of an element has at its vertex, of its strongest order; nothing for other screens, and where
/// no smooth order has more than half of the light, or that order turns the axis aside, or has two powers.
pub fn vertex_power(screen: &Screen, wavenumber: f64) -> Option<f64> {
    let ScreenKind::Doe(doe) = &screen.kind else {
        return None;
    };
    let orders = smooth_orders(doe, [0.0; 2])?;
    let main = orders.into_iter().find(|order| order.share > 0.5)?;
    let [xx, xy, yy] = main.hessian;
    let round = (xx - yy).abs().max(xy.abs()) <= ROUND * xx.abs().max(yy.abs());
    let along = main
        .gradient
        .iter()
        .all(|g| g.abs() / wavenumber < STRAIGHT);
    (round && along).then_some(-xx / wavenumber)
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::fixtures::parts::{element, screen};
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::{Doe, Layer};
    use crate::optics::frame::Frame;
    use crate::optics::phase::profile::Profile;
    use crate::optics::phase::vertex_power::vertex_power;
    use crate::optics::screen::ScreenKind;

    fn power(doe: Doe) -> Option<f64> {
        vertex_power(&screen(Frame::GLOBAL, ScreenKind::Doe(doe)), 900.0)
    }

    /// A lens has its power; the stronger of two orders counts; a grating turns the axis, and two equal orders have none.
    #[test]
    fn the_strongest_order_bends_light() {
        let lens = |focal_length: f64| Profile::Lens {
            focal_length,
            wavenumber: 900.0,
        };
        let one = |profile: Profile| element(Layer::Phase(profile), Aperture::OPEN);
        let near = |found: Option<f64>, expected: f64| {
            assert!(
                found.is_some_and(|found| (found - expected).abs() < 1e-12),
                "{found:?}"
            );
        };
        near(power(one(lens(50.0))), 0.02);
        let sum = |weights: [f64; 2]| {
            let terms = weights.iter().zip([50.0, -20.0]);
            let terms =
                terms.map(|(weight, f)| (Complex64::from(*weight), vec![Layer::Phase(lens(f))]));
            element(Layer::Sum(terms.collect()), Aperture::OPEN)
        };
        near(power(sum([0.3, 0.5])), -0.05);
        assert_eq!(power(sum([0.5, 0.5])), None);
        let gradient = [30.0, 0.0];
        assert_eq!(power(one(Profile::Linear { gradient })), None);
    }
}
