//! What goes wrong while a value of a tree is turned into a Rust one, before it has its full address.

use std::fmt;
use std::ops::Range;

use serde::de::{self, Expected, Unexpected};

use crate::file::decode::fault::{Fault, shortened};
use crate::file::decode::origin::Origin;

/// A value that does not fit. It gathers its path on the way out and becomes a [`Fault`] at the root.
#[derive(Debug)]
pub(crate) struct DecodeError {
    found: String,
    expected: String,
    hint: Option<String>,
    /// Steps from the innermost outwards, such as `.radius_mm`, `[2]`, `.element`.
    path: Vec<String>,
    span: Option<Range<usize>>,
}

impl DecodeError {
    /// An error without a place yet.
    pub(crate) fn new(found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self {
            found: found.into(),
            expected: expected.into(),
            hint: None,
            path: Vec::new(),
            span: None,
        }
    }

    /// Placed at these bytes, if there are any, unless an inner value has placed it already.
    pub(crate) fn at(mut self, span: &Option<Range<usize>>) -> Self {
        self.span = self.span.or_else(|| span.clone());
        self
    }

    /// Met below this key.
    pub(crate) fn below_key(mut self, key: &str) -> Self {
        self.path.push(format!(".{}", shortened(key)));
        self
    }

    /// Met at this place of a list.
    pub(crate) fn below_index(mut self, index: usize) -> Self {
        self.path.push(format!("[{index}]"));
        self
    }

    /// The fault with its full address. A value that stood in no text is looked up by its path.
    pub(crate) fn into_fault(self, origin: &Origin) -> Fault {
        let path: String = self.path.iter().rev().map(String::as_str).collect();
        let path = path.trim_start_matches('.').to_owned();
        let fault = match self.span {
            Some(span) => {
                let address = origin.address(path, Some(span));
                Fault::at(address, self.found, self.expected)
            }
            None => origin.fault(&path, self.found, self.expected),
        };
        Fault {
            hint: self.hint,
            ..fault
        }
    }
}

/// "one of `a`, `b`, `c`", or "`a`" alone.
pub(crate) fn one_of(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.as_slice() {
        [] => "nothing".to_owned(),
        [only] => only.clone(),
        many => format!("one of {}", many.join(", ")),
    }
}

/// The longest name, in bytes, that is compared with known ones.
const LONGEST_GUESS: usize = 200;

/// The known name nearest to a given one, if any is near enough to be meant.
pub(crate) fn nearest<'n>(given: &str, known: &[&'n str]) -> Option<&'n str> {
    // Nobody means a known name by a very long one, and likeness costs the product of the lengths.
    if given.len() > LONGEST_GUESS {
        return None;
    }
    let given = given.to_lowercase();
    known
        .iter()
        .map(|&name| (strsim::jaro_winkler(&given, &name.to_lowercase()), name))
        .filter(|&(likeness, _)| likeness > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// A hint that names the nearest known name.
fn guess(given: &str, known: &[&str]) -> Option<String> {
    nearest(given, known).map(|name| format!("did you mean `{name}`?"))
}

/// What was found, in the words of the file rather than of Rust.
fn found(unexpected: &Unexpected<'_>) -> String {
    match unexpected {
        Unexpected::Bool(value) => value.to_string(),
        Unexpected::Unsigned(value) => value.to_string(),
        Unexpected::Signed(value) => value.to_string(),
        // With its point or exponent, so that 1e9 does not look like a whole number.
        Unexpected::Float(value) => format!("{value:?}"),
        Unexpected::Str(value) => format!("the string \"{}\"", shortened(value)),
        Unexpected::Seq => "a list".to_owned(),
        Unexpected::Map => "a table".to_owned(),
        other => shortened(&other.to_string()),
    }
}

/// What was expected, in the words of the file rather than of Rust.
fn expected(expectation: &dyn Expected) -> String {
    let text = expectation.to_string();
    match text.as_str() {
        "f64" => "a number".to_owned(),
        "u8" | "u32" | "u64" | "usize" => "a whole number, not negative".to_owned(),
        "i32" => format!("a whole number from {} to {}", i32::MIN, i32::MAX),
        "i64" => "a whole number".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a sequence" => "a list".to_owned(),
        "path string" => "a file name".to_owned(),
        _ if text.starts_with("struct ") => "a table".to_owned(),
        _ => match text.strip_prefix("an array of length ") {
            Some(length) => format!("a list of {length} values"),
            None => text,
        },
    }
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "found {}, expected {}", self.found, self.expected)
    }
}

