//! A whole run: from the source through every hop to the sensor.

use std::ops::ControlFlow;
use std::time::Instant;

use ndarray::Array2;

use crate::engine::chain::hop_run::{HopError, HopRun};
use crate::engine::error::lost_light::lost_light;
use crate::engine::error::tally::{FATES, Tally};
use crate::engine::plan::direction_spread::LightDirections;
use crate::engine::plan::downstream::Downstream;
use crate::engine::plan::hop_plan::{Plan, plan};
use crate::engine::plan::plan_error::PlanError;
use crate::engine::plan::settings::Settings;
use crate::engine::progress::{Cancelled, Reply};
use crate::engine::rims::pixel_light::PixelValues;
use crate::engine::rims::rim_screens::{Rim, Rimmed, edge_error, with_rims};
use crate::math::nufft::NufftError;
use crate::math::vec3::Vec3;
use crate::optics::screen::{Act, Screen, Sensor};
use crate::optics::system::{Hop, System};
use crate::wave::grid::field::{Axis, Field, Grid};
use crate::wave::grid::height_stack::HeightStack;
use crate::wave::grid::raster::Raster;
use crate::wave::grid::sampling::{Reach, SamplingError, act, plan_grid, plan_raster};

/// Why a run is impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulateError {
    /// A hop has no plan.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A screen cannot be sampled.
    #[error(transparent)]
    Sampling(#[from] SamplingError),
    /// The last screen is no sensor.
    #[error("the last screen is '{0}', expected a sensor")]
    NoSensor(String),
    /// Nothing is left of the light.
    #[error("no light leaves screen '{0}'")]
    NoLight(String),
    /// A field came out that is no number.
    #[error("the field on screen '{0}' is not finite")]
    NotFinite(String),
    /// The sum of plane waves cannot be planned.
    #[error(transparent)]
    Sum(#[from] NufftError),
    /// The progress callback cancelled the run.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<HopError> for SimulateError {
    fn from(error: HopError) -> Self {
        match error {
            HopError::Sum(error) => Self::Sum(error),
            HopError::Cancelled(error) => Self::Cancelled(error),
        }
    }
}

/// What one hop did.
#[derive(Clone, Debug)]
pub struct HopReport {
    /// Names of its screens.
    pub screens: [String; 2],
    /// Its plan.
    pub plan: Plan,
    /// Rays and energy by fate.
    pub tally: Tally,
    /// ∫|U|² just before the first screen acted (over its samples), just behind it, and on the second
    /// screen, in mm² for unit amplitude.
    pub power: [f64; 3],
    /// Samples of the field on the first screen, [ny, nx].
    pub samples: [usize; 2],
    /// Seconds it took.
    pub seconds: f64,
}

/// The result of a run at one wavelength.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Complex field at the sensor's pixel centres.
    pub field: Field,
    /// Standard error of the field at each of them, indexed [y, x], where the last hop drew rays at random:
    /// what that hop adds. Its real and imaginary parts each have this over √2.
    pub standard_error: Option<Array2<f64>>,
    /// What each hop did.
    pub hops: Vec<HopReport>,
    /// The system as it was run, with a screen at every rim that matters, and all rims.
    pub rimmed: Rimmed,
}

/// How far a run has come.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
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
    fn of(system: &'a System, hop: usize, plan: &Plan, done: f64) -> Self {
        Self {
            hop,
            hops: system.trains.len(),
            to: &system.screens[hop + 1].name,
            done,
            rays: plan.rays(),
        }
    }
}

/// Directions of the incident light on the first screen: cosines at its centre and the largest |p|.
pub(crate) fn incidence(system: &System) -> ([f64; 2], [f64; 2]) {
    let screen = &system.screens[0];
    let cosines = |point: Vec3| {
        let d = screen.frame.turn_in(system.source.direction(point));
        [d.x * screen.index, d.y * screen.index]
    };
    let centre = cosines(screen.frame.origin);
    let mut largest = centre.map(f64::abs);
    if let Some([x0, x1, y0, y1]) = screen.bounds() {
        for (x, y) in [(x0, y0), (x0, y1), (x1, y0), (x1, y1)] {
            let p = cosines(screen.frame.to_global(Vec3::new(x, y, 0.0)));
            largest = [largest[0].max(p[0].abs()), largest[1].max(p[1].abs())];
        }
    }
    (centre, largest)
}

