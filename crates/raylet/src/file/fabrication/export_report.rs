//! What an export reports: what was written, what was rounded, and what the file does not hold.

use std::collections::BTreeMap;
use std::fmt;

/// A short report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExportReport {
    /// What was written, each as a name and a value.
    pub lines: Vec<(String, String)>,
    /// What the file does not hold.
    pub lost: Vec<String>,
    /// The numbers of the report by their names, which say their units.
    pub numbers: BTreeMap<String, f64>,
}

impl ExportReport {
    /// Adds a line.
    pub(crate) fn line(&mut self, name: &str, value: impl Into<String>) {
        self.lines.push((name.to_owned(), value.into()));
    }

    /// Adds a number.
    pub(crate) fn number(&mut self, name: &str, value: f64) {
        self.numbers.insert(name.to_owned(), value);
    }
}

impl fmt::Display for ExportReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, value) in &self.lines {
            writeln!(f, "{name:<18}{value}")?;
        }
        if !self.lost.is_empty() {
            writeln!(f, "Not in the file:")?;
        }
        for sentence in &self.lost {
            writeln!(f, "  - {sentence}")?;
        }
        Ok(())
    }
}

/// A number with few digits.
pub(crate) fn short(value: f64) -> String {
    let text = match value.abs() {
        0.0 => return String::from("0"),
        size if (1e-4..1e7).contains(&size) => {
            let digits = (5 - size.log10().floor() as i32).max(0);
            format!("{value:.*}", digits as usize)
        }
        _ => return format!("{value:.3e}"),
    };
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use crate::file::fabrication::export_report::{ExportReport, short};

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.3335, "0.3335"),
            (-1234.5678, "-1234.57"),
            (6_000_000.0, "6000000"),
            (1e-9, "1.000e-9"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn a_report_has_lines_and_losses() {
        let mut report = ExportReport::default();
        report.line("Cells", "4 x 5");
        report.lost.push(String::from("the amplitude"));
        let text = "Cells             4 x 5\nNot in the file:\n  - the amplitude\n";
        assert_eq!(report.to_string(), text);
    }
}
