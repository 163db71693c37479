//! Bad input at the command line: one message with an address, exit code 2, nothing written.

use std::fs;

use crate::refusal::none_of;
use crate::stage::{SCENE, Stage, complaint};

/// A change to the scene, and what the message must say.
struct Case {
    from: &'static str,
    to: &'static str,
    says: &'static [&'static str],
}

const fn case(from: &'static str, to: &'static str, says: &'static [&'static str]) -> Case {
    Case { from, to, says }
}

const CASES: [Case; 26] = [
    case(
        "N-BK7",
        "N-BK77",
        &[
            "scene.toml:25:",
            "element[1].surface[0].glass",
            "N-BK77",
            "N-BK7",
        ],
    ),
    case(
        "wavelength_um = 0.7",
        "wavelength_um = 12",
        &["scene.toml:", "N-BK7", "12"],
    ),
    case(
        "wavelength_um = 0.7",
        "wavelength_um = -0.7",
        &["scene.toml:3:", "-0.7"],
    ),
    case(
        "wavelength_um = 0.7",
        "wavelength_um = nan",
        &["scene.toml:3:", "nan"],
    ),
    case(
        "wavelength_um = 0.7",
        "wavelength_um = []",
        &["scene.toml:3:"],
    ),
    case("version = 1", "version = 7", &["scene.toml:1:", "7", "1"]),
    case(
        "thickness_mm = 8",
        "thicknes_mm = 8",
        &["scene.toml:", "thicknes_mm", "thickness_mm"],
    ),
    case(
        "thickness_mm = 8",
        "thickness_mm = -20",
        &["scene.toml:", "thickness_mm", "-20"],
    ),
    case(
        "phase.npy",
        "missing.npy",
        &["scene.toml:16:", "missing.npy", "No such file"],
    ),
    case("phase.npy", "scene.toml", &["scene.toml:16:", ".npy"]),
    case(
        "pitch_um = 6",
        "pitch_um = -6",
        &["scene.toml:15:", "pitch_um", "-6"],
    ),
    case("pitch_um = 6", "pitch_um = inf", &["scene.toml:15:", "inf"]),
    case(
        "pitch_um = 6",
        "pitch_um = 6\nsize = [31, 30]",
        &["scene.toml:", "30", "31"],
    ),
    case(
        "radius_mm = 0.09",
        "radius_mm = 0",
        &["scene.toml:12:", "radius_mm", "0"],
    ),
    case(
        "kind = \"plane\"",
        "kind = \"plain\"",
        &["scene.toml:6:", "plain", "plane"],
    ),
    case(
        "pitch_um = 5\n",
        "pitch_um = 5\ndecenter_mm = [300, 0]\n",
        &["scene.toml:30:", "'camera'", "reaches"],
    ),
    case(
        "pixels = [48, 40]",
        "pixels = [90000, 90000]",
        &["scene.toml:33:", "MB", "memory_limit_mb"],
    ),
    case(
        "pixels = [48, 40]",
        "pixels = [0, 40]",
        &["scene.toml:33:", "pixels", "0"],
    ),
    case(
        "[source]",
        "settings.memory_limit_mb = 0.005\n[source]",
        &["scene.toml:", "memory_limit_mb"],
    ),
    case(
        "[source]",
        "settings.method = \"beamlet\"\nsettings.memory_limit_mb = 0.2\n[source]",
        &["scene.toml:", "samples", "memory_limit_mb"],
    ),
    case(
        "[source]",
        "settings.method = \"magic\"\n[source]",
        &["scene.toml:5:", "magic", "beamlet"],
    ),
    case("kind = \"sensor\"", "kind = \"mirror\"", &["scene.toml:"]),
    case(
        "radius_mm = 5\n",
        "radius_mm = 0.5\n",
        &["scene.toml:", "conic ends"],
    ),
    case("name = \"camera\"", "name = \"L\"", &["scene.toml:", "L"]),
    case("title = \"Small\"", "title = \"Small", &["scene.toml:2:"]),
    case(
        "phase = \"phase.npy\"",
        "phase = \"phase.npy\"\namplitude = \"dark.npy\"",
        &["scene.toml:8:", "no light"],
    ),
];

#[test]
fn scenes_are_refused_at_the_right_place() {
    let mut wrong = Vec::new();
    for Case { from, to, says } in &CASES {
        assert!(SCENE.contains(from), "{from}");
        let stage = Stage::new(&SCENE.replacen(from, to, 1));
        let dark = ndarray::Array2::<f64>::zeros((30, 30));
        ndarray_npy::write_npy(stage.join("dark.npy"), &dark).unwrap();
        wrong.push(crate::refusal::wrong(
            &stage,
            &["simulate", "scene.toml"],
            says,
        ));
    }
    none_of(wrong);
}

#[test]
fn arguments_are_checked() {
    let stage = Stage::new(SCENE);
    fs::write(stage.join("binary.toml"), [0xff, 0xfe, 0x00]).unwrap();
    for (arguments, says) in [
        (&["simulate"][..], "SCENE"),
        (&["simulate", "none.toml"], "none.toml"),
        (&["check", "none.toml"], "none.toml"),
        (&["simulate", "."], "TOML"),
        (&["simulate", "binary.toml"], "binary.toml"),
        (&["simulate", "phase.npy"], "phase.npy"),
        (&["simulate", "scene.toml", "--threads", "0"], "--threads"),
        (&["simulate", "scene.toml", "--method", "magic"], "beamlet"),
        (&["check", "scene.toml", "--out", "x"], "--out"),
        (&["fly"], "fly"),
    ] {
        let output = stage.raylet(arguments);
        let message = complaint(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(
            message.contains(says) && !message.contains("panicked"),
            "{arguments:?}: {message}"
        );
    }
    assert_eq!(stage.names(), ["binary.toml", "phase.npy", "scene.toml"]);
}
