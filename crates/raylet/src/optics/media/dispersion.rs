//! Dispersion: how an index of refraction depends on the wavelength.
//!
//! Wavelengths are in micrometres here and only here, because the coefficients of every published
//! formula and table are made for them.

use thiserror::Error;

/// The number of table entries that an interpolated index is drawn through.
const TABLE_WINDOW: usize = 4;

/// Numbers that do not fit the form of a dispersion.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("expected {expected}, found {found}")]
pub struct DispersionError {
    /// What the form needs.
    pub expected: &'static str,
    /// What was given.
    pub found: String,
}

impl DispersionError {
    fn new(expected: &'static str, found: impl ToString) -> Self {
        Self {
            expected,
            found: found.to_string(),
        }
    }
}

/// The form of a dispersion formula, over the wavelength λ in µm and coefficients c₀, c₁, …
///
/// The numbers in brackets are those of refractiveindex.info, whose order of coefficients is kept.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Formula {
    /// \[1\] n² = 1 + c₀ + Σ B·λ²/(λ² − C²) over the pairs (B, C): resonances as wavelengths.
    Sellmeier,
    /// \[2\] n² = 1 + c₀ + Σ B·λ²/(λ² − C) over the pairs (B, C): resonances squared, as SCHOTT prints them.
    SellmeierSquared,
    /// \[3\] n² = c₀ + Σ B·λᵖ over the pairs (B, p): SCHOTT's former power series and its extensions.
    PowerSeries,
    /// \[4\] n² = c₀ + Σ B·λᵖ/(λ² − Cᵠ) over at most two quadruples (B, p, C, q), then + Σ B·λᵖ over pairs.
    Rational,
    /// \[5\] n = c₀ + Σ B·λᵖ over the pairs (B, p).
    Cauchy,
}

/// How the index of refraction depends on the wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum Dispersion {
    /// The same index at every wavelength.
    Constant(f64),
    /// A formula with its coefficients, valid from the first to the second wavelength of its range.
    Formula {
        /// The form of the formula.
        formula: Formula,
        /// Its coefficients, for wavelengths in micrometres.
        coefficients: Vec<f64>,
        /// Shortest and longest valid wavelength, in micrometres.
        range_um: [f64; 2],
    },
    /// Measured indices, valid from the first wavelength to the last.
    ///
    /// Between them the index is the cubic in 1/λ through the four nearest entries. On the spectral
    /// lines of glass catalogues that is within 6e-5 for the strongest flints (linear: 2e-3).
    Table {
        /// Wavelengths in micrometres, increasing; four or more.
        wavelengths_um: Vec<f64>,
        /// The index at each of them.
        indices: Vec<f64>,
    },
}

impl Dispersion {
    /// Whether the numbers fit their form.
    ///
    /// # Errors
    /// [`DispersionError`] with what was expected and what was found.
    pub fn check(&self) -> Result<(), DispersionError> {
        match self {
            Self::Constant(index) => positive("an index above zero", [index]),
            Self::Formula {
                formula,
                coefficients,
                range_um: [from, to],
            } => {
                formula.check(coefficients)?;
                positive("a range above zero", [from, to])?;
                increasing(
                    "a range from a shorter to a longer wavelength",
                    &[*from, *to],
                )
            }
            Self::Table {
                wavelengths_um,
                indices,
            } => {
                let (count, other) = (wavelengths_um.len(), indices.len());
                if count != other || count < TABLE_WINDOW {
                    return Err(DispersionError::new(
                        "four or more wavelengths with one index each",
                        format!("{count} wavelengths and {other} indices"),
                    ));
                }
                positive(
                    "table entries above zero",
                    wavelengths_um.iter().chain(indices),
                )?;
                increasing("increasing wavelengths", wavelengths_um)
            }
        }
    }

    /// Shortest and longest valid wavelength, in micrometres; none for a constant.
    pub fn range_um(&self) -> Option<[f64; 2]> {
        match self {
            Self::Constant(_) => None,
            Self::Formula { range_um, .. } => Some(*range_um),
            Self::Table { wavelengths_um, .. } => {
                Some([*wavelengths_um.first()?, *wavelengths_um.last()?])
            }
        }
    }

    /// The index at a wavelength in micrometres, without regard to the range; not a number where the
    /// numbers give none.
    pub fn evaluate(&self, wavelength_um: f64) -> f64 {
        match self {
            Self::Constant(index) => *index,
            Self::Formula {
                formula,
                coefficients,
                ..
            } => formula.evaluate(coefficients, wavelength_um),
            Self::Table {
                wavelengths_um,
                indices,
            } => interpolate(wavelengths_um, indices, wavelength_um),
        }
    }
}

