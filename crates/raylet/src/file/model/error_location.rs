//! Faults found while computing, reported at the element of the scene they belong to.

use crate::engine::chain::needed_memory::{Saving, needed_memory, savings};
use crate::engine::chain::reference::{ReferenceError, ReferenceOptions};
use crate::engine::chain::reference_forecast::needed_for_reference;
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::geometrical::eikonal::EikonalError;
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::plan::plan_error::PlanError;
use crate::engine::plan::settings::Settings;
use crate::file::arrays::memory::MachineMemory;
use crate::file::decode::fault::Fault;
use crate::file::model::build::SOURCE;
use crate::file::scene::scene_file::Scene;
use crate::optics::system::System;
use crate::wave::grid::sampling::SamplingError;

/// Limits are named in whole multiples of these bytes.
const MEGABYTE: usize = 1_000_000;

/// The fault of a scene whose system cannot be computed with these settings.
pub fn simulate_fault(
    scene: &Scene,
    system: &System,
    settings: &Settings,
    error: &SimulateError,
) -> Fault {
    let fault = located(scene, error);
    match (error.too_large(), error.memory_needed()) {
        (Some(screen), Some(here)) => {
            let planned = needed_memory(system, settings);
            // Some arrays are known in the run alone, and what needs fewer values of these is not.
            let saved = planned.filter(|bytes| *bytes >= here);
            let saved = saved.map(|bytes| savings(system, settings, screen, bytes));
            let enough = planned.map(|planned| planned.max(here.next_multiple_of(MEGABYTE)));
            with_hint(fault, memory_hint(enough, &saved.unwrap_or_default()))
        }
        _ => fault,
    }
}

/// What may be done where memory is short: the limit that would do for the whole system, and changes that need less.
fn memory_hint(enough: Option<usize>, savings: &[Saving]) -> String {
    let limit = match enough {
        Some(bytes) => {
            let (needed, machine) = (
                bytes as f64 * 1e-6,
                MachineMemory::now().total as f64 * 1e-6,
            );
            let beyond = match machine > 0.0 && needed > machine {
                true => format!(", but this machine has {machine:.0} MB"),
                false => String::new(),
            };
            format!("settings.memory_limit_mb = {needed:.0} would do{beyond}")
        }
        None => String::from("no memory limit that was tried would do"),
    };
    let words: Vec<&str> = savings.iter().map(|saving| saving.words()).collect();
    match words.is_empty() {
        true => limit,
        false => format!("{limit}; {} needs less", words.join(" or ")),
    }
}

/// A fault with one hint more, which comes first.
fn with_hint(fault: Fault, hint: String) -> Fault {
    let hint = match &fault.hint {
        Some(more) => format!("{hint}; {more}"),
        None => hint,
    };
    fault.hint(hint)
}

/// The fault of a scene that cannot be computed, at its element.
fn located(scene: &Scene, error: &SimulateError) -> Fault {
    let found = error.to_string();
    match error {
        SimulateError::Plan(error) => plan_fault(scene, error),
        SimulateError::Sampling(error) => sampling_fault(scene, error),
        SimulateError::NoSensor(name) => {
            scene.fault(&path_of(scene, name), found, "a sensor as the last element")
        }
        SimulateError::NoLight(name) => {
            let expected = "an element that lets some light through";
            scene.fault(&path_of(scene, name), found, expected)
        }
        SimulateError::NotFinite(name) => {
            let expected = "a system whose field is finite: sizes, distances and amplitudes that lie less far apart";
            scene.fault(&path_of(scene, name), found, expected)
        }
        SimulateError::LocalBands(error) => local_bands_fault(scene, error),
        SimulateError::TooLarge { whole, bands } => {
            let fault = located(scene, whole);
            let more = fault
                .hint
                .as_ref()
                .map_or(String::new(), |hint| format!("{hint}; "));
            fault.hint(format!(
                "{more}local bands, which need no such field, cannot carry this light: {bands}"
            ))
        }
        SimulateError::Cancelled(_) => {
            Fault::of_file(&scene.origin.file, found, "a run to its end")
        }
        SimulateError::Sum(_) => {
            let expected = "a sum that can be planned";
            scene.fault("settings.nufft_tolerance", found, expected)
        }
    }
}

/// What may help where a hop takes many plane waves.
const TOUCHING: &str =
    "what touches a diffractive element, such as a thin lens, can be one of its layers";

/// A screen with too many of something, whose numbers along x and y take the place of # in `what`.
fn too_many<'a>(
    screen: &'a String,
    what: &str,
    [nx, ny]: &[usize; 2],
    expected: String,
) -> (&'a String, String, String) {
    let found = what.replace('#', &format!("{nx} × {ny}"));
    (screen, found, expected)
}

