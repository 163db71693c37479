//! Fields from one kind of file to another: folders of results, field.npz, beam files (.zbf).

use std::io::{BufWriter, Write};
use std::path::Path;

use ndarray::Axis;

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npz::Fields;
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

/// Writes the fields of a source to a file .zbf or .npz, and reports what it holds.
///
/// # Errors
/// A source that cannot be used, choices that do not fit, or a file that may not be replaced or cannot be written.
pub fn convert_field(
    source: &Path,
    target: &Path,
    choices: &ConversionChoices,
) -> Result<ExportReport, Fault> {
    let to_beam = has_extension(target, "zbf");
    if !to_beam && !has_extension(target, "npz") {
        let found = format!("the name {}", target.display());
        return Err(Fault::of_file(
            target,
            found,
            "a name ending in .zbf or .npz",
        ));
    }
    // A place that cannot be written is refused before the work begins.
    let file = OwnFile::claim(target, Replace::any_if(choices.overwrite))?;
    let FieldSource {
        path,
        fields,
        mut report,
    } = FieldSource::read(source, choices.beam, choices.limit)?;
    let chosen = channel(&path, &fields, choices.wavelength)?;
    if to_beam {
        let k = match (chosen, fields.wavelength_um.len()) {
            (Some(k), _) => k,
            (None, 1) => 0,
            (None, count) => {
                let found = format!("{count} wavelengths: {} µm", fields.wavelength_um);
                let expected = "one of them, by --wavelength N from 1: a beam file has one";
                return Err(Fault::of_file(&path, found, expected));
            }
        };
        let plan = BeamPlan::new(&path, &fields, k)?;
        file.fill(|file| plan.write(BufWriter::with_capacity(1 << 20, file)))?;
        let written = plan.report();
        report.lines.extend(written.lines);
        report.lost.extend(written.lost);
        report.numbers.extend(written.numbers);
        return Ok(report);
    }
    let fields = match chosen {
        Some(k) => only(&fields, k),
        None => fields,
    };
    file.fill(|mut file| {
        fields.write_npz(&mut file)?;
        file.flush()
    })?;
    let (channels, ny, nx) = fields.field.dim();
    report.line(
        "Field",
        format!("{channels} x {ny} x {nx} amplitudes [wavelength, y, x]"),
    );
    Ok(report)
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
