//! Pixels of which only a part is active.

use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

// It lies between the active area and that of the next pixel.
/// What the inactive part of a pixel does to light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rest {
    /// It is dark.
    #[default]
    Dark,
    /// It lets light pass, or mirrors it, with phase zero.
    Flat,
}

/// The fill factor: the part of a pixel's area that carries its phase.
///
/// The pixel acts as a box with its mean transmission, f·e^{iφ} + (1 − f)·rest. That is exact for light
/// that leaves within a small part of the angle λ/pitch. The finer structure sends light into higher
/// orders, which the mean does not include.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    share: f64,
    rest: f64,
}

/// A fill factor outside its range: not a number, not above 0, or above 1.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a fill factor of {0}; expected more than 0 and at most 1")]
pub struct FillError(f64);

impl Fill {
    /// Pixels without gaps.
    pub const WHOLE: Fill = Fill {
        share: 1.0,
        rest: 0.0,
    };

    /// Pixels active over this share of their area.
    ///
    /// # Errors
    /// When the share is not above 0 and at most 1.
    pub fn new(share: f64, rest: Rest) -> Result<Self, FillError> {
        if !(share > 0.0 && share <= 1.0) {
            return Err(FillError(share));
        }
        let rest = match rest {
            Rest::Dark => 0.0,
            Rest::Flat => 1.0 - share,
        };
        Ok(Self { share, rest })
    }

    /// The mean transmission of a pixel.
    pub fn transmit(&self, phase: f64) -> Complex64 {
        Complex64::from_polar(self.share, phase) + self.rest
    }

    /// The cotangent of the phase from that of the transmission.
    pub fn transmit_adjoint(&self, phase: f64, transmission_bar: Complex64) -> f64 {
        // t = f·e^{iφ} + rest
        (transmission_bar * Complex64::from_polar(self.share, -phase)).im
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::design::constraints::fill::{Fill, FillError, Rest};

    #[test]
    fn transmit_inner_product_with_differences() {
        let bar = Complex64::new(0.3, -0.8);
        for fill in [
            Fill::WHOLE,
            Fill::new(0.8, Rest::Dark).unwrap(),
            Fill::new(0.7, Rest::Flat).unwrap(),
        ] {
            for phase in [-2.0, 0.1, 9.0] {
                let change = (fill.transmit(phase + 1e-5) - fill.transmit(phase - 1e-5)) / 2e-5;
                let along = (bar.conj() * change).re;
                assert!((fill.transmit_adjoint(phase, bar) - along).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn light_in_and_between_the_orders() {
        // Mean power of a random phase: f² where the rest is dark, f² + (1 − f)² where it is flat; a flat
        // rest leaves a plain mirror at phase zero.
        let dark = Fill::new(0.8, Rest::Dark).unwrap();
        let flat = Fill::new(0.8, Rest::Flat).unwrap();
        let mean = |fill: Fill| {
            let phase = |i| std::f64::consts::TAU * f64::from(i) / 12.0;
            (0..12)
                .map(|i| fill.transmit(phase(i)).norm_sqr())
                .sum::<f64>()
                / 12.0
        };
        assert!((mean(dark) - 0.64).abs() < 1e-15 && (mean(flat) - 0.68).abs() < 1e-15);
        assert_eq!(flat.transmit(0.0), Complex64::ONE);
        assert_eq!(
            Fill::new(1.0, Rest::Flat).unwrap().transmit(0.7),
            Fill::WHOLE.transmit(0.7)
        );
        for share in [0.0, -0.1, 1.1, f64::NAN] {
            assert!(matches!(Fill::new(share, Rest::Dark), Err(FillError(_))));
        }
    }
}
