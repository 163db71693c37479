//! Losses that compare the intensity with a picture, pixel by pixel.

use ndarray::{Array2, ArrayView2, Zip};

use crate::design::losses::loss::{
    Loss, LossError, LossValue, check_pixels, check_positive, weights,
};

/// How bright the intensity I is meant to be beside the picture T. Sums run over pixels with their weights w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Brightness {
    /// Whatever fits best: L = Σw(αI − T)²/ΣwT², α = ΣwIT/ΣwI². That is 1 − NCC², NCC the normalised
    /// cross-correlation ΣwIT/√(ΣwI² ΣwT²); how much light there is does not matter. 1 for no light.
    Free,
    /// Both with sum 1: L = Σw(I/ΣwI − T/ΣwT)², as in the code of the source paper. With weights of 0 and 1 it is
    /// 0 ≤ L ≤ 2. L may be as small as 1/(lit pixels) for unlike pictures. Without light L = Σw(T/ΣwT)².
    Sum,
    /// That of the picture times a scale: the mean of (scale·I − T)², Σw(scale·I − T)²/Σw.
    Given {
        /// The picture's unit over that of intensity.
        scale: f64,
    },
}

/// The distance from a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Likeness {
    picture: Array2<f64>,
    weight: Array2<f64>,
    brightness: Brightness,
    /// What the sum of squares is divided by.
    unit: f64,
}

impl Likeness {
    /// The loss for a target picture at the sensor's pixels, [y, x], with weights from 0 (ignored) to 1; all pixels
    /// count if there are none.
    ///
    /// # Errors
    /// When the picture is black where it counts, a value is negative or not a number, or shapes differ.
    pub fn new(
        picture: Array2<f64>,
        weight: Option<Array2<f64>>,
        brightness: Brightness,
    ) -> Result<Self, LossError> {
        check_pixels("the picture", &picture, f64::INFINITY)?;
        let weight = weights(weight, picture.dim())?;
        if let Brightness::Given { scale } = brightness {
            check_positive("the scale of the intensity", scale)?;
        }
        let sum = (&picture * &weight).sum();
        if sum == 0.0 {
            return Err(LossError::Empty("the picture, where it counts,"));
        }
        let (picture, unit) = match brightness {
            Brightness::Free => {
                let square = (&picture * &picture * &weight).sum();
                (picture, square)
            }
            Brightness::Sum => (picture / sum, 1.0),
            Brightness::Given { .. } => (picture, weight.sum()),
        };
        Ok(Self {
            picture,
            weight,
            brightness,
            unit,
        })
    }

    /// Σ w·a·b.
    fn inner(&self, a: ArrayView2<'_, f64>, b: ArrayView2<'_, f64>) -> f64 {
        Zip::from(a)
            .and(b)
            .and(&self.weight)
            .fold(0.0, |sum, a, b, w| sum + w * a * b)
    }

    /// The factor of the intensity.
    fn factor(&self, intensity: ArrayView2<'_, f64>) -> f64 {
        let quotient = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        match self.brightness {
            Brightness::Free => {
                let along = self.inner(intensity, self.picture.view());
                quotient(along, self.inner(intensity, intensity))
            }
            Brightness::Sum => {
                let sum = Zip::from(intensity)
                    .and(&self.weight)
                    .fold(0.0, |sum, i, w| sum + w * i);
                quotient(1.0, sum)
            }
            Brightness::Given { scale } => scale,
        }
    }
}

impl Loss for Likeness {
    fn shape(&self) -> (usize, usize) {
        self.picture.dim()
    }

    fn evaluate(&self, intensity: ArrayView2<'_, f64>) -> LossValue {
        let factor = self.factor(intensity);
        let rest = Zip::from(intensity)
            .and(&self.picture)
            .map_collect(|i, t| factor * i - t);
        let value = self.inner(rest.view(), rest.view()) / self.unit;

        // The best factor has no first-order say in the value; a given one has none at all. One over the
        // sum falls by factor²·w per unit of intensity.
        let pull = match self.brightness {
            Brightness::Free | Brightness::Given { .. } => 0.0,
            Brightness::Sum => factor * self.inner(rest.view(), intensity),
        };
        let gain = 2.0 * factor / self.unit;
        let bar = Zip::from(&rest)
            .and(&self.weight)
            .map_collect(|r, w| gain * w * (r - pull));
        LossValue { value, bar }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, array};

    use crate::design::losses::discrepancy::discrepancy;
    use crate::design::losses::likeness::{Brightness, Likeness};
    use crate::design::losses::loss::Loss;
    use crate::fixtures::noise::real_noise;
    use crate::wave::grid::metrics::ncc;

