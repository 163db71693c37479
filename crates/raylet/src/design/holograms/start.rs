//! Phases to start a design from.

use std::f64::consts::{PI, TAU};

use ndarray::Array2;

use crate::math::random::{self, Purpose};
use crate::optics::paraxial::Abcd;

/// A quadratic phase that spreads the light geometrically: every ray of the element meets the sensor at
/// its own place, enlarged.
///
/// Along each axis φ = ½k·((s/r − A)/B)·x², which sends the rim x = r to s: x′ = A·x + B·φ′/k. Designs from
/// here end without the vortices of a random start, which no descent removes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpreadingPhase {
    /// Vacuum wavelength in mm.
    pub wavelength: f64,
    /// Paraxial matrix from the element to the sensor; its entry b is not zero.
    pub train: Abcd,
    /// Distance of neighbouring pixels along x and y in mm.
    pub pitch: [f64; 2],
    /// Half width and height of the lit part of the element, r, in mm.
    pub lit: [f64; 2],
    /// Half width and height of where the light is to go, s, in mm; no farther than the pixels send it.
    pub spread: [f64; 2],
}

impl SpreadingPhase {
    /// The phase of each pixel of an element of that many rows and columns, in rad, [y, x].
    pub(crate) fn phase(&self, shape: (usize, usize)) -> Array2<f64> {
        let k = TAU / self.wavelength;
        let Abcd { a, b, .. } = self.train;
        let lens = |axis: usize, count: usize, i: usize| {
            let x = (i as f64 - 0.5 * (count as f64 - 1.0)) * self.pitch[axis];
            let most = 0.5 * self.wavelength * b.abs() / self.pitch[axis];
            let spread = self.spread[axis].min(most);
            0.5 * k * (spread / self.lit[axis] - a) / b * x * x
        };
        let (ny, nx) = shape;
        Array2::from_shape_fn(shape, |(j, i)| lens(0, nx, i) + lens(1, ny, j))
    }
}

/// Phases uniform in \[−π, π), [y, x]: a function of the seed, the number of the element, the purpose and the pixel.
pub(crate) fn random_phase(
    seed: u64,
    element: u32,
    purpose: Purpose,
    shape: (usize, usize),
) -> Array2<f64> {
    Array2::from_shape_fn(shape, |(j, i)| {
        let at = [element, j as u32, i as u32, purpose as u32];
        PI * (2.0 * random::uniform(seed, at) - 1.0)
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use crate::design::holograms::start::{SpreadingPhase, random_phase};
    use crate::math::random::Purpose;
    use crate::optics::paraxial::Abcd;

    #[test]
    fn the_rim_goes_where_it_is_sent() {
        let spreading = SpreadingPhase {
            wavelength: 0.7e-3,
            train: Abcd::IDENTITY
                .drift(3.0, 1.0)
                .thin_lens(0.02)
                .drift(44.7, 1.0),
            pitch: [0.002, 0.003],
            lit: [0.4, 0.3],
            spread: [0.9, 0.5],
        };
        let phase = spreading.phase((201, 401));
        let k = TAU / spreading.wavelength;
        let Abcd { a, b, .. } = spreading.train;
        // Slopes at the rim by differences: exact for a parabola.
        let along_x = (phase[[100, 400]] - phase[[100, 399]]) / spreading.pitch[0];
        let along_y = (phase[[200, 200]] - phase[[199, 200]]) / spreading.pitch[1];
        let (x, y) = (0.399, 0.2985);
        assert!((a * x + b * along_x / k - 0.9 * x / 0.4).abs() < 1e-9);
        assert!((a * y + b * along_y / k - 0.5 * y / 0.3).abs() < 1e-9);
        assert_eq!(phase[[100, 200]], 0.0);

        // Pixels of this pitch send nothing farther than half of λB/pitch.
        let far = SpreadingPhase {
            spread: [90.0; 2],
            ..spreading
        };
        let phase = far.phase((1, 401));
        let step = phase[[0, 400]] - phase[[0, 399]];
        let lens = k * a / b * 0.399 * spreading.pitch[0];
        assert!((step + lens - PI * 0.399 / 0.4).abs() < 1e-9);
    }

    #[test]
    fn random_phases_are_of_their_address() {
        let all = random_phase(3, 0, Purpose::StartPhase, (40, 50));
        assert_eq!(all, random_phase(3, 0, Purpose::StartPhase, (40, 50)));
        assert_ne!(all, random_phase(4, 0, Purpose::StartPhase, (40, 50)));
        assert_ne!(all, random_phase(3, 1, Purpose::StartPhase, (40, 50)));
        assert!(all.iter().all(|phase| (-PI..PI).contains(phase)));
        // Mean within four standard deviations; part of a larger element is the same.
        let count = all.len() as f64;
        assert!(all.sum().abs() / count < 4.0 * (PI * PI / 3.0 / count).sqrt());
        assert_eq!(
            random_phase(3, 0, Purpose::StartPhase, (80, 80))[[39, 49]],
            all[[39, 49]]
        );
    }
}
