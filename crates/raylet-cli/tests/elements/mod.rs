//! Bad input for every kind of surface, aperture, layer, break and setting: one message with file, line and field.

use crate::refusal::{self, none_of};
use crate::stage::{self, Stage};

/// A scene of an element, some light and a sensor.
const SCENE: &str = r#"version = 1
wavelength_um = 0.5
source = { kind = "plane" }
#settings
[[element]]
kind = "doe"
thickness_mm = 20
aperture = { disc = { radius_mm = 0.2 } }
#surface
[[element.layer]]
kind = "lens"
focal_length_mm = 50
#layer
#element
[[element]]
kind = "sensor"
pixels = [16, 16]
pitch_um = 5
"#;

/// Where the case goes, the case, the field that must be named with its line, and what was found.
type Case = (&'static str, &'static str, &'static str, &'static str);

const SURFACES: &[Case] = &[
    (
        "surface",
        r#"shape = { kind = "sphere" }"#,
        "9:18: element[0].shape.kind",
        "\"sphere\"",
    ),
    (
        "surface",
        r#"shape = { kind = "biconic", radius_x_mm = 0 }"#,
        "9:43: element[0].shape.radius_x_mm",
        "0.0",
    ),
    (
        "surface",
        r#"shape = { kind = "biconic", radius_x_mm = 0.05 }"#,
        "8:12: element[0].aperture",
        "does not exist",
    ),
    (
        "surface",
        r#"shape = { kind = "biconic", conic_x = nan }"#,
        "9:39: element[0].shape.conic_x",
        "nan",
    ),
    (
        "surface",
        r#"shape = { kind = "toroid", aspheric = 3 }"#,
        "9:39: element[0].shape.aspheric",
        "3",
    ),
    (
        "surface",
        r#"shape = { kind = "toroid", rotation_radius_mm = 0.1 }"#,
        "8:12: element[0].aperture",
        "does not exist",
    ),
    (
        "surface",
        r#"shape = { kind = "cylinder", radius_mm = 5 }"#,
        "9:9: element[0].shape",
        "straight_along",
    ),
    (
        "surface",
        r#"shape = { kind = "cylinder", straight_along = "z", radius_mm = 5 }"#,
        "9:47: element[0].shape.straight_along",
        "\"z\"",
    ),
    (
        "surface",
        r#"shape = { kind = "cylinder", straight_along = 1, radius_mm = 5 }"#,
        "9:47: element[0].shape.straight_along",
        "one of `x`, `y`",
    ),
    (
        "surface",
        r#"shape = { kind = "odd", coefficients = [] }"#,
        "9:40: element[0].shape.coefficients",
        "empty",
    ),
    (
        "surface",
        r#"shape = { kind = "xy", norm_radius_mm = 1, terms = [{ x = 41, height_um = 1 }] }"#,
        "9:59: element[0].shape.terms[0].x",
        "41",
    ),
    (
        "surface",
        r#"shape = { kind = "xy", norm_radius_mm = 1e-12, terms = [{ x = 12, height_um = 1 }] }"#,
        "8:12: element[0].aperture",
        "does not exist",
    ),
    (
        "surface",
        r#"shape = { kind = "zernike", norm_radius_mm = -1, coefficients_um = [1] }"#,
        "9:46: element[0].shape.norm_radius_mm",
        "-1.0",
    ),
    (
        "surface",
        r#"shape = { kind = "zernike", norm_radius_mm = 1, coefficients = [1] }"#,
        "9:49: element[0].shape.coefficients",
        "coefficients_um",
    ),
    (
        "surface",
        r#"shape = { kind = "gaussian", bumps = [{ height_um = 1, sigma_mm = 0 }] }"#,
        "9:67: element[0].shape.bumps[0].sigma_mm",
        "0.0",
    ),
    (
        "surface",
        r#"shape = { kind = "gaussian", bumps = [{ height_um = 1, sigma_mm = 1, centre_mm = [1] }] }"#,
        "9:82: element[0].shape.bumps[0].centre_mm",
        "1 value",
    ),
    (
        "surface",
        r#"shape = { kind = "grid", pitch_um = 20, height_um = "none.npy" }"#,
        "9:53: element[0].shape.height_um",
        "none.npy",
    ),
    (
        "surface",
        r#"shape = { kind = "grid", pitch_um = 20, height_um = "" }"#,
        "9:53: element[0].shape.height_um",
        "no file name",
    ),
    (
        "surface",
        r#"shape = { kind = "grid", pitch_um = 20, height_um = "small.npy" }"#,
        "9:53: element[0].shape.height_um",
        "3 rows of 3",
    ),
    (
        "surface",
        r#"shape = { kind = "grid", pitch_um = 20, height_um = "line.npy" }"#,
        "9:53: element[0].shape.height_um",
        "1 axes",
    ),
    (
        "surface",
        r#"shape = { kind = "grid", pitch_um = 20, height_um = "hole.npy" }"#,
        "9:53: element[0].shape.height_um",
        "NaN at [3, 4]",
    ),
    (
        "surface",
        r#"shape = { kind = "grid", pitch_um = 20, height_um = "hole.npy", key = "z" }"#,
        "9:53: element[0].shape.height_um",
        "key `z`",
    ),
    (
        "surface",
        r#"shape = { kind = "grid", pitch_um = [20], height_um = "phase.npy" }"#,
        "9:37: element[0].shape.pitch_um",
        "two for x and y",
    ),
    (
        "surface",
        r#"shape = { kind = "grid", pitch_um = 2, height_um = "phase.npy" }"#,
        "8:12: element[0].aperture",
        "does not exist",
    ),
    (
        "surface",
        "radius_mm = 5\nshape = { kind = \"toroid\", radius_mm = 5 }",
        "9:13: element[0].radius_mm",
        "toroid",
    ),
    (
        "surface",
        r#"coordinates = "polar""#,
        "9:15: element[0].coordinates",
        "\"polar\"",
    ),
    (
        "surface",
        "coordinates = 3",
        "9:15: element[0].coordinates",
        "one of `projected`, `surface`",
    ),
    (
        "surface",
        "coordinates = \"surface\"\nshape = { kind = \"biconic\", radius_x_mm = 5, radius_y_mm = 9 }",
        "9:15: element[0].coordinates",
        "curved in two ways",
    ),
    (
        "surface",
        "tilt_deg = [nan, 0, 0]",
        "9:13: element[0].tilt_deg[0]",
        "nan",
    ),
    (
        "surface",
        "reflect = true",
        "7:16: element[0].thickness_mm",
        "20",
    ),
];

