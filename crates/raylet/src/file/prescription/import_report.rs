//! What an import tells: what was read, what was changed, and what was left out and may cost.

use std::collections::BTreeMap;
use std::fmt;

/// What a reader could not keep.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Losses {
    /// What the scene has in another form.
    pub changed: Vec<String>,
    /// What the scene does not have.
    pub left_out: Vec<String>,
    /// What may make the scene another lens.
    pub warnings: Vec<String>,
    /// Values that the file computes from others.
    pub solves: usize,
    /// Words of records that mean nothing to raylet, and how often each stands in the file.
    pub unused: BTreeMap<String, usize>,
}

impl Losses {
    /// Notes what the scene has in another form.
    pub(crate) fn change(&mut self, sentence: impl Into<String>) {
        note(&mut self.changed, sentence.into());
    }

    /// Notes what the scene does not have.
    pub(crate) fn leave_out(&mut self, sentence: impl Into<String>) {
        note(&mut self.left_out, sentence.into());
    }

    /// Notes what may make the scene another lens.
    pub(crate) fn warn(&mut self, sentence: impl Into<String>) {
        note(&mut self.warnings, sentence.into());
    }

    /// Counts a record that is not used; of a word that is too long to be one, nothing is kept.
    pub(crate) fn ignore(&mut self, word: &str) {
        if word.len() <= 8 && self.unused.len() < 200 {
            *self.unused.entry(word.to_owned()).or_default() += 1;
        }
    }
}

/// A sentence stands once.
fn note(list: &mut Vec<String>, sentence: String) {
    if !list.contains(&sentence) {
        list.push(sentence);
    }
}

/// A number that raylet computed, beside that of the file where it states one.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportedNumber {
    /// What it is, with its unit.
    pub name: String,
    /// The value of raylet; none where the system has none.
    pub value: Option<f64>,
    /// The value in the file.
    pub stated: Option<f64>,
}

/// What an import tells, in plain sentences.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportReport {
    /// What was read.
    pub read: Vec<String>,
    /// First-order data at the wavelength of the scene.
    pub numbers: Vec<ReportedNumber>,
    /// What may make the scene another lens.
    pub warnings: Vec<String>,
    /// What the scene has in another form.
    pub changed: Vec<String>,
    /// What the scene does not have, and what that may cost.
    pub left_out: Vec<String>,
}

impl ImportReport {
    /// The number of this name; none where the report has none.
    pub fn number(&self, name: &str) -> Option<f64> {
        let found = self.numbers.iter().find(|number| number.name == name);
        found.and_then(|number| number.value)
    }
}

impl fmt::Display for ImportReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for sentence in &self.read {
            writeln!(f, "{sentence}")?;
        }
        writeln!(f, "First-order data:")?;
        for number in &self.numbers {
            let value = number.value.map_or("none".to_owned(), rounded);
            write!(f, "  {:<36}{value}", number.name)?;
            if let Some(stated) = number.stated {
                write!(f, "   ({} in the file)", rounded(stated))?;
            }
            writeln!(f)?;
        }
        for (title, list) in [
            ("Warnings", &self.warnings),
            ("Changed", &self.changed),
            ("Left out", &self.left_out),
        ] {
            if !list.is_empty() {
                writeln!(f, "{title}:")?;
            }
            for sentence in list {
                writeln!(f, "  - {sentence}")?;
            }
        }
        Ok(())
    }
}

/// Eight digits.
fn rounded(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = 7 - value.abs().log10().floor() as i32;
    match (0..=12).contains(&digits) {
        true => format!("{value:.*}", digits as usize),
        false => format!("{value:.7e}"),
    }
}