/// The error to expect from the rims that cut light ray by ray in a hop.
fn cut_by_ray(rims: &[Rim], hop: usize) -> f64 {
    let here = rims.iter().filter(|rim| rim.hop == hop);
    here.map(Rim::error).fold(0.0, f64::hypot)
}

/// The incident field of the source on a grid of the first screen.
pub(crate) fn illuminate(system: &System, grid: Grid) -> Field {
    let screen = &system.screens[0];
    let k = system.wavenumber() * screen.index;
    let mut field = Field::zeros(grid.clone());
    ndarray::Zip::indexed(field.values.rows_mut()).par_for_each(|j, mut row| {
        let y = grid.y.node(j);
        for (i, value) in row.iter_mut().enumerate() {
            let x = grid.x.node(i);
            let z = screen.height([x, y]).map_or(0.0, |here| here.z);
            let point = screen.frame.to_global(Vec3::new(x, y, z));
            *value = system.source.field(point, k);
        }
    });
    field
}

/// The uniform grid of a sensor.
pub fn sensor_grid(sensor: &Sensor) -> Grid {
    let axis = |a: usize| Axis::uniform(sensor.pixels[a], sensor.pitch[a], 0.0);
    Grid {
        x: axis(0),
        y: axis(1),
    }
}

/// Direction on the next screen of the ray through the middle of this one; straight on when it is lost.
pub(crate) fn chief(hop: &Hop, anchor: [f64; 2]) -> [f64; 2] {
    match hop.trace([0.0, 0.0], anchor, &mut ()) {
        Ok(landing) => landing.cosines,
        Err(_) => [0.0, 0.0],
    }
}

/// What the light is when it arrives at a screen.
pub struct Arriving {
    /// The field as summed before the screen acts; nothing on the first screen, which the source lights.
    pub sum: Option<HeightStack>,
    /// Its directions, roughly.
    pub directions: LightDirections,
    /// Its largest |p| along x and y.
    pub reach: [f64; 2],
}

impl Arriving {
    /// The source's light on the first screen.
    pub fn from_source(system: &System) -> Self {
        let (anchor, reach) = incidence(system);
        Self {
            sum: None,
            directions: LightDirections {
                anchor,
                usual: reach,
            },
            reach,
        }
    }

    /// The light on any grid of the screen, before the screen acts.
    pub(crate) fn on(&self, system: &System, screen: &Screen, grid: Grid) -> Field {
        match &self.sum {
            None => illuminate(system, grid),
            Some(sheets) => sheets.on(screen, &grid),
        }
    }

    /// The field just before and just behind a screen, on nodes that resolve what arrives and what matters
    /// behind it.
    ///
    /// # Errors
    /// When the screen cannot be sampled, or lets nothing through.
    pub fn pass(
        &self,
        system: &System,
        screen: &Screen,
        leaving: [f64; 2],
        settings: &Settings,
    ) -> Result<(Field, Field), SimulateError> {
        let reach = Reach {
            arriving: self.reach,
            leaving,
        };
        let grid = plan_grid(screen, reach, system.wavelength, settings.samples_allowed())?;
        let arrived = self.on(system, screen, grid);
        let mut behind = arrived.clone();
        act(screen, &mut behind);
        if behind.power() == 0.0 {
            return Err(SimulateError::NoLight(screen.name.clone()));
        }
        Ok((arrived, behind))
    }
}

/// The raster on which light is summed on a screen: a sensor's own pixels, or one that resolves `reach`.
///
/// # Errors
/// When the screen cannot be sampled.
pub fn receiving_raster(
    hop: &Hop,
    reach: [f64; 2],
    settings: &Settings,
) -> Result<Raster, SimulateError> {
    let allowed = settings.samples_allowed();
    Ok(match &hop.to.act {
        Act::Sensor(sensor) => Raster::of(sensor),
        _ => plan_raster(hop.to, reach, hop.wavelength, allowed)?,
    })
}

/// Carries the light of a system to its sensor. `progress` is called after each chunk of work.
///
/// # Errors
/// When a screen has no edge or needs too many samples, no ray gets through a hop, no light is left, or `progress`
/// cancels the run.
pub fn simulate<R: Reply>(
    system: &System,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> R + Sync),
) -> Result<Outcome, SimulateError> {
    run_hops(system, settings, &|here| progress(here).flow())
}

