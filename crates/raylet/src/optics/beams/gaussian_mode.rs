//! The mode of a single-mode fibre of which the mode field diameter is known: a Gaussian on the end of the fibre.

use ndarray::Array2;
use num_complex::Complex64;

/// The amplitude exp(−r²/w²) on a plane, whose radius w is half the mode field diameter. It is carried on by its plane waves,
/// without the paraxial approximation of a [`GaussianBeam`](crate::optics::beams::gaussian_beam::GaussianBeam).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianMode {
    /// The radius w in mm.
    radius: f64,
}

/// Samples in a radius, and radii from the middle to the last sample: the mode there, and its spectrum at the Nyquist frequency,
/// have less than 1e-6 of their peaks.
const IN_RADIUS: f64 = 4.0;
const END: f64 = 3.75;

impl GaussianMode {
    /// The mode of this mode field diameter in mm.
    pub fn of_diameter(diameter: f64) -> Self {
        Self {
            radius: 0.5 * diameter,
        }
    }

    /// Its samples [y, x], and their distance in mm: an even number along each axis.
    pub fn samples(&self) -> (Array2<Complex64>, f64) {
        let half = (END * IN_RADIUS).ceil();
        let amplitude = |i: usize| {
            let place = (i as f64 + 0.5 - half) / IN_RADIUS;
            (-place * place).exp()
        };
        let count = 2 * half as usize;
        let product = |(j, i): (usize, usize)| Complex64::from(amplitude(j) * amplitude(i));
        (
            Array2::from_shape_fn((count, count), product),
            self.radius / IN_RADIUS,
        )
    }
}
