//! Holograms and designs that a scene describes.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};

use ndarray::Array2;
use numpy::Ix2;
use pyo3::prelude::*;
use raylet::design::holograms::hologram::{Score, design as seek};
use raylet::design::optimizers::step::{Step, is_moderate};
use raylet::design::project::ProjectError;
use raylet::design::run::{Run, State};
use raylet::engine::progress::{Cancelled, Pulse};
use raylet::file::decode::fault::Fault;
use raylet::file::model::hologram::commission;
use raylet::file::model::project::{SceneDesign, scene_design};
use raylet::file::scene::scene_file::Scene as File;
use raylet::file::storage::checkpoint::{Checkpoints, Restored};
use raylet::file::storage::own_file::Replace;
use raylet::file::storage::run_folder::RunFolder;

use crate::arrays::Lent;
use crate::refusal::{error, fault};
use crate::scene::Scene;
use crate::typed::{ByPath, Made, finite};
use crate::watch::{BREATH, Watch, run};

/// The phase in rad [y, x] with which the sensor shows a picture, on the paraxial train: its path in the scene, what
/// goes there, and (NCC with the softened picture, NCC over the sensor, share of the light in it).
#[pyfunction]
#[pyo3(signature = (scene, arrays, naive, threads, progress))]
pub(crate) fn hologram<'py>(
    py: Python<'py>,
    scene: &Scene,
    arrays: ByPath<'py>,
    naive: bool,
    threads: Option<usize>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(String, Made<'py, f64, Ix2>, [f64; 3])> {
    let file = held(py, scene, &arrays)?;
    let work = move |watch: &Watch| {
        let job = commission(&file, naive)?;
        let all = job.task.iterations as f64;
        let mut report = |score: Score| {
            let words = format!("NCC {:.4}", score.ncc);
            watch.report(score.iteration as f64, all, &words)
        };
        let found = seek(&job.task, &mut report).map_err(|failure| job.fault(&file, &failure))?;
        Ok((job.field, found.phase / job.phase_scale, found.score))
    };
    let found: Result<(String, Array2<f64>, Score), Fault> = run(py, threads, progress, work)?;
    let (path, phase, score) = found.map_err(|failure| fault(py, &failure))?;
    let scores = [score.ncc, score.ncc_sensor, score.efficiency];
    finite(py, &scores)?;
    Ok((path, Made::new(py, phase)?, scores))
}

/// Numbers of the field and the wavelength of each run, and its losses by kind.
type Parts = Vec<(usize, usize, Vec<(String, f64)>)>;

/// What a design found.
struct DesignResult {
    /// What goes where in the scene.
    pixels: Vec<(String, Array2<f64>)>,
    /// Names and values of the parameters.
    parameters: Vec<(String, f64)>,
    /// The loss after each iteration.
    course: Vec<f64>,
    /// The loss of what was found, and its parts.
    loss: f64,
    parts: Parts,
    evaluations: usize,
    /// What was wrong with the newest checkpoint, if the one before it was taken.
    warning: Option<String>,
    /// The scene with its parameters.
    scene: File,
}

type Answer<'py> = (
    Vec<(String, Made<'py, f64, Ix2>)>,
    Vec<(String, f64)>,
    (Vec<f64>, f64, usize, Option<String>),
    Parts,
    Scene,
);

/// Where checkpoints are kept.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Keeping {
    folder: PathBuf,
    /// What the run depends on beside its scene.
    rest: String,
    /// Whether to go on from the last checkpoint.
    resume: bool,
}

/// Runs the `[design]` of a scene.
///
/// Returns (arrays by their paths in the scene, parameters by name, (loss after each iteration, loss of what was found,
/// evaluations, what was wrong with the newest checkpoint), (field, wavelength, losses by kind) of each run, the scene
/// with its parameters).
#[pyfunction]
#[pyo3(signature = (scene, arrays, keeping, threads, progress))]
pub(crate) fn design<'py>(
    py: Python<'py>,
    scene: &Scene,
    arrays: ByPath<'py>,
    keeping: Option<Keeping>,
    threads: Option<usize>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Answer<'py>> {
    let file = held(py, scene, &arrays)?;
    let keeps = keeping.is_some();
    let (at_work, ended) = channel::<()>();
    let found = run(py, threads, progress, move |watch: &Watch| {
        let _at_work = at_work;
        find(&file, keeping.as_ref(), watch)
    });
    if found.is_err() && keeps {
        wait(py, ended);
    }
    let found = found?.map_err(|failure| match failure {
        Failure::Fault(failure) => fault(py, &failure),
        Failure::Other(failure) => error(py, failure),
    })?;
    let pixels = found.pixels.into_iter();
    let pixels = pixels.map(|(path, array)| Ok((path, Made::new(py, array)?)));
    let losses = found.parts.iter().flat_map(|(_, _, losses)| losses);
    finite(py, losses.map(|(_, loss)| loss).chain([&found.loss]))?;
    finite(py, found.parameters.iter().map(|(_, value)| value))?;
    finite(py, &found.course)?;
    let scene = Scene {
        file: Arc::new(found.scene),
    };
    Ok((
        pixels.collect::<PyResult<_>>()?,
        found.parameters,
        (found.course, found.loss, found.evaluations, found.warning),
        found.parts,
        scene,
    ))
}

/// Waits until a search that was cancelled has ended and released its folder, or until the next signal.
fn wait(py: Python<'_>, mut ended: Receiver<()>) {
    loop {
        let (back, outcome) = py.detach(move || {
            let outcome = ended.recv_timeout(BREATH);
            (ended, outcome)
        });
        ended = back;
        if outcome != Err(RecvTimeoutError::Timeout) || py.check_signals().is_err() {
            return;
        }
    }
}

