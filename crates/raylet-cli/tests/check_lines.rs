//! What `raylet check` says of parts that do not fit together, and of the powers of a system.

use crate::stage::{Stage, complaint};

/// All that a check says of a scene with these elements before a small sensor.
fn said(elements: &str) -> String {
    said_of(&scene(elements))
}

fn said_of(scene: &str) -> String {
    let stage = Stage::new(scene);
    let run = stage.raylet(&["check", "scene.toml"]);
    assert!(run.status.success(), "{}", complaint(&run));
    String::from_utf8(run.stdout).unwrap()
}

fn scene(elements: &str) -> String {
    format!(
        r#"version = 1
wavelength_um = 0.55
[source]
kind = "plane"
{elements}
[[element]]
kind = "sensor"
name = "camera"
pixels = [16, 16]
pitch_um = 2
"#
    )
}

/// A biconvex lens of 20 µm and 1 mm in radius, with nothing before it, and with its front as an element.
#[test]
fn surfaces_that_cross_are_told_whatever_stands_before_them() {
    let back = r#"[[element]]
kind = "surface"
radius_mm = -5
thickness_mm = 4
semi_aperture_mm = 1
"#;
    let front = r#"[[element]]
kind = "surface"
radius_mm = 5
glass = "N-BK7"
thickness_mm = 0.02
semi_aperture_mm = 1
"#;
    let element = r#"[[element]]
kind = "doe"
name = "front"
radius_mm = 5
glass = "N-BK7"
thickness_mm = 0.02
aperture = { disc = { radius_mm = 1 } }
layer = [{ kind = "radial", norm_radius_mm = 1, coefficients = [-10] }]
"#;
    let bare = said(&format!("{front}{back}"));
    let words =
        "warning: surfaces 1 and 2 behind 'entrance' cross inside their apertures: 1.0000 mm";
    assert!(bare.contains(words), "{bare}");
    let hybrid = said(&format!("{element}{back}"));
    let words = "warning: 'front' and surface 1 behind it cross inside their apertures: 1.0000 mm";
    assert!(hybrid.contains(words), "{hybrid}");
    let thick = said(&format!("{front}{back}").replace("0.02", "0.4"));
    assert!(!thick.contains("cross inside"), "{thick}");
}