impl Formula {
    /// The index at a wavelength in micrometres; not a number where n² is negative.
    fn evaluate(self, coefficients: &[f64], wavelength_um: f64) -> f64 {
        let squared = wavelength_um * wavelength_um;
        let [first, rest @ ..] = coefficients else {
            return f64::NAN;
        };
        match self {
            Self::Sellmeier => {
                (1.0 + first + pairs(rest, |b, c| b * squared / (squared - c * c))).sqrt()
            }
            Self::SellmeierSquared => {
                (1.0 + first + pairs(rest, |b, c| b * squared / (squared - c))).sqrt()
            }
            Self::PowerSeries => (first + pairs(rest, |b, p| b * wavelength_um.powf(p))).sqrt(),
            Self::Rational => {
                // Two quotients at most, then powers.
                let (quotients, powers) = rest.split_at(rest.len().min(8));
                let quotients: f64 = quotients
                    .chunks_exact(4)
                    .map(|t| t[0] * wavelength_um.powf(t[1]) / (squared - t[2].powf(t[3])))
                    .sum();
                (first + quotients + pairs(powers, |b, p| b * wavelength_um.powf(p))).sqrt()
            }
            Self::Cauchy => first + pairs(rest, |b, p| b * wavelength_um.powf(p)),
        }
    }

    /// Whether the coefficients fit the formula.
    fn check(self, coefficients: &[f64]) -> Result<(), DispersionError> {
        let count = coefficients.len();
        let (fits, expected) = match self {
            Self::Rational => (
                matches!(count, 1 | 5) || (count >= 9 && count % 2 == 1),
                "1 coefficient, then up to two groups of 4, then pairs",
            ),
            _ => (count % 2 == 1, "1 coefficient, then pairs"),
        };
        if !fits {
            return Err(DispersionError::new(
                expected,
                format!("{count} coefficients"),
            ));
        }
        match coefficients.iter().find(|c| !c.is_finite()) {
            None => Ok(()),
            Some(bad) => Err(DispersionError::new("finite coefficients", bad)),
        }
    }
}

/// Whether all coefficients are finite and above zero.
fn positive<'a>(
    expected: &'static str,
    coefficients: impl IntoIterator<Item = &'a f64>,
) -> Result<(), DispersionError> {
    let bad = |x: &&f64| !(**x > 0.0 && x.is_finite());
    match coefficients.into_iter().find(bad) {
        None => Ok(()),
        Some(bad) => Err(DispersionError::new(expected, bad)),
    }
}

/// Whether each wavelength is longer than the one before.
fn increasing(expected: &'static str, wavelengths: &[f64]) -> Result<(), DispersionError> {
    match wavelengths.windows(2).find(|pair| pair[0] >= pair[1]) {
        None => Ok(()),
        Some(pair) => Err(DispersionError::new(
            expected,
            format!("{} µm before {} µm", pair[0], pair[1]),
        )),
    }
}

/// The sum of a term over pairs of coefficients.
fn pairs(coefficients: &[f64], term: impl Fn(f64, f64) -> f64) -> f64 {
    coefficients
        .chunks_exact(2)
        .map(|pair| term(pair[0], pair[1]))
        .sum()
}

