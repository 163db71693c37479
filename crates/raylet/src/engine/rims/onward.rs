//! Whether light that arrives on a screen goes on to the sensor, by rays.
//!
//! Light that a rim sends aside arrives in other directions than the rest. Behind a smooth element it lands elsewhere, mostly
//! beside the sensor. Behind pixels it goes everywhere.

use crate::engine::rims::source_ray::SourceRay;
use crate::engine::rims::source_rays::{is_open, ray_behind};
use crate::optics::screen::ScreenKind;
use crate::optics::system::{Hop, System};

/// How far beside the sensor light counts, in diffraction widths λ/D of the aperture before it.
const WIDTHS: f64 = 4.0;

/// Points along each side of a box whose rays are followed.
const SIDE: usize = 7;

/// The hops behind a screen up to the sensor.
pub(crate) struct Onward<'a> {
    hops: Vec<Hop<'a>>,
}

impl<'a> Onward<'a> {
    /// What follows a hop of a system; nothing behind the last one, and behind pixels.
    pub(crate) fn behind(system: &'a System, number: usize) -> Self {
        let hops: Vec<Hop> = system.hops().skip(number + 1).collect();
        let smooth = |hop: &Hop| match &hop.from.kind {
            ScreenKind::Stop(_) => true,
            ScreenKind::Doe(doe) => doe.phase_gradient(0.0, 0.0).is_some(),
            ScreenKind::Sensor(_) => false,
        };
        match hops.iter().all(smooth) {
            true => Self { hops },
            false => Self { hops: Vec::new() },
        }
    }

    /// Of light of which nothing more is known.
    pub(crate) fn nowhere() -> Self {
        Self { hops: Vec::new() }
    }

    /// Whether anything is known of the hops behind.
    pub(crate) fn is_known(&self) -> bool {
        !self.hops.is_empty()
    }

    /// The share of the points of a box of which the rays lead on.
    pub(crate) fn share(
        &self,
        [x0, x1, y0, y1]: [f64; 4],
        ray: impl Fn([f64; 2]) -> SourceRay,
    ) -> f64 {
        if !self.is_known() {
            return 1.0;
        }
        let place =
            |low: f64, high: f64, i: usize| low + (high - low) * (i as f64 + 0.5) / SIDE as f64;
        let points = (0..SIDE * SIDE).map(|n| [place(x0, x1, n % SIDE), place(y0, y1, n / SIDE)]);
        let on = points.filter(|point| self.leads_on(ray(*point))).count();
        on as f64 / (SIDE * SIDE) as f64
    }

    /// Whether a ray on the first of their screens lands on the sensor or near it; true where nothing is known.
    pub(crate) fn leads_on(&self, mut ray: SourceRay) -> bool {
        for (number, hop) in self.hops.iter().enumerate() {
            if !is_open(hop.from, ray.at) {
                return false;
            }
            let bent = ray_behind(hop, &ray);
            let Ok((landing, j)) = hop.jacobian(bent.at, bent.p) else {
                return false;
            };
            if number + 1 == self.hops.len() {
                return near(hop, landing.at, &j);
            }
            ray.at = landing.at;
            ray.p = landing.cosines;
        }
        true
    }
}

/// Whether a landing lies in the box of a hop's last screen, or no farther away than the box is wide, or than light of the
/// first screen's aperture is spread by diffraction.
fn near(hop: &Hop, at: [f64; 2], j: &[[f64; 4]; 4]) -> bool {
    let (Some(from), Some(to)) = (hop.from.bounds(), hop.to.bounds()) else {
        return true;
    };
    (0..2).all(|a| {
        let [low, high] = [to[2 * a], to[2 * a + 1]];
        let widths = [0, 1].map(|b| {
            let cosines = hop.wavelength / (from[2 * b + 1] - from[2 * b]);
            WIDTHS * cosines * j[a][2 + b].abs()
        });
        let margin = (high - low).max(widths[0]).max(widths[1]);
        (low - margin..=high + margin).contains(&at[a])
    })
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::engine::rims::onward::Onward;
    use crate::engine::rims::source_ray::SourceRay;
    use crate::fixtures::parts::{box_pixels, element, lit, on_axis, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::profile::Profile;
    use crate::optics::screen::ScreenKind;

    /// A lens of 20 mm focal length and a sensor of 0.1 mm at its focus: what arrives along the axis goes on.
    #[test]
    fn directions_decide_behind_a_lens_and_pixels_send_everywhere() {
        let lens = Profile::Lens {
            focal_length: 20.0,
            wavenumber: std::f64::consts::TAU / 0.5e-3,
        };
        let smooth = ScreenKind::Doe(element(Layer::Phase(lens), Aperture::disc(1.0)));
        let pixels = box_pixels(Array2::from_elem((10, 10), Complex64::ONE), 0.2);
        for (kind, aside) in [(smooth, false), (pixels, true)] {
            let aperture = screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(1.0)));
            let middle = screen(on_axis(5.0), kind);
            let last = screen(on_axis(25.0), sensor(10, 0.01));
            let mut system = lit(vec![aperture, middle, last], vec![vec![], vec![]]);
            system.wavelength = 0.5e-3;
            let onward = Onward::behind(&system, 0);
            let ray = |sine: f64| SourceRay {
                at: [0.5, 0.2],
                p: [sine, 0.0],
                energy: 1.0,
                spread: [0.0; 2],
            };
            assert!(onward.leads_on(ray(0.0)));
            assert_eq!(onward.leads_on(ray(0.1)), aside);
        }
    }
}