fn plan_fault(scene: &Scene, error: &PlanError) -> Fault {
    let (screen, found, expected) = match error {
        PlanError::Dark { to, .. } => (
            to,
            error.to_string(),
            String::from("a place that light reaches through the elements before it"),
        ),
        PlanError::Boundless(name) => return without_edge(scene, name),
        PlanError::NotFinite { from, .. } => {
            let expected = "sizes, distances and widths that lie less far apart";
            return scene.fault(&path_of(scene, from), error.to_string(), expected);
        }
        PlanError::Modes {
            screen,
            modes,
            allowed,
        } => too_many(
            screen,
            "patches of # modes",
            modes,
            memory(*allowed, "modes"),
        ),
        PlanError::Patches {
            screen,
            patches,
            allowed,
        } => too_many(screen, "# patches", patches, memory(*allowed, "patches")),
        PlanError::Directions {
            from,
            directions,
            allowed,
            ..
        } => {
            let expected = memory(*allowed, "plane waves");
            let (_, found, expected) =
                too_many(from, "# plane waves behind it", directions, expected);
            return (scene.fault(&path_of(scene, from), found, expected)).hint(TOUCHING);
        }
        PlanError::WholeField { .. } => {
            return scene.fault("settings.method", error.to_string(), "another method");
        }
        PlanError::TwoMedia(screen) => (
            screen,
            String::from("an element between two media"),
            String::from("method = \"local_bands\", or the same medium on both sides"),
        ),
        PlanError::Curved { method, screen } => (
            screen,
            format!("a curved element, and the method {method}"),
            String::from("the method beamlet or auto, or a plane element"),
        ),
    };
    // A width that the scene gives is more likely wrong than the element.
    let patches = matches!(error, PlanError::Modes { .. } | PlanError::Patches { .. });
    match scene.settings.sigma_um {
        Some(_) if patches => scene.fault("settings.sigma_um", found, expected),
        _ => scene.fault(&path_of(scene, screen), found, expected),
    }
}

fn local_bands_fault(scene: &Scene, error: &LocalBandError) -> Fault {
    let found = error.to_string();
    match error {
        LocalBandError::Boundless(name) => without_edge(scene, name),
        LocalBandError::Mirror(name) => {
            scene.fault(&path_of(scene, name), found, "exactly one of the two")
        }
        LocalBandError::Layers(name) => {
            let expected = "phases, and pixels over x and y of one lattice; or no interface, and the method beamlet or auto";
            scene.fault(&path_of(scene, name), found, expected)
        }
        LocalBandError::NoWidth(name) => scene.fault(&path_of(scene, name), found, "a width"),
        LocalBandError::NoLight(name) => {
            let expected = "a place that light reaches through the elements before it";
            scene.fault(&path_of(scene, name), found, expected)
        }
        LocalBandError::Windows { screen, .. } | LocalBandError::Tile { screen, .. } => {
            let path = match scene.settings.sigma_um {
                Some(_) => String::from("settings.sigma_um"),
                None => path_of(scene, screen),
            };
            scene.fault(
                &path,
                found,
                "wider or narrower windows, a smaller aperture, or a higher memory limit",
            )
        }
        LocalBandError::Memory { .. } => {
            let expected = "a limit that holds the beamlets, or light of fewer directions";
            scene.fault("settings.memory_limit_mb", found, expected)
        }
        LocalBandError::NoSensor => scene.fault("element", found, "a sensor as the last element"),
        LocalBandError::Cancelled(_) => {
            Fault::of_file(&scene.origin.file, found, "a run to its end")
        }
    }
}

fn sampling_fault(scene: &Scene, error: &SamplingError) -> Fault {
    match error {
        SamplingError::Boundless(name) => without_edge(scene, name),
        SamplingError::TooLarge {
            screen,
            needed,
            needed_y,
            allowed,
        } => {
            let found = format!("a field of {needed} × {needed_y} samples");
            scene.fault(&path_of(scene, screen), found, memory(*allowed, "samples"))
        }
        SamplingError::Absent(name) => {
            let expected = "an aperture inside which the surface exists";
            scene.fault(&path_of(scene, name), error.to_string(), expected)
        }
    }
}

fn without_edge(scene: &Scene, name: &str) -> Fault {
    scene.fault(&path_of(scene, name), "no edge", "an aperture")
}

fn memory(allowed: usize, what: &str) -> String {
    format!("at most {allowed} {what} (settings.memory_limit_mb)")
}

/// The fault of a scene whose system has no reference, or not the chosen one.
pub fn reference_fault(
    scene: &Scene,
    system: &System,
    settings: &Settings,
    choice: ReferenceOptions,
    error: &ReferenceError,
) -> Fault {
    let here = |screen: &str, expected: &str| {
        scene.fault(&path_of(scene, screen), error.to_string(), expected)
    };
    let other = "a system that the method applies to, or another --method";
    match error {
        ReferenceError::Run(error) => {
            let fault = located(scene, error);
            match error.memory_needed() {
                Some(_) => {
                    let enough = needed_for_reference(system, settings, choice);
                    with_hint(fault, memory_hint(enough, &[]))
                }
                None => fault,
            }
        }
        ReferenceError::NotApplicable { from, .. } => here(from, other),
        ReferenceError::NoMethod { from, .. } => here(
            from,
            "a system that some method without rays applies to; 'raylet simulate' needs none",
        ),
        ReferenceError::TooLong { from, .. } => {
            here(from, "a sum that ends sooner, or a larger --most-hours")
        }
        ReferenceError::Refraction(EikonalError::NotSmooth(name) | EikonalError::Curved(name)) => {
            here(name, other)
        }
        ReferenceError::Refraction(EikonalError::Boundless(name)) => here(name, "an aperture"),
        ReferenceError::Refraction(EikonalError::NoSensor(name)) => {
            here(name, "a sensor as the last element")
        }
        ReferenceError::Refraction(EikonalError::Dark(name)) => {
            here(name, "an element that sends some light to the sensor")
        }
        ReferenceError::Refraction(EikonalError::Focus { .. }) | ReferenceError::Collins(_) => {
            let last = scene.element.len().saturating_sub(1);
            scene.fault(&format!("element[{last}]"), error.to_string(), other)
        }
    }
}

/// The path of the element that a screen was made of.
fn path_of(scene: &Scene, screen: &str) -> String {
    match scene.number_of(screen) {
        Some(number) => format!("element[{number}]"),
        None if screen == SOURCE => String::from(SOURCE),
        // An entrance belongs to the first.
        None => String::from("element[0]"),
    }
}
