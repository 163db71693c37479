//! Tests: lens files of other projects, against numbers of Optiland and against those that OpticStudio left in the files.
//!
//! `scenes/prescriptions/reference.json` is made by `benches/peers/prescriptions.py`. Optiland's indices take the place of glasses
//! here, so that only the reading of a file is compared, and the tracing.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::engine::geometrical::system_trace::trace_system;
use crate::file::model::build::system;
use crate::file::prescription::import::{ImportChoices, ImportedLens, import_bytes};
use crate::file::prescription::lens_text::decoded;
use crate::file::scene::element::Element;
use crate::math::vec3::Vec3;
use crate::optics::source::Source;

#[derive(Deserialize)]
pub(crate) struct Reference {
    lenses: BTreeMap<String, Lens>,
    /// Files of CODE V, as ray-optics reads them.
    pub(crate) sequences: BTreeMap<String, Lens>,
    /// Files of Zemax, as ray-optics reads them.
    pub(crate) zemax: BTreeMap<String, Lens>,
}

#[derive(Deserialize)]
pub(crate) struct Lens {
    #[serde(default)]
    pub(crate) indices: Vec<f64>,
    pub(crate) focal_length: Option<f64>,
    pub(crate) back_focal_distance: Option<f64>,
    #[serde(default)]
    pub(crate) rays: Vec<Ray>,
}

#[derive(Deserialize)]
pub(crate) struct Ray {
    pub(crate) start: [f64; 2],
    pub(crate) direction: [f64; 3],
    pub(crate) landing: Option<[f64; 2]>,
}

/// Optiland takes parameter 2 of a toroid as its radius of rotation, which is parameter 1 in files of OpticStudio: its rays are
/// those of a cylinder.
const TOROID: &str = "HoO-V2C18Ex46.zmx";

pub(crate) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/prescriptions")
}

pub(crate) fn text(name: &str) -> String {
    decoded(&fs::read(folder().join(name)).unwrap())
}

pub(crate) fn read(text: &str, name: &str, field: usize) -> ImportedLens {
    let choices = ImportChoices {
        field,
        ..ImportChoices::default()
    };
    let lens = import_bytes(text.as_bytes(), Path::new(name), &choices);
    lens.unwrap_or_else(|fault| panic!("{fault}"))
}

/// The text with an index in place of each glass; Optiland counts no coordinate breaks.
pub(crate) fn with_indices(text: &str, indices: &[f64]) -> String {
    let (mut surface, mut out) = (None::<usize>, String::new());
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["SURF", ..] => surface = Some(surface.map_or(0, |number| number + 1)),
            ["TYPE", "COORDBRK", ..] => surface = surface.and_then(|number| number.checked_sub(1)),
            _ => {}
        }
        match words[..] {
            ["GLAS", name, ..] if name != "MIRROR" => {
                let index = indices[surface.unwrap()];
                out += &format!("  GLAS ___BLANK 1 0 {index} 0\n");
            }
            _ => out += &format!("{line}\n"),
        }
    }
    out
}

/// Where a ray from a point of the first surface's vertex plane meets the image, in mm on its axes.
pub(crate) fn landing(lens: &ImportedLens, start: [f64; 2], direction: Vec3) -> [f64; 2] {
    landing_of(lens, start, direction).unwrap()
}

/// The same; nothing where the ray misses a surface.
pub(crate) fn landing_of(
    lens: &ImportedLens,
    start: [f64; 2],
    direction: Vec3,
) -> Option<[f64; 2]> {
    // Rims are no matter here: rays lie on them.
    let made = system(&lens.scene, 0).unwrap().without_edges();
    let origin = Vec3::new(0.0, 0.0, 0.0);
    let source = Source::Plane { direction, origin };
    let slopes = [direction.x, direction.y].map(|cosine| cosine / direction.z);
    let ahead = |depth: f64| [0, 1].map(|i| start[i] + slopes[i] * (lens.first_element_mm + depth));
    // A ray is given by where it meets the first screen, which may be curved.
    let mut at = ahead(0.0);
    for _ in 0..50 {
        at = ahead(made.screens[0].shape.sag(at[0], at[1])?);
    }
    let ray = trace_system(&made, &source, at);
    if ray.lost.is_some() {
        return None;
    }
    let hit = made
        .screens
        .last()
        .unwrap()
        .frame
        .to_local(ray.hits.last().unwrap().point);
    let Some(Element::Sensor(sensor)) = lens.scene.element.last() else {
        panic!("no sensor");
    };
    Some([hit.x + sensor.decenter_mm[0], hit.y + sensor.decenter_mm[1]])
}

