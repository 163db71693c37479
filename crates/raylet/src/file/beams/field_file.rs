//! Fields in files that keep every digit: .npz, FITS, HDF5.

use std::io::{BufWriter, Write};
use std::path::Path;

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npz::Fields;
use crate::file::beams::fits_fields::{read_fits_fields, write_fits};
use crate::file::beams::hdf5_fields::{read_hdf5_fields, write_hdf5};
use crate::file::decode::fault::Fault;
use crate::file::storage::own_file::OwnFile;

/// Bytes that are gathered before they go to the disk.
const BUFFER: usize = 1 << 20;

/// A format of whole fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FieldFormat {
    Npz,
    Fits,
    Hdf5,
}

impl FieldFormat {
    /// The format of a file of this name.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let end = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match end.as_str() {
            "npz" => FieldFormat::Npz,
            "fits" | "fit" | "fts" => FieldFormat::Fits,
            "h5" | "hdf5" => FieldFormat::Hdf5,
            _ => return None,
        })
    }

    /// Reads fields.
    ///
    /// # Errors
    /// A file that cannot be used, or arrays beyond the limit.
    pub(crate) fn read(self, path: &Path, limit: MemoryLimit) -> Result<Fields, Fault> {
        match self {
            FieldFormat::Npz => Fields::read(path, limit),
            FieldFormat::Fits => read_fits_fields(path, limit),
            FieldFormat::Hdf5 => read_hdf5_fields(path, limit),
        }
    }

    /// Writes fields.
    ///
    /// # Errors
    /// A file that may not be replaced, or an error of the file system.
    pub(crate) fn write(self, file: &OwnFile, fields: &Fields) -> Result<(), Fault> {
        file.fill(|file| {
            if self == FieldFormat::Npz {
                fields.write_npz(&mut *file)?;
                return file.flush();
            }
            let mut out = BufWriter::with_capacity(BUFFER, file);
            match self {
                FieldFormat::Fits => write_fits(fields, &mut out)?,
                _ => write_hdf5(fields, &mut out)?,
            }
            out.flush()
        })
    }
}
