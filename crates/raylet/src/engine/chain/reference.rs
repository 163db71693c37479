//! A whole run without rays, or with one geometrical ray per pixel: references for every other method.

use std::ops::ControlFlow;
use std::time::Instant;

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::chain::arriving_light::{Arriving, chief, receiving_raster, sensor_of};
use crate::engine::chain::outcome::{Progress, check_sound, with_cosines};
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::free::free_method::{Approach, FreeMethod, Route, free_method};
use crate::engine::geometrical::eikonal::{self, EikonalError, Geometrical};
use crate::engine::plan::direction_spread::LightDirections;
use crate::engine::plan::settings::Settings;
use crate::engine::progress::{Cancelled, Reply};
use crate::math::vec3::Vec3;
use crate::optics::pixels::pixel_axes::system_on_pixel_axes;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::{Hop, System};
use crate::wave::free::collins::{Collins, CollinsError};
use crate::wave::free::rayleigh::{Emitters, PAIRS_PER_SECOND};
use crate::wave::grid::field::{Field, Grid};
use crate::wave::grid::height_stack::HeightStack;
use crate::wave::grid::heights::Heights;
use crate::wave::grid::raster::Raster;
use crate::wave::grid::sampling::power_behind;

/// Period of a reference's free hop over the sum of the half widths of screen and target.
pub const PADDING: f64 = 8.0;

/// Directions that a reference's sampling resolves, over those that reach the target: of pixels, whose
/// Gauss nodes converge fast, and of open areas, whose hard edges alias slowly.
const PIXEL_FINENESS: f64 = 1.5;
const EDGE_FINENESS: f64 = 8.0;

/// The choices of a user for a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceOptions {
    /// The method.
    pub approach: Approach,
    /// Longest direct sum in seconds that is begun.
    pub patience: f64,
}

impl Default for ReferenceOptions {
    fn default() -> Self {
        Self {
            approach: Approach::Auto,
            patience: 3.0 * 3600.0,
        }
    }
}

/// Why a reference is impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReferenceError {
    /// The scene cannot be sampled or lit.
    #[error(transparent)]
    Run(#[from] SimulateError),
    /// Geometrical optics does not apply.
    #[error(transparent)]
    Refraction(#[from] EikonalError),
    /// Collins' integral does not apply.
    #[error(transparent)]
    Collins(#[from] CollinsError),
    /// The chosen method does not apply to a hop.
    #[error("{approach} does not apply from '{from}' to '{to}': {why}")]
    NotApplicable {
        /// The method.
        approach: &'static str,
        /// First screen of the hop.
        from: String,
        /// Second screen of the hop.
        to: String,
        /// What stands against it.
        why: String,
    },
    /// No method applies to a hop.
    #[error("no method without rays carries light from '{from}' to '{to}': {why}")]
    NoMethod {
        /// First screen of the hop.
        from: String,
        /// Second screen of the hop.
        to: String,
        /// What stands against each of them.
        why: String,
    },
    /// A direct sum would take too long.
    #[error(
        "the direct sum from '{from}' to '{to}' has {pairs:.2e} pairs, about {} on this machine, more than \
         the {} allowed; use fewer sensor pixels or a smaller element", span(*hours), span(*allowed)
    )]
    TooLong {
        /// First screen of the hop.
        from: String,
        /// Second screen of the hop.
        to: String,
        /// Nodes × points.
        pairs: f64,
        /// Hours it would take.
        hours: f64,
        /// Hours allowed.
        allowed: f64,
    },
}

impl From<Cancelled> for ReferenceError {
    fn from(error: Cancelled) -> Self {
        Self::Run(error.into())
    }
}

/// A span of hours in the unit that suits it.
fn span(hours: f64) -> String {
    let (value, unit) = match hours * 60.0 {
        minutes if minutes >= 60.0 => (hours, "hours"),
        minutes if minutes >= 1.0 => (minutes, "minutes"),
        minutes => (60.0 * minutes, "seconds"),
    };
    format!("{value:.1} {unit}")
}

/// The report on one step of a reference.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceStep {
    /// Names of its first and last screen.
    pub screens: [String; 2],
    /// Method of the step.
    pub approach: Approach,
    /// Why this method: that it was chosen, or what stands against those before it.
    pub why: String,
    /// Effects that the method leaves out, in words; empty if there are none.
    pub neglects: &'static str,
    /// Samples of the field on the first screen [ny, nx]; zero where no field is needed.
    pub samples: [usize; 2],
    /// As in a [`HopReport`](crate::engine::chain::outcome::HopReport); nothing for what a method does not know.
    pub power: [Option<f64>; 3],
    /// Node–point pairs of a direct sum, plane waves of a spectrum, or rays.
    pub work: f64,
    /// Sensor pixels left dark because they are too close to a focus or caustic.
    pub unresolved: u64,
    /// Seconds it took.
    pub seconds: f64,
}

