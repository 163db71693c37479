//! The result of a run, and how far it has come.

use std::ops::ControlFlow;

use ndarray::Array2;

use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::error::error_budget::ErrorBudget;
use crate::engine::error::tally::Tally;
use crate::engine::geometrical::chief_ray::chief_landing;
use crate::engine::local_bands::source::source_light::power_behind;
use crate::engine::plan::hop_method::HopMethod;
use crate::engine::plan::hop_plan::Plan;
use crate::engine::rims::rim_screens::Rimmed;
use crate::optics::system::System;
use crate::wave::grid::field::Field;
use crate::wave::grid::mean_cosine::mean_cosine;

/// The report on one hop of a run.
#[derive(Clone, Debug)]
pub struct HopReport {
    /// Names of its screens.
    pub screens: [String; 2],
    /// Its method, with the plan.
    pub method: HopMethod,
    /// Rays and energy by fate.
    pub tally: Tally,
    /// ∫(n/n₀)|U|² just before the first screen acted (over its samples), just behind it, and on the second
    /// screen, in mm² for unit amplitude, with the index n of the medium there and n₀ of the ambient one; behind the first
    /// screen of a system and on its sensor the power through them, with the cosines of the directions.
    pub power: [Option<f64>; 3],
    /// Samples of the field on the first screen, [ny, nx]; nothing for local bands.
    pub samples: Option<[usize; 2]>,
    /// Seconds it took.
    pub seconds: f64,
}

impl HopReport {
    /// The expected error of the hop, by cause; `None` for a method whose errors are not estimated.
    pub fn budget(&self) -> Option<ErrorBudget> {
        ErrorBudget::of(&self.method, &self.tally)
    }
}

/// The power that passes the first screen of a system, with the cosines of its directions; nothing for a screen without an edge.
pub(crate) fn power_passed(system: &System) -> Option<f64> {
    let first = system.screens.first()?;
    let power = power_behind(&system.source, first, system.wavenumber())?;
    Some(power * system.power_in(first.index))
}

/// The mean cosine of the light on the sensor of a system, whose field this is: pixels do not tell steep directions apart, and
/// the light is taken to go about along the chief ray.
pub(crate) fn mean_cosine_on_sensor(system: &System, field: &Field) -> f64 {
    let pitch = [field.grid.x.pitch, field.grid.y.pitch];
    let index = system.screens.last().map_or(1.0, |sensor| sensor.index);
    let about = chief_landing(system).map_or([0.0; 2], |chief| chief.cosines);
    mean_cosine(&field.values, pitch, system.wavenumber() * index, about)
}

/// Makes the powers behind the first screen of a system and on its sensor, of those of its hops, powers through both. Where no
/// light propagates behind the first screen, ∫|U|² there stays.
pub(crate) fn with_cosines<'a>(
    system: &System,
    field: &Field,
    powers: impl Iterator<Item = &'a mut [Option<f64>; 3]>,
) {
    let mut powers: Vec<_> = powers.collect();
    let passed = power_passed(system).filter(|passed| *passed > 0.0);
    if let (Some(first), Some(passed)) = (powers.first_mut(), passed) {
        first[1] = Some(passed);
    }
    if let Some(landed) = powers.last_mut().and_then(|last| last[2].as_mut()) {
        *landed *= mean_cosine_on_sensor(system, field);
    }
}

/// The result of a run at one wavelength.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Complex field at the sensor's pixel centres.
    pub field: Field,
    /// Standard error of the field at each of them, indexed [y, x], where the last hop drew rays at random:
    /// what that hop adds. Its real and imaginary parts each have this over √2.
    pub standard_error: Option<Array2<f64>>,
    /// The report on each hop.
    pub hops: Vec<HopReport>,
    /// The system as it was run, with a screen at every rim that matters, and all rims.
    pub rimmed: Rimmed,
}

impl Outcome {
    /// The expected relative error of the field: the root of the sum of squares over all hops. Nothing where a hop was
    /// carried by a method whose errors are not estimated.
    pub fn expected_error(&self) -> Option<f64> {
        let budgets = self.hops.iter().map(HopReport::budget);
        let squares: Option<f64> = budgets.map(|one| Some(one?.total().powi(2))).sum();
        squares.map(f64::sqrt)
    }
}

/// The progress of a run, for a callback.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Number of the attempt: 0 for the first, 1 and more where the target error was missed.
    pub attempt: usize,
    /// Index of the hop.
    pub hop: usize,
    /// Number of hops.
    pub hops: usize,
    /// Name of the screen the hop leads to.
    pub to: &'a str,
    /// Share of the hop that is done, 0 to 1.
    pub done: f64,
    /// Rays that the hop's plan expects; zero without rays.
    pub rays: f64,
}

impl<'a> Progress<'a> {
    /// A note that follows the name of a screen in messages: " (attempt 2)" for a second attempt, "" for the first.
    pub fn attempt_note(&self) -> String {
        match self.attempt {
            0 => String::new(),
            before => format!(" (attempt {})", before + 1),
        }
    }

    pub(crate) fn of(system: &'a System, hop: usize, plan: &Plan, done: f64) -> Self {
        Self {
            attempt: 0,
            hop,
            hops: system.trains.len(),
            to: &system.screens[hop + 1].name,
            done,
            rays: plan.rays(),
        }
    }
}

/// The function to which a run reports how far it has come. Its answer continues the run or cancels it.
pub(crate) type Listener<'a> = dyn Fn(Progress) -> ControlFlow<()> + Sync + 'a;

/// Refuses a field on the sensor, or its standard errors, that are no numbers.
///
/// # Errors
/// [`SimulateError::NotFinite`] with the sensor's name.
pub(crate) fn check_sound(
    system: &System,
    field: &Field,
    noise: Option<&Array2<f64>>,
) -> Result<(), SimulateError> {
    let mut noise = noise.into_iter().flatten();
    match field.is_sound() && noise.all(|error| error.is_finite()) {
        true => Ok(()),
        false => {
            let name = system.screens.last().map(|screen| screen.name.clone());
            Err(SimulateError::NotFinite(name.unwrap_or_default()))
        }
    }
}
