//! A fault in something the user gave: where it is, what was found there, what was expected.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Longest part of a line that is shown, in characters.
const WIDEST: usize = 160;

/// The most characters of a value that a message shows.
const MOST_OF_A_VALUE: usize = 200;

/// The most characters of a finding or of an expectation, which may name several values.
const MOST: usize = 1000;

/// At most so many characters of a text, and how many it has where some are left out.
fn cut(text: String, most: usize) -> String {
    let count = text.chars().count();
    if count <= most {
        return text;
    }
    let kept: String = text.chars().take(most).collect();
    format!("{kept}… ({count} characters)")
}

/// At most 200 characters of a value for a message.
pub fn shortened(value: &str) -> String {
    cut(value.to_owned(), MOST_OF_A_VALUE)
}

/// Why an input file was refused, with its address.
///
/// Displayed over several lines: the address with the finding and the expectation on the first, then the
/// offending line of the source with the place underlined, then a hint.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct Fault {
    /// Where the fault is.
    pub address: Box<Address>,
    /// What was found there.
    pub found: String,
    /// What was expected instead.
    pub expected: String,
    /// How it may be repaired, when there is a good guess.
    pub hint: Option<String>,
}

/// A place in an input file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Address {
    /// The file; empty for a text that came from no file.
    pub file: PathBuf,
    /// The path of the field inside it, such as `element[2].surface[0].glass`; may be empty.
    pub path: String,
    /// The place in the text, where the file is text.
    pub excerpt: Option<Excerpt>,
}

/// A place in a text and the line around it.
#[derive(Clone, Debug, PartialEq)]
pub struct Excerpt {
    /// Line, counted from 1.
    pub line: usize,
    /// Column in characters, counted from 1.
    pub column: usize,
    /// The whole line.
    pub text: String,
    /// How many characters of it are meant, at least 1.
    pub width: usize,
}

impl Fault {
    /// A fault of a whole file, such as one that cannot be opened.
    pub fn of_file(file: &Path, found: impl Into<String>, expected: impl Into<String>) -> Self {
        let address = Address {
            file: file.to_path_buf(),
            ..Address::default()
        };
        Self::at(address, found, expected)
    }

    /// A fault at an address.
    pub(crate) fn at(
        address: Address,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self {
            address: Box::new(address),
            found: cut(found.into(), MOST),
            expected: cut(expected.into(), MOST),
            hint: None,
        }
    }

    /// The same fault with a hint for its repair.
    pub(crate) fn hint(self, hint: impl Into<String>) -> Self {
        Self {
            hint: Some(hint.into()),
            ..self
        }
    }
}

