//! The share of the light that is in a target mode: a loss of the field itself, phase included.

use ndarray::{Array2, ArrayView2, Zip};
use num_complex::Complex64;

use crate::design::losses::loss::{FieldLoss, FieldLossValue, LossError, check_positive};

/// L = 1 − η, η = |Σ m*U|²·a/P the share of the light sent out that is in a target mode m, Σ|m|² = 1, a the
/// area of a pixel and P the power sent out.
///
/// It is the efficiency of coupling into that mode; one only where amplitude and phase are those of the mode, but
/// for one phase factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlap {
    /// m*, [y, x].
    conjugate: Array2<Complex64>,
    /// a/P.
    scale: f64,
}

impl Overlap {
    /// The loss for a mode at the sensor's pixels, [y, x], of any brightness; `power` is that of the light sent out,
    /// ∫|U|² in mm², and `area` of a pixel of the sensor in mm².
    ///
    /// # Errors
    /// When the mode is dark or not finite, or a number is not positive.
    pub fn new(mode: &Array2<Complex64>, power: f64, area: f64) -> Result<Self, LossError> {
        check_positive("the light's power", power)?;
        check_positive("the area of a pixel", area)?;
        let norm = mode.iter().map(|m| m.norm_sqr()).sum::<f64>().sqrt();
        if norm == 0.0 {
            return Err(LossError::Empty("the mode"));
        }
        check_positive("the brightness of the mode", norm)?;
        Ok(Self {
            conjugate: mode.mapv(|m| m.conj() / norm),
            scale: area / power,
        })
    }
}

impl FieldLoss for Overlap {
    fn pixels(&self) -> (usize, usize) {
        self.conjugate.dim()
    }

    fn evaluate_field(&self, field: ArrayView2<'_, Complex64>) -> FieldLossValue {
        let inner = Zip::from(&self.conjugate)
            .and(field)
            .fold(Complex64::ZERO, |sum, m, u| sum + m * u);
        // d|s|² = 2 Re(s* m* dU): the cotangent is 2 s m.
        let gain = -2.0 * self.scale * inner;
        FieldLossValue {
            value: 1.0 - self.scale * inner.norm_sqr(),
            bar: self.conjugate.mapv(|m| gain * m.conj()),
        }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::design::losses::likeness::{Brightness, Likeness};
    use crate::design::losses::loss::FieldLoss;
    use crate::design::losses::overlap::Overlap;
    use crate::fixtures::noise::noise;

    /// Relative distance of the gradient from central differences along a random direction.
    fn discrepancy(loss: &dyn FieldLoss, field: &Array2<Complex64>) -> f64 {
        let along = noise(field.dim(), 9);
        let at = |by: f64| {
            loss.evaluate_field((field + &along.mapv(|a| a * by)).view())
                .value
        };
        let slope = (at(1e-4) - at(-1e-4)) / 2e-4;
        let bar = loss.evaluate_field(field.view()).bar;
        let terms = bar.iter().zip(&along);
        let found: f64 = terms.map(|(bar, a)| (bar.conj() * a).re).sum();
        (found - slope).abs() / slope.abs()
    }

    #[test]
    fn central_differences() {
        let (field, mode) = (noise((6, 7), 1), noise((6, 7), 2));
        let overlap = Overlap::new(&mode, 40.0, 0.3).unwrap();
        let picture = mode.mapv(|m| m.norm_sqr());
        let likeness = Likeness::new(picture, None, Brightness::Free).unwrap();
        for loss in [&overlap as &dyn FieldLoss, &likeness] {
            assert_eq!(loss.pixels(), (6, 7));
            let off = discrepancy(loss, &field);
            assert!(off < 1e-7, "{off:e}");
        }
    }

    #[test]
    fn the_mode_itself_is_coupled_whole() {
        // Power ∫|U|² of the mode is Σ|m|²·area; any phase factor does, and half the mode couples a quarter.
        let mode = noise((5, 4), 3);
        let power = mode.iter().map(|m| m.norm_sqr()).sum::<f64>() * 0.25;
        let loss = Overlap::new(&mode, power, 0.25).unwrap();
        let turned = mode.mapv(|m| m * Complex64::cis(0.7));
        assert!(loss.evaluate_field(turned.view()).value.abs() < 1e-14);
        let half = mode.mapv(|m| m * 0.5);
        assert!((loss.evaluate_field(half.view()).value - 0.75).abs() < 1e-14);
        assert!(Overlap::new(&(&mode * 0.0), 1.0, 1.0).is_err());
        assert!(Overlap::new(&mode, 0.0, 1.0).is_err() && Overlap::new(&mode, 1.0, -1.0).is_err());
    }
}
