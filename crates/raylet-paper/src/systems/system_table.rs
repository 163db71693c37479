//! What the studies of the source paper's three systems share: methods side by side, as a table and a document.

use std::path::Path;

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;
use raylet::engine::chain::outcome::Progress;
use raylet::engine::monte_carlo::repeated_runs::RepeatedRuns;
use raylet::engine::plan::settings::{Method, Paper, Settings};
use raylet::file::storage::partial::PartialFile;
use raylet::optics::screen::ScreenKind;
use raylet::optics::system::System;
use raylet::wave::grid::metrics::ncc;
use raylet_plot::text_table::table;
use serde_json::{Value, json};

use crate::progress_display::ProgressDisplay;
use crate::study::{Effort, Study};
use crate::study_error::StudyError;
use crate::systems::method_comparison::{Match, MethodRun, light};

/// Extension of the files of unfinished runs.
const KEPT: &str = "npz";

/// A field to compare with, and its name.
pub(crate) struct Rod<'a> {
    pub(crate) name: &'a str,
    pub(crate) field: ArrayView2<'a, Complex64>,
}

/// What was found of one method.
struct Entry {
    run: MethodRun,
    /// How alike it is to references, by name.
    matches: Vec<(String, Match)>,
    /// Correlation of its intensity with the target picture.
    picture: Option<f64>,
    /// Where its brightest pixel is, in µm.
    peak_um: Option<[f64; 2]>,
}

/// All methods of a study.
#[derive(Default)]
pub(crate) struct Board {
    entries: Vec<Entry>,
}

/// The paper's method with these settings.
pub(crate) fn by_paper(paper: Paper) -> Settings {
    Settings {
        method: Method::Paper,
        paper,
        ..Settings::default()
    }
}

/// A run of the default method, or of any other that is no sum of parts.
pub(crate) fn once(
    name: &str,
    system: &System,
    settings: &Settings,
    display: &dyn ProgressDisplay,
) -> Result<MethodRun, StudyError> {
    let meter = display.run();
    let label = format!("{name}, ");
    Ok(MethodRun::once(name, system, settings, &|progress| {
        meter(&label, progress);
    })?)
}

/// A run of the paper's method in parts.
pub(crate) struct DrawnRun<'a> {
    /// What it is called.
    pub(crate) name: &'a str,
    pub(crate) system: &'a System,
    pub(crate) paper: &'a Paper,
    /// How many parts there are.
    pub(crate) parts: usize,
}

/// A run of the paper's method in parts, which share its positions; `seen` is called with what there is after
/// each. With a folder to keep them in, a run that was stopped goes on with the parts that it has.
pub(crate) fn in_parts(
    drawn: &DrawnRun,
    effort: Effort,
    seen: &mut dyn FnMut(&MethodRun),
) -> Result<MethodRun, StudyError> {
    let DrawnRun {
        name,
        system,
        paper,
        parts,
    } = *drawn;
    let (meter, label) = (effort.display.run(), format!("{name}, "));
    let settings = by_paper(Paper {
        rays: paper.rays.div_ceil(parts),
        ..paper.clone()
    });
    let kept = effort.keep.map(|folder| {
        let letters = name.chars().filter(char::is_ascii_alphanumeric);
        let file = folder.join(format!("{}.{KEPT}", letters.collect::<String>()));
        PartialFile::new(&file, &format!("{name} {parts} {settings:?}"))
    });
    let shape = shape(system);
    let before = match &kept {
        Some(kept) => kept.read(shape)?,
        None => None,
    };
    let mut repeats = before.unwrap_or_else(|| RepeatedRuns::new(shape));
    for part in repeats.parts..parts.min(effort.most) {
        // One meter for all parts.
        let whole = |progress: Progress| {
            let done = (part as f64 + progress.done) / parts as f64;
            let rays = progress.rays * parts as f64;
            meter(
                &label,
                Progress {
                    done,
                    rays,
                    ..progress
                },
            );
        };
        repeats.add(system, &settings, &whole)?;
        seen(&MethodRun::of_parts(name, &repeats));
        if let Some(kept) = &kept {
            kept.write(&repeats)?;
        }
    }
    Ok(MethodRun::of_parts(name, &repeats))
}

