//! A loss of the light on the sensor: a number to be made small, and its gradient.
//!
//! A loss takes intensities I = |U|² at the sensor's pixels and returns its value L and the
//! cotangent Ī = ∂L/∂I in one call; the field's own is Ū = 2·Ī·U, so that each [`Loss`] is a [`FieldLoss`] too. A
//! design accepts a user's own loss: any type that implements one of these traits.

use ndarray::{Array2, ArrayView2, Zip};
use num_complex::Complex64;

/// Value and gradient.
#[derive(Clone, Debug, PartialEq)]
pub struct LossValue {
    /// L.
    pub value: f64,
    /// ∂L/∂I at each pixel, [y, x].
    pub bar: Array2<f64>,
}

/// Something that rates intensities.
pub trait Loss: Send + Sync {
    /// Rows and columns of the intensities that it rates.
    fn shape(&self) -> (usize, usize);

    /// Value and gradient for intensities of that shape, [y, x].
    fn evaluate(&self, intensity: ArrayView2<'_, f64>) -> LossValue;
}

/// Value and gradient of a loss of fields.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldLossValue {
    /// L.
    pub value: f64,
    /// ∂L/∂Re U + i ∂L/∂Im U at each pixel, [y, x].
    pub bar: Array2<Complex64>,
}

/// Something that rates fields.
pub trait FieldLoss: Send + Sync {
    /// Rows and columns of the fields that it rates.
    fn pixels(&self) -> (usize, usize);

    /// Value and gradient for the complex amplitude at the sensor's pixels, [y, x].
    fn evaluate_field(&self, field: ArrayView2<'_, Complex64>) -> FieldLossValue;
}

impl<L: Loss> FieldLoss for L {
    fn pixels(&self) -> (usize, usize) {
        self.shape()
    }

    fn evaluate_field(&self, field: ArrayView2<'_, Complex64>) -> FieldLossValue {
        let found = self.evaluate(field.mapv(|u| u.norm_sqr()).view());
        // I = |U|²: Ū = 2ĪU.
        let back = |bar: &f64, u: &Complex64| u * (2.0 * bar);
        FieldLossValue {
            value: found.value,
            bar: Zip::from(&found.bar).and(field).map_collect(back),
        }
    }
}

impl Loss for Box<dyn Loss> {
    fn shape(&self) -> (usize, usize) {
        self.as_ref().shape()
    }

    fn evaluate(&self, intensity: ArrayView2<'_, f64>) -> LossValue {
        self.as_ref().evaluate(intensity)
    }
}

/// Why a loss cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LossError {
    /// Arrays of different shapes.
    #[error("{what} of {} × {} pixels; expected {} × {}", found.1, found.0, expected.1, expected.0)]
    Shape {
        /// Which array.
        what: &'static str,
        /// Its rows and columns.
        found: (usize, usize),
        /// What they should be.
        expected: (usize, usize),
    },
    /// A pixel's value outside its range.
    #[error("{what} is {value} in row {}, column {}; expected {expected}", at.0, at.1)]
    Pixel {
        /// Which array.
        what: &'static str,
        /// Row and column.
        at: (usize, usize),
        /// What is there.
        value: f64,
        /// What may be.
        expected: &'static str,
    },
    /// No pixel counts.
    #[error("{0} is zero everywhere")]
    Empty(&'static str),
    /// A number outside its range.
    #[error("{what} is {value}; expected {expected}")]
    Number {
        /// Which number.
        what: &'static str,
        /// What was found.
        value: f64,
        /// What may be.
        expected: &'static str,
    },
    /// A point that is not on the sensor.
    #[error("the point ({}, {}) mm is off the sensor", .0[0], .0[1])]
    Outside([f64; 2]),
}

/// Refuses an array with values below zero or above `most`, or with none above zero.
///
/// # Errors
/// When it is so.
pub fn check_pixels(what: &'static str, values: &Array2<f64>, most: f64) -> Result<(), LossError> {
    let expected = match most {
        most if most.is_finite() => "0 to 1",
        _ => "a number, none below zero",
    };
    let bad = |value: f64| !(value >= 0.0 && value <= most && value.is_finite());
    if let Some((at, value)) = values.indexed_iter().find(|(_, value)| bad(**value)) {
        return Err(LossError::Pixel {
            what,
            at,
            value: *value,
            expected,
        });
    }
    if values.iter().all(|value| *value == 0.0) {
        return Err(LossError::Empty(what));
    }
    Ok(())
}

/// Refuses a number that is not positive.
///
/// # Errors
/// When it is so.
pub fn check_positive(what: &'static str, value: f64) -> Result<(), LossError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(LossError::Number {
        what,
        value,
        expected: "a positive number",
    })
}

