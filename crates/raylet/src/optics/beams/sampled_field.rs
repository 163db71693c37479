//! A field that is given on a plane by samples: an element there, which makes it of a plane wave.

use ndarray::Array2;
use num_complex::Complex64;

use crate::math::band_limit::twice_sampled;
use crate::optics::aperture::Aperture;
use crate::optics::doe::{Doe, Layer};
use crate::optics::phase::placement::Placement;
use crate::optics::pixels::active_area::ActiveArea;
use crate::optics::pixels::pixel_grid::{PixelForm, Pixels};

/// The element of samples [y, x] at these distances in mm, about the middle, of a field whose band ends at their Nyquist
/// frequency and which is zero beyond them.
pub(crate) fn sampled_field(samples: &Array2<Complex64>, pitch: [f64; 2]) -> Doe {
    let pixels = Pixels {
        pitch: pitch.map(|pitch| 0.5 * pitch),
        values: twice_sampled(samples),
        form: PixelForm::BandLimited,
        active: ActiveArea::WHOLE,
        placement: Placement::NONE,
    };
    Doe {
        layers: vec![Layer::Pixels(pixels)],
        aperture: Aperture::OPEN,
        reflect: false,
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::optics::beams::sampled_field::sampled_field;

    /// A tilted Gaussian near the Nyquist frequency, between its samples.
    #[test]
    fn the_element_follows_the_light_between_its_samples() {
        let light =
            |x: f64, y: f64| Complex64::cis(2.4 * x - 1.1 * y) * (-(x * x + y * y) / 70.0).exp();
        let place = |i: usize, count: usize| i as f64 - 0.5 * (count as f64 - 1.0);
        let samples = Array2::from_shape_fn((60, 64), |(j, i)| light(place(i, 64), place(j, 60)));
        let doe = sampled_field(&samples, [1.0, 1.0]);
        let mut worst = 0.0f64;
        for [x, y] in [[0.0, 0.0], [0.3, -0.2], [4.13, 2.77], [-9.6, 5.01]] {
            worst = worst.max((doe.transmission(x, y) - light(x, y)).norm());
        }
        assert!(worst < 1e-4, "{worst:e}");
        assert_eq!(doe.bounds(), Some([-32.0, 32.0, -30.0, 30.0]));
    }
}
