//! The cards of a FITS header: keywords and their values, 80 characters a card, 36 cards a block.

use std::io::Read;

/// Bytes of a block; headers and data fill whole blocks.
pub(crate) const BLOCK: u64 = 2880;

/// Bytes of a card.
pub(crate) const CARD: usize = 80;

/// The most cards of a header.
const MOST_CARDS: usize = 36_000;

/// The largest number of axes of the standard.
const MOST_AXES: i64 = 999;

/// A header.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Header {
    /// Keywords with the text of their values, without comments.
    cards: Vec<(String, Value)>,
    /// Bytes of the header in the file.
    pub(crate) bytes: u64,
}

/// The value of a card.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    /// Between quotation marks.
    Text(String),
    /// Anything else: numbers and T or F.
    Plain(String),
}

impl Header {
    /// Reads a header up to the end of its last block.
    ///
    /// # Errors
    /// What was found instead, in words.
    pub(crate) fn read(stream: &mut impl Read) -> Result<Self, String> {
        let mut header = Self::default();
        loop {
            let mut block = Vec::with_capacity(BLOCK as usize);
            let read = stream.take(BLOCK).read_to_end(&mut block);
            read.map_err(|error| error.to_string())?;
            if block.len() as u64 != BLOCK {
                return Err(String::from("a file that ends within a header"));
            }
            header.bytes += BLOCK;
            let (cards, _) = block.as_chunks::<CARD>();
            for card in cards {
                let (keyword, rest) = card.split_at(8);
                match String::from_utf8_lossy(keyword).trim_end() {
                    "END" => return Ok(header),
                    keyword => header.add(keyword, rest),
                }
            }
            if header.bytes > (MOST_CARDS * CARD) as u64 {
                return Err(format!("a header of more than {MOST_CARDS} cards"));
            }
        }
    }

    /// Adds the value of a card, if it has one.
    fn add(&mut self, keyword: &str, rest: &[u8]) {
        let Some(value) = rest.strip_prefix(b"= ") else {
            return;
        };
        let value = String::from_utf8_lossy(value);
        let value = match value.trim_start().strip_prefix('\'') {
            Some(text) => Value::Text(quoted(text)),
            None => {
                let plain = value.split('/').next().unwrap_or_default();
                Value::Plain(plain.trim().to_owned())
            }
        };
        self.cards.push((keyword.to_owned(), value));
    }

    fn get(&self, keyword: &str) -> Option<&Value> {
        let card = self.cards.iter().find(|(name, _)| name == keyword);
        card.map(|(_, value)| value)
    }

    /// A text.
    pub(crate) fn text(&self, keyword: &str) -> Option<&str> {
        match self.get(keyword) {
            Some(Value::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// Whether a keyword is T.
    pub(crate) fn is_true(&self, keyword: &str) -> bool {
        self.get(keyword) == Some(&Value::Plain(String::from("T")))
    }

    /// A number, if the keyword is there.
    ///
    /// # Errors
    /// A value that is no finite number, as (found, expected).
    pub(crate) fn number(&self, keyword: &str) -> Result<Option<f64>, (String, String)> {
        let Some(value) = self.get(keyword) else {
            return Ok(None);
        };
        let number = match value {
            // Exponents of double precision may be written with a D.
            Value::Plain(plain) => plain.replace(['D', 'd'], "E").parse().ok(),
            Value::Text(_) => None,
        };
        match number.filter(|number: &f64| number.is_finite()) {
            Some(number) => Ok(Some(number)),
            None => Err((format!("{keyword} = {value:?}"), String::from("a number"))),
        }
    }

    /// A whole number, if the keyword is there.
    ///
    /// # Errors
    /// A value that is no whole number, as (found, expected).
    pub(crate) fn whole(&self, keyword: &str) -> Result<Option<i64>, (String, String)> {
        let Some(value) = self.get(keyword) else {
            return Ok(None);
        };
        let whole = match value {
            Value::Plain(plain) => plain.parse().ok(),
            Value::Text(_) => None,
        };
        match whole {
            Some(whole) => Ok(Some(whole)),
            None => Err((
                format!("{keyword} = {value:?}"),
                String::from("a whole number"),
            )),
        }
    }

    /// The lengths of the axes; the first one runs fastest.
    ///
    /// # Errors
    /// Lengths that are missing or negative, as (found, expected).
    pub(crate) fn axes(&self) -> Result<Vec<u64>, (String, String)> {
        let count = self.whole("NAXIS")?.unwrap_or(-1);
        if !(0..=MOST_AXES).contains(&count) {
            let found = format!("NAXIS = {count}");
            return Err((found, format!("from 0 to {MOST_AXES} axes")));
        }
        (1..=count)
            .map(|axis| {
                let length = self.whole(&format!("NAXIS{axis}"))?;
                let length = length.and_then(|length| u64::try_from(length).ok());
                length.ok_or_else(|| {
                    let found = format!("no length of axis {axis}");
                    (found, format!("a number in NAXIS{axis}"))
                })
            })
            .collect()
    }

    /// Bits of a number: 8, 16, 32 or 64 of whole numbers, -32 or -64 of others.
    ///
    /// # Errors
    /// Another number, as (found, expected).
    pub(crate) fn bits(&self) -> Result<i64, (String, String)> {
        match self.whole("BITPIX")? {
            Some(bits @ (8 | 16 | 32 | 64 | -32 | -64)) => Ok(bits),
            other => Err((
                format!("BITPIX = {}", other.unwrap_or(0)),
                String::from("8, 16, 32, 64, -32 or -64"),
            )),
        }
    }

    /// Bytes of the data, without what fills the last block; the largest number where there are more.
    ///
    /// # Errors
    /// Sizes that no data have, as (found, expected).
    pub(crate) fn data_bytes(&self) -> Result<u64, (String, String)> {
        let axes = self.axes()?;
        if axes.is_empty() {
            return Ok(0);
        }
        let count = axes.iter().fold(1, |n: u64, axis| n.saturating_mul(*axis));
        let more = self.whole("PCOUNT")?.unwrap_or(0);
        let groups = self.whole("GCOUNT")?.unwrap_or(1);
        match (u64::try_from(more), u64::try_from(groups)) {
            (Ok(more), Ok(groups)) => {
                let numbers = count.saturating_add(more).saturating_mul(groups);
                Ok(numbers.saturating_mul(self.bits()?.unsigned_abs() / 8))
            }
            _ => Err((
                format!("PCOUNT = {more}, GCOUNT = {groups}"),
                String::from("numbers from 0"),
            )),
        }
    }
}

/// The text up to its closing quotation mark; two of them stand for one.
fn quoted(text: &str) -> String {
    let mut inside = String::new();
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '\'' if rest.peek() == Some(&'\'') => {
                rest.next();
                inside.push('\'');
            }
            '\'' => break,
            c => inside.push(c),
        }
    }
    inside.trim_end().to_owned()
}
