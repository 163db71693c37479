//! Figure 5 of the source paper: a hologram before a lens, designed with a thin lens, with principal planes, and
//! through the real lens.

#![expect(
    clippy::indexing_slicing,
    reason = "runs, elements and pixels are made here, as many as are given"
)]

use std::path::PathBuf;
use std::time::Instant;

use ndarray::Array2;
use raylet::design::holograms::hologram::design;
use raylet::design::optimizers::step::Step;
use raylet::design::run::{Run, State};
use raylet::engine::chain::reference::{ReferenceOptions, reference};
use raylet::engine::chain::simulate::simulate;
use raylet::engine::free::free_method::Approach;
use raylet::engine::plan::settings::Settings;
use raylet::engine::progress::uncancelled;
use raylet::file::arrays::phase_file::npy;
use raylet::file::model::hologram::commission;
use raylet::file::model::project::{SceneDesign, scene_design};
use raylet::file::result::machine::Machine;
use raylet::file::scene::scene_file::Scene;
use raylet::file::storage::checkpoint::Checkpoints;
use raylet::file::storage::own_file::Replace;
use raylet::wave::grid::metrics::{field_error, ncc};
use raylet_plot::text_table::table;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::fig5_chart::{Shown, fig5_picture};
use crate::study::{Effort, Study};
use crate::study_error::StudyError;

/// The scene, and the drawing that it names.
const SCENE: &str = include_str!("../../../scenes/paper/fig5.toml");
const DRAWING: &[u8] = include_bytes!("../../../scenes/paper/smiley.png");

/// Iterations of a quick study: of the paraxial designs and through the lens.
const QUICK: [usize; 2] = [30, 8];

/// Iterations between two checkpoints.
const KEEP: usize = 10;

/// One of the three designs.
struct Row {
    name: &'static str,
    file: &'static str,
    /// Phase of the pixels in rad, [y, x].
    phase: Array2<f64>,
    iterations: usize,
    seconds: f64,
    memory_mb: Option<f64>,
    /// |U|² on the sensor through the real lens, [y, x].
    intensity: Array2<f64>,
    ncc: f64,
    light: f64,
    /// NCC with the picture by Collins' integral, and the field error between the two.
    collins: f64,
    apart: f64,
}

/// The search through the lens as it stands.
#[derive(Clone, Serialize, Deserialize)]
struct Saved {
    state: State,
    seconds: f64,
}

/// Designs the hologram by three methods and looks at each through the real lens.
///
/// # Errors
/// What the library refuses, and files that cannot be kept.
pub fn fig5(effort: Effort) -> Result<Study, StudyError> {
    let room = Room::new()?;
    let mut scene = Scene::open(&room.folder.join("fig5.toml"))?;
    if let (true, Some(hologram), Some(design)) =
        (effort.quick, &mut scene.hologram, &mut scene.design)
    {
        [hologram.iterations, design.iterations] = QUICK;
    }
    let scene_design = scene_design(&scene)?;
    let mut rows = Vec::new();
    for (name, file, naive) in [
        ("thin lens at the first vertex", "thin", true),
        ("paraxial, with principal planes", "paraxial", false),
    ] {
        let clock = Instant::now();
        let job = commission(&scene, naive)?;
        let iterations = job.task.iterations;
        let mut steps = effort.display.search(name, 0, iterations);
        let found = design(&job.task, &mut |score| {
            steps.note(score.iteration, &format!("NCC {:.4}", score.ncc));
        });
        steps.end();
        let phase = found.map_err(|error| job.fault(&scene, &error))?.phase;
        let seconds = clock.elapsed().as_secs_f64();
        let found = FoundHologram {
            name,
            file,
            phase,
            iterations,
            seconds,
        };
        rows.push(seen(&scene_design, found)?);
    }
    let iterations = scene_design.design.iterations;
    let (description, bytes) = (
        iterations.to_string(),
        State::saved_bytes(&scene_design.search, iterations),
    );
    let kept = effort
        .keep
        .map(|keep| Checkpoints::within(&keep.join("fig5"), &description, bytes));
    let found = through_lens(&scene_design, kept.as_ref(), effort)?;
    rows.push(seen(&scene_design, found)?);
    let study = study(&rows, &scene_design)?;
    if let Some(kept) = kept {
        kept.remove()?;
    }
    Ok(study)
}

/// A hologram that was found, and what it took.
struct FoundHologram {
    /// What it is called.
    name: &'static str,
    /// The name of its file.
    file: &'static str,
    /// Its phase in rad, [y, x].
    phase: Array2<f64>,
    iterations: usize,
    seconds: f64,
}

/// The hologram found by gradients through the real lens.
fn through_lens(
    scene_design: &SceneDesign,
    kept: Option<&Checkpoints>,
    effort: Effort,
) -> Result<FoundHologram, StudyError> {
    let (clock, iterations) = (Instant::now(), scene_design.design.iterations);
    let before = kept.and_then(|kept| kept.read(|saved| check(saved, scene_design)).ok());
    if let (Some(kept), None) = (kept, &before) {
        kept.claim(Replace::Own)?;
    }
    let earlier = before.as_ref().map_or(0.0, |before| before.state.seconds);
    let mut run = match before {
        Some(before) => Run::resume(
            &scene_design.project,
            before.state.state,
            iterations,
            &uncancelled,
        )?,
        None => Run::new(
            &scene_design.project,
            scene_design.search.clone(),
            iterations,
            &uncancelled,
        )?,
    };
    let [picture, _] = target(scene_design)?;
    let mut steps = effort
        .display
        .search("through the real lens", run.iteration(), iterations);
    while !run.is_done() {
        let found = run.step()?;
        if found.step == Step::Trial {
            continue;
        }
        let like = ncc(found.evaluation.intensities[0].view(), picture.view());
        steps.note(run.iteration(), &format!("NCC {:.4}", like.unwrap_or(0.0)));
        if let Some(kept) = kept.filter(|_| run.iteration().is_multiple_of(KEEP)) {
            kept.write(&Saved {
                state: run.state.clone(),
                seconds: earlier + clock.elapsed().as_secs_f64(),
            })?;
        }
    }
    steps.end();
    let made = scene_design.project.make(run.best(), 1.0);
    Ok(FoundHologram {
        name: "through the real lens",
        file: "real",
        phase: made[0].phases[0].phase.clone(),
        iterations: run.iteration(),
        seconds: earlier + clock.elapsed().as_secs_f64(),
    })
}

