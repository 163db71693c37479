//! A scene as Python holds it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::Ix2;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use raylet::file::decode::fault::Fault;
use raylet::file::decode::origin::Origin;
use raylet::file::decode::tree::Value;
use raylet::file::model::build;
use raylet::file::model::scene_arrays::Arrays;
use raylet::file::prescription::import::{ImportChoices, import_lens};
use raylet::file::prescription::lens_library::lens_catalog::catalog_lens;
use raylet::file::scene::scene_file::Scene as File;
use raylet::file::scene::variable::with_settings;
use raylet::optics::system::System;

use crate::arrays::Lent;
use crate::document::entries;
use crate::refusal::{error, fault};
use crate::typed::{ByPath, Made, Named};
use crate::watch::pool;

/// An imported scene: its report, what may make it another lens, and its arrays by the paths of the fields that name them.
type ImportedScene<'py> = (
    Scene,
    String,
    Vec<String>,
    Vec<(String, Made<'py, f64, Ix2>)>,
);

/// A scene that was read; it never changes.
#[pyclass(frozen, module = "raylet._raylet")]
pub(crate) struct Scene {
    pub(crate) file: Arc<File>,
}

#[pymethods]
impl Scene {
    /// The scene of a document of plain values; messages call its file `name`, whose folder is that of its arrays.
    #[staticmethod]
    fn build(py: Python<'_>, document: Named<'_>, name: PathBuf) -> PyResult<Self> {
        let tree = Value::Table(entries(&document)?).into();
        let read = py.detach(|| File::from_tree(&tree, Origin::new("", &name)));
        Self::of(py, read)
    }

    /// The scene of a file, with every array that it names; those that a design may still have to make can be
    /// missing until they are needed.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let read = || {
            let bare = File::open(Path::new(&path))?;
            let designs = bare.hologram.is_some() || bare.design.is_some();
            match bare.clone().load() {
                Err(_) if designs => Ok(bare),
                loaded => loaded,
            }
        };
        Self::of(py, py.detach(read))
    }

    /// The scene of a lens file of another program, the report of what was changed and left out, what may make the
    /// scene another lens, and arrays that it names, by the paths of their fields. The numbers are those of the field,
    /// the wavelength and the configuration, from 1.
    #[staticmethod]
    fn import_lens<'py>(
        py: Python<'py>,
        path: PathBuf,
        numbers: (usize, Option<usize>, Option<usize>),
        skip_unknown: bool,
        glasses: BTreeMap<String, String>,
        glass_files: Vec<PathBuf>,
    ) -> PyResult<ImportedScene<'py>> {
        let (field, wavelength, configuration) = numbers;
        let choices = ImportChoices {
            field,
            wavelength,
            configuration,
            skip_unknown,
            glasses,
            glass_files,
        };
        let imported = py.detach(|| import_lens(&path, &choices));
        let imported = imported.map_err(|failure| fault(py, &failure))?;
        let (report, warnings) = (imported.report.to_string(), imported.report.warnings);
        let arrays = imported.arrays.iter().map(|array| {
            let values = Made::new(py, (*array.values).clone())?;
            Ok((array.field.clone(), values))
        });
        let arrays = arrays.collect::<PyResult<_>>()?;
        let scene = Self::of(py, Ok(imported.scene))?;
        Ok((scene, report, warnings, arrays))
    }

    /// The scene of a lens that raylet carries, by its part number, with the report and what may make it another lens.
    #[staticmethod]
    fn catalog_lens(
        py: Python<'_>,
        name: &str,
        numbers: (usize, Option<usize>),
    ) -> PyResult<(Self, String, Vec<String>)> {
        let (field, wavelength) = numbers;
        let choices = ImportChoices {
            field,
            wavelength,
            ..ImportChoices::default()
        };
        let lens = catalog_lens(name).map_err(|failure| error(py, failure))?;
        let imported = lens
            .import(&choices)
            .map_err(|failure| fault(py, &failure))?;
        let (report, warnings) = (imported.report.to_string(), imported.report.warnings);
        Ok((Self::of(py, Ok(imported.scene))?, report, warnings))
    }

    /// The same scene with other settings, given as plain values by the keys of the table `[settings]`.
    fn with_settings(&self, py: Python<'_>, settings: Named<'_>) -> PyResult<Self> {
        let settings = entries(&settings)?;
        Self::of(py, with_settings(&self.file, settings))
    }

    /// The scene as TOML, with every default.
    fn to_toml(&self, py: Python<'_>) -> PyResult<String> {
        self.file.to_toml().map_err(|failure| fault(py, &failure))
    }

    /// The scene as JSON, with every default.
    fn to_json(&self, py: Python<'_>) -> PyResult<String> {
        serde_json::to_string(&*self.file).map_err(|failure| error(py, failure))
    }
}

impl Scene {
    fn of(py: Python<'_>, read: Result<File, Fault>) -> PyResult<Self> {
        let file = read.map_err(|failure| fault(py, &failure))?;
        Ok(Self {
            file: Arc::new(file),
        })
    }

    /// Does something with the scene's arrays, those in `arrays` looked at where they are, without Python's lock.
    pub(crate) fn with_arrays<T: Send>(
        &self,
        py: Python<'_>,
        arrays: &ByPath<'_>,
        work: impl FnOnce(&File, &Arrays) -> Result<T, Fault> + Send,
    ) -> PyResult<T> {
        let (lent, pool) = (Lent::new(arrays)?, pool(None)?);
        let (arrays, file) = (lent.borrowed_all(), &*self.file);
        let done = py.detach(|| pool.install(|| work(file, &file.load_with(&arrays)?)));
        done.map_err(|failure| fault(py, &failure))
    }

    /// The systems of all wavelengths.
    pub(crate) fn systems(&self, py: Python<'_>, arrays: &ByPath<'_>) -> PyResult<Vec<System>> {
        self.with_arrays(py, arrays, |file, arrays| {
            (0..file.wavelength_um.len())
                .map(|channel| build::system_with(file, arrays, channel))
                .collect()
        })
    }

    /// The system of one wavelength.
    pub(crate) fn system(
        &self,
        py: Python<'_>,
        arrays: &ByPath<'_>,
        channel: usize,
    ) -> PyResult<System> {
        self.check(channel)?;
        self.with_arrays(py, arrays, |file, arrays| {
            build::system_with(file, arrays, channel)
        })
    }

    /// Refuses the index of a wavelength that is not there.
    pub(crate) fn check(&self, channel: usize) -> PyResult<()> {
        let count = self.file.wavelength_um.len();
        if channel < count {
            return Ok(());
        }
        let message = format!("channel is {channel}, expected from 0 to {}", count - 1);
        Err(PyIndexError::new_err(message))
    }
}
