//! What a user must know of a result: that it misses its target error, that the sensor is dark, that it holds more light
//! than came.

use crate::engine::chain::outcome::{HopReport, Outcome};
use crate::engine::error::advice::lost_orders;
use crate::engine::error::error_budget::ErrorBudget;
use crate::engine::plan::hop_method::HopMethod;
use crate::engine::plan::settings::Settings;

/// Estimates are no more exact than this: one that is above the target by less is not worth a warning.
const NEAR: f64 = 1.1;

/// Sums over pixels are no more exact than this share of the light.
const SUM: f64 = 1e-3;

/// Whether an expected error misses a target.
pub fn misses(error: f64, target_error: f64) -> bool {
    error > NEAR * target_error
}

/// The share of light beyond all that came, from the power on the sensor and behind the first screen; nothing where there is
/// no more than sums over pixels explain.
pub fn excess(landed: f64, behind: f64) -> Option<f64> {
    let beyond = landed / behind - 1.0;
    (beyond > SUM).then_some(beyond)
}

/// The warnings about a result; the last says that it misses its target error.
pub(crate) fn run_warnings(outcome: &Outcome, settings: &Settings) -> Vec<String> {
    let target_error = settings.target_error;
    let expected = outcome.expected_error();
    let budgets = outcome
        .hops
        .iter()
        .filter_map(|hop| Some((hop, hop.budget()?)));
    let worst = budgets.max_by(|(_, a), (_, b)| a.total().total_cmp(&b.total()));
    let missed = expected
        .filter(|expected| misses(*expected, target_error))
        .zip(worst)
        .map(|(expected, (hop, budget))| missed_target(expected, settings, hop, &budget));
    let list = [
        dark_sensor(outcome),
        light_that_stays(outcome),
        excess_light(outcome, expected),
        missed,
    ];
    list.into_iter().flatten().collect()
}

/// That the expected error is above the target, where most of it comes from, and what may help.
fn missed_target(
    expected: f64,
    settings: &Settings,
    hop: &HopReport,
    budget: &ErrorBudget,
) -> String {
    let (cause, help) = main_cause(hop, budget, settings);
    let ([from, to], target) = (&hop.screens, settings.target_error);
    format!(
        "the expected field error {expected:.1e} misses the target {target:.1e}: most of it comes from {cause} between \
         {from} and {to}; {help}"
    )
}

/// The largest cause of a hop's error, and what may help.
fn main_cause(
    hop: &HopReport,
    budget: &ErrorBudget,
    settings: &Settings,
) -> (&'static str, &'static str) {
    let ErrorBudget {
        aberration,
        windows,
        dropped,
        rims,
    } = *budget;
    let largest = aberration.max(windows).max(dropped).max(rims);
    let given = settings.sigma.is_some();
    let width = "without settings.sigma_um the width of windows is chosen for the target error";
    match (largest, &hop.method) {
        _ if largest == rims => (
            "rims of surfaces that cut light",
            "where a rim cuts ray by ray, an element of kind \"stop\" in its place diffracts the light",
        ),
        _ if largest == dropped => (
            "modes and tails that were left out",
            "a tighter target error may help",
        ),
        _ if largest == windows => (
            "windows and their period",
            if given {
                width
            } else {
                "a smaller settings.step or a longer settings.period may help"
            },
        ),
        _ if given => ("aberration inside beamlets", width),
        (_, HopMethod::WholeField(_)) => (
            "aberration inside beamlets",
            "settings.method = \"local_bands\" may do better",
        ),
        (_, HopMethod::LocalBands(_)) => (
            "aberration inside beamlets",
            "settings.method = \"beamlet\" may do better, or a smaller settings.sigma_um",
        ),
    }
}

/// That no sample of the sensor has light.
fn dark_sensor(outcome: &Outcome) -> Option<String> {
    let dark = outcome.field.values.iter().all(|u| u.norm_sqr() == 0.0);
    dark.then(|| {
        String::from(
            "no light comes to the centre of any pixel of the sensor: it lies beside the light, or its pixels are so \
             large that the light falls between their centres",
        )
    })
}

/// Below this share of the light on the sensor a run looks for orders that do not propagate.
const DIM: f64 = 1e-3;

/// That hardly any light reaches the sensor because orders of an element do not propagate.
fn light_that_stays(outcome: &Outcome) -> Option<String> {
    let [_, behind, _] = outcome.hops.first()?.power;
    let [_, _, landed] = outcome.hops.last()?.power;
    let (behind, landed) = (behind?, landed?);
    if landed > DIM * behind {
        return None;
    }
    let lost = lost_orders(&outcome.rimmed.system)?;
    Some(format!("hardly any light reaches the sensor: {lost}"))
}

/// That the pixels sum to more light than left the first screen: the field is wrong by √(sum) − 1 of itself at least, unless
/// its pixels are too coarse to sum it.
fn excess_light(outcome: &Outcome, expected: Option<f64>) -> Option<String> {
    let [_, behind, _] = outcome.hops.first()?.power;
    let [_, _, landed] = outcome.hops.last()?.power;
    let beyond = excess(landed?, behind?)?;
    let (percent, least) = (100.0 * beyond, (1.0 + beyond).sqrt() - 1.0);
    let cause = match expected {
        Some(expected) if least > expected => format!(
            "the pixels are too coarse to sum it, or the field is wrong by {least:.1e} at least, more than the expected \
             {expected:.1e}"
        ),
        _ => format!("an error of the method, by which the field is wrong by {least:.1e} at least"),
    };
    Some(format!(
        "the pixels sum to {percent:.2} % more light than came: {cause}"
    ))
}