const PARTS: &[Case] = &[
    (
        "layer",
        "[[element.layer]]\nkind = \"sum\"\nterms = [[]]",
        "15:10: element[0].layer[1].terms[0]",
        "empty term",
    ),
    (
        "layer",
        "[[element.layer]]\nkind = \"sum\"\nterms = [[{ kind = \"vortex\", charge = 1 }]]\nweights = [1, 2]",
        "16:11: element[0].layer[1].weights",
        "2 weights",
    ),
    (
        "layer",
        "[[element.layer]]\nkind = \"vortex\"\ncharge = 99999999999",
        "15:10: element[0].layer[1].charge",
        "2147483647",
    ),
    (
        "layer",
        "[[element.layer]]\nkind = \"zernike\"\nnorm_radius_mm = 1\ncoefficients = [inf]",
        "16:17: element[0].layer[1].coefficients[0]",
        "inf",
    ),
    (
        "element",
        "[[element]]\nkind = \"paraxial_lens\"\nthickness_mm = 10\naperture = { disc = { radius_mm = 1 } }\nfocal_length_mm = 0",
        "18:19: element[1].focal_length_mm",
        "0.0",
    ),
    (
        "element",
        "[[element]]\nkind = \"coordinate_break\"\ntilt_deg = [1, 2]",
        "16:12: element[1].tilt_deg",
        "2 values",
    ),
    (
        "element",
        "[[element]]\nkind = \"coordinate_break\"\nthickness_mm = inf",
        "16:16: element[1].thickness_mm",
        "inf",
    ),
    (
        "element",
        "[[element]]\nkind = \"coordinate_break\"\ntilt_deg = [180, 0, 0]",
        "element[2]",
        "no ray",
    ),
    (
        "element",
        "[[element]]\nkind = \"stop\"\nthickness_mm = 1\naperture = { annulus = { inner_radius_mm = 0.3, outer_radius_mm = 0.2 } }",
        "17:44: element[1].aperture.annulus.inner_radius_mm",
        "0.3",
    ),
    (
        "element",
        "[[element]]\nkind = \"stop\"\nthickness_mm = 1\naperture = { polygon = { corners_mm = [[0,0], [1,1], [1,0], [0,1]] } }",
        "17:39: element[1].aperture.polygon.corners_mm",
        "cross",
    ),
    (
        "element",
        "[[element]]\nkind = \"stop\"\nthickness_mm = 1\naperture = { regular_polygon = { sides = 2, radius_mm = 1 } }",
        "17:42: element[1].aperture.regular_polygon.sides",
        "2",
    ),
    (
        "element",
        "[[element]]\nkind = \"stop\"\nthickness_mm = 1\naperture = { disc = { radius_mm = 1 }, blocked = [{}] }",
        "17:51: element[1].aperture.blocked[0]",
        "no outline",
    ),
    (
        "element",
        "[[element]]\nkind = \"mirror\"\nthickness_mm = -5\nradius_mm = 1\nsemi_aperture_mm = 2",
        "18:20: element[1].semi_aperture_mm",
        "2",
    ),
    (
        "element",
        "[[element]]\nkind = \"doe\"\nname = \"a\"\nthickness_mm = 1\naperture = { disc = { radius_mm = 1 } }",
        "14:1: element[1]",
        "no `layer`",
    ),
];

