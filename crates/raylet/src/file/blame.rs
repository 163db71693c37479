//! Faults found while computing, told at the element of the scene they belong to.

use crate::engine::plan::PlanError;
use crate::engine::simulate::SimulateError;
use crate::file::fault::Fault;
use crate::file::scene::Scene;
use crate::wave::sampling::SamplingError;

/// The fault of a scene that cannot be computed.
pub fn blame(scene: &Scene, error: &SimulateError) -> Fault {
    let (screen, expected) = match error {
        SimulateError::Plan(PlanError::Dark { to, .. }) => (
            to,
            "a place that light reaches through the elements before it",
        ),
        SimulateError::Plan(PlanError::Boundless(name))
        | SimulateError::Sampling(SamplingError::Boundless(name)) => (name, "an aperture"),
        SimulateError::Sampling(SamplingError::TooLarge { screen, .. }) => (
            screen,
            "a field that fits in memory (settings.memory_limit_mb)",
        ),
        SimulateError::NoSensor(name) => (name, "a sensor as the last element"),
        SimulateError::NoLight(name) => (name, "an element that lets some light through"),
    };
    scene.fault(&path_of(scene, screen), error.to_string(), expected)
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
