//! A whole run by local bands: the choices for a system, and its outcome as that of any run.

use crate::engine::chain::outcome::{
    HopReport, Listener, Outcome, Progress, check_sound, mean_cosine_on_sensor, power_passed,
};
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::local_bands::carry::{LocalBandHop, carry_with, planned};
use crate::engine::local_bands::edge_workload::width_for_edge;
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::local_bands::settings::{LocalBandSettings, STEP};
use crate::engine::local_bands::source::source_aperture::source_aperture;
use crate::engine::local_bands::window_widths::window_widths;
use crate::engine::local_bands::workload::quickest_widths;
use crate::engine::plan::hop_method::HopMethod;
use crate::engine::plan::settings::{Correction, Settings};
use crate::engine::rims::rim_screens::{Rimmed, cut_by_ray};
use crate::optics::system::System;
use crate::wave::grid::field::Field;

/// Share of the target error that plane waves which are left out may cost.
const DROPPED_SHARE: f64 = 0.33;

/// What is left out where all plane waves are requested, as a share of what is left out otherwise.
const NEARLY_ALL: f64 = 0.1;

/// Share of the target error that the period of windows may cost.
const PERIOD_SHARE: f64 = 0.06;

/// The choices of a run by local bands: as given, or such that each hop has its part of the target error.
///
/// # Errors
/// When a screen has no edge or reflects into another medium, an element has layers of another kind, or no ray of the source arrives.
pub fn local_band_settings(
    system: &System,
    settings: &Settings,
) -> Result<LocalBandSettings, LocalBandError> {
    let hops = system.trains.len();
    let shared = settings.shared(hops);
    let step = settings.step.unwrap_or(STEP);
    let aperture = source_aperture(system, settings.target_error)?;
    let sigmas = match settings.sigma {
        Some(sigma) => vec![sigma; hops],
        None => window_widths(system, aperture, step, shared.target_error)?,
    };
    let period = 2.0 * (2.0 / (PERIOD_SHARE * settings.target_error)).ln().sqrt();
    // A threshold of zero asks for all plane waves: of these there is no end, so the bands end far below the target error.
    let share = match settings.mode_threshold {
        Some(0.0) => NEARLY_ALL,
        _ => 1.0,
    };
    let threshold = settings.mode_threshold.filter(|given| *given > 0.0);
    let mut chosen = LocalBandSettings {
        step,
        period: settings.period.unwrap_or(period),
        threshold: threshold.unwrap_or(share * settings.coarsest_threshold()),
        dropped: match threshold {
            Some(_) => None,
            None => Some(share * DROPPED_SHARE * shared.target_error),
        },
        corrected: settings.correction != Correction::Off,
        aperture,
        memory_limit: settings.memory_limit,
        ..LocalBandSettings::new(sigmas)
    };
    planned(system, &chosen)?;
    if settings.sigma.is_none() {
        chosen.sigmas = quickest_widths(system, &chosen, shared.target_error)?;
        if let Some(narrow) = width_for_edge(system, &chosen, shared.target_error)? {
            chosen.sigmas = vec![narrow];
            chosen.edge_sums = true;
        }
    }
    Ok(chosen)
}

/// Light on the sensor, and what its hops did.
pub(crate) struct Landed {
    field: Field,
    hops: Vec<HopReport>,
}

impl Landed {
    /// The outcome of the run.
    pub(crate) fn outcome(self, rimmed: Rimmed) -> Outcome {
        Outcome {
            hops: self.hops,
            field: self.field,
            standard_error: None,
            rimmed,
        }
    }
}

/// Carries the light of a system, in which rims that matter are screens, to its sensor.
///
/// # Errors
/// When an element has layers of another kind, no light is left, the beamlets take too much
/// memory, the field is not finite, or `progress` cancels the run.
pub(crate) fn run_local_bands(
    original: &System,
    rimmed: &Rimmed,
    settings: &LocalBandSettings,
    progress: &Listener,
) -> Result<Landed, SimulateError> {
    let system = &rimmed.system;
    let outcome = carry_with(system, settings, &|here| {
        progress(Progress {
            attempt: 0,
            hop: here.hop,
            hops: system.trains.len(),
            to: &system.screens[here.hop + 1].name,
            done: here.done,
            rays: 0.0,
        })
    })?;
    check_sound(original, &outcome.field, None)?;
    let in_sensor = (system.screens.last()).map_or(1.0, |sensor| system.power_in(sensor.index));
    let landed = outcome.field.power() * in_sensor;
    let steep = mean_cosine_on_sensor(system, &outcome.field);
    let hops = outcome.hops.into_iter().enumerate();
    let hops = hops.map(|(number, hop)| report(rimmed, number, hop, landed, steep));
    Ok(Landed {
        hops: hops.collect(),
        field: outcome.field,
    })
}

/// What a hop did, of a run that brings light of ∫|U|² = `landed`, with this mean cosine, to the sensor.
fn report(rimmed: &Rimmed, number: usize, hop: LocalBandHop, landed: f64, steep: f64) -> HopReport {
    let mut tally = hop.statistics.tally;
    let (system, from) = (&rimmed.system, &rimmed.system.screens[number]);
    let behind_first = power_passed(system);
    let behind = behind_first.filter(|_| number == 0);
    let last = number + 1 == system.trains.len();
    let cut = rimmed.edge_error(number, |from, to| {
        let whole = from == 0 && to == system.trains.len();
        let behind = behind_first.filter(|power| whole && *power > 0.0 && landed > 0.0)?;
        Some(landed * steep / behind)
    });
    tally.edge = cut.hypot(cut_by_ray(&rimmed.rims, number));
    if last {
        let area = (hop.plan.step * hop.plan.sigma).powi(2);
        let leaving = system.power_in(from.index_behind());
        tally.landed = Some(landed / (leaving * area * tally.total_energy()));
    }
    HopReport {
        screens: hop.screens,
        method: HopMethod::LocalBands(hop.plan),
        tally,
        power: [None, behind, last.then_some(landed * steep)],
        samples: None,
        seconds: hop.seconds,
    }
}
