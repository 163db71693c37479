//! Glasses of a CODE V file: names with makers, codes of index and Abbe number, and glasses whose indices the file has.

use std::collections::BTreeMap;

use crate::file::decode::fault::{Fault, shortened};
use crate::file::prescription::codev::codev_commands::{Command, key, unquoted};
use crate::file::prescription::glasses::formula_table::tabulated;
use crate::file::prescription::lens_text::LensText;
use crate::file::prescription::sequential::{Behind, GlassRequest};
use crate::file::scene::material::OwnMedium;

/// Most glasses that a file may define.
const MOST: usize = 1000;

/// The range in µm in which a formula of the file is used.
const FORMULA_RANGE: [f64; 2] = [0.35, 2.0];

/// What the file says of a glass of its own: its medium, or why there is none.
type Defined = Result<OwnMedium, String>;

/// The glasses that a file defines itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct PrivateGlasses {
    /// Whether commands define glasses now.
    pub reading: bool,
    waves_um: Vec<f64>,
    defined: BTreeMap<String, Defined>,
}

impl PrivateGlasses {
    /// Reads a command between PRV and END.
    ///
    /// # Errors
    /// Values that are no numbers, or not as many as there are wavelengths.
    pub(crate) fn read(&mut self, text: &LensText, command: &Command<'_>) -> Result<(), Fault> {
        match command.key.as_str() {
            "END" => self.reading = false,
            "PWL" => {
                let numbers = command.numbers(text)?;
                self.waves_um = numbers.iter().map(|nm| nm / 1e3).collect();
            }
            _ => {
                if self.defined.len() >= MOST {
                    let found = format!("more than {MOST} glasses of the file's own");
                    return Err(text.fault(command.word, found, "fewer"));
                }
                let medium = self.medium(text, command)?;
                let name = unquoted(command.word).to_ascii_uppercase();
                self.defined.insert(name, medium);
            }
        }
        Ok(())
    }

    /// The medium of a command: a list of indices, or the word of a formula with its coefficients.
    fn medium(&self, text: &LensText, command: &Command<'_>) -> Result<Defined, Fault> {
        let Some(first) = command.values.first() else {
            return Err(text.fault(
                command.word,
                "a glass without indices",
                "indices behind its name",
            ));
        };
        let formula = first.starts_with(|c: char| c.is_ascii_alphabetic());
        if formula {
            let word = key(first);
            let numbers = command.values.iter().skip(1);
            let numbers: Result<Vec<f64>, Fault> = numbers.map(|word| text.number(word)).collect();
            return Ok(match word.as_str() {
                "LAU" => laurent(&numbers?),
                _ => Err(format!("a formula of kind {}", shortened(first))),
            });
        }
        let indices = command.numbers(text)?;
        if indices.len() != self.waves_um.len() {
            let found = format!(
                "{} indices for {} wavelengths",
                indices.len(),
                self.waves_um.len()
            );
            return Err(text.fault(command.word, found, "an index for each wavelength of PWL"));
        }
        Ok(table(&self.waves_um, &indices))
    }

    /// What stands behind a surface, by the word of a file.
    ///
    /// # Errors
    /// A glass that the file defines in a way that is not read.
    pub(crate) fn behind(&self, text: &LensText, line: usize, word: &str) -> Result<Behind, Fault> {
        let name = unquoted(word);
        let upper = name.to_ascii_uppercase();
        match upper.as_str() {
            "REFL" => return Ok(Behind::Reflected),
            "" | "AIR" | "REFR" => return Ok(Behind::Air),
            _ => {}
        }
        let plain = GlassRequest {
            line,
            name: name.to_owned(),
            maker: None,
            code: None,
            own: None,
        };
        Ok(Behind::Glass(match self.defined.get(&upper) {
            Some(Ok(own)) => GlassRequest {
                own: Some(Box::new(own.clone())),
                ..plain
            },
            Some(Err(found)) => {
                let found = format!("the glass {} by {found}", shortened(name));
                let expected = "indices at the wavelengths of PWL, or the formula LAU";
                return Err(text.fault_of_line(line, found, expected));
            }
            None if code(name).is_some() => GlassRequest {
                code: code(name),
                ..plain
            },
            None => match name.rsplit_once('_') {
                Some((name, maker)) if !name.is_empty() && !maker.is_empty() => GlassRequest {
                    name: name.to_owned(),
                    maker: Some(maker.to_ascii_uppercase()),
                    ..plain
                },
                _ => plain,
            },
        }))
    }
}

/// Index and Abbe number of a code: 517.642, 517642 and 517000.642000 have 1.517 and 64.2.
fn code(name: &str) -> Option<[f64; 2]> {
    let (index, abbe) = match name.split_once('.') {
        Some(parts) => parts,
        None if name.len() == 6 => name.split_at_checked(3)?,
        None => return None,
    };
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    if !digits(index) || !digits(abbe) {
        return None;
    }
    let fraction = |part: &str| format!("0.{part}").parse::<f64>().ok();
    let (index, abbe) = (1.0 + fraction(index)?, 100.0 * fraction(abbe)?);
    // Six or more digits of each part are exact in decimals.
    let round = |value: f64| (value * 1e9).round() / 1e9;
    (abbe > 0.0).then(|| [round(index), round(abbe)])
}

