//! Files that Python writes: complete or not at all, and never in place of files that raylet did not write.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use raylet::file::decode::fault::Fault;
use raylet::file::storage::own_file::{OwnFile, Replace};

use crate::refusal::fault;

/// Writes files; all are checked before the first is written. Those that raylet did not write are replaced with
/// `overwrite` only.
#[pyfunction]
pub(crate) fn write_files(
    py: Python<'_>,
    files: Vec<(PathBuf, PyBackedBytes)>,
    overwrite: bool,
) -> PyResult<()> {
    let write = || -> Result<(), Fault> {
        let replace = Replace::any_if(overwrite);
        let claim = |(path, _): &(PathBuf, PyBackedBytes)| OwnFile::claim(path, replace);
        let claimed = files.iter().map(claim).collect::<Result<Vec<_>, _>>()?;
        let mut contents = claimed.iter().zip(&files);
        contents.try_for_each(|(file, (_, content))| file.write(content))
    };
    py.detach(write).map_err(|failure| fault(py, &failure))
}
