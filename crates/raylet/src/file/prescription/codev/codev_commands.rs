//! The text of a CODE V file as commands: a word, qualifiers such as `S3` or `EDG`, and values.
//!
//! Commands end with a line or a semicolon, `&` at the end of a line continues it, and `!` begins a remark. Capitals do not
//! matter; of words with more than three letters the first three count.

use crate::file::decode::fault::{Fault, shortened};
use crate::file::prescription::lens_text::LensText;

/// The longest line that is read, in bytes, and most words of a command.
const LONGEST_LINE: usize = 10_000;
const MOST_WORDS: usize = 10_000;

/// Words that say which aperture is meant.
const APERTURES: [&str; 4] = ["CLR", "EDG", "OBS", "HOL"];

/// A command.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Command<'t> {
    /// Number of the line where it begins, from 1.
    pub line: usize,
    /// Its first word, as it is written.
    pub word: &'t str,
    /// The same in the form that is compared: `TIT` for `Title`.
    pub key: String,
    /// Words behind it that say which surface, position, field or aperture is meant, in capitals.
    pub qualifiers: Vec<String>,
    /// What follows.
    pub values: Vec<&'t str>,
}

/// A word, or the end of a command.
enum Piece<'t> {
    Word(&'t str),
    End,
}

/// Calls `act` for each command of a text, until it returns false.
///
/// # Errors
/// A line or command that is too long, or what `act` returns.
pub(crate) fn each_command<'t>(
    text: &'t LensText,
    mut act: impl FnMut(&Command<'t>) -> Result<bool, Fault>,
) -> Result<(), Fault> {
    let mut words: Vec<&str> = Vec::new();
    let mut start = 1;
    let mut finish = |words: &mut Vec<&'t str>, line: usize| match Command::of(words, line) {
        Some(command) => {
            words.clear();
            act(&command)
        }
        None => Ok(true),
    };
    for (line, row) in text.lines() {
        if row.len() > LONGEST_LINE {
            let found = format!("a line of {} bytes", row.len());
            let expected = format!("lines of at most {LONGEST_LINE} bytes");
            return Err(text.fault_of_line(line, shortened(&found), expected));
        }
        let (pieces, continued) = pieces(row);
        let ended = (!continued).then_some(Piece::End);
        for piece in pieces.into_iter().chain(ended) {
            match piece {
                Piece::Word(word) if words.len() < MOST_WORDS => {
                    if words.is_empty() {
                        start = line;
                    }
                    words.push(word);
                }
                Piece::Word(_) => {
                    let found = format!("a command of more than {MOST_WORDS} words");
                    return Err(text.fault_of_line(start, found, "fewer"));
                }
                Piece::End => {
                    if !finish(&mut words, start)? {
                        return Ok(());
                    }
                }
            }
        }
    }
    finish(&mut words, start).map(|_| ())
}

/// The word of a line that began at `start` and ends here, if one has begun.
fn word<'t>(row: &'t str, start: &mut Option<usize>, end: usize) -> Option<Piece<'t>> {
    let word = start.take().and_then(|start| row.get(start..end));
    word.map(Piece::Word)
}

/// The pieces of a line, and whether the next one continues it.
fn pieces(row: &str) -> (Vec<Piece<'_>>, bool) {
    let (mut list, mut continued) = (Vec::new(), false);
    let (mut start, mut quote) = (None, None);
    let mut end = row.len();
    for (at, c) in row.char_indices() {
        if let Some(open) = quote {
            if c == open {
                quote = None;
            }
            continue;
        }
        match c {
            '!' => {
                end = at;
                break;
            }
            '&' => {
                list.extend(word(row, &mut start, at));
                continued = true;
            }
            ';' => {
                list.extend(word(row, &mut start, at));
                list.push(Piece::End);
                continued = false;
            }
            c if c.is_whitespace() => list.extend(word(row, &mut start, at)),
            c => {
                if matches!(c, '\'' | '"') {
                    quote = Some(c);
                }
                start.get_or_insert(at);
                continued = false;
            }
        }
    }
    list.extend(word(row, &mut start, end));
    (list, continued)
}

impl<'t> Command<'t> {
    /// The command of these words; none without any.
    fn of(words: &[&'t str], line: usize) -> Option<Self> {
        let (word, rest) = words.split_first()?;
        let key = key(word);
        let (qualifiers, values) = qualified(rest);
        Some(Self {
            line,
            word,
            key,
            qualifiers,
            values,
        })
    }

    /// Another command that stands in this one: its words from `start` on, qualifiers first, with these values.
    pub(crate) fn inner(&self, word: &'t str, rest: &[&'t str]) -> Self {
        let (qualifiers, values) = qualified(rest);
        Self {
            line: self.line,
            word,
            key: key(word),
            qualifiers,
            values,
        }
    }

