//! What a run will take: methods, samples and memory of every hop, without running it; and the choice between whole
//! fields and local bands.

use crate::engine::chain::arriving_light::{arrival_reach, incidence, leaving, receiving_raster};
use crate::engine::chain::local_band_run::local_band_settings;
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::error::error_budget::ErrorBudget;
use crate::engine::local_bands::carry::planned;
use crate::engine::local_bands::hop_step::BEAMLETS_AT_ONCE;
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::local_bands::settings::LocalBandSettings;
use crate::engine::local_bands::workload::{LocalBandWorkload, workload};
use crate::engine::plan::cost_model::{as_conics, whole_field};
use crate::engine::plan::direction_spread::LightDirections;
use crate::engine::plan::downstream::Downstream;
use crate::engine::plan::hop_method::HopMethod;
use crate::engine::plan::hop_plan::{Plan, plan as plan_hop};
use crate::engine::plan::settings::{Method, Settings};
use crate::engine::plan::work::Work;
use crate::engine::progress::{Cancelled, Reply};
use crate::engine::rims::pixel_light::PixelValues;
use crate::engine::rims::rim_screens::{Rimmed, cut_by_ray, with_rims};
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::{Hop, System};
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::free::propagate::FreeHop;
use crate::wave::grid::sampling::{Reach, plan_grid};

/// One hop as it would be run.
#[derive(Clone, Debug)]
pub struct Forecast {
    /// Its method, with the plan.
    pub method: HopMethod,
    /// The samples of whole fields; nothing for local bands, which have none.
    pub grids: Option<Grids>,
    /// What it takes.
    pub work: Work,
    /// Beamlets of local bands in memory at a time, about: all that it sends to the next screen, or some of those to the sensor.
    pub beamlets: usize,
    /// The error to expect from all causes but rims; nothing for methods whose errors are not estimated.
    pub error: Option<f64>,
}

/// Samples of the whole fields of a hop.
#[derive(Clone, Copy, Debug)]
pub struct Grids {
    /// Samples of the field on its first screen, [ny, nx].
    pub samples: [usize; 2],
    /// Points on its second screen where the field is summed, [ny, nx].
    pub sums: [usize; 2],
    /// Transforms from the first screen to plane waves: of a curved screen one or three for each level.
    pub transforms: usize,
}

impl Forecast {
    /// Bytes of the largest arrays: the fields on both screens, as they are summed and as they are kept,
    /// and the plane waves of a free hop, before and after the transfer. Of local bands those of the beamlets.
    pub fn bytes(&self) -> usize {
        let count = |[ny, nx]: [usize; 2]| nx.saturating_mul(ny);
        let waves = match &self.method {
            HopMethod::WholeField(Plan::Free(_, free)) => {
                count([0, 1].map(|a| free.bands[a].count))
            }
            HopMethod::WholeField(_) => 0,
            HopMethod::LocalBands(_) => return self.beamlets.saturating_mul(size_of::<Arrival>()),
        };
        let fields = self
            .grids
            .map_or(0, |grids| count(grids.samples) + count(grids.sums));
        (fields + waves).saturating_mul(2 * size_of::<num_complex::Complex64>())
    }
}

/// Whole fields that take less than these seconds of one core are not compared with local bands. Where rims of small
/// lenses diffract, local bands take longer than their forecast and are less exact: behind a lens of 100 λ with pixels
/// of 2 λ, 22 s and an error of 1.6e-3 instead of 11 s and 5.0e-4.
const QUICK: f64 = 20.0;

/// Local bands are taken where they take this many times less. The modulator of real size is forecast at 1.5 times less, and
/// takes three times less.
const MUCH_LESS: f64 = 1.4;

/// [`QUICK`] for light that leaves one screen without pixels and meets no other on its way to the
/// sensor, as behind the stop in front of a lens: no rim diffracts there.
const QUICK_FIRST: f64 = 5.0;

/// A screen of more wavelengths than this is wide.
const WIDE: f64 = 1000.0;

/// Surfaces that take a ray as long as so many conics are many.
const MANY: f64 = 12.0;

/// Whether a hop without rays, given with its number, has none either where the system varies.
pub(crate) type StaysFree<'a> = dyn Fn(usize, &Hop, &FreeHop) -> bool + 'a;

