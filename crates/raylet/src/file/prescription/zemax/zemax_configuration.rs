//! Configurations of a Zemax file: records behind MNUM that give values to one of them.
//!
//! Each record has a word, the number of a surface, wavelength or field, the number of the configuration, and the value.

use crate::file::decode::fault::{Fault, shortened};
use crate::file::prescription::lens_text::{LensText, Record};

/// Most records of this kind that a file may have.
const MOST: usize = 100_000;

/// Words of values that a scene does not have: weights, vignetting factors, temperatures, names.
const WITHOUT_EFFECT: [&str; 22] = [
    "MOFF", "MCOM", "WLWT", "FLWT", "FVDX", "FVDY", "FVCX", "FVCY", "FVAN", "TEMP", "PRES", "CWGT",
    "CROR", "LTTL", "MIND", "MABB", "MDPG", "UDAF", "GPEX", "GPEY", "COTN", "TELE",
];

/// A value of one configuration.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Operand {
    /// Its word.
    pub word: String,
    /// The number of the surface, wavelength or field.
    pub number: usize,
    /// The value as it is written.
    pub value: String,
    /// The line of the file.
    pub line: usize,
    configuration: usize,
}

/// The values of all configurations, as they are read.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Operands(Vec<Operand>);

impl Operands {
    /// Reads a record behind MNUM; false where it has no numbers of a surface and a configuration.
    ///
    /// # Errors
    /// More records than a file may have.
    pub(crate) fn read(&mut self, text: &LensText, record: &Record<'_>) -> Result<bool, Fault> {
        let number = |place: usize| record.values.get(place)?.parse::<usize>().ok();
        let upper = record.word.len() == 4
            && record
                .word
                .bytes()
                .all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit());
        let (true, Some(number), Some(configuration)) = (upper, number(0), number(1)) else {
            return Ok(false);
        };
        if WITHOUT_EFFECT.contains(&record.word) {
            return Ok(true);
        }
        if self.0.len() >= MOST {
            let found = format!("more than {MOST} values of configurations");
            return Err(text.fault(record.word, found, "fewer"));
        }
        let value = record.values.get(2).copied().unwrap_or_default();
        self.0.push(Operand {
            word: record.word.to_owned(),
            number,
            value: value.trim_matches('"').to_owned(),
            line: record.line,
            configuration,
        });
        Ok(true)
    }

    /// The values of a configuration.
    pub(crate) fn of(&self, configuration: usize) -> impl Iterator<Item = &Operand> {
        let wanted = move |operand: &&Operand| operand.configuration == configuration;
        self.0.iter().filter(wanted)
    }
}

impl Operand {
    /// The value as a number.
    ///
    /// # Errors
    /// A value that is none.
    pub(crate) fn number_of(&self, text: &LensText) -> Result<f64, Fault> {
        let value = self
            .value
            .parse::<f64>()
            .ok()
            .filter(|value| value.abs() <= 1e12);
        value.ok_or_else(|| {
            let found = format!("{} of {}", shortened(&self.value), self.word);
            text.fault_of_line(self.line, found, "a number of magnitude up to 1e12")
        })
    }

    /// The fault of a value that has no counterpart.
    pub(crate) fn refused(&self, text: &LensText) -> Fault {
        let found = format!("the value {} of a configuration", self.word);
        let expected = "CRVT, THIC, CONN, GLSS, SDIA, STPS, APER, WAVE, PRWV, XFIE or YFIE";
        text.fault_of_line(self.line, found, expected)
    }
}
