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

/// A sum of a grating of 0.4 µm and one of 20 µm, and the orders 2 and 3 of a grating of 1 µm; a run of the grating alone says why
/// its sensor is dark.
#[test]
fn orders_that_do_not_propagate_are_told() {
    let element = |layer: &str| {
        format!(
            r#"[[element]]
kind = "doe"
name = "orders"
thickness_mm = 1
aperture = {{ disc = {{ radius_mm = 0.05 }} }}
layer = [{layer}]
"#
        )
    };
    let grating = |period: f64| format!(r#"{{ kind = "grating", period_um = {period} }}"#);
    let kinoform = |keys: &str, period: f64| {
        element(&format!(
            r#"{{ kind = "kinoform", {keys} layer = [{}] }}"#,
            grating(period)
        ))
    };
    let sum = element(&format!(
        r#"{{ kind = "sum", terms = [[{}], [{}]] }}"#,
        grating(0.4),
        grating(20.0)
    ));
    let text = said(&sum);
    assert!(
        text.contains("50 % of the light behind 'orders' does not propagate"),
        "{text}"
    );
    let text = said(&kinoform("levels = 2, orders = [0, 1, 2, 3],", 1.0));
    assert!(
        text.contains("10 % of the light behind 'orders' does not propagate"),
        "{text}"
    );
    assert!(!said(&kinoform("", 1.0)).contains("does not propagate"));

    let stage = Stage::new(&scene(&kinoform("", 0.4)));
    let text = stage.raylet(&["check", "scene.toml"]);
    assert!(
        String::from_utf8_lossy(&text.stdout).contains("100 % of the light"),
        "{text:?}"
    );
    let run = stage.raylet(&["simulate", "scene.toml", "--out", "out"]);
    assert!(run.status.success(), "{}", complaint(&run));
    let report = std::fs::read_to_string(stage.join("out/result.json")).unwrap();
    assert!(
        report.contains("hardly any light reaches the sensor: 100 % of the light behind 'orders' does not propagate"),
        "{report}"
    );
}

/// Edmund Optics 65-988, of 15.02 mm, as scenes/real_size/hybrid_asphere.toml has it: its back alone has 90.93 mm.
#[test]
fn the_focal_length_has_the_power_of_elements() {
    let hybrid = r#"[[element]]
kind = "doe"
name = "front"
radius_mm = 9.93
conic = -0.71
thickness_mm = 3.7
glass = { index = 1.53116 }
aperture = { disc = { radius_mm = 0.1 } }
layer = [{ kind = "radial", norm_radius_mm = 6, coefficients = [-695.76804228564] }]
[[element]]
kind = "surface"
radius_mm = -48.3
thickness_mm = 12.94603
semi_aperture_mm = 0.2
"#;
    let text = said_of(&scene(hybrid).replace("0.55", "0.5875618"));
    assert!(
        text.contains("front to camera, surfaces alone: focal length 90.93"),
        "{text}"
    );
    let line = text.split("all parts: focal length ").nth(1);
    let number = line.and_then(|line| line.split(' ').next()?.parse::<f64>().ok());
    assert!(number.is_some_and(|f| (f - 15.02).abs() < 0.01), "{text}");
}