/// The method that propagates the light of a system.
pub(crate) enum Chosen {
    /// By whole fields: for each hop its plan and the size of its grids.
    WholeFields(Vec<(Plan, Grids)>),
    /// By local bands, with these settings.
    LocalBands(LocalBandSettings),
}

/// Chooses for a system in which rims that matter are screens: local bands where they are requested, where an
/// element has two media, where they take much less time, and where a whole field does not fit into memory; `progress`
/// is called before each hop is planned.
///
/// # Errors
/// As [`simulate`](crate::engine::chain::simulate::simulate), except that light which does not arrive is no error.
pub(crate) fn choose<R: Reply>(
    system: &System,
    settings: &Settings,
    progress: impl FnMut(usize, &Hop) -> R,
) -> Result<Chosen, SimulateError> {
    choose_with(system, settings, &|_, _, _| true, progress)
}

/// [`choose`], but a hop without rays is propagated by beamlets where `stays` is false: where its screens may tilt.
///
/// # Errors
/// As [`choose`].
pub(crate) fn choose_with<R: Reply>(
    system: &System,
    settings: &Settings,
    stays: &StaysFree,
    progress: impl FnMut(usize, &Hop) -> R,
) -> Result<Chosen, SimulateError> {
    let crosses = system.screens.iter().any(|screen| screen.behind.is_some());
    let only_bands = crosses && settings.method == Method::Auto;
    if settings.method == Method::LocalBands || only_bands {
        return Ok(Chosen::LocalBands(local_band_settings(system, settings)?));
    }
    if let Some(bands) = clearly_quicker(system, settings) {
        return Ok(Chosen::LocalBands(bands));
    }
    let whole = match whole_field_forecast(system, settings, stays, progress) {
        Ok(hops) => return Ok(quicker(system, settings, hops)),
        Err(whole) => whole,
    };
    if settings.method != Method::Auto || !whole.is_too_large() {
        return Err(whole);
    }
    match local_band_settings(system, settings) {
        Ok(bands) => Ok(Chosen::LocalBands(bands)),
        Err(bands) => Err(SimulateError::TooLarge {
            whole: Box::new(whole),
            bands,
        }),
    }
}

/// Rims that are too large for whole fields diffract where local bands take no more than these seconds of one core. Otherwise they cut
/// ray by ray, the expected error counts that, and a stop in the place of one diffracts. With a grating at
/// the stop of a Cooke triplet and light at 20°, the rims before the stop took more than ten minutes; the expected error is 1.5e-2 with
/// them and 4.2e-2 without.
const RIMS: f64 = 120.0;

/// The rims and the method of a run: where local bands carry the light, rims that cut a noticeable part of it are screens at any
/// size.
pub(crate) fn with_wide_rims(
    given: &System,
    settings: &Settings,
    (rimmed, chosen): (Rimmed, Chosen),
) -> (Rimmed, Chosen) {
    let wide = match &chosen {
        Chosen::LocalBands(_) => rimmed.of_any_size(given),
        Chosen::WholeFields(_) => None,
    };
    let planned = wide.and_then(|wide| {
        let bands = local_band_settings(&wide.system, settings).ok()?;
        let hops = workload(&wide.system, &bands).ok()?;
        let seconds: f64 = hops.iter().map(|hop| hop.work.seconds).sum();
        (seconds <= RIMS).then_some((wide, Chosen::LocalBands(bands)))
    });
    planned.unwrap_or((rimmed, chosen))
}

/// Local bands where they promise the target error in little time, behind one wide screen and through a lens of many
/// aspheres: the plan of whole fields alone takes as long there. Through ten aspheric surfaces it takes a second, the local
/// bands themselves 0.8 s. Through a few spheres it takes 0.05 s.
fn clearly_quicker(system: &System, settings: &Settings) -> Option<LocalBandSettings> {
    let [x0, x1, y0, y1] = system.screens.first()?.bounds()?;
    let wide = (x1 - x0).min(y1 - y0) > WIDE * system.wavelength;
    let [train] = &system.trains[..] else {
        return None;
    };
    if settings.method != Method::Auto || !wide || as_conics(train) < MANY {
        return None;
    }
    let bands = local_band_settings(system, settings).ok()?;
    let [hop] = workload(system, &bands).ok()?[..] else {
        return None;
    };
    let quick = hop.work.seconds < QUICK_FIRST;
    (quick && hop.aberration <= settings.target_error).then_some(bands)
}