    fn picture(purpose: u32) -> Array2<f64> {
        real_noise((7, 9), 1, [0, purpose])
    }

    const ALL: [Brightness; 3] = [
        Brightness::Free,
        Brightness::Sum,
        Brightness::Given { scale: 0.7 },
    ];

    #[test]
    fn central_differences_and_pixels_that_do_not_count() {
        let mask = picture(2).mapv(|w| if w < 0.3 { 0.0 } else { w });
        for brightness in ALL {
            for weight in [None, Some(mask.clone())] {
                let loss = Likeness::new(picture(0), weight.clone(), brightness).unwrap();
                let mut intensity = picture(1);
                let off = discrepancy(&loss, intensity.view(), 5);
                assert!(off < 1e-10, "{brightness:?} {off:e}");

                // What does not count changes nothing and is left alone.
                let found = loss.evaluate(intensity.view());
                if weight.is_some() {
                    let spots = mask.mapv(|w| if w == 0.0 { 3.0 } else { 0.0 });
                    intensity += &spots;
                    let other = loss.evaluate(intensity.view());
                    assert!((other.value - found.value).abs() < 1e-15);
                    assert_eq!((&other.bar * &spots).mapv(f64::abs).sum(), 0.0);
                }
            }
        }
    }

    #[test]
    fn free_brightness_is_one_less_the_correlation_squared() {
        let (picture, intensity) = (picture(0), picture(1));
        let loss = Likeness::new(picture.clone(), None, Brightness::Free).unwrap();
        let found = loss.evaluate((&intensity * 3.3).view());
        let likeness = ncc(intensity.view(), picture.view()).unwrap();
        assert!((found.value - (1.0 - likeness * likeness)).abs() < 1e-14);

        // More light of the same shape is no better: the gradient is at right angles to the intensity.
        assert!((&found.bar * &intensity).sum().abs() < 1e-15);
        let exact = loss.evaluate((&picture * 0.2).view());
        assert!(exact.value < 1e-30 && exact.bar.iter().all(|bar| bar.abs() < 1e-15));
        let dark = loss.evaluate(Array2::zeros((7, 9)).view());
        assert!((dark.value - 1.0).abs() < 1e-15 && dark.bar.sum() == 0.0);
    }

    #[test]
    fn sums_and_scales_by_hand() {
        let picture = array![[1.0, 3.0]];
        let intensity = array![[2.0, 2.0]];
        let sum = Likeness::new(picture.clone(), None, Brightness::Sum).unwrap();
        let found = sum.evaluate(intensity.view());
        assert!((found.value - 0.125).abs() < 1e-15);
        // With shares s = I/ΣI: ∂L/∂I = (2/ΣI)(r − Σrs), r = (¼, −¼).
        assert!((found.bar - array![[0.125, -0.125]]).mapv(f64::abs).sum() < 1e-15);

        let given = Brightness::Given { scale: 2.0 };
        let given = Likeness::new(picture, None, given).unwrap();
        let found = given.evaluate(intensity.view());
        assert_eq!(found.value, 5.0);
        assert_eq!(found.bar, array![[6.0, 2.0]]);
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        for brightness in ALL {
            let refused = |picture, weight| {
                let found = Likeness::new(picture, weight, brightness);
                found.unwrap_err().to_string()
            };
            let black = refused(Array2::zeros((2, 2)), None);
            assert_eq!(black, "the picture is zero everywhere");
            let negative = refused(array![[0.1, -0.1]], None);
            assert!(negative.starts_with("the picture is -0.1 in row 0, column 1"));
            let none = refused(array![[0.1, f64::NAN]], None);
            assert!(none.starts_with("the picture is NaN in row 0, column 1"));
            let hidden = refused(array![[0.1, 0.0]], Some(array![[0.0, 1.0]]));
            assert_eq!(hidden, "the picture, where it counts, is zero everywhere");
            let heavy = refused(array![[0.1, 0.2]], Some(array![[0.0, 1.1]]));
            assert!(heavy.starts_with("the weight is 1.1 in row 0, column 1"));
            let tall = refused(array![[0.1, 0.2]], Some(array![[1.0], [1.0]]));
            assert_eq!(tall, "the weight of 1 × 2 pixels; expected 2 × 1");
        }
        let scale = Brightness::Given { scale: -1.0 };
        let found = Likeness::new(array![[1.0]], None, scale).unwrap_err();
        let says = "the scale of the intensity is -1;";
        assert!(found.to_string().starts_with(says), "{found}");
    }
}
