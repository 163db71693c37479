//! What `raylet check` expects of a lens of many aspheres is what the run reports, and what a run reports of light that cannot
//! be.

use std::fs;

use raylet_testkit::scenes::scene_path;

use crate::stage::{Stage, complaint};

/// The five aspheric elements of a lens for a phone, changed passage by passage.
fn phone(changes: &[(&str, &str)]) -> Stage {
    let text = fs::read_to_string(scene_path("real_size/phone_lens")).unwrap();
    let change = |text: String, (from, to): &(&str, &str)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    };
    Stage::new(&changes.iter().fold(text, change))
}

/// The field error that a check expects of the run.
fn forecast(stage: &Stage) -> f64 {
    let run = stage.raylet(&["check", "scene.toml"]);
    assert!(run.status.success(), "{}", complaint(&run));
    let said = String::from_utf8_lossy(&run.stdout);
    let line = said.lines().find(|line| line.starts_with("  the run: "));
    let error = line.and_then(|line| line.split("expected field error ").nth(1));
    let number = error.and_then(|error| error.split(' ').next()?.parse().ok());
    number.unwrap_or_else(|| panic!("no expected error in: {said}"))
}

/// The document of a run and what it said.
fn run(stage: &Stage) -> (serde_json::Value, String) {
    let run = stage.raylet(&["simulate", "scene.toml", "--out", "out"]);
    assert!(run.status.success(), "{}", complaint(&run));
    let report = fs::read_to_string(stage.join("out/result.json")).unwrap();
    let said = String::from_utf8(run.stdout).unwrap();
    (serde_json::from_str(&report).unwrap(), said)
}

const COARSE: (&str, &str) = ("[source]", "settings.target_error = 1e-2\n[source]");
const ON_AXIS: [(&str, &str); 3] = [
    ("angle_deg = [20, 0]", "angle_deg = [0, 0]"),
    ("decenter_mm = [1.3173, 0]", ""),
    COARSE,
];

/// A width that is too large for this lens.
const FIXED: (&str, &str) = (
    "settings.target_error = 1e-2",
    "settings = { target_error = 1e-2, sigma_um = 60, method = \"beamlet\" }",
);

/// Widths that are too large or fixed were forecast four times worse than they are: rays counted that start beyond the
/// aperture and meet the rims of the lens.
#[test]
fn a_check_expects_the_error_that_the_run_reports() {
    let [a, b, c] = ON_AXIS;
    let cases: [&[(&str, &str)]; 3] = [&[a, b, c], &[COARSE], &[a, b, c, FIXED]];
    let mut wrong = Vec::new();
    for changes in cases {
        let stage = phone(changes);
        let expected = forecast(&stage);
        let reported = run(&stage).0["channels"][0]["error"].as_f64().unwrap();
        let ratio = expected / reported;
        if !(0.5..=2.0).contains(&ratio) {
            wrong.push(format!("{changes:?}: {expected:e} for {reported:e}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// A run that misses its target marks its estimate, and ends with what may help.
#[test]
fn a_missed_target_is_the_last_line() {
    let [a, b, c] = ON_AXIS;
    let (report, said) = run(&phone(&[a, b, c, FIXED]));
    assert!(said.contains("(above the target 1e-2)"), "{said}");
    let warnings = report["channels"][0]["warnings"].as_array().unwrap();
    let missed = warnings.last().unwrap().as_str().unwrap();
    assert!(
        missed.contains("misses the target 1.0e-2") && missed.contains("without settings.sigma_um"),
        "{missed}"
    );
    assert!(said.trim_end().ends_with(missed), "{said}");
}

/// A focus that falls between pixels much larger than itself, but for the one in whose middle it is.
const COARSE_PIXELS: &str = r#"version = 1
wavelength_um = 0.5
source = { kind = "plane" }
[[element]]
kind = "doe"
layer = [{ kind = "lens", focal_length_mm = 0.5 }]
aperture = { disc = { radius_mm = 0.05 } }
thickness_mm = 0.5
[[element]]
kind = "sensor"
pixels = [3, 3]
pitch_um = 5
"#;

/// More light than came is no share of it.
#[test]
fn more_light_than_came_is_no_share() {
    let (report, said) = run(&Stage::new(COARSE_PIXELS));
    let power = &report["channels"][0]["hops"][0]["power"];
    let share = power["landed"].as_f64().unwrap() / power["behind"].as_f64().unwrap();
    assert!(share > 3.0, "{share}");
    let first = said.lines().next().unwrap();
    assert!(
        first.contains("more light on the sensor than came") && !first.contains('%'),
        "{first}"
    );
    let warning = report["channels"][0]["warnings"][0].as_str().unwrap();
    assert!(
        warning.contains("% more light than came: the pixels are too coarse to sum it"),
        "{warning}"
    );
}