/// Whole fields, or local bands where these promise the target error in much less time.
fn quicker(system: &System, settings: &Settings, hops: Vec<(Plan, Grids)>) -> Chosen {
    let seconds: f64 = hops
        .iter()
        .map(|(plan, grids)| whole_field_work(plan, grids).seconds)
        .sum();
    let quick = match is_first_and_smooth(system) {
        true => QUICK_FIRST,
        false => QUICK,
    };
    if settings.method != Method::Auto || seconds < quick {
        return Chosen::WholeFields(hops);
    }
    let error = settings.shared(system.trains.len()).target_error;
    let bands = local_band_settings(system, settings);
    let found = bands.and_then(|bands| Ok((workload(system, &bands)?, bands)));
    match found {
        Ok((work, bands))
            if work.iter().all(|hop| hop.aberration <= error)
                && MUCH_LESS * work.iter().map(|hop| hop.work.seconds).sum::<f64>() < seconds =>
        {
            Chosen::LocalBands(bands)
        }
        _ => Chosen::WholeFields(hops),
    }
}

/// Whether the light of the source meets one screen alone, without pixels, and goes from there to the sensor.
fn is_first_and_smooth(system: &System) -> bool {
    let pixels =
        |screen: &Screen| matches!(&screen.kind, ScreenKind::Doe(doe) if doe.pixels().is_some());
    system.trains.len() == 1 && !system.screens.iter().any(pixels)
}

/// What a hop from a whole field takes.
pub(crate) fn whole_field_work(plan: &Plan, grids: &Grids) -> Work {
    let count = |[ny, nx]: [usize; 2]| nx as f64 * ny as f64;
    let rays = match plan {
        Plan::Beamlets(plan) => plan.work,
        Plan::Free(..) | Plan::Planes(_) | Plan::Paper(_) => Work {
            rays: plan.rays(),
            ..Work::default()
        },
    };
    let waves = match plan {
        Plan::Free(_, free) => free.bands.iter().map(|band| band.count as f64).product(),
        Plan::Beamlets(_) | Plan::Planes(_) | Plan::Paper(_) => 0.0,
    };
    let further = grids.transforms.saturating_sub(1) as f64;
    let seconds = (count(grids.samples) + count(grids.sums)) * whole_field::SAMPLE
        + further * (count(grids.samples) + waves) * whole_field::TRANSFORMED;
    rays + Work {
        seconds,
        ..Work::default()
    }
}

/// Every hop of a system as it would be run.
///
/// # Errors
/// As [`simulate`](crate::engine::chain::simulate::simulate), except that light which does not arrive is no error.
pub fn forecast(system: &System, settings: &Settings) -> Result<Vec<Forecast>, SimulateError> {
    forecast_with_progress(system, settings, |_, _| ())
}

/// The same; `progress` is called with the number of every hop and the hop before it is planned: some take seconds.
///
/// # Errors
/// As [`forecast`]; when `progress` cancels the work.
pub fn forecast_with_progress<R: Reply>(
    system: &System,
    settings: &Settings,
    progress: impl FnMut(usize, &Hop) -> R,
) -> Result<Vec<Forecast>, SimulateError> {
    hops_of(system, choose(system, &settings.for_planning(), progress)?)
}

/// A run as it would be.
#[derive(Clone, Debug)]
pub struct RunForecast {
    /// The system with its rims, as it would be run.
    pub rimmed: Rimmed,
    /// Its hops.
    pub hops: Vec<Forecast>,
}

/// A whole run of a system as it is given, rims included; `progress` is called with the number of every hop, the count of hops
/// and the hop before it is planned.
///
/// # Errors
/// As [`forecast_with_progress`].
pub fn forecast_run<R: Reply>(
    given: &System,
    settings: &Settings,
    mut progress: impl FnMut([usize; 2], &Hop) -> R,
) -> Result<RunForecast, SimulateError> {
    let rimmed = with_rims(given, settings, PixelValues::Fixed);
    let settings = &settings.for_planning();
    let count = rimmed.system.trains.len();
    let planning = |number: usize, hop: &Hop| progress([number, count], hop);
    let chosen = choose(&rimmed.system, settings, planning)?;
    let (rimmed, chosen) = with_wide_rims(given, settings, (rimmed, chosen));
    let hops = hops_of(&rimmed.system, chosen)?;
    Ok(RunForecast { rimmed, hops })
}