/// Checks that the search can go on from this; returns what was found otherwise.
fn check(saved: &Saved, scene_design: &SceneDesign) -> Result<(), String> {
    let iterations = scene_design.design.iterations;
    let checked = saved
        .state
        .check(&scene_design.project, &scene_design.search, iterations);
    checked.map_err(|error| error.to_string())
}

/// The picture on the sensor, and where its outline is.
fn target(scene_design: &SceneDesign) -> Result<&[Array2<f64>; 2], StudyError> {
    let picture = scene_design
        .described
        .first()
        .and_then(|first| first.picture.as_ref());
    picture.ok_or_else(|| StudyError::from("the scene has no picture to be shown"))
}

/// What a phase shows through the real lens, and by Collins' integral.
fn seen(scene_design: &SceneDesign, found: FoundHologram) -> Result<Row, StudyError> {
    let FoundHologram {
        name,
        file,
        phase,
        iterations,
        seconds,
    } = found;
    let memory_mb = Machine::here().peak_memory_mb;
    let point: Vec<f64> = phase.iter().copied().collect();
    let made = scene_design.project.make(&point, 1.0);
    let system = scene_design.project.system(0, &made, &[])?;
    let ours = simulate(&system, &Settings::default(), &|_| {})?;
    let choice = ReferenceOptions {
        approach: Approach::Collins,
        ..ReferenceOptions::default()
    };
    let other = reference(&system, &Settings::default(), choice, &|_| {})?.field;
    let intensity = ours.field.intensity();
    let behind = ours
        .hops
        .first()
        .map_or(f64::NAN, |hop| hop.power[1].unwrap_or(f64::NAN));
    let [picture, window] = target(scene_design)?;
    let like = |seen: &Array2<f64>| ncc(seen.view(), picture.view()).unwrap_or(f64::NAN);
    let apart = field_error(ours.field.values.view(), other.values.view());
    Ok(Row {
        name,
        file,
        phase,
        iterations,
        seconds,
        memory_mb,
        ncc: like(&intensity),
        light: (&intensity * window).sum() * scene_design.pixel_area / behind,
        collins: like(&other.intensity()),
        apart: apart.unwrap_or(f64::NAN),
        intensity,
    })
}

/// The rows as text, document, picture and arrays.
fn study(rows: &[Row], scene_design: &SceneDesign) -> Result<Study, StudyError> {
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            vec![
                row.name.to_owned(),
                format!("{:.4}", row.ncc),
                format!("{:.1} %", 100.0 * row.light),
                format!("{:.4}", row.collins),
                format!("{:.1e}", row.apart),
                row.iterations.to_string(),
                format!("{:.1}", row.seconds),
                row.memory_mb.map_or(String::new(), |mb| format!("{mb:.0}")),
            ]
        })
        .collect();
    let head = [
        "design",
        "NCC",
        "light",
        "NCC by Collins",
        "field error to it",
        "iterations",
        "s",
        "MB so far",
    ];
    let entries = rows.iter().map(|row| {
        json!({
            "design": row.name,
            "ncc": row.ncc,
            "light_in_picture": row.light,
            "ncc_by_collins": row.collins,
            "field_error_to_collins": row.apart,
            "iterations": row.iterations,
            "seconds": row.seconds,
            "peak_memory_mb_so_far": row.memory_mb,
        })
    });
    let entries: Vec<_> = entries.collect();
    let shown = rows.iter().map(|row| Shown {
        name: row.name,
        phase: &row.phase,
        intensity: &row.intensity,
        ncc: row.ncc,
    });
    let [picture, _] = target(scene_design)?;
    let png = fig5_picture(&shown.collect::<Vec<_>>(), picture, scene_design)?;
    let mut pictures = vec![(String::from("fig5.png"), png)];
    for row in rows {
        pictures.push((format!("{}.npy", row.file), npy(&row.phase)?));
    }
    Ok(Study {
        text: format!(
            "A hologram before the LA1131-A, seen through the real lens\n{}",
            table(&head, &lines, &[1, 2, 3, 4, 5, 6, 7])
        ),
        document: json!({ "designs": entries, "machine": Machine::here() }),
        pictures,
    })
}

/// A folder with the scene and its drawing among the system's temporary files.
struct Room {
    folder: PathBuf,
}

/// What is in it.
const FILES: [(&str, &[u8]); 2] = [("fig5.toml", SCENE.as_bytes()), ("smiley.png", DRAWING)];

impl Room {
    fn new() -> Result<Self, StudyError> {
        let folder = std::env::temp_dir().join(format!("raylet-fig5-{}", std::process::id()));
        std::fs::create_dir(&folder)?;
        let room = Self { folder };
        for (name, content) in FILES {
            std::fs::write(room.folder.join(name), content)?;
        }
        Ok(room)
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        // What cannot be removed is left to the system.
        for (name, _) in FILES {
            let _ = std::fs::remove_file(self.folder.join(name));
        }
        let _ = std::fs::remove_dir(&self.folder);
    }
}