/// The hops of [`simulate`], one after the other.
fn run_hops(
    system: &System,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Outcome, SimulateError> {
    let sensor = sensor_of(system)?;
    let original = system;
    let rimmed = with_rims(original, settings, PixelValues::Fixed);
    let system = &rimmed.system;
    let settings = &settings.shared(system.trains.len());
    let mut light = Arriving::from_source(system);
    let (mut reports, mut standard_error) = (Vec::<HopReport>::new(), None);
    for (number, hop) in system.hops().enumerate() {
        let clock = Instant::now();
        let downstream = &Downstream::of(system, number);
        let plan = plan(&hop, light.directions, downstream, settings)?;
        let (arrived, field) = light.pass(system, hop.from, leaving(&plan), settings)?;
        let before = arrived.power();
        drop(arrived);
        let reach = arrival_reach(&hop, &plan);
        let raster = receiving_raster(&hop, reach, settings)?;
        let step = |done: f64| progress(Progress::of(system, number, &plan, done));
        Cancelled::check(step(0.0))?;
        let run = HopRun::new(number, hop, &plan, settings, downstream);
        let (sheets, mut tally) = run.carry(&field, raster, reach, &step)?;
        if !sheets.power().is_finite() {
            return Err(SimulateError::NotFinite(hop.to.name.clone()));
        }
        standard_error = tally.noise.take();
        tally.divide_elsewhere(surveyed(system, &hop, &light));
        let ended = (1.0 - field.power() / before).max(rimmed.cut_at(hop.from));
        tally.edge = edge_error(original, hop.from, ended).hypot(cut_by_ray(&rimmed.rims, number));
        Cancelled::check(step(1.0))?;
        let directions = plan.light(&hop, light.directions);
        reports.push(HopReport {
            screens: [hop.from.name.clone(), hop.to.name.clone()],
            plan,
            tally,
            power: [before, field.power(), sheets.power()],
            samples: field.grid.shape(),
            seconds: clock.elapsed().as_secs_f64(),
        });
        light = Arriving {
            sum: Some(sheets),
            directions,
            reach,
        };
    }
    note_landed(system, &mut reports);
    let field = on_sensor(sensor, light.sum);
    check_sound(original, &field, standard_error.as_ref())?;
    Ok(Outcome {
        field,
        standard_error,
        hops: reports,
        rimmed,
    })
}

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

/// Notes which share of the light behind its first screen each hop brings to the sensor.
fn note_landed(system: &System, reports: &mut [HopReport]) {
    let landed = reports.last().map_or(0.0, |last| last.power[2]);
    for (number, report) in reports.iter_mut().enumerate() {
        let share = landed / report.power[1];
        report.tally.landed = Downstream::reaches_end(system, number).then_some(share);
    }
}

/// The field at the pixel centres of a sensor; dark when no light was summed there.
fn on_sensor(sensor: &Sensor, sum: Option<HeightStack>) -> Field {
    let grid = sensor_grid(sensor);
    let dark = || Array2::zeros(grid.shape());
    let values = sum.map_or_else(dark, HeightStack::into_middle);
    Field { grid, values }
}

/// The sensor at the end of a system.
///
/// # Errors
/// When the last screen is none.
pub(crate) fn sensor_of(system: &System) -> Result<&Sensor, SimulateError> {
    match system.screens.last() {
        Some(Screen {
            act: Act::Sensor(sensor),
            ..
        }) => Ok(sensor),
        last => Err(SimulateError::NoSensor(
            last.map(|screen| screen.name.clone()).unwrap_or_default(),
        )),
    }
}

/// Largest |p| that a plan wants behind the screen.
pub fn leaving(plan: &Plan) -> [f64; 2] {
    let bands = plan.bands();
    [0, 1].map(|a| {
        let band = &bands[a];
        let last = band.count.max(1) - 1;
        band.at(0).abs().max(band.at(last).abs())
    })
}

/// Largest |p| of the light that a plan brings to the next screen.
pub(crate) fn arrival_reach(hop: &Hop, plan: &Plan) -> [f64; 2] {
    match plan {
        Plan::Free(..) => leaving(plan).map(|p| p.min(hop.to.index)),
        Plan::Beamlets(beamlets) => beamlets.arriving,
        Plan::Planes(planes) => planes.arriving,
        Plan::Paper(paper) => paper.arriving,
    }
}

/// Energy by fate, in proportion, of all light behind the first screen.
fn surveyed(system: &System, hop: &Hop, light: &Arriving) -> [f64; FATES.len()] {
    let behind = |grid: Grid| {
        let mut field = light.on(system, hop.from, grid);
        act(hop.from, &mut field);
        field
    };
    lost_light(hop, &behind)
}
