//! Systems designed together are better than the best of their parts, by references that share no code with the rays.

use std::path::Path;

use raylet::design::run::Run;
use raylet::engine::progress::uncancelled;
use raylet::file::model::project::scene_design;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::system::System;
use raylet_accuracy::designed::{overlap, spots};

/// Two phase elements and a mode; `FIRST` and `SECOND` are what is designed of them.
const MODE: &str = r#"version = 1
wavelength_um = 0.633
settings.target_error = 1e-2
source = { kind = "plane" }

[[element]]
kind = "doe"
name = "first"
thickness_mm = 0.4
aperture = { disc = { radius_mm = 0.0216 } }
layer = [{ kind = "pixels", pitch_um = 2.4, size = [18, 18] FIRST }]

[[element]]
kind = "doe"
name = "second"
thickness_mm = 0.3
aperture = { disc = { radius_mm = 0.0216 } }
layer = [{ kind = "pixels", pitch_um = 2.4, size = [18, 18] SECOND }]

[[element]]
kind = "sensor"
name = "sensor"
pixels = [30, 30]
pitch_um = 1.2

[design]
iterations = 8
element = [NAMES]
loss = [{ kind = "overlap", picture = "photograph.png", size_mm = [0.027, 0.027] }]
"#;

/// A strong singlet of flint, its radius `RADIUS`, behind a radial phase, `POWER` rad at its rim, for two wavelengths
/// on the axis; `VARIABLES` are designed.
const ACHROMAT: &str = r#"version = 1
wavelength_um = [0.5, 0.65]
source = { kind = "plane" }

[settings]
method = "auto"
coating = "unit"
target_error = 0.01
mode_threshold = 0.01

[[element]]
kind = "doe"
name = "phase"
thickness_mm = 0.1
aperture = { disc = { radius_mm = 0.2 } }
layer = [{ kind = "radial", norm_radius_mm = 0.2, coefficients = [POWER, 0.0] }]

[[element]]
kind = "lens"
name = "singlet"
thickness_mm = 0.929
[[element.surface]]
radius_mm = RADIUS
thickness_mm = 0.15
glass = "N-SF11"
semi_aperture_mm = 0.3
[[element.surface]]
semi_aperture_mm = 0.3

[[element]]
kind = "sensor"
name = "sensor"
pixels = [9, 9]
pitch_um = 0.7

[design]
iterations = 4
field = [{ angle_deg = [0.0, 0.0] }]
loss = [{ kind = "spot", field = [0], at_mm = [[0.0, 0.0]], focal_length_mm = 1.01, sharing = "log" }]
variable = [VARIABLES]
"#;

/// The result of a design: the scene with its numbers, the system with its pixels, and the loss of both.
fn designed(text: &str) -> (Scene, System, f64) {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/in_a_test.toml");
    let scene = Scene::parse(text, &beside).unwrap();
    let scene_design = scene_design(&scene).unwrap();
    let project = &scene_design.project;
    let mut run = Run::new(
        project,
        scene_design.search.clone(),
        scene_design.design.iterations,
        &uncancelled,
    )
    .unwrap();
    while !run.is_done() {
        run.step().unwrap();
    }
    let loss = run.finish().unwrap().value;
    let parameters = &run.best()[scene_design.project.system_parameters_from()..];
    let system = project.system(0, &project.make(run.best(), 1.0), parameters);
    let found = scene_design.scene_at(&scene, run.best()).unwrap();
    (found, system.unwrap(), loss)
}

/// The shares of the mode by the design and by the reference.
fn shares(names: &[&str]) -> [f64; 2] {
    let mut text = String::from(MODE);
    let mut elements = Vec::new();
    for (key, name) in [("FIRST", "first"), ("SECOND", "second")] {
        let file = match names.contains(&name) {
            true => format!(", phase = \"{name}.npy\""),
            false => String::new(),
        };
        text = text.replace(key, &file);
    }
    for name in names {
        elements.push(format!("{{ name = \"{name}\" }}"));
    }
    let (scene, system, loss) = designed(&text.replace("NAMES", &elements.join(", ")));
    [1.0 - loss, overlap(&scene, &system).unwrap().mode]
}

#[test]
fn two_elements_reach_a_mode_that_one_cannot_slow() {
    let one = ["first", "second"].map(|name| shares(&[name]));
    let both = shares(&["first", "second"]);
    for [design, reference] in [one[0], one[1], both] {
        assert!((design - reference).abs() < 2e-3, "{one:?} {both:?}");
    }
    let better = one[0][1].max(one[1][1]);
    assert!(both[1] > better + 0.05, "{one:?} {both:?}");
}

/// Where a design of the lens and the phase begins: all power in the lens, or shared so that paraxially both wavelengths
/// come to one focus.
const LENS: [&str; 2] = ["0.8", "0.0"];
const SHARED: [&str; 2] = ["0.91", "-26.0"];

/// Mean −log of the spots' brightness by the design and by the reference.
fn dimness(start: [&str; 2], variables: &[(&str, f64)]) -> [f64; 2] {
    let text = ACHROMAT
        .replace("RADIUS", start[0])
        .replace("POWER", start[1]);
    let variable =
        |(path, scale): &(&str, f64)| format!("{{ path = \"{path}\", scale = {scale} }}");
    let listed: Vec<String> = variables.iter().map(variable).collect();
    let (scene, _, loss) = designed(&text.replace("VARIABLES", &listed.join(", ")));
    let found = spots(&scene).unwrap();
    let sum: f64 = found.iter().map(|spot| -spot.strehl.ln()).sum();
    [loss, sum / found.len() as f64]
}

#[test]
fn lens_and_phase_together_focus_two_wavelengths_slow() {
    let lens = [
        ("element[1].surface[0].radius_mm", 0.002),
        ("element[1].surface[0].conic", 0.3),
        ("element[1].thickness_mm", 0.003),
    ];
    let phase = [
        ("element[0].layer[0].coefficients[0]", 1.0),
        ("element[0].layer[0].coefficients[1]", 1.0),
        ("element[1].thickness_mm", 0.003),
    ];
    let both = [&lens[..], &phase[..2]].concat();
    let [lens, phase] = [lens, phase].map(|part| dimness(LENS, &part));
    let together = dimness(SHARED, &both);
    let found = format!("{together:?} {lens:?} {phase:?}");
    for [design, reference] in [together, lens, phase] {
        assert!((design - reference).abs() < 2e-2, "{found}");
    }
    assert!(together[1] < 0.2 * lens[1].min(phase[1]), "{found}");
}
