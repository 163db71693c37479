//! A beam as raylet's field: axes, scale, phase.
//!
//! raylet's field u varies as exp(+ikz); samples E of beam files are conjugate, and |E|² is the power of a sample. So
//! u = conj(E) / √(dx dy). The sample n/2, from 0, lies at x = 0 or y = 0.

use std::f64::consts::TAU;
use std::path::Path;

use ndarray::{Array1, Axis};
use num_complex::Complex64;

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npz::Fields;
use crate::file::beams::zbf_header::Header;
use crate::file::beams::zbf_reader::{Beam, read_beam};
use crate::file::decode::fault::Fault;
use crate::file::fabrication::export_report::{ExportReport, short};

/// What a user chooses of a beam file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BeamChoices {
    /// Takes Ey in place of Ex.
    pub second: bool,
    /// Adds the phase of the reference sphere of the pilot beam.
    pub sphere: bool,
}

/// Reads a beam file as a field of raylet, and reports what it says.
///
/// # Errors
/// A file that is not a beam file or does not fit into the limit, or values that no light has.
pub fn read_zbf(
    path: &Path,
    choices: BeamChoices,
    limit: MemoryLimit,
) -> Result<(Fields, ExportReport), Fault> {
    let beam = read_beam(path, choices.second, limit)?;
    let refuse = |(found, expected): (String, String)| Fault::of_file(path, found, expected);
    let mut report = ExportReport::default();
    report_beam(&mut report, &beam, choices.second);
    let radius = reference(&beam.header, choices.sphere).map_err(refuse)?;
    report_phase(&mut report, &beam.header, radius);
    let fields = fields_of(beam, radius);
    fields.check_for(path)?;
    Ok((fields, report))
}

/// The radius of the sphere whose phase is to be added, if any, as the header and the choice say.
fn reference(header: &Header, wanted: bool) -> Result<Option<f64>, (String, String)> {
    let [x, y] = header.pilot.map(|pilot| pilot.radius());
    match (x, y) {
        _ if !wanted => Ok(None),
        (Some(x), Some(y)) if (x - y).abs() <= 1e-12 * x.abs() => Ok(Some(x)),
        (None, None) => Ok(None),
        (x, y) => {
            let radius = |r: Option<f64>| r.map_or(String::from("none"), short);
            let found = format!("reference radii of {} mm and {} mm", radius(x), radius(y));
            let expected = "the same along x and y; without --sphere phases stay as they are";
            Err((found, expected.to_owned()))
        }
    }
}

/// The field, on the axes of the file.
fn fields_of(beam: Beam, radius: Option<f64>) -> Fields {
    let Beam {
        header,
        mut samples,
        ..
    } = beam;
    let axis = |count: u32, step: f64| -> Array1<f64> {
        let middle = f64::from(count / 2);
        (0..count).map(|i| (f64::from(i) - middle) * step).collect()
    };
    let ([nx, ny], [dx, dy]) = (header.size, header.step_mm);
    let (x_mm, y_mm) = (axis(nx, dx), axis(ny, dy));
    let scale = header.scale();
    samples.mapv_inplace(|e| e.conj() / scale);

    // A wave from a point behind (R > 0) has exp(+ikr) with the distance r from it.
    if let Some(radius) = radius {
        let k = TAU / header.wavelength_mm;
        for (row, y) in samples.rows_mut().into_iter().zip(&y_mm) {
            for (value, x) in row.into_iter().zip(&x_mm) {
                let square = x * x + y * y;
                let path = square / ((radius * radius + square).sqrt() + radius.abs());
                *value *= Complex64::cis(k * path * radius.signum());
            }
        }
    }
    Fields {
        field: samples.insert_axis(Axis(0)),
        x_mm,
        y_mm,
        wavelength_um: Array1::from_elem(1, header.vacuum_um()),
    }
}

/// Reports what the file holds.
fn report_beam(report: &mut ExportReport, beam: &Beam, second: bool) {
    let Header { size, step_mm, .. } = &beam.header;
    let header = &beam.header;
    report.line(
        "Beam",
        format!(
            "version {}, {} x {} samples of {} x {} mm, unit {}",
            header.version,
            size[0],
            size[1],
            short(step_mm[0]),
            short(step_mm[1]),
            header.unit
        ),
    );
    report.line(
        "Wavelength",
        format!(
            "{} µm in vacuum, index {}",
            short(header.vacuum_um()),
            short(header.index)
        ),
    );
    let [x, y] = header.pilot;
    let pilot = |values: [f64; 2]| values.map(short).join(", ");
    report.line(
        "Pilot beam (x, y)",
        format!(
            "waist {} mm, Rayleigh range {} mm, {} mm behind the waist",
            pilot([x.waist, y.waist]),
            pilot([x.rayleigh, y.rayleigh]),
            pilot([x.z, y.z])
        ),
    );
    let power: f64 = beam.samples.iter().map(Complex64::norm_sqr).sum();
    let scale = short(header.scale());
    let name = if second { "Ey" } else { "Ex" };
    report.line(
        "Scale",
        format!("amplitude = {name} / {scale} mm, since |{name}|² is the power of a sample"),
    );
    report.line("Power", format!("{} (the sum of |{name}|²)", short(power)));
    report.number("power", power);
    report.number("wavelength_um", header.vacuum_um());
    if header.polarised {
        let other = if second { "Ex" } else { "Ey" };
        let all = power + beam.other_power;
        let share = if all > 0.0 {
            beam.other_power / all
        } else {
            0.0
        };
        report.number("share_left_out", share);
        let percent = short(100.0 * share);
        let text = format!("{other}, with {percent} % of the power: raylet's waves are scalar");
        report.lost.push(text);
    }
    let lost = "the pilot beam, the index of the medium and the efficiencies of fibres";
    report.lost.push(lost.to_owned());
}

/// Reports what phases are relative to.
fn report_phase(report: &mut ExportReport, header: &Header, added: Option<f64>) {
    let [x, y] = header.pilot.map(|pilot| pilot.radius());
    let relative = match (added, x, y) {
        (Some(radius), _, _) => format!("that of the sphere of radius {} mm added", short(radius)),
        (None, None, None) => String::from("relative to a plane"),
        (None, x, y) => {
            let radius = |r: Option<f64>| r.map_or(String::from("none"), short);
            format!(
                "as in the file, most likely relative to a sphere of radius {} mm along x, {} mm along y: --sphere adds it",
                radius(x),
                radius(y)
            )
        }
    };
    report.line("Phase", format!("conjugated, as exp(+ikz); {relative}"));
}
