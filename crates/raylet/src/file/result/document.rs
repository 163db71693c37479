//! JSON documents whose numbers are all finite.
//!
//! JSON has no infinity and no NaN, and its writer puts `null` for them without an error. So a document is read again
//! after it is written: where it differs from what was meant, it is refused. What may be infinite, such as the radius
//! of a plane, is an `Option` that is `None`.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::file::decode::fault::Fault;

/// The text of a document, of several lines, for a file of this name.
///
/// # Errors
/// A number that is not finite, named by its path, or what JSON cannot hold.
pub fn text<T>(document: &T, name: &str) -> Result<String, Fault>
where
    T: Serialize + DeserializeOwned + PartialEq,
{
    let refuse = |found: String, expected: &str| Fault::of_file(Path::new(name), found, expected);
    let text = serde_json::to_string_pretty(document)
        .map_err(|error| refuse(error.to_string(), "a document that JSON can hold"))?;
    let read = &mut serde_json::Deserializer::from_str(&text);
    let again: T = serde_path_to_error::deserialize(read).map_err(|error| {
        let found = format!("a number at {} that is not finite", error.path());
        refuse(found, "finite numbers only")
    })?;
    match again == *document {
        true => Ok(text),
        false => Err(refuse(
            String::from("a number that is not finite"),
            "finite numbers only",
        )),
    }
}

#[cfg(test)]
mod tests {
    use serde::{Deserialize, Serialize};

    use crate::file::result::document::text;

    #[derive(Serialize, Deserialize, PartialEq)]
    struct Spot {
        width: Option<f64>,
        sums: Vec<f64>,
    }

    #[test]
    fn numbers_that_are_not_finite_are_refused_at_their_path() {
        let written = |width, sums: &[f64]| {
            let sums = sums.to_vec();
            text(&Spot { width, sums }, "spot.json").map_err(|fault| fault.to_string())
        };
        assert!(written(None, &[0.1, 5e-324, -1.7e308]).is_ok());
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let fault = written(Some(1.0), &[0.0, bad]).unwrap_err();
            assert!(
                fault.contains("spot.json") && fault.contains("sums[1]"),
                "{fault}"
            );
            assert!(written(Some(bad), &[]).is_err());
        }
    }
}