/// Millimetres in the unit of the file; Optiland does not convert.
pub(crate) fn unit(text: &str) -> f64 {
    if text.contains("UNIT IN ") { 25.4 } else { 1.0 }
}

#[test]
fn optiland_reads_the_same_lenses() {
    let json = fs::read_to_string(folder().join("reference.json")).unwrap();
    let reference: Reference = serde_json::from_str(&json).unwrap();
    let (mut lenses, mut rays) = (0, 0);
    for (name, peer) in &reference.lenses {
        if peer.rays.is_empty() || name == TOROID {
            continue;
        }
        let text = text(name);
        let (unit, lens) = (
            unit(&text),
            read(&with_indices(&text, &peer.indices), name, 1),
        );
        for (word, theirs) in [
            ("focal length (mm)", peer.focal_length),
            ("back focal distance (mm)", peer.back_focal_distance),
            ("focal length, axis unfolded (mm)", peer.focal_length),
        ] {
            // Of tilted parts raylet has none.
            if let (Some(ours), Some(theirs)) = (lens.report.number(word), theirs) {
                // Behind one mirror Optiland has another sign for its own.
                let theirs = if word.ends_with("unfolded (mm)") {
                    theirs.abs()
                } else {
                    theirs
                };
                let ours = if word.ends_with("unfolded (mm)") {
                    ours.abs()
                } else {
                    ours
                };
                let error = (ours / (theirs * unit) - 1.0).abs();
                assert!(error < 1e-9, "{name}: {word} {ours}, {theirs}");
            }
        }
        for ray in &peer.rays {
            let Some(theirs) = ray.landing else { continue };
            let [x, y, z] = ray.direction;
            let ours = landing(&lens, ray.start.map(|a| a * unit), Vec3::new(x, y, z));
            for (ours, theirs) in ours.into_iter().zip(theirs) {
                assert!(
                    (ours - theirs * unit).abs() < 1e-7,
                    "{name}: {ours}, {theirs}"
                );
            }
            rays += 1;
        }
        lenses += 1;
    }
    assert!(lenses >= 12 && rays >= 40, "{lenses} lenses, {rays} rays");
}

/// The largest distance from the axis at which rays of all fields through four points of the pupil's rim meet the image.
fn image_radius(name: &str) -> f64 {
    let text = text(name);
    let fields = text.lines().find_map(|line| line.strip_prefix("FTYP "));
    let count = fields
        .and_then(|line| line.split_whitespace().nth(2))
        .unwrap();
    let mut largest = 0.0f64;
    for field in 1..=count.parse().unwrap() {
        let lens = read(&text, name, field);
        let number = |word| lens.report.number(word).unwrap();
        let radius = 0.5 * number("entrance pupil diameter (mm)");
        let depth = number("entrance pupil position (mm)");
        let Source::Plane { direction, .. } = system(&lens.scene, 0).unwrap().source else {
            panic!("no plane wave");
        };
        let slopes = [direction.x, direction.y].map(|cosine| cosine / direction.z);
        for [x, y] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
            let start = [
                radius * x - slopes[0] * depth,
                radius * y - slopes[1] * depth,
            ];
            let [x, y] = landing(&lens, start, direction);
            largest = largest.max(x.hypot(y));
        }
    }
    largest
}

/// OpticStudio stores the semi-diameter of the image that it computed from real rays. It settles signs: of gratings in
/// transmission and reflection, of tilts and of shifts.
#[test]
fn images_are_as_wide_as_opticstudio_computed_them() {
    for (name, stored, within) in [
        (
            "flat_transmission_grating.zmx",
            13.319_073_572_664_644,
            1e-12,
        ),
        (
            "curved_transmission_grating.zmx",
            15.906_291_922_754_132,
            1e-12,
        ),
        (
            "curved_reflective_grating.zmx",
            24.799_609_695_789_15,
            1e-12,
        ),
        // Its rays were others than these four, whose image is round.
        ("HoO-V2C18Ex46.zmx", 5.313_781_281_956_929, 2e-5),
        (
            "complicated_fold_mirrors_setup_v2.zmx",
            0.262_793_237_011_282,
            1e-12,
        ),
    ] {
        let found = image_radius(name);
        assert!(
            (found / stored - 1.0).abs() < within,
            "{name}: {found} {stored}"
        );
    }
}