/// The medium of indices at wavelengths in µm. One index holds at every wavelength; through two or three goes the polynomial
/// in 1/λ.
fn table(waves_um: &[f64], indices: &[f64]) -> Defined {
    let mut pairs: Vec<[f64; 2]> = waves_um
        .iter()
        .zip(indices)
        .map(|(w, n)| [*w, *n])
        .collect();
    pairs.sort_by(|a, b| a[0].total_cmp(&b[0]));
    pairs.dedup_by_key(|pair| pair[0]);
    let own = match pairs.as_slice() {
        [[_, index]] => OwnMedium {
            index: Some(*index),
            ..OwnMedium::default()
        },
        [[from, _], .., [to, _]] if pairs.len() < 4 => {
            let through = |um: f64| polynomial(&pairs, um);
            let (own, _) = tabulated(through, [*from, *to]).ok_or("indices below 1 or above 10")?;
            own
        }
        _ => OwnMedium {
            wavelengths_um: Some(pairs.iter().map(|pair| pair[0]).collect()),
            indices: Some(pairs.iter().map(|pair| pair[1]).collect()),
            ..OwnMedium::default()
        },
    };
    checked(own)
}

/// The value at a wavelength of the polynomial in 1/λ through a few pairs.
fn polynomial(pairs: &[[f64; 2]], um: f64) -> f64 {
    let term = |i: usize, at: &[f64; 2]| {
        let others = pairs.iter().enumerate().filter(|(j, _)| *j != i);
        let factors =
            others.map(|(_, other)| (1.0 / um - 1.0 / other[0]) / (1.0 / at[0] - 1.0 / other[0]));
        at[1] * factors.product::<f64>()
    };
    pairs.iter().enumerate().map(|(i, at)| term(i, at)).sum()
}

/// n² = a₀ + a₁ λ² + a₂ λ⁻² + a₃ λ⁻⁴ + a₄ λ⁻⁶ + a₅ λ⁻⁸, as a table.
fn laurent(numbers: &[f64]) -> Defined {
    let at = |place: usize| numbers.get(place).copied().unwrap_or(0.0);
    let index = |um: f64| {
        let inverse = 1.0 / (um * um);
        let series = (2..6)
            .rev()
            .fold(0.0, |sum, place| (sum + at(place)) * inverse);
        (at(0) + at(1) * um * um + series).sqrt()
    };
    let (own, _) =
        tabulated(index, FORMULA_RANGE).ok_or("a formula without an index from 1 to 10")?;
    checked(own)
}

/// A medium that a scene can have.
fn checked(own: OwnMedium) -> Defined {
    match own.medium() {
        Ok(_) if own.index.is_none_or(|index| (1.0..=10.0).contains(&index)) => Ok(own),
        Ok(_) => Err("an index that is not from 1 to 10".to_owned()),
        Err((found, _)) => Err(found),
    }
}

#[cfg(test)]
mod tests {
    use crate::file::prescription::codev::codev_glass::{code, laurent, table};

    #[test]
    fn codes_have_their_digits() {
        assert_eq!(code("517642"), Some([1.517, 64.2]));
        assert_eq!(code("517.642"), Some([1.517, 64.2]));
        assert_eq!(code("517000.520000"), Some([1.517, 52.0]));
        assert_eq!(code("500.700"), Some([1.5, 70.0]));
        for none in ["NBK7", "517", "517.", "517.0", "1.5.2", "-17.5"] {
            assert_eq!(code(none), None, "{none}");
        }
    }

    #[test]
    fn few_indices_give_the_polynomial_through_them() {
        let index = |waves: &[f64], indices: &[f64], um: f64| {
            let medium = table(waves, indices).unwrap().medium().unwrap();
            medium.index(um * 1e-3).unwrap()
        };
        assert_eq!(index(&[0.5], &[1.5], 0.7), 1.5);
        let halfway = 2.0 / (1.0 / 0.4 + 1.0 / 0.8);
        assert!((index(&[0.8, 0.4], &[1.5, 1.6], halfway) - 1.55).abs() < 1e-12);
        let through = |um: f64| 1.4 + 0.02 / um + 0.01 / (um * um);
        let waves = [0.4, 0.55, 0.8];
        assert!((index(&waves, &waves.map(through), 0.5) - through(0.5)).abs() < 1e-12);
    }

    #[test]
    fn a_laurent_series_has_its_powers() {
        let own = laurent(&[2.36390625, 0.001, 0.025493134, -0.000580235]).unwrap();
        let um: f64 = 0.55;
        let squared =
            2.36390625 + 0.001 * um.powi(2) + 0.025493134 / um.powi(2) - 0.000580235 / um.powi(4);
        let found = own.medium().unwrap().index(um * 1e-3).unwrap();
        assert!((found - squared.sqrt()).abs() < 2e-9);
    }
}
