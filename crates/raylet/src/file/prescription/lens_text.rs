//! The text of a lens file: its encoding, its lines as records, and faults that point into it.

use std::ops::Range;
use std::path::Path;

use crate::file::decode::fault::{Fault, shortened};
use crate::file::decode::origin::Origin;

/// The largest number that is believed, in the units of the file.
const LARGEST: f64 = 1e12;

/// The text of a lens file.
#[derive(Clone, Debug)]
pub(crate) struct LensText {
    origin: Origin,
}

/// A line: its first word, and what follows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Record<'t> {
    /// Number of the line, from 1.
    pub line: usize,
    /// The first word.
    pub word: &'t str,
    /// The words behind it.
    pub values: Vec<&'t str>,
    /// All that stands behind the first word, without blanks at its ends.
    pub rest: &'t str,
}

/// The text of bytes in one of the encodings of lens files: UTF-16 or UTF-8 with their marks, UTF-8 without, or else
/// ISO-8859-1. Lines end with a line feed afterwards.
pub(crate) fn decoded(bytes: &[u8]) -> String {
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        // Files begin with a letter, whose other byte is zero.
        [first, 0, ..] if *first != 0 => wide(bytes, u16::from_le_bytes),
        [0, first, ..] if *first != 0 => wide(bytes, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => narrow(rest),
        _ => narrow(bytes),
    };
    text.replace("\r\n", "\n").replace('\r', "\n")
}

fn wide(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let pairs = bytes.as_chunks().0;
    let units: Vec<u16> = pairs.iter().map(|pair| unit(*pair)).collect();
    String::from_utf16_lossy(&units)
}

fn narrow(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        // The characters of ISO-8859-1 are the first of Unicode.
        Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
    }
}

impl LensText {
    /// The text of the bytes of a file.
    pub(crate) fn new(bytes: &[u8], file: &Path) -> Self {
        let origin = Origin::new(&decoded(bytes), file);
        Self { origin }
    }

    /// The name of the file, without its folder.
    pub(crate) fn file_name(&self) -> String {
        let name = self.origin.file.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    /// The name of the file without its folder and its ending, of letters, digits, hyphens and underscores alone.
    pub(crate) fn stem(&self) -> String {
        let stem = self.origin.file.file_stem().unwrap_or_default();
        let stem = stem.to_string_lossy();
        let kept = stem.chars().map(|c| {
            if c.is_alphanumeric() || c == '-' {
                c
            } else {
                '_'
            }
        });
        kept.take(80).collect()
    }

    /// All lines with their numbers, from 1.
    pub(crate) fn lines(&self) -> impl Iterator<Item = (usize, &str)> {
        (1..).zip(self.origin.text.split('\n'))
    }

    /// The lines that are not blank.
    pub(crate) fn records(&self) -> impl Iterator<Item = Record<'_>> {
        let lines = (1..).zip(self.origin.text.split('\n'));
        lines.filter_map(|(line, text)| {
            let text = text.trim();
            let mut words = text.split_whitespace();
            let word = words.next()?;
            Some(Record {
                line,
                word,
                values: words.collect(),
                rest: text.get(word.len()..).unwrap_or_default().trim(),
            })
        })
    }

