//! FITS headers and arrays, written in whole blocks of 2880 bytes.

use std::io::{self, Write};

use crate::file::fits::fits_header::{BLOCK, CARD};

/// The cards of a header that is to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Cards(Vec<String>);

impl Cards {
    /// The cards that begin a header of numbers of 64 bits: of the first part, or of an extension of this name. The
    /// first axis runs fastest.
    pub(crate) fn of_doubles(extension: Option<&str>, axes: &[usize]) -> Self {
        let mut cards = Self::default();
        match extension {
            None => cards.plain("SIMPLE", "T", "FITS"),
            Some(_) => cards.text("XTENSION", "IMAGE", "image extension"),
        }
        cards.plain("BITPIX", "-64", "numbers of 64 bits");
        cards.plain("NAXIS", &axes.len().to_string(), "");
        for (i, length) in axes.iter().enumerate() {
            cards.plain(&format!("NAXIS{}", i + 1), &length.to_string(), "");
        }
        match extension {
            None => cards.plain("EXTEND", "T", ""),
            Some(name) => {
                cards.plain("PCOUNT", "0", "");
                cards.plain("GCOUNT", "1", "");
                cards.text("EXTNAME", name, "");
            }
        }
        cards
    }

    /// Adds a number or T or F.
    fn plain(&mut self, keyword: &str, value: &str, comment: &str) {
        self.push(format!("{keyword:<8}= {value:>20}"), comment);
    }

    /// Adds a number.
    pub(crate) fn number(&mut self, keyword: &str, value: f64, comment: &str) {
        self.plain(keyword, &format!("{value:E}"), comment);
    }

    /// Adds a text without quotation marks.
    pub(crate) fn text(&mut self, keyword: &str, value: &str, comment: &str) {
        self.push(format!("{keyword:<8}= '{value:<8}'"), comment);
    }

    fn push(&mut self, card: String, comment: &str) {
        let card = match comment {
            "" => card,
            _ => format!("{card} / {comment}"),
        };
        let card: String = card.chars().take(CARD).collect();
        self.0.push(format!("{card:<80}"));
    }

    /// Writes the header.
    pub(crate) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let mut written = 0;
        for card in self.0.iter().map(String::as_str).chain(["END"]) {
            write!(out, "{card:<80}")?;
            written += CARD as u64;
        }
        pad(out, written, b' ')
    }
}

/// Writes numbers of 64 bits.
pub(crate) fn write_doubles(
    out: &mut impl Write,
    numbers: impl Iterator<Item = f64>,
) -> io::Result<()> {
    let mut written = 0;
    for number in numbers {
        out.write_all(&number.to_be_bytes())?;
        written += 8;
    }
    pad(out, written, 0)
}

/// Fills the last block.
fn pad(out: &mut impl Write, written: u64, byte: u8) -> io::Result<()> {
    let rest = written.next_multiple_of(BLOCK) - written;
    out.write_all(&vec![byte; rest as usize])
}
