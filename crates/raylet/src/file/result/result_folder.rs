//! Folders of results: the document and the fields, written and read.

use std::path::Path;

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npz::Fields;
use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;
use crate::file::result::document;
use crate::file::result::report::{Report, VERSION};
use crate::file::storage::folder::{Draft, RESULT_FILE};

/// The file that holds the fields.
pub const FIELD_FILE: &str = "field.npz";

/// The largest document of results that is read, in bytes. As a tree of values it takes up to 16 times as much memory.
const LARGEST_DOCUMENT: u64 = 16_000_000;

/// What a folder of results holds beside its pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct ResultFolder {
    /// The document.
    pub report: Report,
    /// The fields on the sensor.
    pub fields: Fields,
}

impl ResultFolder {
    /// Writes field.npz and result.json, and gives the folder its name; `report.files` should name everything else
    /// already.
    ///
    /// # Errors
    /// Fields or numbers that are not finite, or an error of the file system.
    pub fn publish(&self, mut draft: Draft) -> Result<(), Fault> {
        draft.fill(FIELD_FILE, &|file| self.fields.write_npz(file))?;
        draft.publish(&document::text(&self.report, RESULT_FILE)?)
    }

    /// Reads a folder of results.
    ///
    /// # Errors
    /// No such folder, a document of another version or kind, or fields that cannot be used.
    pub fn read(folder: &Path) -> Result<Self, Fault> {
        let path = folder.join(RESULT_FILE);
        let expected = "a folder of results with a result.json";
        let text = regular_file::read_text(&path, LARGEST_DOCUMENT)
            .map_err(|found| Fault::of_file(&path, found, expected))?;

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
        let report: Report = serde_path_to_error::deserialize(document)
            .map_err(|error| refuse(error.to_string(), "a document as raylet writes it"))?;
        let limit = MemoryLimit::of_settings((report.settings.memory_limit_mb * 1e6) as u64);
        let fields = Fields::read(&folder.join(FIELD_FILE), limit)?;
        Ok(Self { report, fields })
    }
}
