//! What a user must know of a result: that it misses its target error, that the sensor is dark, that it holds more light
//! than came.

use crate::engine::chain::outcome::{HopReport, Outcome};
use crate::engine::error::error_budget::ErrorBudget;
use crate::engine::plan::hop_method::HopMethod;

/// Estimates are no more exact than this: one that is above the target by less is not worth a warning.
const NEAR: f64 = 1.1;

/// Sums over pixels are no more exact than this share of the light.
const SUM: f64 = 1e-3;

/// The warnings about a result, for this target error.
pub(crate) fn run_warnings(outcome: &Outcome, target_error: f64) -> Vec<String> {
    let expected = outcome.expected_error();
    let budgets = outcome
        .hops
        .iter()
        .filter_map(|hop| Some((hop, hop.budget()?)));
    let worst = budgets.max_by(|(_, a), (_, b)| a.total().total_cmp(&b.total()));
    let missed = expected
        .filter(|expected| *expected > NEAR * target_error)
        .zip(worst)
        .map(|(expected, (hop, budget))| missed_target([expected, target_error], hop, &budget));
    let list = [
        missed,
        dark_sensor(outcome),
        excess_light(outcome, expected),
    ];
    list.into_iter().flatten().collect()
}

/// That the expected error is above the target, where most of it comes from, and what may help.
fn missed_target([expected, target]: [f64; 2], hop: &HopReport, budget: &ErrorBudget) -> String {
    let (cause, help) = main_cause(hop, budget);
    let [from, to] = &hop.screens;
    format!(
        "the expected field error {expected:.1e} misses the target {target:.1e}: most of it comes from {cause} between \
         {from} and {to}{help}"
    )
}

/// The largest cause of a hop's error, and what may help.
fn main_cause(hop: &HopReport, budget: &ErrorBudget) -> (&'static str, &'static str) {
    let ErrorBudget {
        aberration,
        windows,
        dropped,
        rims,
    } = *budget;
    let largest = aberration.max(windows).max(dropped).max(rims);
    match (largest, &hop.method) {
        _ if largest == rims => (
            "rims of surfaces that cut light",
            "; where a rim cuts ray by ray, an element of kind \"stop\" in its place diffracts the light",
        ),
        _ if largest == dropped => (
            "modes and tails that were left out",
            "; a tighter target error may help",
        ),
        _ if largest == windows => (
            "windows and their period",
            "; a smaller settings.step or a longer settings.period may help",
        ),
        (_, HopMethod::WholeField(_)) => (
            "aberration inside beamlets",
            "; settings.method = \"local_bands\" may do better",
        ),
        (_, HopMethod::LocalBands(_)) => ("aberration inside beamlets", ""),
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

/// That the pixels sum to more light than left the first screen.
fn excess_light(outcome: &Outcome, expected: Option<f64>) -> Option<String> {
    let [_, behind, _] = outcome.hops.first()?.power;
    let [_, _, landed] = outcome.hops.last()?.power;
    let share = landed? / behind?;
    let allowed = 1.0 + SUM.max(2.0 * expected.unwrap_or(0.0));
    (share > allowed).then(|| {
        let percent = 100.0 * share;
        format!(
            "the pixels sum to {percent:.2} % of the light that came: the field is too bright, or the pixels are too \
             coarse to sum it"
        )
    })
}
