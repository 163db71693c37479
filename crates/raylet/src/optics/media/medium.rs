//! What light travels in: a medium and its index of refraction as a function of wavelength.
//!
//! Indices are relative to air, as the makers of glass publish them, so that air is exactly 1 and the
//! wavelengths of a design are wavelengths in air. (Vacuum differs by 2.7e-4, and is treated as air. For a
//! lens in vacuum multiply the catalogue index by 1.00027.)
//! They hold at the temperature of the measurement, 20 to 25 °C for most; absorption is ignored.
//!
//! A medium answers inside the range it was measured in and nowhere else: there is no clamping, no
//! extrapolation and no substitute.

use std::sync::Arc;

use thiserror::Error;

use crate::optics::media::dispersion::{Dispersion, DispersionError};

/// A wavelength this close to the end of a range, relatively, counts as inside: unit conversion rounds.
const RANGE_ROUNDING: f64 = 1e-12;

/// Why a medium has no index to give.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MediumError {
    /// The wavelength is not a length.
    #[error("{name}: expected a wavelength above zero in millimetres, found {wavelength_mm}")]
    Wavelength {
        /// The medium.
        name: String,
        /// The requested wavelength, in millimetres.
        wavelength_mm: f64,
    },
    /// The wavelength lies outside the range in which the medium is known.
    #[error(
        "{name} is known from {from_um} to {to_um} µm, found a wavelength of {wavelength_um} µm"
    )]
    OutOfRange {
        /// The medium.
        name: String,
        /// The requested wavelength, in micrometres.
        wavelength_um: f64,
        /// The shortest wavelength it is known for, in micrometres.
        from_um: f64,
        /// The longest wavelength it is known for, in micrometres.
        to_um: f64,
    },
    /// The dispersion formula does not give an index.
    #[error("{name}: expected an index above zero at {wavelength_um} µm, found {found}")]
    Index {
        /// The medium.
        name: String,
        /// The requested wavelength, in micrometres.
        wavelength_um: f64,
        /// What the formula gave.
        found: f64,
    },
    /// The numbers that describe the dispersion do not fit its form.
    #[error("{name}: {error}")]
    Malformed {
        /// The medium described.
        name: String,
        /// What was expected and what was found.
        error: DispersionError,
    },
}

/// What light travels in. Cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium(Arc<Description>);

#[derive(Debug, PartialEq)]
struct Description {
    name: String,
    source: String,
    dispersion: Dispersion,
}

impl Medium {
    /// A medium of the same index at every wavelength.
    ///
    /// That the index is a number above zero is checked where it is used.
    pub fn constant(index: f64) -> Self {
        Self(Arc::new(Description {
            name: format!("constant index {index}"),
            source: String::new(),
            dispersion: Dispersion::Constant(index),
        }))
    }

    /// A medium by its dispersion; `source` says where the numbers come from.
    ///
    /// # Errors
    /// [`MediumError::Malformed`] if the numbers do not fit the form of the dispersion.
    pub fn new(
        name: impl Into<String>,
        source: impl Into<String>,
        dispersion: Dispersion,
    ) -> Result<Self, MediumError> {
        let name = name.into();
        if let Err(error) = dispersion.check() {
            return Err(MediumError::Malformed { name, error });
        }
        Ok(Self(Arc::new(Description {
            name,
            source: source.into(),
            dispersion,
        })))
    }

    /// The name, for a catalogue glass with its catalogue: `SCHOTT:N-BK7`.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Where the numbers come from; empty for a constant index.
    pub fn source(&self) -> &str {
        &self.0.source
    }

    /// How the index depends on the wavelength.
    pub fn dispersion(&self) -> &Dispersion {
        &self.0.dispersion
    }

    /// Shortest and longest wavelength the medium is known for, in micrometres; none for a constant.
    pub fn range_um(&self) -> Option<[f64; 2]> {
        self.0.dispersion.range_um()
    }

