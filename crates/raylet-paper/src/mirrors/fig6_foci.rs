//! Figure 6 of the source paper, designed: a conformal mirror with two foci, found by gradients from phases that
//! ignore its height.

use raylet::file::arrays::phase_file::npy;
use raylet::file::result::machine::Machine;
use raylet_plot::text_table::table;
use serde_json::{Value, json};

use crate::mirrors::conformal_mirror::{Conformal, LitArea, Show, Substrate};
use crate::mirrors::conformal_seen::Seen;
use crate::mirrors::mirror_search::{Sought, forget, seek};
use crate::study::{Effort, Study};
use crate::study_error::StudyError;

/// The searches, by the pixels that are lit, and a mirror that is not sought.
const NAMES: [&str; 2] = ["square", "disc"];
const WEIGHTED: &str = "disc_weighted";

/// Iterations of each search.
const ITERATIONS: usize = 30;
const QUICK: usize = 20;

/// Share of the full size of a quick study.
const SMALL: f64 = 0.08;

/// What was found.
struct Row {
    name: &'static str,
    title: String,
    seen: Seen,
    /// Iterations, evaluations and seconds of the search.
    search: Option<(usize, usize, f64)>,
}

/// Designs mirrors with square and round apertures, and weights the round one.
///
/// # Errors
/// What the library refuses, and files that cannot be kept.
pub fn fig6_foci(effort: Effort) -> Result<Study, StudyError> {
    let mirror = Conformal {
        substrate: Substrate::Bump,
        show: Show::Foci,
        scale: if effort.quick { SMALL } else { 1.0 },
    };
    let iterations = if effort.quick { QUICK } else { ITERATIONS };
    let (mut study, mut rows) = (Study::default(), Vec::new());
    for (name, aperture) in NAMES.into_iter().zip([LitArea::Square, LitArea::Disc]) {
        let sought = seek(name, mirror, aperture, iterations, effort)?;
        let values = sought.values();
        let seen = sought.seen(name, &values, effort.display)?;
        let title = format!("Two foci, designed; pixels lit: {name}{}", size(&mirror));
        let picture = sought.png(&title, &values, &seen)?;
        study.pictures.push((format!("{name}.png"), picture));
        for (array, which) in sought.arrays().iter().zip(["1", "2"]) {
            let file = format!("{name}_phase_{which}.npy");
            study.pictures.push((file, npy(array)?));
        }
        let search = Some((sought.iterations, sought.evaluations, sought.seconds));
        rows.push(Row {
            name,
            title,
            seen,
            search,
        });
        if aperture == LitArea::Disc {
            rows.push(weighted(&sought, &mut study, effort)?);
        }
    }
    study.text = text(&rows, &mirror);
    let entries: Vec<Value> = rows.iter().map(entry).collect();
    study.document = json!({ "mirrors": entries, "machine": Machine::here() });
    forget(effort.keep, &NAMES)?;
    Ok(study)
}

/// The disc's pixels times their distance from the middle over the rim's: what a weight on the rim brings and takes.
fn weighted(disc: &Sought, study: &mut Study, effort: Effort) -> Result<Row, StudyError> {
    let (mut values, mirror) = (disc.values(), disc.mirror);
    for ((j, i), value) in values.indexed_iter_mut() {
        let [x, y] = [i, j].map(|n| mirror.place(n));
        *value *= (2.0 * x.hypot(y) / mirror.width()).min(1.0);
    }
    let seen = disc.seen(WEIGHTED, &values, effort.display)?;
    let title = format!("The designed disc times r/R{}", size(&mirror));
    let picture = disc.png(&title, &values, &seen)?;
    study.pictures.push((format!("{WEIGHTED}.png"), picture));
    Ok(Row {
        name: WEIGHTED,
        title,
        seen,
        search: None,
    })
}

fn size(mirror: &Conformal) -> String {
    match mirror.scale {
        1.0 => String::new(),
        scale => format!(", at {scale} of the full size"),
    }
}

/// The numbers as text.
fn text(rows: &[Row], mirror: &Conformal) -> String {
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let um = |length: f64| format!("{:.3}", 1e3 * length);
            let [apart, x, y] = row.seen.foci.unwrap_or([f64::NAN; 3]);
            let searched = row.search.map(|(iterations, evaluations, seconds)| {
                format!("{iterations}, {evaluations}, {seconds:.0} s")
            });
            vec![
                row.name.to_owned(),
                um(apart),
                format!("{} × {}", um(x), um(y)),
                um(0.5 * (x + y)),
                row.seen
                    .lobe
                    .map_or(String::new(), |lobe| format!("{lobe:.3}")),
                format!("{:.3}", row.seen.light),
                searched.unwrap_or_default(),
            ]
        })
        .collect();
    let head = [
        "pixels",
        "apart µm",
        "FWHM µm",
        "mean",
        "side lobe",
        "light in 4.1 µm squares",
        "iterations, evaluations, time",
    ];
    format!(
        "Two foci by a mirror of smallest radius 506 λ{}, by the direct integral over its surface\n{}\n",
        size(mirror),
        table(&head, &lines, &[1, 2, 3, 4, 5])
    )
}

/// The same as a document.
fn entry(row: &Row) -> Value {
    json!({
        "name": row.name,
        "title": row.title,
        "separation_and_fwhm_um": row.seen.foci.map(|foci| foci.map(|length| 1e3 * length)),
        "side_lobe": row.seen.lobe,
        "light_in_windows": row.seen.light,
        "pairs": row.seen.pairs,
        "iterations": row.search.map(|search| search.0),
        "evaluations": row.search.map(|search| search.1),
        "seconds": row.search.map(|search| search.2),
    })
}
