//! The light of a scene on its sensor.

use std::sync::Arc;
use std::time::Instant;

use ndarray::{Array1, Array2};
use num_complex::Complex64;
use numpy::{Ix1, Ix2};
use pyo3::prelude::*;
use raylet::engine::chain::outcome::{Outcome, Progress};
use raylet::engine::chain::simulate::simulate as carry;
use raylet::engine::plan::settings::Settings;
use raylet::file::decode::fault::Fault;
use raylet::file::model::build;
use raylet::file::model::error_location::simulate_fault;
use raylet::file::result::channel::Channel;
use raylet::file::result::document;
use raylet::file::result::report::Report;
use raylet::file::scene::scene_file::Scene as File;
use raylet::optics::system::System;

use crate::refusal::fault;
use crate::scene::Scene;
use crate::typed::{ByPath, Made};
use crate::watch::{Watch, run};

/// Carries the light of every wavelength to the sensor.
///
/// Returns (fields, x, y, standard errors, report as JSON): for each wavelength the complex field [y, x], whose
/// memory is the library's own; the pixel centres in mm; float64 [y, x] or None.
#[pyfunction]
#[pyo3(signature = (scene, arrays, threads, progress))]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    scene: &Scene,
    arrays: ByPath<'py>,
    threads: Option<usize>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Answer<'py>> {
    let clock = Instant::now();
    let systems = scene.systems(py, &arrays)?;
    let (file, settings) = (Arc::clone(&scene.file), build::settings(&scene.file));
    let work = move |watch: &Watch| carry_all(&file, &systems, &settings, watch, clock);
    let carried = run(py, threads, progress, work)?.map_err(|failure| fault(py, &failure))?;
    let report =
        document::text(&carried.report, "report").map_err(|failure| fault(py, &failure))?;
    let (mut fields, mut errors, mut axes) = (Vec::new(), Vec::new(), [Vec::new(), Vec::new()]);
    for (field, noise) in carried.fields {
        axes = [field.grid.x.nodes(), field.grid.y.nodes()];
        fields.push(Made::new(py, field.values)?);
        errors.push(noise.map(|noise| Made::new(py, noise)).transpose()?);
    }
    let [x, y] = axes.map(|axis| Made::new(py, Array1::from(axis)));
    Ok((fields, x?, y?, errors, report))
}

type Answer<'py> = (
    Vec<Made<'py, Complex64, Ix2>>,
    Made<'py, f64, Ix1>,
    Made<'py, f64, Ix1>,
    Vec<Option<Made<'py, f64, Ix2>>>,
    String,
);

/// What came out of all wavelengths.
struct Carried {
    fields: Vec<(raylet::wave::grid::field::Field, Option<Array2<f64>>)>,
    report: Report,
}

fn carry_all(
    file: &File,
    systems: &[System],
    settings: &Settings,
    watch: &Watch,
    clock: Instant,
) -> Result<Carried, Fault> {
    let (mut fields, mut channels) = (Vec::new(), Vec::new());
    for (number, system) in systems.iter().enumerate() {
        let began = Instant::now();
        let report = |progress: Progress| {
            let before = (number * progress.hops + progress.hop) as f64;
            let all = (systems.len() * progress.hops) as f64;
            let label = format!("{}{}", progress.to, progress.attempt_note());
            watch.report(before + progress.done, all, &label)
        };
        let outcome: Outcome = carry(system, settings, &report)
            .map_err(|error| simulate_fault(file, system, settings, &error))?;
        let seconds = began.elapsed().as_secs_f64();
        channels.push(Channel::new(&outcome, settings, seconds));
        fields.push((outcome.field, outcome.standard_error));
    }
    let seconds = clock.elapsed().as_secs_f64();
    let report = Report::new("simulate", file, settings, channels, seconds);
    Ok(Carried { fields, report })
}
