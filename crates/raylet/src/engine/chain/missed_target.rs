//! Further attempts where a run misses its target error.
//!
//! How much light is left out with aberrated tails is known only when the beamlets were traced. So a plan may end far
//! above the target error, where the plan for a tighter target (with screens at more rims) or for a looser one (with
//! other widths) ends below. The attempt with the smallest expected error is kept.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::engine::chain::attempt::Attempt;
use crate::engine::chain::forecast::{Grids, whole_field_work};
use crate::engine::chain::outcome::{HopReport, Listener, Outcome, Progress};
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::plan::hop_plan::Plan;
use crate::engine::plan::settings::{Method, Settings};
use crate::optics::system::System;

/// When a run is repeated with plans for looser targets.
struct Repetition {
    /// A run misses its target if its expected error is this many times as large.
    missed: f64,
    /// The loosest target that is tried, over the expected error.
    loosest: f64,
}

/// For systems with beamlets.
const BEAMLETS: Repetition = Repetition {
    missed: 2.0,
    loosest: 2.0,
};

/// For systems of free hops alone: they cost little to repeat, and their errors are often far below their targets.
const FREE: Repetition = Repetition {
    missed: 1.0,
    loosest: 10.0,
};

/// The tighter targets that are tried, as shares of the given one: the first with other widths.
const TIGHTER: [f64; 2] = [0.1, 0.01];

/// From one looser target to the next; they end where the expected error is this many times that of the best attempt.
const LOOSER: f64 = 10.0;
const WORSE: f64 = 1.1;

/// Attempts take at most these seconds of one core, as their plans expect, or this many times what the first takes.
const LONGEST: f64 = 20.0;
const LONGER: f64 = 4.0;

/// An attempt adds a field on the sensor to those of a run: the samples of a sensor for which there is memory, as a
/// share of those that the limit allows.
const SPARE: usize = 4;

/// The best outcome of a system: that of the plans for the target error, or of those for another one.
///
/// # Errors
/// Those of the first attempt; when `progress` cancels any of them.
pub(crate) fn best_outcome(
    system: &System,
    settings: &Settings,
    progress: &Listener,
) -> Result<Outcome, SimulateError> {
    let settings = &settings.for_planning();
    let first = Attempt::plan(system, settings, progress)?;
    let longest = LONGEST.max(LONGER * seconds(&first));
    let tried = vec![choices(&first)];
    let free = tried[0].iter().all(Option::is_none);
    let mut attempts = Attempts {
        system,
        settings,
        progress,
        longest,
        repetition: if free { FREE } else { BEAMLETS },
        tried,
        best: first.run(system, progress)?,
    };
    if attempts.may_be_repeated() {
        if attempts.is_aberrated() {
            attempts.try_tighter()?;
        }
        attempts.try_looser()?;
    }
    Ok(attempts.best)
}

/// Which plans for another target are run.
#[derive(Clone, Copy, PartialEq)]
enum OtherWidths {
    /// Those of which some hop has another width than in all attempts before.
    Only,
    /// All.
    OrTheSame,
}

/// The attempts of a run, with the best outcome so far.
struct Attempts<'a> {
    system: &'a System,
    settings: &'a Settings,
    progress: &'a Listener<'a>,
    longest: f64,
    repetition: Repetition,
    tried: Vec<Vec<Option<Choice>>>,
    best: Outcome,
}