    /// The fault of a part of the text.
    pub(crate) fn fault(
        &self,
        part: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Fault {
        let start = (part.as_ptr() as usize).checked_sub(self.origin.text.as_ptr() as usize);
        let span = start.map(|start| start..start + part.len());
        self.at(
            span.filter(|span| span.end <= self.origin.text.len()),
            found,
            expected,
        )
    }

    /// The fault of a line, from 1.
    pub(crate) fn fault_of_line(
        &self,
        line: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Fault {
        let text = self.origin.text.split('\n').nth(line.wrapping_sub(1));
        match text {
            Some(text) => self.fault(text.trim(), found, expected),
            None => self.at(None, found, expected),
        }
    }

    /// The fault of the whole file.
    pub(crate) fn fault_of_file(
        &self,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Fault {
        self.at(None, found, expected)
    }

    fn at(
        &self,
        span: Option<Range<usize>>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Fault {
        let address = self.origin.address(String::new(), span);
        Fault::at(address, found, expected)
    }

    /// The number that a word writes.
    ///
    /// # Errors
    /// A word that writes none, or one that is not finite or larger than 1e12.
    pub(crate) fn number(&self, word: &str) -> Result<f64, Fault> {
        // Some programs write the comma of their country.
        let number = word.replace(',', ".").parse::<f64>().ok();
        number
            .filter(|number| number.abs() <= LARGEST)
            .ok_or_else(|| self.fault(word, shortened(word), "a number of magnitude up to 1e12"))
    }

    /// The number at a place among the values of a record, from 0.
    ///
    /// # Errors
    /// No value there, or none that is a number.
    pub(crate) fn value(&self, record: &Record<'_>, place: usize) -> Result<f64, Fault> {
        match record.values.get(place) {
            Some(word) => self.number(word),
            None => {
                let found = format!("{} with {} values", record.word, record.values.len());
                let expected = format!("a number as value {}", place + 1);
                Err(self.fault(record.word, found, expected))
            }
        }
    }

    /// The number at a place among the values of a record; `otherwise` where nothing stands there.
    ///
    /// # Errors
    /// A value that is no number.
    pub(crate) fn value_or(
        &self,
        record: &Record<'_>,
        place: usize,
        otherwise: f64,
    ) -> Result<f64, Fault> {
        let value = record.values.get(place);
        value.map_or(Ok(otherwise), |word| self.number(word))
    }

    /// The whole number from 0 to `most` at a place among the values of a record.
    ///
    /// # Errors
    /// No value there, or another one.
    pub(crate) fn count(
        &self,
        record: &Record<'_>,
        place: usize,
        most: usize,
    ) -> Result<usize, Fault> {
        let value = self.value(record, place)?;
        if value.fract() == 0.0 && value >= 0.0 && value <= most as f64 {
            return Ok(value as usize);
        }
        let word = record.values.get(place).copied().unwrap_or(record.word);
        Err(self.fault(
            word,
            shortened(word),
            format!("a whole number from 0 to {most}"),
        ))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::file::prescription::lens_text::{LensText, decoded};

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "NAME Ø = 2 µm\r\nMODE SEQ\rUNIT MM\n";
        let expected = "NAME Ø = 2 µm\nMODE SEQ\nUNIT MM\n";
        let units: Vec<u16> = text.encode_utf16().collect();
        let wide = |bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            units.iter().flat_map(|unit| bytes(*unit)).collect()
        };
        let (little, big) = (wide(u16::to_le_bytes), wide(u16::to_be_bytes));
        let marked = |mark: &[u8], bytes: &[u8]| [mark, bytes].concat();
        let latin: Vec<u8> = text.chars().map(|c| u8::try_from(c).unwrap()).collect();
        for bytes in [
            text.as_bytes().to_vec(),
            marked(&[0xef, 0xbb, 0xbf], text.as_bytes()),
            marked(&[0xff, 0xfe], &little),
            marked(&[0xfe, 0xff], &big),
            little,
            big,
            latin,
        ] {
            assert_eq!(decoded(&bytes), expected);
        }
        assert_eq!(decoded(&[]), "");
        assert_eq!(decoded(&[0xff, 0xfe, 0x41]), "");
    }

    #[test]
    fn records_have_their_lines_and_faults_their_places() {
        let lens = LensText::new(
            b"MODE SEQ\n\n  DISZ 5 nan\n  CURV 1,5\n",
            Path::new("a.zmx"),
        );
        let records: Vec<_> = lens.records().collect();
        assert_eq!(records.len(), 3);
        assert_eq!((records[1].line, records[1].word), (3, "DISZ"));
        assert_eq!(records[1].values, ["5", "nan"]);
        assert_eq!(lens.value(&records[1], 0).unwrap(), 5.0);
        assert_eq!(lens.value(&records[2], 0).unwrap(), 1.5);
        let fault = lens.value(&records[1], 1).unwrap_err().to_string();
        assert!(
            fault.starts_with("a.zmx:3:10: found nan, expected a number"),
            "{fault}"
        );
        let fault = lens.value(&records[2], 3).unwrap_err().to_string();
        assert!(
            fault.starts_with("a.zmx:4:3: found CURV with 1 values"),
            "{fault}"
        );
        let fault = lens.fault_of_line(4, "a", "b").to_string();
        assert!(
            fault.starts_with("a.zmx:4:3: found a, expected b"),
            "{fault}"
        );
        assert!(lens.count(&records[1], 0, 4).is_err());
    }
}