/// Removes what runs in parts kept in a folder, and the folder if nothing else is in it.
///
/// # Errors
/// A file that cannot be removed.
pub fn clear(folder: &Path) -> Result<(), StudyError> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Ok(());
    };
    for entry in entries {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == KEPT) {
            PartialFile::remove(&path)?;
        }
    }
    // A folder with other things in it stays.
    let _ = std::fs::remove_dir(folder);
    Ok(())
}

/// Samples [ny, nx] of a system's sensor.
fn shape(system: &System) -> [usize; 2] {
    match system.screens.last().map(|screen| &screen.kind) {
        Some(ScreenKind::Sensor(sensor)) => [sensor.pixels[1], sensor.pixels[0]],
        _ => [0, 0],
    }
}

impl Board {
    /// Notes a method, compared with references and with the target picture.
    pub(crate) fn add(&mut self, run: &MethodRun, rods: &[Rod], picture: Option<&Array2<f64>>) {
        // A field is not compared with itself.
        let others = rods.iter().filter(|rod| rod.field != run.field);
        let matches = others.map(|rod| {
            let found = Match::of(run.field.view(), rod.field);
            (rod.name.to_owned(), found)
        });
        let shown = light(run.field.view());
        self.entries.push(Entry {
            run: run.clone(),
            matches: matches.collect(),
            picture: picture.and_then(|wanted| ncc(shown.view(), wanted.view())),
            peak_um: None,
        });
    }

    /// Notes where the brightest pixel of the last method is, in µm.
    pub(crate) fn note_peak(&mut self, peak_um: Option<[f64; 2]>) {
        if let Some(entry) = self.entries.last_mut() {
            entry.peak_um = peak_um;
        }
    }

    /// Everything as text: what each method cost and showed, then how alike it is to each reference.
    pub(crate) fn text(&self) -> String {
        let number = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.4}"));
        let small = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.3e}"));
        let mut costs = Vec::new();
        let mut likes = Vec::new();
        for entry in &self.entries {
            let (run, cost) = (&entry.run, entry.run.cost);
            costs.push(vec![
                run.name.clone(),
                format!("{:.3e}", cost.draws),
                format!("{:.3e}", cost.rays as f64),
                format!("{:.1}", cost.seconds),
                cost.memory_mb
                    .map_or(String::new(), |mb| format!("{mb:.0}")),
                number(entry.picture),
                entry
                    .peak_um
                    .map_or(String::new(), |[x, y]| format!("{x:.2}, {y:.2}")),
                small(run.standard_error),
            ]);
            for (against, found) in &entry.matches {
                likes.push(vec![
                    run.name.clone(),
                    against.clone(),
                    found.ncc.map_or(String::new(), |v| format!("{v:.6}")),
                    small(found.unit_sum_mse),
                    small(found.field_error),
                    small(found.shape_error),
                ]);
            }
        }
        let cost_head = [
            "method",
            "draws",
            "rays",
            "s",
            "MB",
            "NCC with the picture",
            "peak µm",
            "standard error",
        ];
        let like_head = [
            "method",
            "against",
            "NCC",
            "unit-sum MSE",
            "field error",
            "shape error",
        ];
        format!(
            "{}\n{}",
            table(&cost_head, &costs, &[1, 2, 3, 4, 5, 6, 7]),
            table(&like_head, &likes, &[2, 3, 4, 5])
        )
    }

    /// The same as a document.
    fn document(&self) -> Vec<Value> {
        let entry = |entry: &Entry| {
            let like =
                |(against, found): &(String, Match)| json!({ "against": against, "match": found });
            json!({
                "method": entry.run.name,
                "cost": entry.run.cost,
                "standard_error": entry.run.standard_error,
                "ncc_with_picture": entry.picture,
                "peak_um": entry.peak_um,
                "matches": entry.matches.iter().map(like).collect::<Vec<_>>(),
            })
        };
        self.entries.iter().map(entry).collect()
    }

    /// The study: the board, notes under it, and files.
    pub(crate) fn study(&self, title: &str, notes: &str, files: Vec<(String, Vec<u8>)>) -> Study {
        let names: Vec<&String> = files.iter().map(|(name, _)| name).collect();
        let document = json!({
            "title": title,
            "files": names,
            "methods": self.document(),
            "notes": notes.lines().collect::<Vec<_>>(),
        });
        Study {
            text: format!("{title}\n\n{}\n{notes}\n", self.text()),
            document,
            pictures: files,
        }
    }
}
