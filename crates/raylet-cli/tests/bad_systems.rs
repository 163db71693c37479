//! Designs of impossible systems: one message with an address, exit code 2, nothing written.

use ndarray::Array2;
use raylet::file::arrays::image::write_gray16;

use crate::refusal::{none_of, wrong};
use crate::stage::{SCENE, Stage};

/// Two elements in free space at two wavelengths, for a picture.
const TWO: &str = r#"version = 1
wavelength_um = [0.6, 0.5]
source = { kind = "plane" }
[[element]]
kind = "doe"
name = "first"
thickness_mm = 0.4
aperture = { disc = { radius_mm = 0.02 } }
[[element.layer]]
kind = "pixels"
pitch_um = 4
size = [10, 10]
phase = "first.npy"
[[element]]
kind = "doe"
name = "second"
thickness_mm = 0.4
aperture = { disc = { radius_mm = 0.02 } }
[[element.layer]]
kind = "pixels"
pitch_um = 4
size = [10, 10]
[[element]]
kind = "sensor"
pixels = [12, 10]
pitch_um = 4
[design]
iterations = 8
[[design.element]]
name = "first"
[[design.loss]]
kind = "likeness"
picture = "picture.png"
size_mm = [0.03, 0.03]
"#;

/// A passage of the scene, what stands in its place, and what the message must say.
type Case = (&'static str, &'static str, &'static [&'static str]);

const FIRST: &str = "name = \"first\"\n[[design.loss]]";
const KIND: &str = "kind = \"likeness\"\npicture = \"picture.png\"\nsize_mm = [0.03, 0.03]\n";
const LAYER: &str = "size = [10, 10]\nphase = \"first.npy\"\n";
const SIZE: &str = "size_mm = [0.03, 0.03]\n";
const PART: &str = "design.element[0]";
const LOSS: &str = "design.loss[0]";

const PARTS: [Case; 16] = [
    (
        FIRST,
        "name = \"first\"\nfree = \"all\"\n[[design.loss]]",
        &[".free", "two_phase"],
    ),
    (
        FIRST,
        "name = \"first\"\nfree = \"both\"\n[[design.loss]]",
        &["element[0].layer[0]", "no file for the amplitude"],
    ),
    (
        FIRST,
        "name = \"first\"\nfree = \"height\"\n[[design.loss]]",
        &["element[0].layer[0]", "kind \"height\""],
    ),
    (
        FIRST,
        "name = \"first\"\nfree = \"two_phase\"\n[[design.loss]]",
        &["element[0].layer[0]", "kind \"sum\""],
    ),
    (
        FIRST,
        "name = \"first\"\nhighest_um = 2\n[[design.loss]]",
        &[PART, ".highest_um", "height"],
    ),
    (
        FIRST,
        "name = \"first\"\nlevels = 1\n[[design.loss]]",
        &[PART, ".levels", "two or more"],
    ),
    (
        FIRST,
        "name = \"first\"\nblock = 0\n[[design.loss]]",
        &[PART, ".block", "above zero"],
    ),
    (
        FIRST,
        "name = \"first\"\nblur = 0.5\n[[design.loss]]",
        &[PART, ".blur", "one or more"],
    ),
    (
        FIRST,
        "name = \"first\"\nsmoothness = -1\n[[design.loss]]",
        &[PART, ".smoothness", "zero or more"],
    ),
    (
        FIRST,
        "name = \"first\"\nstart = \"spread\"\n[[design.loss]]",
        &[PART, ".start", "[hologram]"],
    ),
    (
        FIRST,
        "name = \"first\"\n[[design.element]]\nname = \"first\"\n[[design.loss]]",
        &["design.element[1].name", "once"],
    ),
    (
        FIRST,
        "name = \"third\"\n[[design.loss]]",
        &[PART, ".name", "third"],
    ),
    (
        LAYER,
        "phase = \"first.npy\"\n",
        &["element[0].layer[0]", "size = [nx, ny]"],
    ),
    (
        LAYER,
        "size = [10, 10]\n",
        &["element[0].layer[0]", "no file for the phase"],
    ),
    (
        LAYER,
        "size = [10, 10]\nphase = \"first.npy\"\namplitude = \"a.npy\"\n",
        &["element[0].layer[0].amplitude", "both"],
    ),
    (
        LAYER,
        "size = [10, 10]\nphase = \"first.npy\"\nfill = 1.5\n",
        &["element[0].layer[0].fill", "up to 1"],
    ),
];

