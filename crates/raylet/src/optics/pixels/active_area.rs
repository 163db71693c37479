//! The part of each pixel that has its value, and the gap around it.
//!
//! A pixel of a light modulator is smaller than its cell: a gap with electrodes lies around it. With w the side of the
//! active area and P the pitch, the order (m, n) of the lattice of equal pixels v has the amplitude
//! (v − r)·(w/P)² sinc(mw/P) sinc(nw/P), and the order zero r besides, r the transmission of the gap.

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

impl Rest {
    /// Its transmission.
    pub(crate) fn transmission(self) -> Complex64 {
        match self {
            Self::Dark => Complex64::ZERO,
            Self::Flat => Complex64::ONE,
        }
    }
}

/// The part of a pixel that has its value: a rectangle about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActiveArea {
    /// Its sides along x and y over the pitch, above 0 and up to 1.
    pub sides: [f64; 2],
    /// What the rest of the pixel does.
    pub rest: Rest,
}

/// A fill factor outside its range: not a number, not above 0, or above 1.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a fill factor of {0}; expected more than 0 and at most 1")]
pub struct FillError(pub f64);

impl ActiveArea {
    /// The whole pixel.
    pub const WHOLE: Self = Self {
        sides: [1.0; 2],
        rest: Rest::Dark,
    };

    /// A share `fill` of the pixel's area, with the pixel's proportions.
    ///
    /// # Errors
    /// A share that is not above 0 and up to 1.
    pub fn of_fill(fill: f64, rest: Rest) -> Result<Self, FillError> {
        match fill > 0.0 && fill <= 1.0 {
            true if fill == 1.0 => Ok(Self::WHOLE),
            true => Ok(Self {
                sides: [fill.sqrt(); 2],
                rest,
            }),
            false => Err(FillError(fill)),
        }
    }

    /// Whether there is no gap.
    pub fn is_whole(&self) -> bool {
        self.sides == [1.0; 2]
    }

    /// The share of the pixel's area.
    pub fn fill(&self) -> f64 {
        self.sides[0] * self.sides[1]
    }

    /// Whether a place along an axis is inside, counted in pitches from the lower side of its pixel.
    pub(crate) fn holds(&self, axis: usize, place: f64) -> bool {
        (place - 0.5).abs() <= 0.5 * self.sides[axis]
    }

    /// The mean transmission of a pixel of this value.
    pub(crate) fn mean(&self, value: Complex64) -> Complex64 {
        let fill = self.fill();
        value * fill + self.rest.transmission() * (1.0 - fill)
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::optics::pixels::active_area::{ActiveArea, FillError, Rest};

    #[test]
    fn light_in_and_between_the_orders() {
        // Mean power of a random phase: f² where the rest is dark, f² + (1 − f)² where it is flat; a flat
        // rest leaves a plain mirror at phase zero.
        let of = |fill, rest| ActiveArea::of_fill(fill, rest).unwrap();
        let (dark, flat) = (of(0.8, Rest::Dark), of(0.8, Rest::Flat));
        let mean = |active: ActiveArea| {
            let phase = |i| std::f64::consts::TAU * f64::from(i) / 12.0;
            (0..12)
                .map(|i| active.mean(Complex64::cis(phase(i))).norm_sqr())
                .sum::<f64>()
                / 12.0
        };
        assert!((mean(dark) - 0.64).abs() < 1e-15 && (mean(flat) - 0.68).abs() < 1e-15);
        assert!((flat.mean(Complex64::ONE) - 1.0).norm() < 1e-15);
        assert_eq!(of(1.0, Rest::Flat), ActiveArea::WHOLE);
        for fill in [0.0, -0.1, 1.1, f64::NAN] {
            assert!(matches!(
                ActiveArea::of_fill(fill, Rest::Dark),
                Err(FillError(_))
            ));
        }
    }
}
