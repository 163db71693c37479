//! Folders of results: the document and the fields, written and read.

use std::path::Path;

use crate::file::fault::Fault;
use crate::file::folder::{Draft, RESULT_FILE};
use crate::file::npz::Fields;
use crate::file::report::{Report, VERSION};

/// The file that holds the fields.
pub const FIELD_FILE: &str = "field.npz";

/// What a folder of results holds beside its pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct ResultFolder {
    /// The document.
    pub report: Report,
    /// The fields on the sensor.
    pub fields: Fields,
}

impl ResultFolder {
    /// Writes field.npz and result.json; `report.files` should name everything else already.
    ///
    /// # Errors
    /// What the file system said.
    pub fn write(&self, draft: &Draft) -> Result<(), Fault> {
        draft.write(FIELD_FILE, &self.fields.to_npz()?)?;
        let text = serde_json::to_string_pretty(&self.report).map_err(|error| {
            let expected = "a document that JSON can hold";
            Fault::of_file(Path::new(RESULT_FILE), error.to_string(), expected)
        })?;
        draft.write(RESULT_FILE, format!("{text}\n").as_bytes())
    }

    /// Reads a folder of results.
    ///
    /// # Errors
    /// No such folder, a document of another version or kind, or fields that cannot be used.
    pub fn read(folder: &Path) -> Result<Self, Fault> {
        let path = folder.join(RESULT_FILE);
        let expected = "a folder of results with a result.json";
        let text = std::fs::read_to_string(&path)
            .map_err(|error| Fault::of_file(&path, error.to_string(), expected))?;

        // The version comes first: another one may differ in anything else.
        let refuse = |found: String, expected: &str| Fault::of_file(&path, found, expected);
        let document: serde_json::Value = serde_json::from_str(&text)
            .map_err(|error| refuse(error.to_string(), "a JSON document"))?;
        let expected = format!("version {VERSION}");
        match document.get("version").and_then(|v| v.as_u64()) {
            Some(version) if version == u64::from(VERSION) => {}
            Some(other) => return Err(refuse(format!("version {other}"), &expected)),
            None => return Err(refuse(String::from("no version"), &expected)),
        }
        let report = serde_path_to_error::deserialize(document)
            .map_err(|error| refuse(error.to_string(), "a document as raylet writes it"))?;
        Ok(Self {
            report,
            fields: Fields::read(&folder.join(FIELD_FILE))?,
        })
    }
}