/// Why nothing was found.
enum Failure {
    Fault(Box<Fault>),
    Other(String),
}

impl From<Fault> for Failure {
    fn from(failure: Fault) -> Self {
        Self::Fault(Box::new(failure))
    }
}

impl From<Cancelled> for Failure {
    fn from(failure: Cancelled) -> Self {
        Self::Other(failure.to_string())
    }
}

impl From<ProjectError> for Failure {
    fn from(failure: ProjectError) -> Self {
        Self::Other(failure.to_string())
    }
}

/// A search on its way, and what it leaves behind.
struct Going<'b> {
    search: Run<'b>,
    /// The loss after each iteration.
    course: Vec<f64>,
    /// Where it is kept, in a folder that no other run writes meanwhile.
    kept: Option<(Checkpoints, RunFolder)>,
    warning: Option<String>,
}

impl<'b> Going<'b> {
    /// From the start, or from the last checkpoint.
    fn new(
        file: &File,
        scene_design: &'b SceneDesign,
        keeping: Option<&Keeping>,
        pulse: &'b Pulse<'b>,
    ) -> Result<Self, Failure> {
        let (project, iterations) = (&scene_design.project, scene_design.design.iterations);
        let mut going = Self {
            search: Run::new(project, scene_design.search.clone(), iterations, pulse)?,
            course: Vec::new(),
            kept: None,
            warning: None,
        };
        let Some(Keeping {
            folder,
            rest,
            resume,
        }) = keeping
        else {
            return Ok(going);
        };
        let held = RunFolder::open(folder)?;
        let bytes = State::saved_bytes(&scene_design.search, iterations);
        let checkpoints = Checkpoints::within(folder, &(file.to_toml()? + rest), bytes);
        if *resume {
            let check = |(state, course): &(State, Vec<f64>)| check(state, course, scene_design);
            let Restored { state, warning } = checkpoints.read(check)?;
            going.search = Run::resume(project, state.0, iterations, pulse)?;
            (going.course, going.warning) = (state.1, warning);
        } else {
            checkpoints.claim(Replace::Own)?;
        }
        going.kept = Some((checkpoints, held));
        Ok(going)
    }

    /// To the end, keeping a checkpoint as often as the design says.
    fn follow(&mut self, scene_design: &SceneDesign, watch: &Watch) -> Result<(), Failure> {
        let (iterations, each) = (
            scene_design.design.iterations,
            scene_design.design.checkpoint,
        );
        while !self.search.is_done() {
            let found = self.search.step()?;
            if found.step == Step::Trial || !found.evaluation.is_finite() {
                continue;
            }
            self.course.push(found.evaluation.value);
            let (done, words) = (
                self.search.iteration(),
                format!("loss {:.5}", found.evaluation.value),
            );
            Cancelled::check(watch.report(done as f64, iterations as f64, &words))?;
            if let Some((checkpoints, _)) = &self.kept
                && (done.is_multiple_of(each) || self.search.is_done())
            {
                checkpoints.write(&(&self.search.state, &self.course))?;
            }
        }
        Ok(())
    }
}

/// Checks that a design can go on from this; returns what was found otherwise.
fn check(state: &State, course: &[f64], scene_design: &SceneDesign) -> Result<(), String> {
    let checked = state.check(
        &scene_design.project,
        &scene_design.search,
        scene_design.design.iterations,
    );
    checked.map_err(|error| error.to_string())?;
    let counted =
        course.len() <= state.evaluations && course.is_empty() == (state.evaluations == 0);
    match counted && course.iter().all(|loss| is_moderate(*loss)) {
        true => Ok(()),
        false => Err(String::from("a course of another design")),
    }
}

fn find(file: &File, keeping: Option<&Keeping>, watch: &Watch) -> Result<DesignResult, Failure> {
    let scene_design = scene_design(file)?;
    let pulse = || watch.pulse();
    let mut going = Going::new(file, &scene_design, keeping, &pulse)?;
    going.follow(&scene_design, watch)?;
    let (project, search) = (&scene_design.project, &going.search);
    let evaluation = search.finish()?;

    // What it is made of, where that goes in the scene, and what each run's losses are.
    let (best, made) = (search.best(), project.make(search.best(), 1.0));
    let outputs = scene_design.outputs.iter();
    let values = best.iter().skip(project.system_parameters_from());
    let parameters = project.system_parameters.iter().zip(values);
    let parts = scene_design.described.iter().zip(&evaluation.parts);
    Ok(DesignResult {
        pixels: outputs
            .map(|output| (output.field.clone(), output.values(&made)))
            .collect(),
        parameters: parameters
            .map(|(parameter, value)| (parameter.name.clone(), *value))
            .collect(),
        loss: evaluation.value,
        parts: parts
            .map(|(channel, parts)| {
                let kinds = channel.kinds.iter().map(|kind| String::from(*kind));
                let losses = kinds.zip(parts.iter().copied()).collect();
                (channel.place[0], channel.place[1], losses)
            })
            .collect(),
        evaluations: search.state.evaluations,
        warning: going.warning,
        scene: scene_design.scene_at(file, best)?,
        course: going.course,
    })
}

/// The scene with copies of the arrays that Python holds.
fn held(py: Python<'_>, scene: &Scene, arrays: &ByPath<'_>) -> PyResult<File> {
    let lent = Lent::new(arrays)?;
    let held = (*scene.file).clone().holding(&lent.borrowed_all());
    held.map_err(|failure| fault(py, &failure))
}