/// Lagrange's cubic in 1/λ through the four entries nearest to a wavelength: in 1/λ the ultraviolet
/// resonance that bends the curve is nearly evened out.
fn interpolate(wavelengths: &[f64], indices: &[f64], wavelength: f64) -> f64 {
    // Two entries on either side, or the four at an end.
    let above = wavelengths.partition_point(|x| *x < wavelength);
    let start = above
        .saturating_sub(TABLE_WINDOW / 2)
        .min(wavelengths.len().saturating_sub(TABLE_WINDOW));
    let near: Vec<(f64, f64)> = wavelengths[start..]
        .iter()
        .zip(&indices[start..])
        .take(TABLE_WINDOW)
        .map(|(x, n)| (x.recip(), *n))
        .collect();

    // Each index, weighted by the polynomial that is 1 at its own entry and 0 at the others.
    let x = wavelength.recip();
    near.iter()
        .map(|(own, n)| {
            near.iter()
                .filter(|(other, _)| other != own)
                .fold(*n, |weighted, (other, _)| {
                    weighted * (x - other) / (own - other)
                })
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use crate::optics::media::dispersion::{Dispersion, DispersionError, Formula};

    fn by_formula(formula: Formula, coefficients: &[f64]) -> Dispersion {
        Dispersion::Formula {
            formula,
            coefficients: coefficients.to_vec(),
            range_um: [0.3, 2.5],
        }
    }

    fn by_table(wavelengths_um: &[f64], indices: &[f64]) -> Dispersion {
        Dispersion::Table {
            wavelengths_um: wavelengths_um.to_vec(),
            indices: indices.to_vec(),
        }
    }

    #[test]
    fn every_formula_gives_its_published_form() {
        // At λ = 1/2 µm each sum is a fraction worked out by hand.
        let at_half =
            |formula, coefficients: &[f64]| by_formula(formula, coefficients).evaluate(0.5);
        // 1 + 1/4 + 3/4·(1/4)/(1/4 − 1/16) = 9/4.
        assert_eq!(at_half(Formula::Sellmeier, &[0.25, 0.75, 0.25]), 1.5);
        assert_eq!(
            at_half(Formula::SellmeierSquared, &[0.25, 0.75, 0.0625]),
            1.5
        );
        // 2 + 1·(1/2)² = 9/4.
        assert_eq!(at_half(Formula::PowerSeries, &[2.0, 1.0, 2.0]), 1.5);
        // 1 + (1/4)/(1/4 − 1/8) + 0 + (1/8)·(1/2)⁻¹ = 13/4.
        let quotients = [1.0, 1.0, 2.0, 0.5, 3.0, 0.0, 0.0, 0.0, 1.0, 0.125, -1.0];
        assert_eq!(at_half(Formula::Rational, &quotients), 3.25_f64.sqrt());
        // 1.25 + (1/16)·(1/2)⁻² = 1.5.
        assert_eq!(at_half(Formula::Cauchy, &[1.25, 0.0625, -2.0]), 1.5);
    }

    #[test]
    fn a_table_keeps_its_entries_and_follows_the_formula_between() {
        // The strongest common flint, SCHOTT SF11, on the spectral lines of the catalogues.
        let lines_um = [
            0.3650, 0.40466, 0.43583, 0.47999, 0.48613, 0.54607, 0.58756, 0.6328, 0.65627, 0.70652,
            0.8521, 1.0139, 1.1286, 1.3951, 1.5296, 1.8131, 1.9701, 2.2493, 2.3254,
        ];
        let coefficients = [
            0.0,
            1.73759695,
            0.013188707,
            0.313747346,
            0.0623068142,
            1.89878101,
            155.23629,
        ];
        let flint = by_formula(Formula::SellmeierSquared, &coefficients);
        let exact = |um: f64| flint.evaluate(um);
        let table = by_table(&lines_um, &lines_um.map(exact));
        let drawn = |um: f64| table.evaluate(um);

        for um in lines_um {
            assert!((drawn(um) - exact(um)).abs() < 1e-14);
        }
        let worst = (0..=1000)
            .map(|i| 0.3650 + (2.3254 - 0.3650) * f64::from(i) * 1e-3)
            .map(|um| (drawn(um) - exact(um)).abs())
            .fold(0.0, f64::max);
        assert!(worst < 6e-5, "{worst}");
        assert_eq!(table.range_um(), Some([0.3650, 2.3254]));
    }

    #[test]
    fn numbers_that_do_not_fit_are_refused() {
        let torn = by_formula(Formula::Sellmeier, &[0.0, 1.0]).check();
        assert_eq!(
            torn,
            Err(DispersionError::new(
                "1 coefficient, then pairs",
                "2 coefficients"
            ))
        );
        assert!(by_formula(Formula::Rational, &[1.0; 7]).check().is_err());
        assert!(by_formula(Formula::Cauchy, &[]).check().is_err());
        assert!(by_formula(Formula::Cauchy, &[f64::NAN]).check().is_err());
        assert!(Dispersion::Constant(-1.0).check().is_err());

        let backwards = Dispersion::Formula {
            formula: Formula::Cauchy,
            coefficients: vec![1.5],
            range_um: [2.5, 0.3],
        };
        assert!(backwards.check().is_err());

        let um = [0.4, 0.5, 0.6, 0.7];
        assert!(by_table(&um, &[1.5; 4]).check().is_ok());
        assert!(by_table(&um, &[1.5; 3]).check().is_err());
        assert!(by_table(&um[..3], &[1.5; 3]).check().is_err());
        assert!(by_table(&[0.4, 0.6, 0.5, 0.7], &[1.5; 4]).check().is_err());
        assert!(by_table(&um, &[1.5, 1.5, f64::NAN, 1.5]).check().is_err());
    }
}
