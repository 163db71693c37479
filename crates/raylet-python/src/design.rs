//! Holograms and designs that a scene asks for.

use std::sync::Arc;

use ndarray::Array2;
use numpy::Ix2;
use pyo3::prelude::*;
use raylet::design::hologram::{Score, design as seek};
use raylet::design::project::ProjectError;
use raylet::design::run::Run;
use raylet::design::step::Step;
use raylet::file::fault::Fault;
use raylet::file::hologram::commission;
use raylet::file::project::brief;
use raylet::file::scene::Scene as File;

use crate::arrays::Lent;
use crate::refusal::{error, fault};
use crate::scene::Scene;
use crate::typed::{ByPath, Made};
use crate::watch::{Watch, run};

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
        let wanted = commission(&file, naive)?;
        let all = wanted.task.iterations as f64;
        let mut tell = |score: Score| {
            let words = format!("NCC {:.4}", score.ncc);
            watch.tell(score.iteration as f64, all, &words);
        };
        let found = seek(&wanted.task, &mut tell).map_err(|told| wanted.blame(&file, &told))?;
        Ok((wanted.field, found.phase / wanted.phase_scale, found.score))
    };
    let found: Result<(String, Array2<f64>, Score), Fault> = run(py, threads, progress, work)?;
    let (path, phase, score) = found.map_err(|told| fault(py, &told))?;
    let scores = [score.ncc, score.ncc_sensor, score.efficiency];
    Ok((path, Made::new(py, phase), scores))
}

/// Numbers of the field and the wavelength of each run, and its losses by kind.
type Parts = Vec<(usize, usize, Vec<(String, f64)>)>;

/// What a design found.
struct Found {
    /// What goes where in the scene.
    pixels: Vec<(String, Array2<f64>)>,
    /// Names and values of the numbers.
    numbers: Vec<(String, f64)>,
    /// The loss after each iteration.
    course: Vec<f64>,
    /// The loss of what was found, and its parts.
    loss: f64,
    parts: Parts,
    evaluations: usize,
    /// The scene with its numbers.
    scene: File,
}

type Answer<'py> = (
    Vec<(String, Made<'py, f64, Ix2>)>,
    Vec<(String, f64)>,
    (Vec<f64>, f64, usize),
    Parts,
    Scene,
);

/// Designs what the `[design]` of a scene asks for.
///
/// Returns (arrays by their paths in the scene, numbers by name, (loss after each iteration, loss of what was found,
/// evaluations), (field, wavelength, losses by kind) of each run, the scene with its numbers).
#[pyfunction]
#[pyo3(signature = (scene, arrays, threads, progress))]
pub(crate) fn design<'py>(
    py: Python<'py>,
    scene: &Scene,
    arrays: ByPath<'py>,
    threads: Option<usize>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Answer<'py>> {
    let file = held(py, scene, &arrays)?;
    let found = run(py, threads, progress, move |watch: &Watch| {
        find(&file, watch)
    })?;
    let found = found.map_err(|told| match told {
        Failure::Fault(told) => fault(py, &told),
        Failure::Other(told) => error(py, told),
    })?;
    let pixels = found.pixels.into_iter();
    let pixels = pixels.map(|(path, array)| (path, Made::new(py, array)));
    let scene = Scene {
        file: Arc::new(found.scene),
    };
    Ok((
        pixels.collect(),
        found.numbers,
        (found.course, found.loss, found.evaluations),
        found.parts,
        scene,
    ))
}

/// Why nothing was found.
enum Failure {
    Fault(Box<Fault>),
    Other(String),
}

impl From<Fault> for Failure {
    fn from(told: Fault) -> Self {
        Self::Fault(Box::new(told))
    }
}

impl From<ProjectError> for Failure {
    fn from(told: ProjectError) -> Self {
        Self::Other(told.to_string())
    }
}

fn find(file: &File, watch: &Watch) -> Result<Found, Failure> {
    let brief = brief(file)?;
    let (project, iterations) = (&brief.project, brief.design.iterations);
    let mut search = Run::new(project, brief.search.clone(), iterations)?;
    let mut course = Vec::new();
    while !search.is_done() {
        watch.pulse();
        let found = search.step()?;
        if found.step == Step::Trial {
            continue;
        }
        course.push(found.look.value);
        let words = format!("loss {:.5}", found.look.value);
        watch.tell(search.iteration() as f64, iterations as f64, &words);
    }
    let look = search.finish()?;

    // What it is made of, where that goes in the scene, and what each run's losses are.
    let (best, made) = (search.best(), project.make(search.best(), 1.0));
    let outputs = brief.outputs.iter();
    let values = &best[project.numbers_from()..];
    let numbers = project.numbers.iter().zip(values);
    let parts = brief.glances.iter().zip(&look.parts);
    Ok(Found {
        pixels: outputs
            .map(|output| (output.field.clone(), output.values(&made)))
            .collect(),
        numbers: numbers
            .map(|(number, value)| (number.name.clone(), *value))
            .collect(),
        loss: look.value,
        parts: parts
            .map(|(glance, parts)| {
                let kinds = glance.kinds.iter().map(|kind| String::from(*kind));
                let losses = kinds.zip(parts.iter().copied()).collect();
                (glance.place[0], glance.place[1], losses)
            })
            .collect(),
        evaluations: search.state.evaluations,
        course,
        scene: brief.scene_at(file, best)?,
    })
}

/// The scene with copies of the arrays that Python holds.
fn held(py: Python<'_>, scene: &Scene, arrays: &ByPath<'_>) -> PyResult<File> {
    let lent = Lent::new(arrays)?;
    let held = (*scene.file).clone().holding(&lent.looks());
    held.map_err(|told| fault(py, &told))
}