    /// What follows a letter among the qualifiers: `3` for S3.
    pub(crate) fn qualifier(&self, letter: char) -> Option<&str> {
        let found = self
            .qualifiers
            .iter()
            .find_map(|word| word.strip_prefix(letter));
        found.filter(|rest| !APERTURES.iter().any(|word| word.get(1..) == Some(rest)))
    }

    /// The number at a place among the values, from 0.
    ///
    /// # Errors
    /// No value there, or none that is a number.
    pub(crate) fn number(&self, text: &LensText, place: usize) -> Result<f64, Fault> {
        match self.values.get(place) {
            Some(word) => text.number(word),
            None => {
                let found = format!("{} with {} values", self.word, self.values.len());
                let expected = format!("a number as value {}", place + 1);
                Err(text.fault(self.word, found, expected))
            }
        }
    }

    /// All values as numbers.
    ///
    /// # Errors
    /// A value that is none.
    pub(crate) fn numbers(&self, text: &LensText) -> Result<Vec<f64>, Fault> {
        self.values.iter().map(|word| text.number(word)).collect()
    }

    /// Yes without a value or with one that begins with Y, no with one that begins with N.
    pub(crate) fn agrees(&self) -> bool {
        let first = self
            .values
            .first()
            .and_then(|word| unquoted(word).chars().next());
        !first.is_some_and(|c| c.eq_ignore_ascii_case(&'n'))
    }
}

/// A command's word in the form that is compared.
pub(crate) fn key(word: &str) -> String {
    let upper = word.to_ascii_uppercase();
    let long = upper.len() > 3 && upper.bytes().all(|byte| byte.is_ascii_alphabetic());
    match long {
        true => upper.chars().take(3).collect(),
        false => upper,
    }
}

/// Splits words into qualifiers, in capitals, and values.
fn qualified<'t>(words: &[&'t str]) -> (Vec<String>, Vec<&'t str>) {
    let count = words.iter().take_while(|word| qualifies(word)).count();
    let (first, rest) = words.split_at(count);
    let upper = first.iter().map(|word| word.to_ascii_uppercase());
    (upper.collect(), rest.to_vec())
}

/// Whether a word says which surface (S3, SI, S2..4), position (Z2), field (F1), wavelength (W1), coefficient (C2), label or
/// aperture is meant.
fn qualifies(word: &str) -> bool {
    let upper = word.to_ascii_uppercase();
    if APERTURES.contains(&upper.as_str()) {
        return true;
    }
    let mut letters = upper.chars();
    let first = letters.next();
    let rest = letters.as_str();
    let numbered = !rest.is_empty() && rest.bytes().all(|byte| byte.is_ascii_digit());
    match first {
        Some('S') => numbered || rest.contains("..") || matches!(rest, "O" | "I" | "S" | "A"),
        Some('Z' | 'F' | 'W' | 'C') => numbered || rest == "A",
        Some('L') => rest.starts_with(['\'', '"']),
        _ => false,
    }
}

/// A word without the quotes around it.
pub(crate) fn unquoted(word: &str) -> &str {
    let inner = |quote: char| {
        let inner = word.strip_prefix(quote)?;
        Some(inner.strip_suffix(quote).unwrap_or(inner))
    };
    inner('\'').or_else(|| inner('"')).unwrap_or(word)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::file::prescription::codev::codev_commands::{each_command, unquoted};
    use crate::file::prescription::lens_text::LensText;

    #[test]
    fn commands_are_told_apart() {
        let text = "RDM;LEN \"a; b\"\nTitle 'it''s ! no remark'\n! nothing\ns .1 &\n2 NBK7 ! glass; epd 3\n\
                    CIR OBS L'A' 0.3;ZOO THI S5..6 1 2& ! next\n  3\nHCO C1 -2\n";
        let lens = LensText::new(text.as_bytes(), Path::new("a.seq"));
        let mut found = Vec::new();
        each_command(&lens, |command| {
            let words = [command.qualifiers.join(","), command.values.join(",")];
            found.push(format!(
                "{} {} {}",
                command.line,
                command.key,
                words.join("|")
            ));
            Ok(true)
        })
        .unwrap();
        let expected = [
            "1 RDM |",
            "1 LEN |\"a; b\"",
            "2 TIT |'it''s ! no remark'",
            "4 S |.1,2,NBK7",
            "6 CIR OBS,L'A'|0.3",
            "6 ZOO |THI,S5..6,1,2,3",
            "8 HCO C1|-2",
        ];
        assert_eq!(found, expected);
        assert_eq!(
            (unquoted("'E48'"), unquoted("\"a"), unquoted("a'")),
            ("E48", "a", "a'")
        );
    }
}
