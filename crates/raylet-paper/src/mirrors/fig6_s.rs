//! Figure 6 of the source paper, designed: a conformal mirror of phases that shows a letter S.

use raylet::file::arrays::phase_file::npy;
use raylet::file::result::machine::Machine;
use raylet::wave::grid::metrics::ncc;
use serde_json::json;

use crate::mirrors::conformal_mirror::{Conformal, LitArea, Show, Substrate};
use crate::mirrors::mirror_search::{forget, seek};
use crate::study::{Effort, Study};
use crate::study_error::StudyError;

const NAME: &str = "letter";

/// Iterations of the search.
const ITERATIONS: usize = 60;
const QUICK: usize = 30;

/// Share of the full size of a quick study.
const SMALL: f64 = 0.15;

/// Designs the mirror and looks at it by the direct integral.
///
/// # Errors
/// What the library refuses, and files that cannot be kept.
pub fn fig6_s(effort: Effort) -> Result<Study, StudyError> {
    let mirror = Conformal {
        substrate: Substrate::Bump,
        show: Show::Letter,
        scale: if effort.quick { SMALL } else { 1.0 },
    };
    let iterations = if effort.quick { QUICK } else { ITERATIONS };
    let sought = seek(NAME, mirror, LitArea::Disc, iterations, effort)?;
    let values = sought.values();
    let shares = sought.search.design.shares(values.view());
    let known = ncc(shares.view(), sought.search.target.view());
    let seen = sought.seen(NAME, &values, effort.display)?;
    let size = match mirror.scale {
        1.0 => String::new(),
        scale => format!(", at {scale} of the full size"),
    };
    let title = format!("An S by a mirror of smallest radius 506 λ{size}");
    let mut study = Study::default();
    let picture = sought.png(&title, &values, &seen)?;
    study.pictures.push((format!("{NAME}.png"), picture));
    for array in &sought.arrays() {
        study
            .pictures
            .push((format!("{NAME}_phase.npy"), npy(array)?));
    }
    let points = seen.fields.first().map_or(0, |field| field.values.len());
    study.text = format!(
        "{title}\n{} iterations, {} evaluations, {:.0} s\nNCC over the sensor: {:.4} as the design knows it, {:.4} by \
         the direct integral over the surface at {points} points between its samples ({:.2e} pairs)\n{:.1} % of the \
         light in the letter\n",
        sought.iterations,
        sought.evaluations,
        sought.seconds,
        known.unwrap_or(f64::NAN),
        seen.letter.unwrap_or(f64::NAN),
        seen.pairs,
        100.0 * seen.light,
    );
    study.document = json!({
        "title": title,
        "iterations": sought.iterations,
        "evaluations": sought.evaluations,
        "seconds": sought.seconds,
        "ncc_as_designed": known,
        "ncc_by_direct_integral": seen.letter,
        "points": points,
        "light_in_letter": seen.light,
        "machine": Machine::here(),
    });
    forget(effort.keep, &[NAME])?;
    Ok(study)
}
