//! Fields from one kind of file to another: folders of results, field.npz, FITS, HDF5, beam files (.zbf).

use std::io::BufWriter;
use std::path::Path;

use ndarray::Axis;

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npz::Fields;
use crate::file::beams::field_file::FieldFormat;
use crate::file::beams::zbf_fields::BeamChoices;
use crate::file::beams::zbf_writer::BeamPlan;
use crate::file::decode::fault::Fault;
use crate::file::fabrication::export::has_extension;
use crate::file::fabrication::export_report::ExportReport;
use crate::file::result::field_source::FieldSource;
use crate::file::storage::own_file::{OwnFile, Replace};

/// What a user chooses for a conversion.
#[derive(Clone, Copy, Debug)]
pub struct ConversionChoices {
    /// Number of the wavelength, from 1; all of them, or the only one, where there is none.
    pub wavelength: Option<usize>,
    /// What is taken of a beam file.
    pub beam: BeamChoices,
    /// Replaces a file that raylet did not write, or that was changed since.
    pub overwrite: bool,
    /// The most memory that the fields may take.
    pub limit: MemoryLimit,
}

/// Reads the fields of a source and what it says of them.
///
/// # Errors
/// A source that cannot be used, or arrays beyond the limit.
pub fn read_field(
    source: &Path,
    choices: BeamChoices,
    limit: MemoryLimit,
) -> Result<(Fields, ExportReport), Fault> {
    let read = FieldSource::read(source, choices, limit)?;
    Ok((read.fields, read.report))
}

/// Writes fields to a file .zbf, .npz, .fits or .h5, and reports what it holds.
///
/// # Errors
/// Fields that no file could give back, choices that do not fit, or a file that may not be replaced or cannot be
/// written.
pub fn write_field(
    fields: Fields,
    target: &Path,
    choices: &ConversionChoices,
) -> Result<ExportReport, Fault> {
    let target = Target::claim(target, choices.overwrite)?;
    fields.check_for(target.file.path())?;
    let source = FieldSource {
        path: target.file.path().to_path_buf(),
        fields,
        report: ExportReport::default(),
    };
    target.put(source, choices.wavelength)
}

/// Writes the fields of a source to a file .zbf, .npz, .fits or .h5, and reports what it holds.
///
/// # Errors
/// A source that cannot be used, choices that do not fit, or a file that may not be replaced or cannot be written.
pub fn convert_field(
    source: &Path,
    target: &Path,
    choices: &ConversionChoices,
) -> Result<ExportReport, Fault> {
    // A place that cannot be written is refused before the work begins.
    let target = Target::claim(target, choices.overwrite)?;
    let source = FieldSource::read(source, choices.beam, choices.limit)?;
    target.put(source, choices.wavelength)
}

/// A file that is to be written, and its format; a beam file where there is none.
struct Target {
    format: Option<FieldFormat>,
    file: OwnFile,
}

impl Target {
    fn claim(path: &Path, overwrite: bool) -> Result<Self, Fault> {
        let format = FieldFormat::of(path);
        if format.is_none() && !has_extension(path, "zbf") {
            let found = format!("the name {}", path.display());
            let expected = "a name ending in .zbf, .npz, .fits or .h5";
            return Err(Fault::of_file(path, found, expected));
        }
        let file = OwnFile::claim(path, Replace::any_if(overwrite))?;
        Ok(Self { format, file })
    }

    /// Writes the fields, or the chosen wavelength alone.
    fn put(&self, source: FieldSource, wavelength: Option<usize>) -> Result<ExportReport, Fault> {
        let FieldSource {
            path,
            fields,
            mut report,
        } = source;
        let chosen = channel(&path, &fields, wavelength)?;
        let Some(format) = self.format else {
            let written = self.put_beam(&path, &fields, chosen)?;
            report.lines.extend(written.lines);
            report.lost.extend(written.lost);
            report.numbers.extend(written.numbers);
            return Ok(report);
        };
        let fields = match chosen {
            Some(k) => only(&fields, k),
            None => fields,
        };
        format.write(&self.file, &fields)?;
        let (channels, ny, nx) = fields.field.dim();
        report.line(
            "Field",
            format!("{channels} x {ny} x {nx} amplitudes [wavelength, y, x]"),
        );
        Ok(report)
    }

    /// Writes a beam file, which holds one wavelength.
    fn put_beam(
        &self,
        path: &Path,
        fields: &Fields,
        chosen: Option<usize>,
    ) -> Result<ExportReport, Fault> {
        let k = match (chosen, fields.wavelength_um.len()) {
            (Some(k), _) => k,
            (None, 1) => 0,
            (None, count) => {
                let found = format!("{count} wavelengths: {} µm", fields.wavelength_um);
                let expected = "one of them, by --wavelength N from 1: a beam file has one";
                return Err(Fault::of_file(path, found, expected));
            }
        };
        let plan = BeamPlan::new(path, fields, k)?;
        self.file
            .fill(|file| plan.write(BufWriter::with_capacity(1 << 20, file)))?;
        Ok(plan.report())
    }
}

/// The index of the chosen wavelength.
fn channel(path: &Path, fields: &Fields, number: Option<usize>) -> Result<Option<usize>, Fault> {
    let count = fields.wavelength_um.len();
    match number {
        Some(number) if !(1..=count).contains(&number) => {
            let found = format!("wavelength {number} of {count}");
            Err(Fault::of_file(
                path,
                found,
                format!("a number from 1 to {count}"),
            ))
        }
        Some(number) => Ok(Some(number - 1)),
        None => Ok(None),
    }
}

/// One channel alone.
fn only(fields: &Fields, k: usize) -> Fields {
    Fields {
        field: fields
            .field
            .index_axis(Axis(0), k)
            .insert_axis(Axis(0))
            .to_owned(),
        x_mm: fields.x_mm.clone(),
        y_mm: fields.y_mm.clone(),
        wavelength_um: fields.wavelength_um.select(Axis(0), &[k]),
    }
}
