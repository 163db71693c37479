//! Numbers that no system has: in every numeric key of every scene they are refused, or do no harm.

use std::path::{Path, PathBuf};

use toml::{Table, Value};

use crate::engine::chain::forecast::forecast;
use crate::engine::chain::reference::{ReferenceError, ReferenceOptions, reference};
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::free::free_method::Approach;
use crate::engine::plan::plan_error::PlanError;
use crate::engine::plan::settings::{Method, Settings};
use crate::file::decode::path_step::PathStep;
use crate::file::model::build;
use crate::file::result::document;
use crate::file::result::hop_entry::PlanEntry;
use crate::file::scene::scene_file::{Scene, schema};
use crate::file::scene::{scene_test, surfaces_test};
use crate::optics::screen::ScreenKind;
use crate::optics::source::Source;
use crate::optics::system::System;

/// Numbers that no length, angle or count has.
const ABSURD: [f64; 7] = [
    1e155,
    1e308,
    -1e308,
    5e-324,
    f64::NAN,
    f64::INFINITY,
    9.2e18,
];

/// The paths of all numbers in a value.
fn numbers(value: &Value, path: &[PathStep], into: &mut Vec<Vec<PathStep>>) {
    let below = |step: PathStep| [path, &[step]].concat();
    match value {
        Value::Table(table) => {
            for (key, inner) in table {
                numbers(inner, &below(PathStep::Key(key.clone())), into);
            }
        }
        Value::Array(list) => {
            for (i, inner) in list.iter().enumerate() {
                numbers(inner, &below(PathStep::Index(i)), into);
            }
        }
        Value::Integer(_) | Value::Float(_) => into.push(path.to_vec()),
        _ => {}
    }
}

/// The document with another value at a path.
fn with(document: &Table, path: &[PathStep], number: Value) -> String {
    let mut root = Value::Table(document.clone());
    let mut place = &mut root;
    for step in path {
        let next = match step {
            PathStep::Key(key) => place.get_mut(key.as_str()),
            PathStep::Index(i) => place.get_mut(*i),
        };
        place = next.expect("a path of the document");
    }
    *place = number;
    toml::to_string(&root).expect("TOML")
}

/// Every text that has one absurd number in place of one of its own, with where and which.
fn altered(text: &str) -> Vec<(String, String)> {
    let document: Table = text.parse().expect("TOML");
    let mut paths = Vec::new();
    numbers(&Value::Table(document.clone()), &[], &mut paths);
    let mut all = Vec::new();
    for path in &paths {
        for number in ABSURD {
            let change = format!("{number:e} at {path:?}");
            all.push((change, with(&document, path, Value::Float(number))));
        }
        let change = format!("9.2e18 at {path:?}, a whole number");
        all.push((change, with(&document, path, Value::Integer(i64::MAX))));
    }
    all
}

/// All scenes that are shipped, and those of the tests.
fn scenes() -> Vec<(PathBuf, String)> {
    let mut all = Vec::new();
    for folder in ["../../scenes", "../../scenes/paper"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "toml") {
                let text = std::fs::read_to_string(&path).unwrap();
                all.push((path, text));
            }
        }
    }
    for text in [scene_test::SCENE, surfaces_test::SCENE] {
        all.push((PathBuf::from("test.toml"), text.to_owned()));
    }
    all
}

