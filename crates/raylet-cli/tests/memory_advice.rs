//! Where memory is short, `raylet check` names a limit that would do for the whole system, and changes that need less.

use std::fs;
use std::process::Output;

use raylet_testkit::scenes::scene_path;

use crate::stage::{SCENE, Stage};

/// A lens whose second surface touches a diffractive element of 5 mm. By beamlets both screens are sampled as a whole, and
/// the second needs more than the first.
const TOUCHING: &str = r#"version = 1
wavelength_um = 0.5876
settings.method = "beamlet"
settings.memory_limit_mb = 4096
source = { kind = "plane" }
[[element]]
kind = "stop"
aperture = { disc = { radius_mm = 2.5 } }
thickness_mm = 0.5
[[element]]
kind = "surface"
radius_mm = 10.9
conic = -0.6
thickness_mm = 2.5
glass = "N-BK7"
semi_aperture_mm = 3.5
[[element]]
kind = "surface"
thickness_mm = 0
semi_aperture_mm = 3.5
[[element]]
kind = "doe"
layer = [{ kind = "lens", focal_length_mm = 392 }]
aperture = { disc = { radius_mm = 2.65 } }
thickness_mm = 18.4
[[element]]
kind = "sensor"
pixels = [128, 128]
pitch_um = 0.5
"#;

/// Fine pixels that touch a larger element: light at any angle comes from one to the other.
const NEAR: &str = r#"version = 1
wavelength_um = 0.5
settings.method = "beamlet"
settings.memory_limit_mb = 100
source = { kind = "plane" }
[[element]]
kind = "stop"
aperture = { disc = { radius_mm = 0.5 } }
thickness_mm = 0.1
[[element]]
kind = "stop"
aperture = { disc = { radius_mm = 1 } }
thickness_mm = 50
[[element]]
kind = "sensor"
pixels = [64, 64]
pitch_um = 10
"#;

fn hint(run: &Output) -> String {
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    let hint = said.lines().find_map(|line| line.strip_prefix("hint: "));
    hint.unwrap_or_else(|| panic!("no hint in: {said}"))
        .to_owned()
}

/// The limit that a hint names.
fn limit(hint: &str) -> f64 {
    let number = (hint.split("settings.memory_limit_mb = ").nth(1))
        .and_then(|rest| rest.split(' ').next())
        .and_then(|number| number.parse().ok());
    number.unwrap_or_else(|| panic!("no limit in: {hint}"))
}

/// The scene with another memory limit.
fn with_limit(scene: &str, megabytes: f64) -> String {
    let old = scene
        .lines()
        .find(|line| line.contains("memory_limit_mb"))
        .unwrap();
    scene.replace(old, &format!("settings.memory_limit_mb = {megabytes}"))
}

/// The limit that fits the first screen once was advised, and the second was then too large.
#[test]
fn the_limit_that_is_advised_does_for_the_whole_system() {
    for scene in [TOUCHING, NEAR] {
        let refused = Stage::new(scene).raylet(&["check", "scene.toml"]);
        let hint = hint(&refused);
        let enough = Stage::new(&with_limit(scene, limit(&hint))).raylet(&["check", "scene.toml"]);
        assert!(enough.status.success(), "{hint}: {enough:?}");
    }
}

/// Arrays under the windows of local bands are known in the run alone. The limit that was advised there was the one that was
/// refused.
#[test]
fn the_limit_advised_for_local_bands_does_for_the_run() {
    let phone = fs::read_to_string(scene_path("real_size/phone_lens")).unwrap();
    let settings = "settings.method = \"local_bands\"\nsettings.sigma_um = 50\nsettings.memory_limit_mb = 5\n[source]";
    let scene = phone.replace("[source]", settings);
    let refused = Stage::new(&scene).raylet(&["simulate", "scene.toml", "--out", "out"]);
    let hint = hint(&refused);
    let enough = with_limit(&scene, limit(&hint));
    let run = Stage::new(&enough).raylet(&["simulate", "scene.toml", "--out", "out"]);
    assert!(run.status.success(), "{hint}: {run:?}");
}

/// A limit beyond the memory of any machine says so.
#[test]
fn a_limit_that_no_machine_has_says_what_this_one_has() {
    let vast = TOUCHING
        .replace("radius_mm = 2.65", "radius_mm = 265")
        .replace("radius_mm = 2.5 ", "radius_mm = 250 ")
        .replace("radius_mm = 10.9", "radius_mm = 1090")
        .replace("semi_aperture_mm = 3.5", "semi_aperture_mm = 350");
    let refused = Stage::new(&vast).raylet(&["check", "scene.toml"]);
    let hint = hint(&refused);
    assert!(hint.contains("but this machine has"), "{hint}");
}

/// A scene, with what a hint may advise and the change of the scene that follows it.
type Advised = (
    &'static str,
    [(&'static str, &'static str, &'static str); 2],
);

const ADVISED: [Advised; 2] = [
    (
        NEAR,
        [
            (
                "a greater distance behind it",
                "thickness_mm = 0.1",
                "thickness_mm = 2.1",
            ),
            (
                "a smaller aperture",
                "radius_mm = 0.5 }",
                "radius_mm = 0.25 }",
            ),
        ],
    ),
    (
        TOUCHING,
        [
            (
                "a greater distance behind it",
                "thickness_mm = 0.5",
                "thickness_mm = 5.5",
            ),
            (
                "a smaller aperture",
                "radius_mm = 2.5 }",
                "radius_mm = 1.25 }",
            ),
        ],
    ),
];

/// A greater distance was advised where it needed more. What is advised now needs less.
#[test]
fn advice_beside_the_limit_needs_less() {
    let run = |scene: &str| Stage::new(scene).raylet(&["check", "scene.toml"]);
    for (scene, changes) in ADVISED {
        let first = hint(&run(scene));
        let (limit_before, advice) = (limit(&first), first.split("; ").nth(1).unwrap_or_default());
        for (words, from, to) in changes
            .into_iter()
            .filter(|(words, ..)| advice.contains(words))
        {
            let then = run(&scene.replace(from, to));
            let needs_less = then.status.success() || limit(&hint(&then)) < limit_before;
            assert!(needs_less, "{words}, of {first}: {then:?}");
        }
    }
    assert!(hint(&run(NEAR)).contains("a greater distance behind it needs less"));
}

/// The limit in use is in the words of a check and in the document of a run; without a setting it follows the machine.
#[test]
fn the_limit_in_use_is_named() {
    let words = |scene: &str| {
        let run = Stage::new(scene).raylet(&["check", "scene.toml"]);
        String::from_utf8_lossy(&run.stdout).into_owned()
    };
    assert!(words(SCENE).contains("MB (half of what is free;"));
    let given = SCENE.replace("[source]", "settings.memory_limit_mb = 321\n[source]");
    assert!(words(&given).contains("memory limit 321 MB (settings.memory_limit_mb)"));
    let stage = Stage::new(SCENE);
    assert!(
        stage
            .raylet(&["simulate", "scene.toml", "--out", "out"])
            .status
            .success()
    );
    let report = std::fs::read_to_string(stage.join("out/result.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let limit = report["settings"]["memory_limit_mb"].as_f64().unwrap();
    assert!(limit >= 1.0 && limit.fract() == 0.0, "{limit}");
}