/// The result of a reference at one wavelength.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Complex field at the sensor's pixel centres.
    pub field: Field,
    /// The steps of the reference, from the source to the sensor.
    pub steps: Vec<ReferenceStep>,
}

/// Carries the light of a system to its sensor without beamlets. `progress` is called after each chunk of work.
///
/// # Errors
/// No method applies; the chosen method does not apply; the sum would take too long; the field is not finite;
/// `progress` cancels the run.
pub fn reference<R: Reply>(
    system: &System,
    settings: &Settings,
    choice: ReferenceOptions,
    progress: &(dyn Fn(Progress) -> R + Sync),
) -> Result<Reference, ReferenceError> {
    sensor_of(system)?;
    let system = &system_on_pixel_axes(system);
    let found = by_routes(system, settings, choice, &|here| progress(here).flow())?;
    check_sound(system, &found.field, None)?;
    Ok(found)
}

/// Called with the progress of a reference, which it may cancel.
type Listener<'a> = dyn Fn(Progress) -> ControlFlow<()> + 'a;

/// Called with the share of a hop that is done; it may cancel the hop.
type HopListener<'a> = dyn Fn(f64) -> Result<(), Cancelled> + 'a;

/// [`reference`] without the check that the field is finite.
fn by_routes(
    system: &System,
    settings: &Settings,
    choice: ReferenceOptions,
    progress: &Listener,
) -> Result<Reference, ReferenceError> {
    let settings = &padded(settings);
    match ways(system, settings, choice.approach)? {
        Ways::Hops(routes) => {
            let run = HopByHop {
                system,
                settings,
                choice,
            };
            run.follow(&routes, progress)
        }
        Ways::Refraction(why) => refraction(system, why, progress),
    }
}

/// The settings with a reference's period of free hops.
pub(crate) fn padded(settings: &Settings) -> Settings {
    Settings {
        padding: PADDING,
        ..settings.clone()
    }
}

/// How a whole system is carried.
pub(crate) enum Ways {
    /// Hop by hop.
    Hops(Vec<Route>),
    /// By rays along smooth phases, and why.
    Refraction(String),
}

/// How a system is carried; known before the first hop is run. Where a hop has no route, rays along smooth phases may
/// still carry the whole system.
pub(crate) fn ways(
    system: &System,
    settings: &Settings,
    approach: Approach,
) -> Result<Ways, ReferenceError> {
    if approach == Approach::Refraction {
        return Ok(Ways::Refraction(String::from("chosen by the user")));
    }
    match routes(system, settings, approach) {
        Err(ReferenceError::NoMethod { from, to, why }) => match eikonal::check_smooth(system) {
            Ok(()) => Ok(Ways::Refraction(why)),
            Err(error) => {
                let why = format!("{why}; {error}");
                Err(ReferenceError::NoMethod { from, to, why })
            }
        },
        routes => Ok(Ways::Hops(routes?)),
    }
}

/// The outlines of both screens of a hop.
pub(crate) fn outlines(hop: &Hop) -> Result<[[f64; 4]; 2], SimulateError> {
    let bounds = |screen: &Screen| {
        let missing = || crate::wave::grid::sampling::SamplingError::Boundless(screen.name.clone());
        screen.bounds().ok_or_else(missing)
    };
    Ok([bounds(hop.from)?, bounds(hop.to)?])
}

/// The routes of all hops.
fn routes(
    system: &System,
    settings: &Settings,
    approach: Approach,
) -> Result<Vec<Route>, ReferenceError> {
    let mut direction = Arriving::from_source(system).directions.chief;
    let mut routes = Vec::new();
    for hop in system.hops() {
        if hop.from.behind.is_some() {
            let (from, to) = (hop.from.name.clone(), hop.to.name.clone());
            let why = format!("'{from}' has two media");
            return Err(ReferenceError::NoMethod { from, to, why });
        }
        let found = free_method(&hop, approach, direction, outlines(&hop)?, settings);
        routes.push(found.map_err(|why| {
            let (from, to) = (hop.from.name.clone(), hop.to.name.clone());
            match approach {
                Approach::Auto => ReferenceError::NoMethod { from, to, why },
                _ => ReferenceError::NotApplicable {
                    approach: approach.name(),
                    from,
                    to,
                    why,
                },
            }
        })?);
        direction = chief(&hop, direction);
    }
    Ok(routes)
}

