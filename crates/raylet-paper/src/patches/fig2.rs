//! Figure 2 of the source paper: how many patches cover a hologram, what periods cost, and what flat
//! patches cost on a curved mirror.

use raylet::file::result::machine::Machine;
use raylet_plot::text_table::table;
use raylet_testkit::patterns::star_hologram;
use serde_json::json;

use crate::patches::covering::{Covering, CoveringCase, RULES};
use crate::patches::flat_patch::{Bent, FlatPatches};
use crate::study::Study;
use crate::study_error::StudyError;

/// Wavelength in mm, and numerical aperture.
const WAVELENGTH: f64 = 1e-3;
const APERTURE: f64 = 0.7;

/// Measures the three parts.
///
/// # Errors
/// What the library refuses.
pub fn fig2(quick: bool) -> Result<Study, StudyError> {
    let width = if quick { 64 } else { 400 };
    let system = star_hologram(width, APERTURE, WAVELENGTH);
    let covering = Covering::measure(&system, &case(width, quick))?;
    let flat = match quick {
        true => FlatPatches::measure(&[10, 20], &[250.0, 1000.0]),
        false => FlatPatches::measure(
            &[10, 16, 24, 36, 50, 70, 100, 150, 200],
            &[250.0, 506.0, 1000.0, 2500.0],
        ),
    }?;
    let title = format!("Hologram of {width} wavelengths, NA {APERTURE}");
    let mut study = Study {
        text: format!(
            "{title}\n{}\n{}",
            covering_text(&covering),
            flat_text(&flat)
        ),
        document: document(&covering, &flat),
        pictures: vec![
            (String::from("patches.png"), covering.images_png(&title)?),
            (String::from("rays.png"), covering.charts_png(&title)?),
            (
                String::from("curvature.png"),
                flat.png("Flat patches on a convex spherical mirror")?,
            ),
        ],
    };
    study.export_scene(&system, "star", &title)?;
    Ok(study)
}

/// The paper's sides of an eighth, a quarter and half of the hologram, and some between.
fn case(width: usize, quick: bool) -> CoveringCase {
    let share = |part: f64| part * width as f64;
    CoveringCase {
        sides: [0.125, 0.25, 0.5].map(share).to_vec(),
        between: match quick {
            true => Vec::new(),
            false => [0.1875, 0.375].map(share).to_vec(),
        },
        counts: match quick {
            true => vec![1, 30, 1000],
            false => vec![1, 3, 10, 30, 100, 300, 1000, 3000, 10_000],
        },
        periods: match quick {
            true => vec![1.0, 2.0],
            false => vec![1.0, 1.5, 2.0, 3.0, 4.0],
        },
    }
}

fn covering_text(found: &Covering) -> String {
    let rows: Vec<Vec<String>> = found
        .needs
        .iter()
        .map(|need| {
            vec![
                need.rule.to_owned(),
                format!("{:.0}", need.side),
                need.positions
                    .map_or(String::from("never"), |n| n.to_string()),
                format!("{:.4}", need.most),
            ]
        })
        .collect();
    let head = ["positions", "patch λ", "rays for NCC 0.99", "NCC at 16384"];
    let mut text = table(&head, &rows, &[1, 2, 3]);
    let rows: Vec<Vec<String>> = found
        .padding
        .iter()
        .map(|[ratio, like, error]| {
            vec![
                format!("{ratio}"),
                format!("{like:.4}"),
                format!("{error:.2e}"),
            ]
        })
        .collect();
    text += "\nThe whole hologram against free space:\n";
    text += &table(&["period / width", "NCC", "field error"], &rows, &[0, 1, 2]);
    text += &format!("  {} sums in {:.1} s\n", found.sums, found.seconds);
    text
}

fn flat_text(found: &FlatPatches) -> String {
    let pair = |[all, shape]: [f64; 2]| format!("{all:.3} {shape:.3}");
    let row = |bent: &Bent| {
        vec![
            format!("{:.0}", bent.radius),
            format!("{:.0}", bent.side),
            format!("{:.4}", bent.angle),
            format!("{:.3}", bent.phase),
            pair(bent.tangent),
            pair(bent.incident),
            pair(bent.whole),
        ]
    };
    let rows: Vec<Vec<String>> = found.found.iter().map(row).collect();
    let head = [
        "R λ",
        "D λ",
        "arcsin(D/2R)",
        "2kD²/8R",
        "tangent",
        "incident",
        "with the height",
    ];
    format!(
        "One patch on a convex spherical mirror: field error, and that of its shape\n{}  {} rays in {:.1} s\n",
        table(&head, &rows, &[0, 1, 2, 3, 4, 5, 6]),
        found.rays,
        found.seconds
    )
}

fn document(covering: &Covering, flat: &FlatPatches) -> serde_json::Value {
    let curves = covering.curves.iter().map(|curve| {
        json!({ "positions": curve.rule, "side": curve.side, "rays_ncc_field_error": curve.points })
    });
    let needs = covering.needs.iter().map(|need| {
        json!({
            "positions": need.rule,
            "side": need.side,
            "rays": need.positions,
            "ncc_at_most": need.most,
        })
    });
    let bent = flat.found.iter().map(|bent| {
        json!({
            "radius": bent.radius,
            "side": bent.side,
            "angle_bound": bent.angle,
            "phase_error": bent.phase,
            "tangent": bent.tangent,
            "incident": bent.incident,
            "with_height": bent.whole,
        })
    });
    json!({
        "rules": RULES.map(|rule| rule.name),
        "curves": curves.collect::<Vec<_>>(),
        "needs": needs.collect::<Vec<_>>(),
        "period_ncc_field_error": covering.padding,
        "flat_patches": bent.collect::<Vec<_>>(),
        "sums": covering.sums,
        "rays": flat.rays,
        "seconds": covering.seconds + flat.seconds,
        "machine": Machine::here(),
    })
}
