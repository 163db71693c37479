//! Tests: files of CODE V and Zemax of other projects, against numbers of ray-optics.
//!
//! `scenes/prescriptions/reference.json` is made by `benches/peers/prescriptions.py`. The indices of ray-optics take the place of
//! glasses here, as glasses of the file itself, so that only the reading of a file is compared, and the tracing.

use std::fs;
use std::path::Path;

use crate::file::prescription::import::{ImportChoices, import_bytes};
use crate::file::prescription::lens_text::decoded;
use crate::file::prescription::optiland_test::{
    Reference, folder, landing, read, text, unit, with_indices as with_zemax_indices,
};
use crate::math::vec3::Vec3;

/// ray-optics has no diffraction in its paraxial numbers, and its rays miss the focus of this lens by millimetres.
const DIFFRACTIVE: &str = "CODV_65988.seq";

/// How many lenses and rays are compared.
const LENSES: usize = 26;
const RAYS: usize = 104;

/// The text with an index of its own for each glass.
fn with_indices(text: &str, indices: &[f64]) -> String {
    let (mut surface, mut glasses, mut out) = (0, String::new(), String::new());
    for line in text.lines() {
        let (body, _) = line.split_once('!').unwrap_or((line, ""));
        let words: Vec<&str> = body.split_whitespace().collect();
        let row = words
            .first()
            .is_some_and(|word| ["S", "SO", "SI"].contains(&word.to_uppercase().as_str()));
        match words.get(3) {
            Some(glass) if row && !glass.eq_ignore_ascii_case("refl") => {
                glasses += &format!("'G{surface}' {}\n", indices[surface]);
                out += &format!("{} 'G{surface}'\n", words[..3].join(" "));
            }
            _ => out += &format!("{body}\n"),
        }
        surface += usize::from(row);
    }
    format!("PRV\nPWL 500\n{glasses}END\n{out}")
}

#[test]
fn rayoptics_reads_the_same_lenses() {
    let json = fs::read_to_string(folder().join("reference.json")).unwrap();
    let reference: Reference = serde_json::from_str(&json).unwrap();
    let (mut lenses, mut rays, mut largest) = (0, 0, [0.0f64; 2]);
    let mut differ = Vec::new();
    for (name, peer) in &reference.sequences {
        if peer.rays.is_empty() || name == DIFFRACTIVE {
            continue;
        }
        // The surfaces of one file continue over several lines.
        let text = decoded(&fs::read(folder().join(name)).unwrap()).replace("&\n", "");
        let unit = if text.contains("DIM   I") { 25.4 } else { 1.0 };
        let text = with_indices(&text, &peer.indices);
        let lens = import_bytes(text.as_bytes(), Path::new(name), &ImportChoices::default());
        let lens = lens.unwrap_or_else(|fault| panic!("{fault}"));
        for (word, theirs) in [
            ("focal length (mm)", peer.focal_length),
            ("back focal distance (mm)", peer.back_focal_distance),
            ("focal length, axis unfolded (mm)", peer.focal_length),
        ] {
            // Of tilted parts raylet has none.
            if let (Some(ours), Some(theirs)) = (lens.report.number(word), theirs) {
                let error = (ours.abs() / (theirs * unit) - 1.0).abs();
                if error > 1e-8 {
                    differ.push(format!("{name}: {word} {ours}, {theirs}"));
                }
                largest[0] = largest[0].max(error);
            }
        }
        for ray in &peer.rays {
            let Some(theirs) = ray.landing else { continue };
            let [x, y, z] = ray.direction;
            let ours = landing(&lens, ray.start.map(|a| a * unit), Vec3::new(x, y, z));
            for (ours, theirs) in ours.into_iter().zip(theirs) {
                let error = (ours - theirs * unit).abs();
                if error > 1e-9 {
                    differ.push(format!("{name}: from {:?} {ours}, {theirs}", ray.start));
                }
                largest[1] = largest[1].max(error);
            }
            rays += 1;
        }
        lenses += 1;
    }
    assert!(differ.is_empty(), "{differ:#?}");
    assert!(
        lenses >= LENSES && rays >= RAYS,
        "{lenses} lenses, {rays} rays, {largest:?}"
    );
}

/// Files of Zemax that ray-optics reads as other lenses; docs/guide/opticstudio.md says why.
const OTHERWISE: [&str; 6] = [
    "HoO-V2C18Ex46.zmx",
    "HoO-V2C18Ex66.zmx",
    "HoO-V2C18Ex66NEW.zmx",
    "curved_reflective_grating.zmx",
    "curved_transmission_grating.zmx",
    "flat_transmission_grating.zmx",
];

#[test]
fn rayoptics_reads_the_same_files_of_zemax() {
    let json = fs::read_to_string(folder().join("reference.json")).unwrap();
    let reference: Reference = serde_json::from_str(&json).unwrap();
    let (mut lenses, mut rays, mut largest) = (0, 0, 0.0f64);
    let mut differ = Vec::new();
    for (name, peer) in &reference.zemax {
        if peer.rays.is_empty() || OTHERWISE.contains(&name.as_str()) {
            continue;
        }
        let text = text(name);
        let unit = unit(&text);
        let lens = read(&with_zemax_indices(&text, &peer.indices), name, 1);
        for ray in &peer.rays {
            let Some(theirs) = ray.landing else { continue };
            let [x, y, z] = ray.direction;
            let ours = landing(&lens, ray.start.map(|a| a * unit), Vec3::new(x, y, z));
            for (ours, theirs) in ours.into_iter().zip(theirs) {
                let error = (ours - theirs * unit).abs();
                if error > 1e-9 {
                    differ.push(format!("{name}: from {:?} {ours}, {theirs}", ray.start));
                }
                largest = largest.max(error);
            }
            rays += 1;
        }
        lenses += 1;
    }
    assert!(differ.is_empty(), "{differ:#?}");
    assert!(
        lenses >= 12 && rays >= 40,
        "{lenses} lenses, {rays} rays, {largest:?}"
    );
}
