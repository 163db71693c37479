//! Flat patches on a curved mirror: `check` and `simulate` report the error of their phase.

use std::fs;
use std::process::Command;

/// A bump of radius 506 µm, of which patches of 25 µm at λ = 1 µm see a phase error of 1.94 rad at most.
const SCENE: &str = r#"version = 1
wavelength_um = 1
source = { kind = "plane" }

[[element]]
kind = "doe"
name = "mirror"
thickness_mm = -0.1
reflect = true
aperture = { rectangle = { width_mm = 0.06, height_mm = 0.06 } }
shape = { kind = "gaussian", bumps = [{ height_um = -12.65, sigma_mm = 0.08 }] }
layer = [{ kind = "lens", focal_length_mm = 0.1 }]

[[element]]
kind = "sensor"
pixels = [16, 16]
pitch_um = 1

[settings]
method = "paper"
paper = { rays = 9, secondary = 10, patch_um = 25, padding = 4, sag = "tangent" }
"#;

#[test]
fn the_phase_is_reported_beside_the_angle() {
    let room = tempfile::tempdir().unwrap();
    let path = |name: &str| room.path().join(name);
    let said = |verb: &str, scene: &str| {
        fs::write(path("scene.toml"), scene).unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_raylet"))
            .current_dir(room.path())
            .args([verb, "scene.toml"])
            .output()
            .unwrap();
        let errors = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{errors}");
        String::from_utf8(output.stdout).unwrap()
    };
    for verb in ["check", "simulate"] {
        let text = said(verb, SCENE);
        for part in ["25.0 µm", "505.9 µm", "1.94 rad", "0.025 rad"] {
            assert!(text.contains(part), "{verb} lacks {part}:\n{text}");
        }
    }
    let report = fs::read_to_string(path("scene-out/result.json")).unwrap();
    assert!(report.contains("1.94 rad"));

    // Half of it where the light that comes meets the true surface, none with the height, none on a plane.
    let with = |from: &str, to: &str| said("check", &SCENE.replace(from, to));
    assert!(with("\"tangent\"", "\"incident\"").contains("0.97 rad"));
    assert!(!with("\"tangent\"", "\"true\"").contains("warning: patches"));
    let shape = SCENE
        .lines()
        .find(|line| line.starts_with("shape"))
        .unwrap();
    assert!(!with(shape, "").contains("warning: patches"));
    assert!(!with("patch_um = 25", "patch_um = 10").contains("warning: patches"));
}
