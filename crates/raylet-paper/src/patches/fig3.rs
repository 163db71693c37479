//! Figure 3 of the source paper: the error of one patch against the number of its secondary rays.

#![expect(
    clippy::indexing_slicing,
    reason = "runs, elements and pixels are made here, as many as are given"
)]

use raylet::optics::system::System;
use raylet_plot::text_table::table;
use raylet_testkit::patterns::{metalens, star_hologram};
use serde_json::json;

use crate::patches::convergence::Convergence;
use crate::study::Study;
use crate::study_error::StudyError;

/// Wavelength in mm.
const WAVELENGTH: f64 = 1e-3;

/// An element of the study, and how often its modes are drawn.
struct HologramTask {
    name: &'static str,
    title: String,
    system: System,
    draws: Vec<usize>,
    seeds: u64,
}

/// Measures both elements.
///
/// # Errors
/// What the library refuses.
pub fn fig3(quick: bool) -> Result<Study, StudyError> {
    let mut study = Study::default();
    let mut entries = Vec::new();
    for task in tasks(quick) {
        let found = Convergence::measure(&task.system, &task.draws, task.seeds)?;
        study.text += &block(&task, &found);
        entries.push(entry(&task, &found));
        let name = format!("{}.png", task.name);
        study.pictures.push((name, found.png(&task.title)?));
        study.export_scene(&task.system, task.name, &task.title)?;
    }
    study.document = serde_json::json!({ "tasks": entries });
    Ok(study)
}

/// The two elements of figure 3; pixels of half a wavelength and the sensor in the focal plane are not
/// in the paper.
fn tasks(quick: bool) -> [HologramTask; 2] {
    let (lens, star) = if quick { (30, 48) } else { (50, 400) };
    let decades = |from: u32, to: u32| (from..=to).map(|n| 10usize.pow(n)).collect::<Vec<_>>();
    [
        HologramTask {
            name: "metalens",
            title: format!("Metalens of {lens} wavelengths, NA 0.1"),
            system: metalens(lens, 0.1, WAVELENGTH),
            draws: if quick { decades(2, 4) } else { decades(1, 5) },
            seeds: if quick { 2 } else { 16 },
        },
        HologramTask {
            name: "star",
            title: format!("Hologram of a Siemens star, {star} wavelengths, NA 0.7"),
            system: star_hologram(star, 0.7, WAVELENGTH),
            draws: if quick { decades(2, 4) } else { decades(3, 6) },
            seeds: if quick { 2 } else { 1 },
        },
    ]
}

/// The numbers of one element as text.
fn block(task: &HologramTask, found: &Convergence) -> String {
    let mut rows = Vec::new();
    for method in &found.methods {
        for (i, [draws, error]) in method.errors.iter().enumerate() {
            let law = method.law.as_ref().map(|law| format!("{:.3e}", law[i][1]));
            rows.push(vec![
                method.name.to_owned(),
                format!("{draws}"),
                format!("{error:.3e}"),
                law.unwrap_or_default(),
            ]);
        }
    }
    let head = ["drawn", "secondary rays", "error²", "by its law"];
    format!(
        "{}\n  {} modes; all of them are {:.1e} from the angular spectrum (unit-sum MSE {:.1e})\n{}  \
         {} rays in {:.1} s\n\n",
        task.title,
        found.modes,
        found.floor,
        found.floor_mse,
        table(&head, &rows, &[1, 2, 3]),
        found.rays,
        found.seconds
    )
}

/// The same as a document.
fn entry(task: &HologramTask, found: &Convergence) -> serde_json::Value {
    let methods = found
        .methods
        .iter()
        .map(|method| json!({ "drawn": method.name, "errors": method.errors, "law": method.law }));
    json!({
        "name": task.name,
        "title": task.title,
        "seeds": task.seeds,
        "modes": found.modes,
        "all_modes_field_error": found.floor,
        "all_modes_unit_sum_mse": found.floor_mse,
        "methods": methods.collect::<Vec<_>>(),
        "rays": found.rays,
        "seconds": found.seconds,
    })
}