#[test]
fn absurd_numbers_are_refused_wherever_they_stand() {
    let (mut refused, mut taken) = (0, Vec::new());
    for (path, text) in scenes() {
        for (change, altered) in altered(&text) {
            match Scene::parse(&altered, &path) {
                Err(_) => refused += 1,
                Ok(_) => taken.push(change),
            }
        }
    }
    // A radius may be infinite, a seed anything, a number of any unit large in its own, and a tiny number may stand
    // where zero may.
    let harmless = |change: &String| {
        let at = |keys: &[&str]| keys.iter().any(|key| change.contains(&format!("{key}\"")));
        let radius = change.starts_with("inf") && change.contains("radius");
        let any_unit = change.starts_with("9.2e18") && at(&["aspheric", "coefficients", "scale"]);
        radius || any_unit || at(&["seed"]) || change.starts_with("5e-324")
    };
    assert!(refused > 2000, "{refused}");
    let wrong: Vec<&String> = taken.iter().filter(|change| !harmless(change)).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// A scene without arrays, with free and refracted light, small enough to be planned hundreds of times.
const SMALL: &str = r#"version = 1
wavelength_um = 0.7
[source]
kind = "point"
position_mm = [0.01, 0, -50]
[settings]
target_error = 0.1
[[element]]
kind = "doe"
thickness_mm = 1
tilt_deg = [0, 0, 0]
decenter_mm = [0, 0]
aperture = { rectangle = { width_mm = 0.06, height_mm = 0.05, rotation_deg = 0 } }
layer = [{ kind = "grating", period_um = 50, order = 1 }, { kind = "radial", norm_radius_mm = 0.1, coefficients = [1] }]
[[element]]
kind = "stop"
thickness_mm = 1
aperture = { disc = { radius_mm = 0.05, centre_mm = [0, 0] } }
[[element]]
kind = "lens"
thickness_mm = 8
surface = [
  { radius_mm = 5, conic = 0, thickness_mm = 1, glass = { index = 1.5 }, semi_aperture_mm = 1 },
  { semi_aperture_mm = 1 },
]
[[element]]
kind = "sensor"
pixels = [8, 6]
pitch_um = 5
"#;

#[test]
fn what_is_not_refused_has_finite_plans_slow() {
    let mut planned = 0;
    for (change, text) in altered(SMALL) {
        let Ok(scene) = Scene::parse(&text, Path::new("small.toml")) else {
            continue;
        };
        let (system, settings) = (build::system(&scene, 0).unwrap(), build::settings(&scene));
        let Ok(forecasts) = forecast(&system, &settings) else {
            continue;
        };
        for (hop, forecast) in system.hops().zip(&forecasts) {
            let entry = PlanEntry::new(&hop, &forecast.method, &settings);
            document::text(&entry, "plan").unwrap_or_else(|fault| panic!("{change}: {fault}"));
        }
        planned += 1;
    }
    assert!(planned > 5, "{planned}");
}

/// A system whose numbers never went through a scene file: a pixel element and a sensor, this far apart in mm, with
/// pixels of this pitch.
fn system(distance: f64, pitch: f64) -> System {
    let mut system = crate::fixtures::patterns::star_hologram(4, 0.5, 1e-3);
    system.screens[1].frame.origin.z = distance;
    for screen in &mut system.screens {
        if let ScreenKind::Doe(doe) = &mut screen.kind
            && let Some(pixels) = doe.free_pixels_mut()
        {
            pixels.pitch = [pitch; 2];
        }
    }
    system
}

/// Pixels of 1e152 mm once ended in "at least one width is always judged".
#[test]
fn plans_that_are_no_numbers_are_errors() {
    let settings = Settings {
        method: Method::Beamlet,
        ..Settings::default()
    };
    for (distance, pitch) in [
        (0.01, 1e152),
        (1e305, 5e-4),
        (0.01, f64::NAN),
        (f64::NAN, 5e-4),
    ] {
        let found = forecast(&system(distance, pitch), &settings);
        assert!(found.is_err(), "{distance:e} {pitch:e}: {found:?}");
    }
    let found = forecast(&system(0.01, 1e152), &settings);
    let not_finite =
        |error: &SimulateError| matches!(error, SimulateError::Plan(PlanError::NotFinite { .. }));
    assert!(found.as_ref().is_err_and(not_finite), "{found:?}");
}

/// Collins' integral over 1e308 mm once gave a field of NaN.
#[test]
fn references_that_are_no_numbers_are_errors() {
    let choice = ReferenceOptions {
        approach: Approach::Collins,
        patience: 10.0,
    };
    let found = |distance: f64| {
        let system = system(distance, 5e-4);
        reference(&system, &Settings::default(), choice, &|_| {})
    };
    assert!(found(1.0).is_ok());
    let far = found(1e308).map(|found| found.field.power());
    assert!(far.is_err(), "{far:?}");

    // Light of amplitudes that no light has.
    let mut bright = system(1.0, 5e-4);
    bright.source = Source::Point {
        position: crate::math::vec3::Vec3::new(0.0, 0.0, -1e-3),
        reference: crate::math::vec3::Vec3::new(0.0, 0.0, 1e300),
    };
    let found = reference(&bright, &Settings::default(), choice, &|_| {});
    let not_finite =
        |error: &ReferenceError| matches!(error, ReferenceError::Run(SimulateError::NotFinite(_)));
    assert!(found.as_ref().is_err_and(not_finite), "{:?}", found.err());
}

/// Every number of the schema has both its bounds: none was forgotten.
#[test]
fn the_schema_bounds_every_number() {
    fn walk(place: &str, schema: &serde_json::Value, free: &mut Vec<String>) {
        let is = |kind: &str| match &schema["type"] {
            serde_json::Value::Array(kinds) => kinds.iter().any(|one| one == kind),
            one => one == kind,
        };
        let has = |words: [&str; 2]| words.iter().any(|word| schema.get(*word).is_some());
        let bounded = has(["minimum", "exclusiveMinimum"]) && has(["maximum", "exclusiveMaximum"]);
        if (is("number") || is("integer")) && !bounded && schema.get("const").is_none() {
            free.push(place.to_owned());
        }
        for (key, inner) in schema.as_object().into_iter().flatten() {
            walk(&format!("{place}/{key}"), inner, free);
        }
        for (i, inner) in schema.as_array().into_iter().flatten().enumerate() {
            walk(&format!("{place}/{i}"), inner, free);
        }
    }
    let mut free = Vec::new();
    walk("", &schema(), &mut free);
    assert_eq!(free, ["/properties/seed"]);
}