impl Excerpt {
    /// The excerpt of `text` at a range of bytes; a range over several lines is cut after its first.
    pub(crate) fn new(text: &str, range: Range<usize>) -> Self {
        // Step back to a character boundary, so that no range can split a character.
        let (before, behind) = (0..=range.start.min(text.len()))
            .rev()
            .find_map(|at| text.split_at_checked(at))
            .unwrap_or(("", text));
        let start = before.len();
        let lead = before.rsplit('\n').next().unwrap_or_default();
        let rest = behind.split('\n').next().unwrap_or_default();
        let line = format!("{lead}{rest}");
        let line = line.trim_end_matches('\r');

        // Count characters, not bytes, for what is shown.
        let column = lead.chars().count();
        let ahead = behind.char_indices();
        let width = ahead.take_while(|(at, _)| start + at < range.end).count();
        let room = line.chars().count().saturating_sub(column);
        Self {
            line: 1 + before.matches('\n').count(),
            column: column + 1,
            text: line.to_owned(),
            width: width.min(room).max(1),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: found {}, expected {}",
            self.address, self.found, self.expected
        )?;
        if let Some(excerpt) = &self.address.excerpt {
            write!(f, "\n{excerpt}")?;
        }
        if let Some(hint) = &self.hint {
            write!(f, "\nhint: {hint}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Editors and terminals make a link of file:line:column.
        if self.file.as_os_str().is_empty() {
            write!(f, "input")?;
        } else {
            write!(f, "{}", name(&self.file))?;
        }
        if let Some(excerpt) = &self.excerpt {
            write!(f, ":{}:{}", excerpt.line, excerpt.column)?;
        }
        if !self.path.is_empty() {
            write!(f, ": {}", self.path)?;
        }
        Ok(())
    }
}

/// No file system has longer names of files with their folders, in bytes.
const LONGEST_NAME: usize = 4096;

/// Characters that are shown of a longer one.
const SHOWN: usize = 200;

/// The name of a file, or the start of one that no file can have.
fn name(file: &Path) -> String {
    let name = file.display().to_string();
    if name.len() <= LONGEST_NAME {
        return name;
    }
    let start: String = name.chars().take(SHOWN).collect();
    format!("{start}… ({} characters)", name.chars().count())
}

impl Excerpt {
    /// The part of the line that is shown: how many characters before the place, and the text. Of a long
    /// line this is what stands around the place.
    fn shown(&self) -> (usize, String) {
        let before = self.column - 1;
        let skipped = before.saturating_sub(WIDEST / 2);
        let skipped = if before < WIDEST - 1 { 0 } else { skipped };
        let mut text: Vec<char> = self.text.chars().skip(skipped).take(WIDEST).collect();
        let cut = skipped + text.len() < self.text.chars().count();
        if let Some(first) = text.first_mut().filter(|_| skipped > 0) {
            *first = '…';
        }
        if let Some(last) = text.last_mut().filter(|_| cut) {
            *last = '…';
        }
        (before - skipped, text.into_iter().collect())
    }
}

impl fmt::Display for Excerpt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Tabs are repeated under the line, so that the mark stands below its text at any tab width.
        let (before, text) = self.shown();
        let lead: String = text.chars().take(before).collect();
        let lead = lead.replace(|c: char| c != '\t', " ");
        let number = self.line.to_string();
        let margin = " ".repeat(number.len());
        let marks = self.width.min(text.chars().count().saturating_sub(before));
        writeln!(f, " {margin} |")?;
        writeln!(f, " {number} | {text}")?;
        write!(f, " {margin} | {lead}{}", "^".repeat(marks.max(1)))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::file::decode::fault::{Address, Excerpt, Fault, shortened};

    #[test]
    fn display_underlines_the_place() {
        let text = "version = 1\n\tpitch_µm = -3 # µm\n";
        let start = text.find("-3").unwrap_or(0);
        let address = Address {
            file: "demo.toml".into(),
            path: "pitch_µm".into(),
            excerpt: Some(Excerpt::new(text, start..start + 2)),
        };
        let fault = Fault::at(address, "-3", "a positive number").hint("remove the sign");
        assert_eq!(
            fault.to_string(),
            "demo.toml:2:13: pitch_µm: found -3, expected a positive number\n   |\n \
             2 | \tpitch_µm = -3 # µm\n   | \t           ^^\nhint: remove the sign"
        );
    }

    #[test]
    fn excerpt_survives_any_range() {
        let text = "a\r\nµ\n";
        for start in 0..=text.len() + 2 {
            for end in 0..=text.len() + 2 {
                let excerpt = Excerpt::new(text, start..end);
                assert!(excerpt.width >= 1 && excerpt.column >= 1);
            }
        }
        assert_eq!(Excerpt::new(text, 0..4).width, 1);
    }

    #[test]
    fn long_lines_are_cut_around_the_place() {
        let text = "x".repeat(5000);
        for (start, end) in [
            (0, 5000),
            (150, 151),
            (158, 170),
            (2500, 2503),
            (4999, 5000),
        ] {
            let excerpt = Excerpt::new(&text, start..end).to_string();
            let lines: Vec<&str> = excerpt.lines().collect();
            assert_eq!(lines.len(), 3);
            assert!(lines.iter().all(|line| line.chars().count() <= 165));
            let (shown, marks) = (lines[1].chars().count(), lines[2].chars().count());
            assert!(marks <= shown && lines[2].contains('^'), "{excerpt}");
        }
    }

    #[test]
    fn messages_are_short_whatever_was_found() {
        let long = "µ".repeat(100_000);
        let found = Fault::of_file(Path::new("a"), &*long, &*long).to_string();
        assert!(found.chars().count() < 2200 && found.contains("(100000 characters)"));
        assert_eq!(shortened("short"), "short");
        assert!(shortened(&long).chars().count() < 230);
    }

    #[test]
    fn whole_file_has_no_line() {
        let fault = Fault::of_file(Path::new("a.npy"), "no such file", "a readable file");
        assert_eq!(
            fault.to_string(),
            "a.npy: found no such file, expected a readable file"
        );
    }
}
