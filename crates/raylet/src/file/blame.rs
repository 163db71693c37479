//! Faults found while computing, told at the element of the scene they belong to.

use crate::engine::plan::PlanError;
use crate::engine::simulate::SimulateError;
use crate::file::fault::Fault;
use crate::file::scene::Scene;
use crate::wave::sampling::SamplingError;

/// The fault of a scene that cannot be computed.
pub fn blame(scene: &Scene, error: &SimulateError) -> Fault {
    let told = error.to_string();
    let (screen, found, expected) = match error {
        SimulateError::Plan(PlanError::Dark { to, .. }) => (
            to,
            told,
            String::from("a place that light reaches through the elements before it"),
        ),
        SimulateError::Plan(PlanError::Boundless(name))
        | SimulateError::Sampling(SamplingError::Boundless(name)) => {
            (name, String::from("no edge"), String::from("an aperture"))
        }
        SimulateError::Sampling(SamplingError::TooLarge {
            screen,
            needed,
            needed_y,
            allowed,
        }) => {
            let found = format!("a field of {needed} × {needed_y} samples");
            let fault = scene.fault(&path_of(scene, screen), found, memory(*allowed, "samples"));
            return fault.hint("reduce its size, its steepest phase or the directions it takes");
        }
        SimulateError::Plan(PlanError::Modes {
            screen,
            modes: [nx, ny],
            allowed,
        }) => (
            screen,
            format!("patches of {nx} × {ny} modes"),
            memory(*allowed, "modes"),
        ),
        SimulateError::NoSensor(name) => (name, told, String::from("a sensor as the last element")),
        SimulateError::NoLight(name) => (
            name,
            told,
            String::from("an element that lets some light through"),
        ),
        SimulateError::Sum(_) => {
            return scene.fault(
                "settings.nufft_tolerance",
                told,
                "a sum that can be planned",
            );
        }
    };
    scene.fault(&path_of(scene, screen), found, expected)
}

fn memory(allowed: usize, what: &str) -> String {
    format!("at most {allowed} {what} (settings.memory_limit_mb)")
}

/// The path of the element that a screen was made of.
fn path_of(scene: &Scene, screen: &str) -> String {
    let named = scene
        .element
        .iter()
        .position(|element| element.name() == Some(screen));
    match named {
        Some(number) => format!("element[{number}]"),
        // Elements without a name give their screens their path; an entrance belongs to the first.
        None if screen.starts_with("element[") => screen.to_owned(),
        None => String::from("element[0]"),
    }
}