/// Every hop of a system by the method that was chosen for it.
fn hops_of(system: &System, chosen: Chosen) -> Result<Vec<Forecast>, SimulateError> {
    match chosen {
        Chosen::WholeFields(hops) => {
            let hops = hops.into_iter().map(|(plan, grids)| Forecast {
                work: whole_field_work(&plan, &grids),
                error: ErrorBudget::expected_of(&plan),
                method: HopMethod::WholeField(plan),
                grids: Some(grids),
                beamlets: 0,
            });
            Ok(hops.collect())
        }
        Chosen::LocalBands(bands) => Ok(local_band_forecast(system, &bands)?),
    }
}

/// Every hop of a system as local bands would carry it.
///
/// # Errors
/// As [`local_band_settings`].
fn local_band_forecast(
    system: &System,
    settings: &LocalBandSettings,
) -> Result<Vec<Forecast>, LocalBandError> {
    let plans = planned(system, settings)?;
    let work = workload(system, settings)?;
    let forecast = |((plan, hop), work): ((_, Hop), LocalBandWorkload)| {
        let sent = work.work.rays as usize;
        Forecast {
            method: HopMethod::LocalBands(plan),
            grids: None,
            work: work.work,
            beamlets: match hop.to.kind {
                ScreenKind::Sensor(_) => sent.min(BEAMLETS_AT_ONCE as usize),
                _ => sent,
            },
            error: Some(work.error),
        }
    };
    let hops = plans.into_iter().zip(system.hops());
    Ok(hops.zip(work).map(forecast).collect())
}

/// The error to expect of a whole run, in which rims that matter are screens: of all hops with their rims. Nothing where the
/// errors of a hop are not estimated.
pub fn expected_error(rimmed: &Rimmed, hops: &[Forecast]) -> Option<f64> {
    let squares = hops.iter().enumerate().map(|(number, hop)| {
        let edge = rimmed.edge_error(number, |_, _| None);
        let rims = edge.hypot(cut_by_ray(&rimmed.rims, number));
        Some(hop.error?.hypot(rims).powi(2))
    });
    squares.sum::<Option<f64>>().map(f64::sqrt)
}

/// Every hop of a system as it would be run from whole fields.
///
/// # Errors
/// As [`choose`].
pub(crate) fn whole_field_forecast<R: Reply>(
    system: &System,
    settings: &Settings,
    stays: &StaysFree,
    mut progress: impl FnMut(usize, &Hop) -> R,
) -> Result<Vec<(Plan, Grids)>, SimulateError> {
    let (chief, mut arriving) = incidence(system);
    let mut light = LightDirections {
        chief,
        usual: arriving,
    };
    let mut list = Vec::new();
    let settings = &settings.shared(system.trains.len());
    for (number, hop) in system.hops().enumerate() {
        Cancelled::check(progress(number, &hop).flow())?;
        let downstream = &Downstream::of(system, number);
        let mut plan = plan_hop(&hop, light, downstream, settings)?;
        if matches!(&plan, Plan::Free(free, _) if !stays(number, &hop, free)) {
            let by_beamlets = Settings {
                method: Method::Beamlet,
                ..settings.clone()
            };
            plan = plan_hop(&hop, light, downstream, &by_beamlets)?;
        }
        let reach = Reach {
            arriving,
            leaving: leaving(&plan),
        };
        let grid = plan_grid(
            hop.from,
            reach,
            system.wavelength,
            settings.samples_allowed(),
        )?;
        arriving = arrival_reach(&hop, &plan);
        let [nx, ny] = receiving_raster(&hop, arriving, settings)?.size;
        light = plan.light(&hop, light);
        let grids = Grids {
            samples: grid.shape(),
            sums: [ny, nx],
            transforms: match &plan {
                Plan::Free(free, plan) => free.transforms(hop.from, plan),
                Plan::Beamlets(_) | Plan::Planes(_) | Plan::Paper(_) => 0,
            },
        };
        list.push((plan, grids));
    }
    Ok(list)
}