    /// The index of refraction, relative to air, at a wavelength in millimetres.
    ///
    /// # Errors
    /// [`MediumError`] if the wavelength is not above zero or outside the range, or if the numbers
    /// give no index there.
    pub fn index(&self, wavelength_mm: f64) -> Result<f64, MediumError> {
        let name = || self.0.name.clone();
        if !(wavelength_mm > 0.0 && wavelength_mm.is_finite()) {
            return Err(MediumError::Wavelength {
                name: name(),
                wavelength_mm,
            });
        }

        // Catalogues count wavelengths in micrometres.
        let wavelength_um = wavelength_mm * 1e3;
        if let Some([from_um, to_um]) = self.range_um()
            && (wavelength_um < from_um * (1.0 - RANGE_ROUNDING)
                || wavelength_um > to_um * (1.0 + RANGE_ROUNDING))
        {
            return Err(MediumError::OutOfRange {
                name: name(),
                wavelength_um,
                from_um,
                to_um,
            });
        }

        // A formula may still meet a resonance or the root of a negative number.
        let found = self.0.dispersion.evaluate(wavelength_um);
        if found > 0.0 && found.is_finite() {
            Ok(found)
        } else {
            Err(MediumError::Index {
                name: name(),
                wavelength_um,
                found,
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::optics::media::dispersion::{Dispersion, Formula};
    use crate::optics::media::medium::{Medium, MediumError};

    fn by_formula(formula: Formula, coefficients: &[f64]) -> Result<Medium, MediumError> {
        let dispersion = Dispersion::Formula {
            formula,
            coefficients: coefficients.to_vec(),
            range_um: [0.3, 2.5],
        };
        Medium::new("glass", "a test", dispersion)
    }

    /// SCHOTT N-BK7, from its data sheet.
    fn crown() -> Medium {
        let schott = [
            0.0,
            1.03961212,
            0.00600069867,
            0.231792344,
            0.0200179144,
            1.01046945,
            103.560653,
        ];
        by_formula(Formula::SellmeierSquared, &schott).expect("it fits")
    }

    #[test]
    fn range_ends_belong_to_the_range() {
        let crown = crown();
        assert!((crown.index(0.7e-3).expect("in range") - 1.513063997196).abs() < 1e-12);
        for wavelength_mm in [0.3e-3, 0.0003, 2.5e-3] {
            assert!(crown.index(wavelength_mm).is_ok());
        }
        assert_eq!(crown.range_um(), Some([0.3, 2.5]));
    }

    #[test]
    fn outside_the_range_is_an_error_that_names_both() {
        for wavelength_mm in [0.2999e-3, 2.501e-3, 0.7] {
            let error = crown()
                .index(wavelength_mm)
                .expect_err("it is out of range");
            assert!(matches!(error, MediumError::OutOfRange { .. }));
        }
        let message = crown().index(0.25).expect_err("250 µm").to_string();
        assert_eq!(
            message,
            "glass is known from 0.3 to 2.5 µm, found a wavelength of 250 µm"
        );
    }

    #[test]
    fn what_is_no_wavelength_or_no_index_is_an_error() {
        for wavelength_mm in [0.0, -0.5e-3, f64::NAN, f64::INFINITY] {
            let error = Medium::constant(1.5).index(wavelength_mm);
            assert!(matches!(error, Err(MediumError::Wavelength { .. })));
        }
        for index in [0.0, -1.5, f64::NAN, f64::INFINITY] {
            let error = Medium::constant(index).index(0.5e-3);
            assert!(matches!(error, Err(MediumError::Index { .. })));
        }
        // n² = −1, and a resonance exactly met.
        for coefficients in [[-2.0, 0.0, 0.0], [0.0, 1.0, 0.5]] {
            let medium = by_formula(Formula::Sellmeier, &coefficients).expect("it fits");
            let error = medium.index(0.5e-3);
            assert!(matches!(error, Err(MediumError::Index { .. })));
        }
        assert_eq!(Medium::constant(1.25).index(0.5e-3), Ok(1.25));
    }

    #[test]
    fn numbers_that_do_not_fit_are_refused() {
        let torn = by_formula(Formula::Sellmeier, &[0.0, 1.0]).expect_err("a pair is torn");
        assert_eq!(
            torn.to_string(),
            "glass: expected 1 coefficient, then pairs, found 2 coefficients"
        );
    }
}
