//! The light of scenes on their sensors.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use ndarray::{Array1, Array2};
use num_complex::Complex64;
use numpy::{Ix1, Ix2};
use pyo3::prelude::*;
use raylet::engine::chain::outcome::Progress;
use raylet::engine::plan::settings::Settings;
use raylet::engine::sweep::simulate_all::{FinishedRun, simulate_all};
use raylet::file::decode::fault::Fault;
use raylet::file::model::build;
use raylet::file::model::error_location::simulate_fault;
use raylet::file::result::channel::Channel;
use raylet::file::result::document;
use raylet::file::result::report::Report;
use raylet::file::scene::scene_file::Scene as File;
use raylet::optics::system::System;
use raylet::wave::grid::field::Field;

use crate::refusal::fault;
use crate::scene::Scene;
use crate::typed::{ByPath, Made};
use crate::watch::{Watch, run};

/// Carries the light of every wavelength of several scenes to their sensors, side by side; the settings are those
/// of the first scene.
///
/// Returns for each scene (fields, x, y, standard errors, report as JSON): for each wavelength the complex field
/// [y, x], whose memory is the library's own; the pixel centres in mm; float64 [y, x] or None.
#[pyfunction]
#[pyo3(signature = (scenes, arrays, threads, progress))]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    scenes: Vec<Bound<'py, Scene>>,
    arrays: Vec<ByPath<'py>>,
    threads: Option<usize>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Vec<Answer<'py>>> {
    let mut sweep = Sweep {
        clock: Instant::now(),
        files: Vec::new(),
        runs: Vec::new(),
    };
    for (number, (scene, arrays)) in scenes.iter().zip(&arrays).enumerate() {
        let scene = scene.get();
        sweep.files.push(Arc::clone(&scene.file));
        sweep
            .runs
            .extend(scene.systems(py, arrays)?.into_iter().map(|system| Run {
                scene: number,
                file: Arc::clone(&scene.file),
                system,
            }));
    }
    let carried = run(py, threads, progress, move |watch| sweep.carry(watch))?;
    let carried = carried.map_err(|failure| fault(py, &failure))?;
    carried.into_iter().map(|one| one.answer(py)).collect()
}

type Answer<'py> = (
    Vec<Made<'py, Complex64, Ix2>>,
    Made<'py, f64, Ix1>,
    Made<'py, f64, Ix1>,
    Vec<Option<Made<'py, f64, Ix2>>>,
    String,
);

/// What came out of all wavelengths of a scene.
struct Carried {
    fields: Vec<(Field, Option<Array2<f64>>)>,
    report: Report,
}

impl Carried {
    fn answer(self, py: Python<'_>) -> PyResult<Answer<'_>> {
        let report =
            document::text(&self.report, "report").map_err(|failure| fault(py, &failure))?;
        let (mut fields, mut errors, mut axes) = (Vec::new(), Vec::new(), [Vec::new(), Vec::new()]);
        for (field, noise) in self.fields {
            axes = [field.grid.x.nodes(), field.grid.y.nodes()];
            fields.push(Made::new(py, field.values)?);
            errors.push(noise.map(|noise| Made::new(py, noise)).transpose()?);
        }
        let [x, y] = axes.map(|axis| Made::new(py, Array1::from(axis)));
        Ok((fields, x?, y?, errors, report))
    }
}

/// One run: a system of a scene, given with its number, at one wavelength.
struct Run {
    scene: usize,
    file: Arc<File>,
    system: System,
}

impl AsRef<System> for Run {
    fn as_ref(&self) -> &System {
        &self.system
    }
}

/// The runs of several scenes, and when they began.
struct Sweep {
    clock: Instant,
    files: Vec<Arc<File>>,
    runs: Vec<Run>,
}

impl Sweep {
    fn carry(self, watch: &Watch) -> Result<Vec<Carried>, Fault> {
        let Some(first) = self.files.first() else {
            return Ok(Vec::new());
        };
        let settings = build::settings(first);
        let shares = Mutex::new(vec![0.0; self.runs.len()]);
        let note = |number: usize, progress: Progress| {
            let mut shares = shares.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(share) = shares.get_mut(number) {
                *share = (progress.hop as f64 + progress.done) / progress.hops.max(1) as f64;
            }
            let done: f64 = shares.iter().sum();
            watch.report(done, shares.len() as f64, &self.label(number, progress))
        };
        let finished = simulate_all(&self.runs, &settings, &note)
            .map_err(|(run, error)| simulate_fault(&run.file, &run.system, &settings, &error))?;
        Ok(self.by_scene(finished, &settings))
    }

    /// What a run is doing: the screen that its light goes to, and the number of the run if there are several scenes.
    fn label(&self, number: usize, progress: Progress) -> String {
        let (to, attempt) = (progress.to, progress.attempt_note());
        match self.files.len() {
            1 => format!("{to}{attempt}"),
            _ => format!(
                "run {} of {} to '{to}'{attempt}",
                number + 1,
                self.runs.len()
            ),
        }
    }

    /// The results of each scene, with the seconds since the call where it is the only one; else those of its runs.
    fn by_scene(&self, finished: Vec<FinishedRun>, settings: &Settings) -> Vec<Carried> {
        let mut finished = self.runs.iter().zip(finished).peekable();
        let of_scene = |(number, file): (usize, &Arc<File>)| {
            let (mut fields, mut channels, mut seconds) = (Vec::new(), Vec::new(), 0.0);
            while let Some((_, done)) = finished.next_if(|(run, _)| run.scene == number) {
                channels.push(Channel::new(&done.outcome, settings, done.seconds));
                fields.push((done.outcome.field, done.outcome.standard_error));
                seconds += done.seconds;
            }
            if self.files.len() == 1 {
                seconds = self.clock.elapsed().as_secs_f64();
            }
            let report = Report::new("simulate", file, settings, channels, seconds);
            Carried { fields, report }
        };
        self.files.iter().enumerate().map(of_scene).collect()
    }
}