/// A reference that goes hop by hop: what all its hops share.
struct HopByHop<'a> {
    /// What the light runs through.
    system: &'a System,
    /// How finely it is sampled.
    settings: &'a Settings,
    /// What the user chose.
    choice: ReferenceOptions,
}

/// What a hop brings to the raster on its second screen.
struct Brought {
    /// The field there [ny, nx].
    values: Array2<Complex64>,
    /// Node–point pairs of a direct sum, plane waves of a spectrum, or nodes.
    work: f64,
    /// What the method leaves out, in words; empty when nothing.
    neglects: &'static str,
}

impl HopByHop<'_> {
    /// All hops by their routes.
    fn follow(&self, routes: &[Route], progress: &Listener) -> Result<Reference, ReferenceError> {
        let mut light = Arriving::from_source(self.system);
        let mut steps = Vec::<ReferenceStep>::new();
        for (number, (hop, route)) in self.system.hops().zip(routes).enumerate() {
            let report = |done: f64| {
                Cancelled::check(progress(Progress {
                    attempt: 0,
                    hop: number,
                    hops: routes.len(),
                    to: &hop.to.name,
                    done,
                    rays: 0.0,
                }))
            };
            let (next, step) = self.carry(&hop, route, &light, &report)?;
            light = next;
            steps.push(step);
        }
        let grid = Grid::of(sensor_of(self.system)?);
        let values = match light.sum {
            Some(levels) => levels.into_middle(),
            None => Array2::zeros(grid.shape()),
        };
        let field = Field { grid, values };
        with_cosines(
            self.system,
            &field,
            steps.iter_mut().map(|step| &mut step.power),
        );
        Ok(Reference { field, steps })
    }

    /// One hop: the field behind the first screen, and what arrives at the second.
    fn carry(
        &self,
        hop: &Hop,
        route: &Route,
        light: &Arriving,
        progress: &HopListener,
    ) -> Result<(Arriving, ReferenceStep), ReferenceError> {
        let clock = Instant::now();
        let Route { method, why } = route;
        let (finer, arriving) = finer_reach(hop, method)?;
        let (arrived, field) = light.pass(self.system, hop.from, finer, self.settings)?;
        let before = arrived.power();
        let behind = power_behind(hop.from, &arrived, &field);
        drop(arrived);
        let raster = receiving_raster(hop, arriving, self.settings)?;
        progress(0.0)?;
        let brought = self.bring(hop, method, &field, &raster, progress)?;
        progress(1.0)?;
        let landed = raster.power(&brought.values);
        let step = ReferenceStep {
            screens: [hop.from.name.clone(), hop.to.name.clone()],
            approach: method.approach(),
            why: why.clone(),
            neglects: brought.neglects,
            samples: field.grid.shape(),
            power: (self.system).power_along(hop, [before, behind, landed]),
            work: brought.work,
            unresolved: 0,
            seconds: clock.elapsed().as_secs_f64(),
        };
        let next = Arriving {
            sum: Some(HeightStack::plane(raster, brought.values)),
            directions: LightDirections {
                chief: chief(hop, light.directions.chief),
                usual: arriving,
            },
            reach: arriving,
        };
        Ok((next, step))
    }

    /// The field behind the first screen, carried to the raster on the second.
    fn bring(
        &self,
        hop: &Hop,
        route: &FreeMethod,
        field: &Field,
        raster: &Raster,
        progress: &HopListener,
    ) -> Result<Brought, ReferenceError> {
        let (values, work, neglects) = match route {
            FreeMethod::AngularSpectrum(free, plan) => {
                let waves = plan.bands[0].count * plan.bands[1].count;
                (free.carry(field, None, raster, plan), waves as f64, "")
            }
            FreeMethod::RayleighSommerfeld(_) => {
                let (values, pairs) = field_of_emitters(hop, field, raster, self.choice, progress)?;
                (values, pairs, "")
            }
            FreeMethod::Collins(train) => {
                let plan = Collins::new(hop.wavelength, *train, &field.grid, raster)?;
                let nodes = field.values.len() as f64;
                let values = plan.carry(field.values.view());
                (values, nodes, "aberrations and the rims of lenses")
            }
        };
        Ok(Brought {
            values,
            work,
            neglects,
        })
    }
}

