//! Elements as files that foundries and other programs take.

use std::path::{Path, PathBuf};

use numpy::ndarray::{Array2, Ix2};
use pyo3::prelude::*;
use raylet::file::decode::fault::Fault;
use raylet::file::fabrication::export::{ExportSource, export_element};
use raylet::file::fabrication::export_choices::ExportChoices;
use raylet::file::fabrication::export_report::ExportReport;
use raylet::file::fabrication::gds::gds_reader;

use crate::arrays::guard;
use crate::refusal::{error, fault};
use crate::scene::Scene;
use crate::typed::{ByPath, Made};

/// The text of a report, and its numbers by their names.
type Report = (String, Vec<(String, f64)>);

/// Exports the element of a file; `choices` is JSON.
#[pyfunction]
pub(crate) fn export_file(
    py: Python<'_>,
    source: PathBuf,
    target: PathBuf,
    choices: &str,
) -> PyResult<Report> {
    let choices = parsed(py, choices)?;
    let made = py.detach(|| export_element(ExportSource::File(&source), &target, &choices));
    report(py, made)
}

/// Exports the cells of an array of float64 or complex128.
#[pyfunction]
pub(crate) fn export_array(
    py: Python<'_>,
    array: &Bound<'_, PyAny>,
    target: PathBuf,
    choices: &str,
) -> PyResult<Report> {
    let choices = parsed(py, choices)?;
    let guard = guard("source", array)?;
    let source = ExportSource::Array(guard.borrowed());
    let made = py.detach(|| export_element(source, &target, &choices));
    report(py, made)
}

/// Exports an element of a scene, some of whose arrays are in memory.
#[pyfunction]
pub(crate) fn export_scene(
    py: Python<'_>,
    scene: &Scene,
    arrays: ByPath<'_>,
    target: PathBuf,
    choices: &str,
) -> PyResult<Report> {
    let choices = parsed(py, choices)?;
    let made = scene.with_arrays(py, &arrays, |file, arrays| {
        export_element(ExportSource::Scene(file, arrays), &target, &choices)
    })?;
    report(py, Ok(made))
}

/// The levels [y, x] of a mask file, and their number.
#[pyfunction]
pub(crate) fn read_masks<'py>(
    py: Python<'py>,
    path: PathBuf,
    choices: &str,
) -> PyResult<(Made<'py, i64, Ix2>, u16)> {
    let choices = parsed(py, choices)?;
    let read = py.detach(|| gds_reader::read_masks(Path::new(&path), &choices));
    let read = read.map_err(|failure| fault(py, &failure))?;
    let [nx, ny] = read.size;
    let levels = read.levels.into_iter().map(i64::from).collect();
    let levels = Array2::from_shape_vec((ny, nx), levels);
    let levels = levels.map_err(|failure| error(py, failure))?;
    Ok((Made::new(py, levels)?, read.count))
}

fn parsed(py: Python<'_>, choices: &str) -> PyResult<ExportChoices> {
    serde_json::from_str(choices).map_err(|failure| error(py, failure))
}

fn report(py: Python<'_>, made: Result<ExportReport, Fault>) -> PyResult<Report> {
    let made = made.map_err(|failure| fault(py, &failure))?;
    let text = made.to_string();
    Ok((text, made.numbers.into_iter().collect()))
}
