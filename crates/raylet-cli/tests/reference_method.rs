//! `raylet reference` names its method, the reason and the seconds that it will take, before it starts.

use std::process::Output;

use crate::stage::{SCENE, Stage};

/// The small scene without its lens, with these settings: before a sensor so wide that the field needs few samples and many
/// plane waves.
fn free(settings: &str) -> Stage {
    let lens = SCENE.find("[[element]]\nkind = \"lens\"").unwrap();
    let camera = SCENE.find("[[element]]\nkind = \"sensor\"").unwrap();
    let scene = format!("{}{}", &SCENE[..lens], &SCENE[camera..])
        .replace("thickness_mm = 1\n", "thickness_mm = 400\n")
        .replace(
            "pixels = [48, 40]\npitch_um = 5",
            "pixels = [24, 20]\npitch_um = 400",
        );
    Stage::new(&scene.replace("[source]", &format!("{settings}\n[source]")))
}

fn run(stage: &Stage) -> Output {
    let run = stage.raylet(&["reference", "scene.toml", "--out", "out"]);
    assert!(run.status.success(), "{run:?}");
    run
}

/// The first line on standard error, which stands there before the work begins.
fn first_line(run: &Output) -> String {
    let said = String::from_utf8_lossy(&run.stderr);
    said.lines().next().unwrap_or_default().to_owned()
}

#[test]
fn the_method_is_named_before_it_starts() {
    let stage = free("");
    let found = run(&stage);
    let line = first_line(&found);
    assert!(
        String::from_utf8_lossy(&found.stdout).contains("% of the light on the sensor"),
        "{found:?}"
    );
    assert!(
        line.starts_with("pixels to camera: angular spectrum, about "),
        "{line}"
    );
    assert!(
        line.ends_with("(parallel screens with at most plates between)"),
        "{line}"
    );
    let chosen = [
        "reference",
        "scene.toml",
        "--method",
        "rayleigh-sommerfeld",
        "--out",
        "out",
    ];
    let line = first_line(&stage.raylet(&chosen));
    assert!(line.ends_with("(chosen by the user)"), "{line}");
}

/// Where memory does not hold the plane waves, the direct sum takes their place: this is said with the limit that would
/// hold them, and that limit does.
#[test]
fn a_sum_in_place_of_plane_waves_says_which_limit_holds_them() {
    let scarce = free("settings.memory_limit_mb = 20");
    let line = first_line(&run(&scarce));
    assert!(line.contains("Rayleigh–Sommerfeld sum, about"), "{line}");
    let limit = (line.split("settings.memory_limit_mb = ").nth(1))
        .and_then(|rest| rest.split(' ').next())
        .unwrap_or_else(|| panic!("no limit in: {line}"));
    let enough = free(&format!("settings.memory_limit_mb = {limit}"));
    let line = first_line(&run(&enough));
    assert!(line.contains("angular spectrum, about"), "{line}");
    let report = std::fs::read_to_string(scarce.join("out/result.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let why = report["channels"][0]["steps"][0]["why"].as_str().unwrap();
    assert!(why.contains("plane waves, more than"), "{why}");
}
