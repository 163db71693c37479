//! Lens files that are written, and lenses by name.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use raylet::file::decode::fault::Fault;
use raylet::file::prescription::export::lens_export::{
    LensExportChoices, export_lens as write_lens, export_lens_of,
};
use raylet::file::prescription::import_report::ImportReport;
use raylet::file::prescription::lens_library::lens_catalog::lenses;
use raylet::file::prescription::lens_library::lens_facts::LensFacts;
use raylet::file::prescription::lens_library::lens_folder::{LensFolder as Folder, LensSearch};

use crate::refusal::{error, fault};
use crate::scene::Scene;

/// The text of a report, its numbers by their names, and its warnings.
type Report = (String, Vec<(String, f64)>, Vec<String>);

/// Where a lens is found, and its facts as JSON.
type Row = (String, String);

/// Two numbers.
type Range = Option<(f64, f64)>;

/// Writes a scene as a lens file.
#[pyfunction]
pub(crate) fn export_lens(
    py: Python<'_>,
    scene: &Scene,
    target: PathBuf,
    skip_unknown: bool,
    overwrite: bool,
) -> PyResult<Report> {
    let choices = LensExportChoices {
        skip_unknown,
        overwrite,
    };
    let file = &*scene.file;
    report(py, py.detach(|| write_lens(file, &target, choices)))
}

/// Writes a scene file or another lens file as a lens file.
#[pyfunction]
pub(crate) fn export_lens_file(
    py: Python<'_>,
    source: PathBuf,
    target: PathBuf,
    skip_unknown: bool,
    overwrite: bool,
) -> PyResult<Report> {
    let choices = LensExportChoices {
        skip_unknown,
        overwrite,
    };
    report(py, py.detach(|| export_lens_of(&source, &target, choices)))
}

/// The lenses that raylet carries: part numbers, and facts as JSON.
#[pyfunction]
pub(crate) fn catalog(py: Python<'_>) -> PyResult<Vec<Row>> {
    let mut rows = Vec::new();
    for lens in lenses() {
        let facts = lens.facts().map_err(|failure| fault(py, &failure))?;
        rows.push((lens.part.to_owned(), text(py, &facts)?));
    }
    Ok(rows)
}

/// The lens files of a folder.
#[pyclass(frozen, module = "raylet._raylet")]
pub(crate) struct LensFolder(Folder);

#[pymethods]
impl LensFolder {
    /// Lists a folder and reads its lens files, those that an index has not.
    #[new]
    fn new(py: Python<'_>, path: PathBuf, index: Option<PathBuf>) -> PyResult<Self> {
        let opened = py.detach(|| Folder::open(&path, index.as_deref()));
        opened.map(Self).map_err(|failure| fault(py, &failure))
    }

    /// How many lens files it has, and how many of them were read now.
    fn counts(&self) -> (usize, usize) {
        (self.0.lenses.len(), self.0.read)
    }

    /// The files that could not be read, each with why.
    fn faults(&self) -> Vec<(String, String)> {
        let faults = self.0.faults();
        faults
            .map(|(path, fault)| (shown(path), fault.to_owned()))
            .collect()
    }

    /// The lenses that fit ranges of focal lengths, diameters and f-numbers, and words.
    fn search(
        &self,
        py: Python<'_>,
        ranges: (Range, Range, Range),
        maker: Option<String>,
        words: Option<String>,
    ) -> PyResult<Vec<Row>> {
        let pair = |range: Range| range.map(|(from, to)| [from, to]);
        let (focal_length, diameter, f_number) = ranges;
        let sought = LensSearch {
            focal_length_mm: pair(focal_length),
            diameter_mm: pair(diameter),
            f_number: pair(f_number),
            maker,
            text: words,
        };
        let found = self.0.search(&sought).into_iter();
        found
            .map(|(path, facts)| Ok((shown(path), text(py, facts)?)))
            .collect()
    }
}

fn shown(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

fn text(py: Python<'_>, facts: &LensFacts) -> PyResult<String> {
    serde_json::to_string(facts).map_err(|failure| error(py, failure))
}

fn report(py: Python<'_>, made: Result<ImportReport, Fault>) -> PyResult<Report> {
    let made = made.map_err(|failure| fault(py, &failure))?;
    let text = made.to_string();
    let numbers = made.numbers.into_iter();
    let numbers = numbers.filter_map(|number| Some((number.name, number.value?)));
    Ok((text, numbers.collect(), made.warnings))
}
