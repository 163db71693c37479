//! The bytes of a lens file on the disk.

use std::io::Read;
use std::path::Path;

use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;

/// The largest file that is read, in bytes.
pub(crate) const LARGEST: u64 = 20_000_000;

/// All bytes of a file; `what` says what it should be.
///
/// # Errors
/// A file that cannot be read or is larger than 20 MB.
pub(crate) fn bytes_of(path: &Path, what: &str) -> Result<Vec<u8>, Fault> {
    let refuse = |found: String| Fault::of_file(path, found, what);
    let file = regular_file::open(path).map_err(refuse)?;
    let mut bytes = Vec::new();
    let read = file.take(LARGEST + 1).read_to_end(&mut bytes);
    read.map_err(|error| refuse(error.to_string()))?;
    match bytes.len() as u64 > LARGEST {
        true => Err(refuse("a file larger than 20 MB".to_owned())),
        false => Ok(bytes),
    }
}
