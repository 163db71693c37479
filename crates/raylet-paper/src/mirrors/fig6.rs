//! Figure 6 of the source paper, forward: a conformal diffractive mirror with conjugate phases.

use raylet::engine::plan::settings::Sag;
use raylet::file::result::machine::Machine;
use raylet_plot::text_table::table;
use serde_json::json;

use crate::mirrors::conformal_methods::{Comparison, Draws, Outcome, PropagationMethod};
use crate::mirrors::conformal_mirror::{Conformal, Show, Substrate};
use crate::study::Study;
use crate::study_error::StudyError;

/// Samples along each axis of the picture of the whole sensor.
const OVERVIEW: usize = 250;
const QUICK_OVERVIEW: usize = 100;

/// Measures both substrates with both things to show.
///
/// # Errors
/// What the library refuses.
pub fn fig6(quick: bool) -> Result<Study, StudyError> {
    let mut study = Study::default();
    let mut entries = Vec::new();
    for substrate in [Substrate::Bumps, Substrate::Bump] {
        for show in [Show::Foci, Show::Letter] {
            let mirror = Conformal {
                substrate,
                show,
                scale: if quick { 0.06 } else { 1.0 },
            };
            let found = Comparison::measure(mirror, &methods(substrate, quick))?;
            let [name, title] = names(&mirror);
            let pixels = if quick { QUICK_OVERVIEW } else { OVERVIEW };
            let overview = Comparison::overview(&mirror, pixels)?;
            let picture = found.png(&title, &overview)?;
            study.pictures.push((format!("{name}.png"), picture));
            study.export_scene(&found.system(), &name, &title)?;
            study.text += &block(&title, &found);
            entries.push(entry(&name, &found));
        }
    }
    study.document = json!({ "mirrors": entries, "machine": Machine::here() });
    Ok(study)
}

/// As many as the paper draws on planes. With the height, whose patches take many transforms each, as many
/// in all, from a fifteenth of the positions: what covers each place is divided out.
fn draws(sag: Sag, quick: bool) -> Draws {
    let (rays, secondary) = match (quick, sag) {
        (true, _) => (50, 500),
        (false, Sag::True) => (200, 60_000),
        (false, Sag::Tangent | Sag::Incident) => (3000, 4000),
    };
    Draws { rays, secondary }
}

/// What is compared; on the nearly flat substrate the methods between planes and the height hardly differ.
fn methods(substrate: Substrate, quick: bool) -> Vec<PropagationMethod> {
    let paper = |sag| PropagationMethod::Paper(sag, draws(sag, quick));
    let mut methods = vec![PropagationMethod::Default, paper(Sag::Tangent)];
    if substrate == Substrate::Bump {
        methods.push(paper(Sag::Incident));
    }
    methods.push(paper(Sag::True));
    methods
}

/// A name for files and a title.
fn names(mirror: &Conformal) -> [String; 2] {
    let (shown, what) = match mirror.show {
        Show::Foci => ("foci", "Two foci"),
        Show::Letter => ("letter", "An S"),
    };
    let (made, on) = match mirror.substrate {
        Substrate::Bumps => ("flat", "a nearly flat substrate"),
        Substrate::Bump => ("curved", "a substrate of smallest radius 506 λ"),
    };
    let size = match mirror.scale {
        1.0 => String::new(),
        scale => format!(", at {scale} of the full size"),
    };
    [
        format!("{shown}_{made}"),
        format!("{what} by a mirror on {on}{size}"),
    ]
}

/// The numbers of one mirror as text.
fn block(title: &str, found: &Comparison) -> String {
    let row = |outcome: &Outcome| {
        let um = |length: f64| format!("{:.2}", 1e3 * length);
        let foci = outcome.foci.map(|foci| foci.map(um));
        let shown = match (foci, outcome.letter) {
            (Some([apart, x, y]), _) => format!("{apart} µm apart, FWHM {x} × {y} µm"),
            (None, Some(like)) => format!("NCC {like:.3}"),
            (None, None) => String::from("no foci"),
        };
        let [all, shape] = outcome.errors.map(|error| match outcome.method {
            PropagationMethod::Exact => String::new(),
            _ => format!("{error:.2e}"),
        });
        vec![
            outcome.method.name(),
            shown,
            all,
            shape,
            format!("{:.4}", outcome.like),
            format!("{:.2e}", outcome.work),
            format!("{:.1}", outcome.seconds),
        ]
    };
    let rows: Vec<Vec<String>> = found.outcomes.iter().map(row).collect();
    let head = [
        "by",
        "shown",
        "field error",
        "of its shape",
        "NCC",
        "rays or pairs",
        "s",
    ];
    format!("{title}\n{}\n", table(&head, &rows, &[2, 3, 4, 5, 6]))
}

/// The same as a document.
fn entry(name: &str, found: &Comparison) -> serde_json::Value {
    let outcomes = found.outcomes.iter().map(|outcome| {
        json!({
            "by": outcome.method.name(),
            "field_error": outcome.errors[0],
            "shape_error": outcome.errors[1],
            "ncc": outcome.like,
            "separation_and_fwhm_um": outcome.foci.map(|foci| foci.map(|length| 1e3 * length)),
            "ncc_with_letter": outcome.letter,
            "rays_or_pairs": outcome.work,
            "seconds": outcome.seconds,
        })
    });
    json!({ "name": name, "outcomes": outcomes.collect::<Vec<_>>() })
}
