//! Runs of raylet beside the exact fields, and how the ratios of estimated to true errors are spread.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::outcome::{HopReport, Outcome};
use raylet::engine::chain::simulate::simulate;
use raylet::engine::chain::simulate_error::SimulateError;
use raylet::engine::plan::settings::Settings;
use raylet::optics::system::System;

use crate::estimates::random_systems::{KINDS, Kind, random_system};
use crate::estimates::surface_sum::surface_sum;

/// A random system, the error that raylet estimated and the true one.
#[derive(Clone, Debug)]
pub struct Case {
    /// Kind of the system.
    pub kind: Kind,
    /// Number of the system within its kind.
    pub number: u32,
    /// The target error of the run.
    pub target: f64,
    /// The error that raylet estimated.
    pub estimate: f64,
    /// The parts of that estimate: aberration, windows, dropped light, rims.
    pub parts: [f64; 4],
    /// Relative L2 distance of the complex field from the exact one, nothing fitted.
    pub truth: f64,
    /// Mean intensity on the sensor.
    pub intensity: f64,
    /// Seconds of raylet, and of the reference.
    pub seconds: [f64; 2],
}

/// The target errors, in turn.
const TARGETS: [f64; 3] = [1e-3, 1e-2, 1e-4];

/// The fineness of the reference.
pub const EFFORT: f64 = 1.0;

/// The fineness of a finer reference, against which the first one is checked.
pub const FINER: f64 = 1.3;

/// Errors below this count as equal: the reference itself may be wrong by as much.
pub const FLOOR: f64 = 2e-5;

impl Case {
    /// Estimated over true error.
    pub fn ratio(&self) -> f64 {
        self.estimate.max(FLOOR) / self.truth.max(FLOOR)
    }
}

/// The kind, number, target error and system of a case.
pub fn case_at(index: u32) -> (Kind, u32, f64, System) {
    let kind = KINDS[index as usize % KINDS.len()];
    let number = index / KINDS.len() as u32;
    let target = TARGETS[number as usize % TARGETS.len()];
    (kind, number, target, random_system(kind, number))
}

/// Runs a case.
///
/// # Errors
/// When raylet refuses the system.
pub fn run_case(index: u32) -> Result<Case, SimulateError> {
    let (kind, number, target, system) = case_at(index);
    let settings = Settings {
        target_error: target,
        ..Settings::default()
    };
    let clock = std::time::Instant::now();
    let outcome = simulate(&system, &settings, &|_| {})?;
    let ours = clock.elapsed().as_secs_f64();
    let exact = surface_sum(&system, EFFORT);
    let reference = clock.elapsed().as_secs_f64() - ours;
    Ok(Case {
        kind,
        number,
        target,
        estimate: outcome.expected_error().unwrap_or(0.0),
        parts: parts(&outcome),
        truth: distance(&outcome.field.values, &exact),
        intensity: power(&exact) / exact.len() as f64,
        seconds: [ours, reference],
    })
}

/// The errors that the hops of a run estimate, by cause.
fn parts(outcome: &Outcome) -> [f64; 4] {
    let budgets = outcome.hops.iter().filter_map(HopReport::budget);
    budgets.fold([0.0; 4], |sums: [f64; 4], budget| {
        let own = [
            budget.aberration,
            budget.windows,
            budget.dropped,
            budget.rims,
        ];
        std::array::from_fn(|part| sums[part].hypot(own[part]))
    })
}

/// Relative L2 distance of a field from the exact one.
pub fn distance(field: &Array2<Complex64>, exact: &Array2<Complex64>) -> f64 {
    (power(&(field - exact)) / power(exact)).sqrt()
}

fn power(field: &Array2<Complex64>) -> f64 {
    field.iter().map(|value| value.norm_sqr()).sum()
}

/// How the ratios of estimated to true errors are spread.
#[derive(Clone, Debug)]
pub struct Spread {
    /// The share of cases in which the estimated error is at least half of the true one.
    pub at_least_half: f64,
    /// The share in which it is at most five times the true one.
    pub at_most_five: f64,
    /// The smallest ratio.
    pub least: f64,
    /// How many ratios lie between the [`BOUNDS`], below the first and above the last.
    pub counts: [usize; BOUNDS.len() + 1],
}

/// The ratios between which cases are counted.
pub const BOUNDS: [f64; 7] = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];

impl Spread {
    /// The spread of these ratios.
    pub fn of(ratios: &[f64]) -> Self {
        let share = |wanted: &dyn Fn(f64) -> bool| {
            let count = ratios.iter().filter(|ratio| wanted(**ratio)).count();
            count as f64 / ratios.len() as f64
        };
        let mut counts = [0; BOUNDS.len() + 1];
        for ratio in ratios {
            counts[BOUNDS.partition_point(|bound| bound <= ratio)] += 1;
        }
        Self {
            at_least_half: share(&|ratio| ratio >= 0.5),
            at_most_five: share(&|ratio| ratio <= 5.0),
            least: ratios.iter().copied().fold(f64::INFINITY, f64::min),
            counts,
        }
    }

    /// Whether estimated errors cover true ones as they should.
    pub fn covers(&self) -> bool {
        self.at_least_half >= 0.95 && self.at_most_five >= 0.93 && self.least > 0.12
    }
}
