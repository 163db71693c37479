//! The index of a folder of lens files as a file, so that only changed lens files are read again.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;
use crate::file::prescription::lens_library::lens_facts::LensFacts;
use crate::file::storage::own_file::{OwnFile, Replace};

/// The largest index that is read, in bytes.
const LARGEST: u64 = 500_000_000;

/// What an index is, in words.
const WHAT: &str = "an index of a folder of lens files that raylet wrote";

/// The version of the format.
const VERSION: u32 = 1;

/// What is known of a lens file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Indexed {
    /// Its size in bytes.
    pub size: u64,
    /// When it was changed, in ns since 1970.
    pub modified_ns: u64,
    /// Its facts, or why it has none.
    pub facts: Result<LensFacts, String>,
}

/// The files of a folder by their paths in it.
pub(crate) type Index = BTreeMap<String, Indexed>;

/// The index as it stands in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    raylet_lens_index: u32,
    files: Index,
}

/// Reads an index; an empty one where the file does not exist.
///
/// # Errors
/// A file that cannot be read, or is no index.
pub(crate) fn read_index(path: &Path) -> Result<Index, Fault> {
    if !path.exists() {
        return Ok(Index::new());
    }
    let refuse = |found: String| Fault::of_file(path, found, WHAT);
    let file = regular_file::open(path).map_err(refuse)?;
    let mut text = String::new();
    let read = file.take(LARGEST).read_to_string(&mut text);
    read.map_err(|error| refuse(error.to_string()))?;
    let written: Written =
        serde_json::from_str(&text).map_err(|error| refuse(error.to_string()))?;
    match written.raylet_lens_index == VERSION {
        true => Ok(written.files),
        false => Err(refuse(format!("version {}", written.raylet_lens_index))),
    }
}

/// Writes an index.
///
/// # Errors
/// A file that may not be replaced, or cannot be written.
pub(crate) fn write_index(path: &Path, index: &Index) -> Result<(), Fault> {
    let file = OwnFile::claim(path, Replace::Own)?;
    let written = Written {
        raylet_lens_index: VERSION,
        files: index.clone(),
    };
    let text = serde_json::to_string(&written)
        .map_err(|error| Fault::of_file(path, error.to_string(), WHAT))?;
    file.write(text.as_bytes())
}
