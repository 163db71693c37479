//! Measured maps, and fields of other programs.

use std::path::PathBuf;

use num_complex::Complex64;
use numpy::ndarray::{Ix1, Ix2, Ix3};
use pyo3::prelude::*;
use raylet::file::arrays::array::Array;
use raylet::file::arrays::memory::{MachineMemory, MemoryLimit};
use raylet::file::arrays::npz::Fields;
use raylet::file::beams::zbf_fields::BeamChoices;
use raylet::file::maps::map_file::{self, Fill, MapChoices};
use raylet::file::maps::map_unit::factor_for;
use raylet::file::result::conversion::{self, ConversionChoices};

use crate::refusal::{error, fault};
use crate::typed::{Given, Made};

/// A map: its real or its complex values, pitch, unit, quantity and doubts.
type Map<'py> = (
    Option<Made<'py, f64, Ix2>>,
    Option<Made<'py, Complex64, Ix2>>,
    Option<[f64; 2]>,
    Option<String>,
    String,
    Vec<String>,
);

/// A field [wavelength, y, x], x and y in mm, wavelengths in µm, and a report.
type Beam<'py> = (
    Made<'py, Complex64, Ix3>,
    Made<'py, f64, Ix1>,
    Made<'py, f64, Ix1>,
    Made<'py, f64, Ix1>,
    String,
);

/// The limit on memory of a file that is read.
fn limit() -> MemoryLimit {
    MemoryLimit {
        bytes: MachineMemory::now().usual_limit(),
        set_by: "half of the free memory",
    }
}

/// Reads a map; missing samples become `fill`, or the nearest other one.
#[pyfunction]
pub(crate) fn read_map<'py>(
    py: Python<'py>,
    path: PathBuf,
    key: Option<&str>,
    fill: Option<f64>,
    nearest: bool,
) -> PyResult<Map<'py>> {
    let fill = match nearest {
        true => Some(Fill::Nearest),
        false => fill.map(Fill::Value),
    };
    let limit = limit();
    let read = py.detach(|| map_file::read_map(&path, &MapChoices { key, fill, limit }));
    let map = read.map_err(|failure| fault(py, &failure))?;
    let (real, complex) = match map.values {
        Array::Real(values) => (Some(Made::with_gaps(py, values)), None),
        Array::Complex(values) => (None, Some(Made::with_gaps(py, values))),
    };
    let (pitch, unit) = (map.pitch_um, map.unit);
    Ok((real, complex, pitch, unit, map.quantity, map.doubts))
}

/// The factor from a unit to that of a key of a scene; None where they do not fit.
#[pyfunction]
pub(crate) fn unit_factor(unit: &str, key: &str) -> Option<f64> {
    factor_for(Some(unit), key).ok()
}

/// Reads a field.
#[pyfunction]
pub(crate) fn read_beam<'py>(
    py: Python<'py>,
    path: PathBuf,
    component: &str,
    sphere: bool,
) -> PyResult<Beam<'py>> {
    let second = match component {
        "x" => false,
        "y" => true,
        other => {
            let message = format!("component is \"{other}\", expected \"x\" or \"y\"");
            return Err(error(py, message));
        }
    };
    let choices = BeamChoices { second, sphere };
    let read = py.detach(|| conversion::read_field(&path, choices, limit()));
    let (fields, report) = read.map_err(|failure| fault(py, &failure))?;
    Ok((
        Made::new(py, fields.field)?,
        Made::new(py, fields.x_mm)?,
        Made::new(py, fields.y_mm)?,
        Made::new(py, fields.wavelength_um)?,
        report.to_string(),
    ))
}

/// Writes a field [wavelength, y, x], and gives the report.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "Python gives them one by one")]
pub(crate) fn write_beam(
    py: Python<'_>,
    field: Given<'_, Complex64, Ix3>,
    x_mm: Given<'_, f64, Ix1>,
    y_mm: Given<'_, f64, Ix1>,
    wavelength_um: Given<'_, f64, Ix1>,
    path: PathBuf,
    wavelength: Option<usize>,
    overwrite: bool,
) -> PyResult<String> {
    let fields = Fields {
        field: field.as_array().to_owned(),
        x_mm: x_mm.as_array().to_owned(),
        y_mm: y_mm.as_array().to_owned(),
        wavelength_um: wavelength_um.as_array().to_owned(),
    };
    let choices = ConversionChoices {
        wavelength,
        beam: BeamChoices::default(),
        overwrite,
        limit: limit(),
    };
    let written = py.detach(|| conversion::write_field(fields, &path, &choices));
    let report = written.map_err(|failure| fault(py, &failure))?;
    Ok(report.to_string())
}