impl std::error::Error for DecodeError {}

impl de::Error for DecodeError {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new(message.to_string(), "another value")
    }

    fn invalid_type(unexpected: Unexpected<'_>, expectation: &dyn Expected) -> Self {
        Self::new(found(&unexpected), expected(expectation))
    }

    fn invalid_value(unexpected: Unexpected<'_>, expectation: &dyn Expected) -> Self {
        Self::new(found(&unexpected), expected(expectation))
    }

    fn invalid_length(length: usize, expectation: &dyn Expected) -> Self {
        let found = match length {
            0 => "an empty list".to_owned(),
            1 => "a list of 1 value".to_owned(),
            _ => format!("a list of {length} values"),
        };
        Self::new(found, expected(expectation))
    }

    fn unknown_variant(variant: &str, known: &'static [&'static str]) -> Self {
        Self {
            hint: absent(variant).or_else(|| guess(variant, known)),
            ..Self::new(format!("\"{}\"", shortened(variant)), one_of(known))
        }
    }

    fn unknown_field(field: &str, known: &'static [&'static str]) -> Self {
        Self {
            hint: absent(field).or_else(|| guess(field, known)),
            ..Self::new(
                format!("an unknown key `{}`", shortened(field)),
                one_of(known),
            )
        }
    }

    fn missing_field(field: &'static str) -> Self {
        Self::new(format!("no `{field}`"), format!("the key `{field}` here"))
    }

    fn duplicate_field(field: &'static str) -> Self {
        Self::new(format!("`{field}` twice"), "it once")
    }
}

/// What raylet does not have, by the beginnings of keys and kinds that ask for it.
const ABSENT: [(&[&str], &str); 4] = [
    (
        &["polari", "jones", "stokes", "vector", "birefring"],
        "waves are scalar: there is no polarisation (docs/limits.md)",
    ),
    (
        &["coheren", "partial", "bandwidth", "spectrum"],
        "light is fully coherent, one wavelength at a time (docs/limits.md): add the intensities of several runs",
    ),
    (
        &["absor", "temperature", "thermal"],
        "media do not absorb, and have the temperature of their catalogue (docs/limits.md)",
    ),
    (
        &["image", "imaging", "psf", "mtf"],
        "there are no images of objects: a point spread function is the intensity of one run, an image a weighted sum of \
         runs (docs/limits.md)",
    ),
];

/// That raylet does not have what a key or a kind asks for.
fn absent(field: &str) -> Option<String> {
    let asked = |starts: &[&str]| starts.iter().any(|start| field.starts_with(start));
    let found = ABSENT.iter().find(|(starts, _)| asked(starts));
    found.map(|(_, text)| (*text).to_owned())
}

#[cfg(test)]
mod tests {
    use crate::file::decode::decode_error::{absent, nearest};

    #[test]
    fn keys_of_absent_physics_say_so() {
        assert!(absent("polarization").is_some_and(|text| text.contains("scalar")));
        assert!(absent("coherence_length").is_some_and(|text| text.contains("coherent")));
        assert!(absent("birefringence").is_some_and(|text| text.contains("scalar")));
        for key in ["image", "psf", "mtf_cutoff"] {
            assert!(absent(key).is_some_and(|text| text.contains("weighted sum of runs")));
        }
        assert_eq!(absent("pitch_um"), None);
    }

    #[test]
    fn nearest_key_is_the_one_a_person_would_guess() {
        let known = [
            "kind",
            "name",
            "thickness_mm",
            "radius_mm",
            "conic",
            "semi_aperture_mm",
            "glass",
        ];
        for (given, meant) in [
            ("radius", "radius_mm"),
            ("raduis_mm", "radius_mm"),
            ("thickness_um", "thickness_mm"),
            ("Glass", "glass"),
            ("conc", "conic"),
            ("semi_aperature_mm", "semi_aperture_mm"),
        ] {
            assert_eq!(nearest(given, &known), Some(meant), "{given}");
        }
        assert_eq!(nearest("wavelength", &known), None);
    }
}