impl Attempts<'_> {
    /// The expected error of the best outcome.
    fn error(&self) -> f64 {
        self.best.expected_error().unwrap_or(0.0)
    }

    /// Whether the best outcome misses the target error.
    fn misses(&self) -> bool {
        self.error() > self.repetition.missed * self.settings.target_error
    }

    /// Whether plans for other targets may help: the target is missed by whole fields, widths are free, and there is
    /// memory.
    fn may_be_repeated(&self) -> bool {
        let whole = self.tried.iter().all(|choices| !choices.is_empty());
        let free = whole && self.settings.method == Method::Auto && self.settings.sigma.is_none();
        let room = SPARE * self.best.field.values.len() <= self.settings.samples_allowed();
        free && room && self.misses()
    }

    /// Whether most of the error comes from aberration, which is smaller with other widths.
    fn is_aberrated(&self) -> bool {
        let budgets = self.best.hops.iter().filter_map(HopReport::budget);
        let aberrated = budgets
            .map(|budget| budget.aberration.hypot(budget.dropped))
            .fold(0.0, f64::hypot);
        aberrated > FRAC_1_SQRT_2 * self.error()
    }

    /// Tries tighter targets, until one has other widths.
    fn try_tighter(&mut self) -> Result<(), SimulateError> {
        for share in TIGHTER {
            if self.attempt(share, OtherWidths::Only)?.is_some() {
                break;
            }
        }
        Ok(())
    }

    /// The loosest target that may help.
    fn loosest(&self) -> f64 {
        self.repetition.loosest * self.error()
    }

    /// Tries looser targets as long as they may help and do. Where no target helps, as where rims make the error, the
    /// plan for a looser one is kept if it reports less: a target ten times tighter does not report more.
    fn try_looser(&mut self) -> Result<(), SimulateError> {
        let mut factor = LOOSER;
        while self.misses() && factor * self.settings.target_error <= self.loosest() {
            let before = self.error();
            let error = self.attempt(factor, OtherWidths::OrTheSame)?;
            if error.is_some_and(|error| error > WORSE * before) {
                break;
            }
            factor *= LOOSER;
        }
        Ok(())
    }

    /// Runs the plans for another target error and keeps the better outcome; its expected error, or nothing where they
    /// have no other widths though they should, would take too long or are impossible.
    fn attempt(&mut self, factor: f64, widths: OtherWidths) -> Result<Option<f64>, SimulateError> {
        let number = self.tried.len();
        let again = |here: Progress| {
            (self.progress)(Progress {
                attempt: number,
                ..here
            })
        };
        let aim = self.settings.aiming_at(factor * self.settings.target_error);
        let Some(planned) = unless_cancelled(Attempt::plan(self.system, &aim, &again))? else {
            return Ok(None);
        };
        let choices = choices(&planned);
        let same = widths == OtherWidths::Only && self.tried.contains(&choices);
        if choices.is_empty() || same || seconds(&planned) > self.longest {
            return Ok(None);
        }
        self.tried.push(choices);
        let outcome = unless_cancelled(planned.run(self.system, &again))?;
        let error = outcome.as_ref().and_then(Outcome::expected_error);
        if let Some(outcome) = outcome.filter(|_| error.is_some_and(|error| error < self.error())) {
            self.best = outcome;
        }
        Ok(error)
    }
}

/// The result of a later attempt, if it has one: where it fails the first one stands.
fn unless_cancelled<T>(result: Result<T, SimulateError>) -> Result<Option<T>, SimulateError> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(SimulateError::Cancelled(cancelled)) => Err(cancelled.into()),
        Err(_) => Ok(None),
    }
}

/// The choices by which the beamlets of a hop for one target error differ from those for another.
#[derive(PartialEq)]
struct Choice {
    /// Their width σ in mm.
    sigma: f64,
    /// Whether the aberration inside them is corrected.
    correct: bool,
}

/// The choices of an attempt from whole fields, nothing for a hop without beamlets; of local bands none, whose plans
/// come from their own forecast.
fn choices(attempt: &Attempt) -> Vec<Option<Choice>> {
    let choice = |(plan, _): &(Plan, Grids)| match plan {
        Plan::Beamlets(plan) => Some(Choice {
            sigma: plan.sigma,
            correct: plan.correct,
        }),
        Plan::Free(..) | Plan::Planes(_) | Plan::Paper(_) => None,
    };
    attempt.whole_fields().iter().map(choice).collect()
}

/// Seconds of one core that an attempt from whole fields expects to take.
fn seconds(attempt: &Attempt) -> f64 {
    let hops = attempt.whole_fields().iter();
    hops.map(|(plan, grids)| whole_field_work(plan, grids).seconds)
        .sum()
}
