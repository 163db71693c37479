//! A whole run: from the source through every hop to the sensor.

use crate::engine::chain::arriving_light::sensor_of;
use crate::engine::chain::missed_target::best_outcome;
use crate::engine::chain::outcome::{Listener, Outcome, Progress};
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::plan::settings::Settings;
use crate::engine::progress::Reply;
use crate::optics::system::System;

/// Carries the light of a system to its sensor. `progress` is called after each chunk of work.
///
/// Where the expected error is more than twice the target error, the plans for looser targets are run too, and those for
/// tighter ones where aberrated beamlets make most of it, unless they take long. The outcome with the smallest expected
/// error is returned.
///
/// # Errors
/// When a screen has no edge or needs too many samples, no ray gets through a hop, no light is left, or `progress`
/// cancels the run.
pub fn simulate<R: Reply>(
    system: &System,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> R + Sync),
) -> Result<Outcome, SimulateError> {
    sensor_of(system)?;
    let listener: &Listener = &|here| progress(here).flow();
    best_outcome(system, settings, listener)
}