const LOSSES: [Case; 17] = [
    ("likeness", "beauty", &[LOSS, "beauty", "overlap"]),
    ("picture.png", "none.png", &[LOSS, ".picture", "none.png"]),
    (SIZE, "", &[LOSS, "one without the other"]),
    (
        SIZE,
        "size_mm = [0.03, 0.03]\nmask = \"none.png\"\n",
        &[LOSS, ".mask", "none.png"],
    ),
    (
        SIZE,
        "size_mm = [0.03, 0.03]\nweight = 0\n",
        &[LOSS, ".weight", "above zero"],
    ),
    (
        SIZE,
        "size_mm = [0.03, 0.03]\nfield = [1]\n",
        &[LOSS, ".field", "below 1"],
    ),
    (
        SIZE,
        "size_mm = [0.03, 0.03]\nwavelength_um = [0.7]\n",
        &[LOSS, ".wavelength_um", "0.7", "0.6"],
    ),
    (
        SIZE,
        "size_mm = [0.03, 0.03]\nwavelength_um = []\n",
        &[LOSS, ".wavelength_um"],
    ),
    (
        SIZE,
        "size_mm = [0.03, 0.03]\nradius_mm = 1\n",
        &[LOSS, "radius_mm", "unknown"],
    ),
    (
        KIND,
        "kind = \"spot\"\nat_mm = [[1.0, 0.0]]\n",
        &[LOSS, ".at_mm", "off the sensor"],
    ),
    (
        KIND,
        "kind = \"spot\"\nat_mm = [[0.0, 0.0]]\nevenness = -1\n",
        &[LOSS, ".evenness", "zero or more"],
    ),
    (
        KIND,
        "kind = \"spot\"\nat_mm = []\n",
        &[LOSS, ".at_mm", "at least one"],
    ),
    (
        KIND,
        "kind = \"encircled_energy\"\nat_mm = [[2.0, 0.0]]\nradius_mm = 0.01\n",
        &[LOSS, ".at_mm", "circles on the sensor"],
    ),
    (
        KIND,
        "kind = \"efficiency\"\nradius_mm = 1\n",
        &[LOSS, "at_mm"],
    ),
    (
        KIND,
        "kind = \"likeness\"\npicture = \"picture.png\"\nsize_mm = [0.03, 0.03]\nmask = \"mask.png\"\n",
        &[LOSS, ".mask", "3 x 2 pixels", "as the picture has"],
    ),
    (KIND, "kind = \"overlap\"\n", &["hologram", "no hologram"]),
    (
        "[[design.loss]]\nkind = \"likeness\"\npicture = \"picture.png\"\nsize_mm = [0.03, 0.03]\n",
        "",
        &["design.loss", "found no loss"],
    ),
];

const REST: [Case; 8] = [
    (
        "[[design.loss]]",
        "[[design.field]]\n[[design.loss]]",
        &["design.field[0]", "angle_deg"],
    ),
    (
        "[[design.loss]]",
        "[[design.field]]\nangle_deg = [95, 0]\n[[design.loss]]",
        &["design.field[0].angle_deg", "90"],
    ),
    (
        "[[design.loss]]",
        "[[design.field]]\nposition_mm = [0, 0, -1]\n[[design.loss]]",
        &["design.field[0]", "plane source"],
    ),
    (
        "[[design.loss]]",
        "[[design.variable]]\npath = \"element[0].thickness_mm\"\nlowest = 1\n[[design.loss]]",
        &["design.variable[0].path", "lowest 1 and highest none"],
    ),
    (
        "iterations = 8",
        "levels = 4",
        &["design.levels", "[[design.element]]"],
    ),
    (
        "iterations = 8",
        "start = \"flat\"",
        &["design.start", "inside"],
    ),
    ("iterations = 8", "block = 2", &["design.block", "inside"]),
    (
        "iterations = 8",
        "efficiency = 0.1",
        &["design.efficiency", "[[design.loss]]"],
    ),
];

fn stage(text: &str) -> Stage {
    let stage = Stage::new(text);
    let picture = Array2::from_elem((4, 4), 1.0);
    write_gray16(stage.join("picture.png"), picture.view(), [0.0, 1.0]).unwrap();
    let mask = Array2::from_elem((2, 3), 1.0);
    write_gray16(stage.join("mask.png"), mask.view(), [0.0, 1.0]).unwrap();
    stage
}

#[test]
fn impossible_systems_are_reported_at_the_right_place() {
    let cases = PARTS.iter().chain(&LOSSES).chain(&REST);
    none_of(cases.map(|(from, to, says)| {
        assert!(TWO.contains(from), "{from}");
        let stage = stage(&TWO.replacen(from, to, 1));
        let says: Vec<&str> = ["scene.toml"].iter().chain(*says).copied().collect();
        wrong(&stage, &["design", "scene.toml"], &says)
    }));
    let none = Stage::new(&format!("{SCENE}[design]\n"));
    none_of([wrong(
        &none,
        &["design", "scene.toml"],
        &["nothing to design"],
    )]);
}
