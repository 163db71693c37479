//! The envelope of pixels: how strongly they turn light of a direction to the sensor.
//!
//! A box pixel of width a turns light by the change p of an optical cosine with the strength sinc²(ap/λ), and far out with the mean
//! λ²/(2π²a²p²) of that. What many pixels add to it is taken to be even over directions. So light that an edge sends to pixels from
//! far aside gets to the sensor weakly, beside the light that the pixels are made for.

use crate::engine::rims::source_ray::SourceRay;
use crate::math::sinc::sinc;
use crate::optics::doe::Layer;
use crate::optics::pixels::pixel_grid::PixelForm;
use crate::optics::screen::ScreenKind;
use crate::optics::surface::without_edges;
use crate::optics::system::{Hop, System};

/// Points along each side of the pixels from which ways to the sensor are known.
const SIDE: usize = 7;

/// Steps of Newton's method that find a way.
const STEPS: usize = 5;

/// The order up to which the spectrum of a pixel counts as it is, and not by its mean.
const BY_MEAN: f64 = 0.5;

/// Pixels from which the light goes to the sensor.
pub(crate) struct PixelEnvelope {
    /// The widths of their active areas over the wavelength.
    widths: [f64; 2],
    /// Places on them, and the optical cosines that lead from there to the middle of the sensor.
    ways: Vec<([f64; 2], [f64; 2])>,
}

impl PixelEnvelope {
    /// Of the box pixels at which a hop of a system ends; nothing where an element has other layers, and where it is not the last.
    pub(crate) fn behind(system: &System, number: usize) -> Option<Self> {
        let hop = system.hops().nth(number + 1)?;
        let (ScreenKind::Doe(doe), ScreenKind::Sensor(_)) = (&hop.from.kind, &hop.to.kind) else {
            return None;
        };
        let pixels = match doe.layers.as_slice() {
            [Layer::Pixels(pixels)] if pixels.form == PixelForm::Box => pixels,
            _ => return None,
        };
        let sides = doe.active_sides();
        let [x0, x1, y0, y1] = hop.from.bounds()?;
        let place =
            |low: f64, high: f64, i: usize| low + (high - low) * (i as f64 + 0.5) / SIDE as f64;
        let places = (0..SIDE * SIDE).map(|n| [place(x0, x1, n % SIDE), place(y0, y1, n / SIDE)]);
        let open = places.filter(|[x, y]| doe.aperture.contains(*x, *y));
        let ways: Vec<_> = open
            .filter_map(|at| Some((at, way_to_sensor(&hop, at)?)))
            .collect();
        (!ways.is_empty()).then_some(Self {
            widths: [0, 1].map(|a| pixels.pitch[a] * sides[a] / system.wavelength),
            ways,
        })
    }

    /// The mean strength with which light is turned to the sensor that has these rays at places of the pixels.
    pub(crate) fn strength(&self, ray: impl Fn([f64; 2]) -> SourceRay) -> f64 {
        let at = |(at, way): &([f64; 2], [f64; 2])| {
            let p = ray(*at).p;
            let along = |a: usize| one_pixel((way[a] - p[a]) * self.widths[a]);
            along(0) * along(1)
        };
        self.ways.iter().map(at).sum::<f64>() / self.ways.len() as f64
    }
}

/// The strength of a pixel's light in this order of its width.
fn one_pixel(order: f64) -> f64 {
    let own = sinc(order).powi(2);
    match order.abs() < BY_MEAN {
        true => own,
        false => own.max(0.5 / (std::f64::consts::PI * order).powi(2)),
    }
}

/// The optical cosines with which light leaves a place for the middle of the target, whatever the edges on its way.
fn way_to_sensor(hop: &Hop, at: [f64; 2]) -> Option<[f64; 2]> {
    let train = without_edges(hop.train);
    let hop = Hop {
        train: &train,
        ..*hop
    };
    let [x0, x1, y0, y1] = hop.to.bounds()?;
    let mut p = [0.0; 2];
    for _ in 0..STEPS {
        let (landing, j) = hop.jacobian(at, p).ok()?;
        let [dx, dy] = [
            0.5 * (x0 + x1) - landing.at[0],
            0.5 * (y0 + y1) - landing.at[1],
        ];
        let determinant = j[0][2] * j[1][3] - j[0][3] * j[1][2];
        p[0] += (dx * j[1][3] - dy * j[0][3]) / determinant;
        p[1] += (dy * j[0][2] - dx * j[1][2]) / determinant;
    }
    p.iter().all(|p| p.is_finite()).then_some(p)
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::engine::rims::pixel_envelope::PixelEnvelope;
    use crate::engine::rims::source_ray::SourceRay;
    use crate::fixtures::parts::{box_pixels, lit, on_axis, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::frame::Frame;
    use crate::optics::screen::ScreenKind;

    /// Pixels of 8 λ, and far behind them a sensor aside, in the direction of sine 0.3: light of this direction goes there as it
    /// is, light by half an order beside it with (2/π)² of the strength along that axis, and by 3.25 orders with the mean.
    #[test]
    fn pixels_turn_light_as_their_sinc_does() {
        let sine = 0.3f64;
        let mut last = screen(on_axis(1e6), sensor(1, 1.0));
        last.frame.origin.x = 1e6 * sine.asin().tan();
        let pixels = box_pixels(Array2::from_elem((8, 8), Complex64::ONE), 8.0);
        let stop = screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(50.0)));
        let middle = screen(on_axis(10.0), pixels);
        let system = lit(vec![stop, middle, last], vec![vec![], vec![]]);
        let envelope = PixelEnvelope::behind(&system, 0).unwrap();
        assert!(PixelEnvelope::behind(&system, 1).is_none());
        let strength = |order: f64| {
            envelope.strength(|at| SourceRay {
                at,
                p: [sine - order / 8.0, 0.0],
                energy: 1.0,
                spread: [0.0; 2],
            })
        };
        let pi = std::f64::consts::PI;
        let mean = 0.5 / (3.25 * pi).powi(2);
        for (order, expected) in [(0.0, 1.0), (0.5, 4.0 / (pi * pi)), (-3.25, mean)] {
            let found = strength(order);
            assert!(
                (found / expected - 1.0).abs() < 2e-3,
                "{order}: {found} {expected}"
            );
        }
    }
}