/// How much each pixel counts, from 0 (don't care) to 1; without any, all count.
///
/// # Errors
/// When the shape differs or a weight lies outside 0 to 1, or none counts.
pub fn weights(
    given: Option<Array2<f64>>,
    expected: (usize, usize),
) -> Result<Array2<f64>, LossError> {
    let Some(weights) = given else {
        return Ok(Array2::ones(expected));
    };
    let found = weights.dim();
    if found != expected {
        return Err(LossError::Shape {
            what: "the weight",
            found,
            expected,
        });
    }
    check_pixels("the weight", &weights, 1.0)?;
    Ok(weights)
}

/// Losses added up, each with a factor.
pub struct Sum {
    parts: Vec<(f64, Box<dyn Loss>)>,
}

impl Sum {
    /// The sum of one loss or more of equal shape, each times its factor.
    ///
    /// # Errors
    /// When there is none, shapes differ or a factor is not a number.
    pub fn new(parts: Vec<(f64, Box<dyn Loss>)>) -> Result<Self, LossError> {
        let Some(expected) = parts.first().map(|(_, loss)| loss.shape()) else {
            return Err(LossError::Empty("a sum of no losses"));
        };
        for (factor, loss) in &parts {
            let found = loss.shape();
            if found != expected {
                return Err(LossError::Shape {
                    what: "a loss",
                    found,
                    expected,
                });
            }
            if !factor.is_finite() {
                return Err(LossError::Number {
                    what: "the factor of a loss",
                    value: *factor,
                    expected: "a number",
                });
            }
        }
        Ok(Self { parts })
    }
}

impl Loss for Sum {
    fn shape(&self) -> (usize, usize) {
        self.parts[0].1.shape()
    }

    fn evaluate(&self, intensity: ArrayView2<'_, f64>) -> LossValue {
        let mut sum = LossValue {
            value: 0.0,
            bar: Array2::zeros(intensity.dim()),
        };
        for (factor, loss) in &self.parts {
            let one = loss.evaluate(intensity);
            sum.value += factor * one.value;
            sum.bar.scaled_add(*factor, &one.bar);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, ArrayView2, array};

    use crate::design::losses::discrepancy::discrepancy;

    use crate::design::losses::loss::{Loss, LossError, LossValue, Sum, check_pixels, weights};

    /// A user's own: Σ I³, right or with a gradient that is off by a share.
    struct Cubes(f64);

    impl Loss for Cubes {
        fn shape(&self) -> (usize, usize) {
            (2, 3)
        }

        fn evaluate(&self, intensity: ArrayView2<'_, f64>) -> LossValue {
            LossValue {
                value: intensity.mapv(|i| i.powi(3)).sum(),
                bar: intensity.mapv(|i| 3.0 * i * i * (1.0 + self.0)),
            }
        }
    }

    #[test]
    fn sums_add_values_and_gradients_and_wrong_gradients_show() {
        let intensity = array![[0.1, 0.5, 0.2], [0.9, 0.3, 0.7]];
        let sum = Sum::new(vec![
            (2.0, Box::new(Cubes(0.0))),
            (-0.5, Box::new(Cubes(0.0))),
        ]);
        let sum = sum.unwrap().evaluate(intensity.view());
        let one = Cubes(0.0).evaluate(intensity.view());
        assert!((sum.value - 1.5 * one.value).abs() < 1e-15);
        assert!(
            (sum.bar - one.bar * 1.5)
                .iter()
                .all(|off| off.abs() < 1e-15)
        );
        assert!(discrepancy(&Cubes(0.0), intensity.view(), 1) < 1e-10);
        assert!(discrepancy(&Cubes(1e-5), intensity.view(), 1) > 1e-6);
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let refused = |values: Array2<f64>| check_pixels("it", &values, 1.0).unwrap_err();
        let pixel = |at: (usize, usize)| move |error| matches!(error, LossError::Pixel { at: found, .. } if found == at);
        assert!(pixel((0, 1))(refused(array![[0.0, -0.1]])));
        assert!(pixel((0, 0))(refused(array![[f64::NAN, 0.1]])));
        assert!(pixel((1, 0))(refused(array![[1.0], [1.1]])));
        assert_eq!(refused(Array2::zeros((2, 2))), LossError::Empty("it"));
        let shape = weights(Some(Array2::ones((2, 2))), (2, 3)).unwrap_err();
        assert_eq!(
            shape.to_string(),
            "the weight of 2 × 2 pixels; expected 3 × 2"
        );
        assert!(Sum::new(Vec::new()).is_err());
        assert!(Sum::new(vec![(f64::NAN, Box::new(Cubes(0.0)))]).is_err());
    }
}