const SETTINGS: &[Case] = &[
    (
        "settings",
        "settings.paper.rays = 0",
        "4:23: settings.paper.rays",
        "1000000000",
    ),
    (
        "settings",
        "settings.paper.secondary = 9000000000",
        "4:28: settings.paper.secondary",
        "1000000000",
    ),
    (
        "settings",
        "settings.paper.padding = 0.5",
        "4:26: settings.paper.padding",
        "one or more",
    ),
    (
        "settings",
        "settings.paper.patch_um = nan",
        "4:27: settings.paper.patch_um",
        "nan",
    ),
    (
        "settings",
        "settings.paper.window = \"kaiser\"",
        "4:25: settings.paper.window",
        "`hann`",
    ),
    (
        "settings",
        "settings.paper.positions = \"everywhere\"",
        "4:28: settings.paper.positions",
        "`jittered`",
    ),
    (
        "settings",
        "settings.paper.sag = 1",
        "4:22: settings.paper.sag",
        "one of `tangent`, `incident`, `true`",
    ),
    (
        "settings",
        "settings.paper.coverage = 1",
        "4:27: settings.paper.coverage",
        "true or false",
    ),
    (
        "settings",
        "settings.paper.ray = 1",
        "4:16: settings.paper.ray",
        "`rays`",
    ),
    (
        "settings",
        "settings.step = 100",
        "4:17: settings.step",
        "up to 3",
    ),
    (
        "settings",
        "settings.period = 0.1",
        "4:19: settings.period",
        "from 2 to 100",
    ),
    (
        "settings",
        "settings.nufft_tolerance = 1e-30",
        "4:28: settings.nufft_tolerance",
        "1e-13",
    ),
    (
        "settings",
        "settings = { method = \"beamlet\", sigma_um = 1e-9 }",
        "settings.sigma_um",
        "from 1e-6 to 1e9 micrometres",
    ),
    (
        "settings",
        "settings = { method = \"plane\", sigma_um = 1e-2 }",
        "settings.sigma_um",
        "a quarter of the wavelength",
    ),
    (
        "settings",
        "settings = { method = \"beamlet\", sigma_um = 1e8 }",
        "settings.sigma_um",
        "modes",
    ),
    (
        "settings",
        "settings = { method = \"plane\", sigma_um = 1e8 }",
        "settings.sigma_um",
        "modes",
    ),
];

#[test]
fn every_field_is_refused_at_its_place() {
    let stage = Stage::new(SCENE);
    let write = |name: &str, array: ndarray::Array2<f64>| {
        ndarray_npy::write_npy(stage.join(name), &array).unwrap();
    };
    write("small.npy", ndarray::Array2::zeros((3, 3)));
    let mut hole = ndarray::Array2::zeros((40, 40));
    hole[[3, 4]] = f64::NAN;
    write("hole.npy", hole);
    ndarray_npy::write_npy(stage.join("line.npy"), &ndarray::Array1::<f64>::zeros(9)).unwrap();
    let mut wrong = Vec::new();
    for (place, case, field, found) in [SURFACES, PARTS, SETTINGS].concat() {
        let scene = SCENE.replacen(&format!("#{place}"), case, 1);
        std::fs::write(stage.join("scene.toml"), scene).unwrap();
        let says = ["scene.toml:", field, found];
        wrong.push(refusal::wrong(&stage, &["simulate", "scene.toml"], &says));
    }
    none_of(wrong);
}

/// The scene that all cases break is sound.
#[test]
fn the_scene_itself_is_sound() {
    let stage = Stage::new(SCENE);
    let output = stage.raylet(&["check", "scene.toml"]);
    assert!(output.status.success(), "{}", stage::complaint(&output));
}
