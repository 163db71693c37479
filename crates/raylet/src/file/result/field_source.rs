//! Fields that a user names: those of a folder of results, a field.npz, a FITS or HDF5 file, or a beam file (.zbf).

use std::path::{Path, PathBuf};

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npz::Fields;
use crate::file::beams::field_file::FieldFormat;
use crate::file::beams::zbf_fields::{BeamChoices, read_zbf};
use crate::file::decode::fault::Fault;
use crate::file::fabrication::export::has_extension;
use crate::file::fabrication::export_report::ExportReport;
use crate::file::result::result_folder::FIELD_FILE;

/// How far positions in mm of one grid may lie from equal steps.
const TOLERANCE: f64 = 1e-9;

/// Fields and where they were found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FieldSource {
    /// The file.
    pub(crate) path: PathBuf,
    /// The fields on equal steps.
    pub(crate) fields: Fields,
    /// What a beam file says; empty for other files.
    pub(crate) report: ExportReport,
}

impl FieldSource {
    /// Reads the fields.
    ///
    /// # Errors
    /// A file that cannot be used, arrays beyond the limit, or positions with unequal steps.
    pub(crate) fn read(
        path: &Path,
        choices: BeamChoices,
        limit: MemoryLimit,
    ) -> Result<Self, Fault> {
        let path = match path.is_dir() {
            true => path.join(FIELD_FILE),
            false => path.to_path_buf(),
        };
        let format = FieldFormat::of(&path).unwrap_or(FieldFormat::Npz);
        let (fields, report) = match has_extension(&path, "zbf") {
            true => read_zbf(&path, choices, limit)?,
            false => (format.read(&path, limit)?, ExportReport::default()),
        };
        for (name, axis) in [("x_mm", &fields.x_mm), ("y_mm", &fields.y_mm)] {
            let step = (axis[axis.len() - 1] - axis[0]) / (axis.len().max(2) - 1) as f64;
            let even = |(i, p): (usize, &f64)| (p - axis[0] - i as f64 * step).abs() <= TOLERANCE;
            if !axis.iter().enumerate().all(even) {
                let found = format!("`{name}` with unequal steps");
                return Err(Fault::of_file(&path, found, "equally spaced positions"));
            }
        }
        Ok(Self {
            path,
            fields,
            report,
        })
    }
}