/// Largest |p| that the sampling of a hop's first screen resolves, and that the light has on the second.
pub(crate) fn finer_reach(
    hop: &Hop,
    method: &FreeMethod,
) -> Result<([f64; 2], [f64; 2]), ReferenceError> {
    let [from, to] = outlines(hop)?;
    let (leaving, arriving) = method.reach(hop, from, to);
    let fineness = fineness(hop.from);
    let finer = leaving
        .map(|p| (fineness * p).min((PIXEL_FINENESS * p).max(2.0 * hop.from.index_behind())));
    Ok((finer, arriving))
}

/// How much finer than the target needs a screen is sampled.
fn fineness(screen: &Screen) -> f64 {
    match &screen.kind {
        ScreenKind::Doe(doe) if doe.pixels().is_some() => PIXEL_FINENESS,
        ScreenKind::Doe(_) | ScreenKind::Stop(_) | ScreenKind::Sensor(_) => EDGE_FINENESS,
    }
}

/// Most points of a direct sum between two notes of progress, and about how many seconds their sums take at most.
const POINTS_AT_ONCE: usize = 4096;
const SECONDS_AT_ONCE: f64 = 0.5;

/// Points of a direct sum between two notes of progress: one for each of some threads at least.
fn points_at_once(emitters: usize, threads: usize) -> usize {
    let most = SECONDS_AT_ONCE * PAIRS_PER_SECOND * threads as f64 / emitters.max(1) as f64;
    (most as usize).min(POINTS_AT_ONCE).max(threads)
}

/// The direct sum onto a raster, and the number of its pairs.
fn field_of_emitters(
    hop: &Hop,
    field: &Field,
    raster: &Raster,
    choice: ReferenceOptions,
    progress: &HopListener,
) -> Result<(Array2<Complex64>, f64), ReferenceError> {
    // The first screen as its own light sees it: it leaves towards +z.
    let leaves = hop.from.leaves();
    let mut heights = Heights::on(hop.from, &field.grid);
    heights.z *= leaves;
    heights.slope.iter_mut().for_each(|slope| *slope *= leaves);
    let emitters = Emitters::new(field, &heights);
    let [nx, ny] = raster.size;
    let pairs = emitters.len() as f64 * (nx * ny) as f64;
    let threads = rayon::current_num_threads();
    let seconds = pairs / (PAIRS_PER_SECOND * threads as f64);
    if seconds > choice.patience {
        return Err(ReferenceError::TooLong {
            from: hop.from.name.clone(),
            to: hop.to.name.clone(),
            pairs,
            hours: seconds / 3600.0,
            allowed: choice.patience / 3600.0,
        });
    }

    // The second screen's points likewise.
    let points: Vec<[f64; 3]> = (0..nx * ny)
        .map(|n| {
            let [x, y] = [n % nx, n / nx];
            let x = raster.start[0] + x as f64 * raster.pitch[0];
            let y = raster.start[1] + y as f64 * raster.pitch[1];
            let global = hop.to.frame.to_global(Vec3::new(x, y, 0.0));
            let local = hop.from.frame.to_local(global);
            [local.x, local.y, local.z * leaves]
        })
        .collect();
    let wavelength = hop.wavelength / hop.from.index_behind();
    let mut values = Vec::with_capacity(points.len());
    for chunk in points.chunks(points_at_once(emitters.len(), threads)) {
        values.extend(emitters.field_at(chunk, wavelength));
        progress(values.len() as f64 / points.len() as f64)?;
    }
    let array = Array2::from_shape_fn((ny, nx), |(j, i)| values[j * nx + i]);
    Ok((array, pairs))
}

/// The whole system by the generalised law of refraction.
fn refraction(
    system: &System,
    why: String,
    progress: &Listener,
) -> Result<Reference, ReferenceError> {
    let clock = Instant::now();
    let name = |screen: Option<&Screen>| screen.map(|s| s.name.clone()).unwrap_or_default();
    let screens = [name(system.screens.first()), name(system.screens.last())];
    let report = |done: f64| {
        Cancelled::check(progress(Progress {
            attempt: 0,
            hop: 0,
            hops: 1,
            to: &screens[1],
            done,
            rays: 0.0,
        }))
    };
    report(0.0)?;
    let Geometrical {
        field,
        unresolved,
        rays,
        ..
    } = eikonal::carry(system)?;
    report(1.0)?;
    let in_sensor = system
        .screens
        .last()
        .map_or(1.0, |sensor| system.power_in(sensor.index));
    let step = ReferenceStep {
        screens,
        approach: Approach::Refraction,
        why,
        neglects: "diffraction",
        samples: [0, 0],
        power: [None, None, Some(field.power() * in_sensor)],
        work: rays as f64,
        unresolved,
        seconds: clock.elapsed().as_secs_f64(),
    };
    Ok(Reference {
        field,
        steps: vec![step],
    })
}
