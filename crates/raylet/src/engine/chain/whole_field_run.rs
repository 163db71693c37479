//! A whole run from fields that are sampled as a whole: from one screen to the next.

use std::time::Instant;

use ndarray::Array2;

use crate::engine::chain::arriving_light::{
    Arriving, arrival_reach, leaving, receiving_raster, sensor_of,
};
use crate::engine::chain::hop_run::HopRun;
use crate::engine::chain::outcome::{
    HopReport, Listener, Outcome, Progress, check_sound, with_cosines,
};
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::error::lost_light::lost_light;
use crate::engine::error::tally::{FATES, Fate};
use crate::engine::plan::downstream::Downstream;
use crate::engine::plan::hop_method::HopMethod;
use crate::engine::plan::hop_plan::Plan;
use crate::engine::plan::settings::Settings;
use crate::engine::progress::Cancelled;
use crate::engine::rims::rim_screens::{Rimmed, cut_by_ray};
use crate::optics::screen::Sensor;
use crate::optics::system::{Hop, System};
use crate::wave::grid::field::{Field, Grid};
use crate::wave::grid::height_stack::HeightStack;
use crate::wave::grid::sampling::{apply_screen, power_behind};

/// Lost light below this share is not divided by cause: no report shows it.
const NOTHING: f64 = 1e-9;

/// Carries the light of a system, in which rims that matter are screens, to its sensor.
///
/// # Errors
/// When a screen needs too many samples, no light is left, the field is not finite, or `progress` cancels the run.
pub(crate) fn run_whole_fields(
    original: &System,
    rimmed: Rimmed,
    plans: Vec<Plan>,
    settings: &Settings,
    progress: &Listener,
) -> Result<Outcome, SimulateError> {
    let system = &rimmed.system;
    let sensor = sensor_of(system)?;
    let settings = &settings.shared(system.trains.len());
    let mut light = Arriving::from_source(system);
    let (mut reports, mut standard_error) = (Vec::<HopReport>::new(), None);
    for ((number, hop), plan) in system.hops().enumerate().zip(plans) {
        let clock = Instant::now();
        let downstream = &Downstream::of(system, number);
        let (arrived, field) = light.pass(system, hop.from, leaving(&plan), settings)?;
        let [before, behind] = [arrived.power(), power_behind(hop.from, &arrived, &field)];
        drop(arrived);
        let reach = arrival_reach(&hop, &plan);
        let raster = receiving_raster(&hop, reach, settings)?;
        let step = |done| progress(Progress::of(system, number, &plan, done));
        Cancelled::check(step(0.0))?;
        let run = HopRun::new(number, hop, &plan, settings, downstream);
        let (levels, mut tally) = run.carry(&field, raster, reach, &step)?;
        if !levels.power().is_finite() {
            return Err(SimulateError::NotFinite(hop.to.name.clone()));
        }
        tally.spot_check = spot_check(&run, &light, system, &field, &levels);
        standard_error = tally.noise.take();
        if tally.share(Fate::Elsewhere) > NOTHING {
            tally.divide_elsewhere(lost_light_shares(system, &hop, &light));
        }
        Cancelled::check(step(1.0))?;
        light.directions = plan.light(&hop, light.directions);
        reports.push(HopReport {
            screens: [hop.from.name.clone(), hop.to.name.clone()],
            method: HopMethod::WholeField(plan),
            tally,
            power: system.power_along(&hop, [before, behind, levels.power()]),
            samples: Some(field.grid.shape()),
            seconds: clock.elapsed().as_secs_f64(),
        });
        (light.sum, light.reach) = (Some(levels), reach);
    }
    note_landed(system, &mut reports);
    note_rims(&rimmed, &mut reports);
    let field = on_sensor(sensor, light.sum);
    check_sound(original, &field, standard_error.as_ref())?;
    let powers = reports.iter_mut().map(|report| &mut report.power);
    with_cosines(system, &field, powers);
    Ok(Outcome {
        field,
        standard_error,
        hops: reports,
        rimmed,
    })
}

/// The error of a free hop at some points, on other samples than those of the run where there is memory for them.
fn spot_check(
    run: &HopRun,
    light: &Arriving,
    system: &System,
    field: &Field,
    levels: &HeightStack,
) -> Option<f64> {
    let Plan::Free(..) = run.plan else {
        return None;
    };
    let other = light.on_other_samples(system, run.hop.from, leaving(run.plan), run.settings);
    run.spot_check(other.as_ref().unwrap_or(field), levels)
}

/// Notes which share of the light behind its first screen each hop brings to the sensor.
fn note_landed(system: &System, reports: &mut [HopReport]) {
    let landed = reports.last().and_then(|last| last.power[2]).unwrap_or(0.0);
    for (number, report) in reports.iter_mut().enumerate() {
        let share = report.power[1].map(|behind| landed / behind);
        report.tally.landed = share.filter(|_| Downstream::reaches_end(system, number));
    }
}

/// Notes the errors of the rims of each hop, beside the light that arrived.
fn note_rims(rimmed: &Rimmed, reports: &mut [HopReport]) {
    let powers: Vec<_> = reports.iter().map(|report| report.power).collect();
    let share = |from: usize, to: usize| {
        let behind = powers.get(from)?[1].filter(|behind| *behind > 0.0)?;
        let arrived = powers.get(to.checked_sub(1)?)?[2];
        Some(arrived.filter(|arrived| *arrived > 0.0)? / behind)
    };
    for (number, report) in reports.iter_mut().enumerate() {
        let edge = rimmed.edge_error(number, share);
        report.tally.edge = edge.hypot(cut_by_ray(&rimmed.rims, number));
    }
}

/// The field at the pixel centres of a sensor; dark when no light was summed there.
fn on_sensor(sensor: &Sensor, sum: Option<HeightStack>) -> Field {
    let grid = Grid::of(sensor);
    let dark = || Array2::zeros(grid.shape());
    let values = sum.map_or_else(dark, HeightStack::into_middle);
    Field { grid, values }
}

/// Energy by fate, in proportion, of all light behind the first screen.
fn lost_light_shares(system: &System, hop: &Hop, light: &Arriving) -> [f64; FATES.len()] {
    let behind = |grid: Grid| {
        let mut field = light.on(system, hop.from, grid);
        apply_screen(hop.from, &mut field);
        field
    };
    lost_light(hop, &behind)
}
