//! The plan of a hop: which method carries it, and how.

use crate::engine::beamlet::beamlet_plan::{BeamletPlan, Planner};
use crate::engine::monte_carlo::paper_plan::PaperPlan;
use crate::engine::plan::direction_spread::LightDirections;
use crate::engine::plan::downstream::Downstream;
use crate::engine::plan::plan_error::{BYTES_OF_DIRECTION, PlanError};
use crate::engine::plan::settings::{Method, Settings};
use crate::engine::plane_wave::plane_wavelets::PlanePlan;
use crate::engine::trace::direction_search::{DirectionSearch, SearchGoal, search_directions};
use crate::optics::aperture::Aperture;
use crate::optics::refraction::Interface;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::shape::Shape;
use crate::optics::surface::Surface;
use crate::optics::system::Hop;
use crate::wave::free::free_plan::{FreePlan, Slab};
use crate::wave::free::propagate::{FreeHop, clear_for};
use crate::wave::patches::patch::Band;

/// The method of one hop from a whole field, with its plan.
#[derive(Clone, Debug)]
pub enum Plan {
    /// Without rays.
    Free(FreeHop, FreePlan),
    /// By beamlets.
    Beamlets(BeamletPlan),
    /// By plane wavelets with prefactor.
    Planes(PlanePlan),
    /// As the source paper does.
    Paper(PaperPlan),
}

impl Plan {
    /// The lattice of directions along x and y.
    pub(crate) fn bands(&self) -> &[Band; 2] {
        match self {
            Plan::Free(_, free) => &free.bands,
            Plan::Beamlets(beamlets) => &beamlets.bands,
            Plan::Planes(planes) => &planes.bands,
            Plan::Paper(paper) => &paper.bands,
        }
    }

    /// The same plan to a target `offset` mm further along the second screen's z axis.
    pub(crate) fn moved(&self, offset: f64) -> Plan {
        let mut plan = self.clone();
        if let Plan::Free(free, _) = &mut plan
            && let Some(last) = free.slabs.last_mut()
        {
            last.thickness += offset;
        }
        plan
    }

    /// The light that it brings to the second screen.
    pub(crate) fn light(&self, hop: &Hop, light: LightDirections) -> LightDirections {
        let usual = match self {
            Plan::Free(..) => light.behind(hop.from, hop.wavelength).usual(),
            Plan::Beamlets(beamlets) => beamlets.usual,
            Plan::Planes(planes) => planes.arriving,
            Plan::Paper(paper) => paper.arriving,
        };
        let chief = match hop.trace([0.0, 0.0], light.chief, &mut ()) {
            Ok(landing) => landing.cosines,
            Err(_) => [0.0, 0.0],
        };
        LightDirections {
            chief,
            usual: usual.map(|p| p.min(hop.to.index)),
        }
    }

    /// Whether all its lengths, directions and costs are numbers.
    fn is_finite(&self) -> bool {
        let own = match self {
            Plan::Free(_, free) => vec![free.period[0], free.period[1], free.depth],
            Plan::Beamlets(plan) => {
                let error = plan.expected_error();
                vec![
                    plan.sigma,
                    plan.step,
                    plan.period,
                    plan.footprint,
                    plan.work.seconds,
                    error,
                ]
            }
            Plan::Planes(plan) => vec![plan.sigma, plan.step[0], plan.step[1], plan.period],
            Plan::Paper(plan) => vec![plan.side, plan.period, plan.area.iter().sum()],
        };
        let ends = |band: &Band| [band.at(0), band.at(band.count.saturating_sub(1))];
        let mut all = own.into_iter().chain(self.bands().iter().flat_map(ends));
        all.all(f64::is_finite) && self.rays().is_finite()
    }

    /// Rays that the plan expects; zero without rays.
    pub fn rays(&self) -> f64 {
        match self {
            Plan::Free(..) => 0.0,
            Plan::Beamlets(beamlets) => beamlets.work.rays,
            Plan::Planes(planes) => planes.rays,
            Plan::Paper(paper) => paper.rays(),
        }
    }
}

/// Plans a hop that begins with `light` on the first screen and whose light goes on `downstream`.
///
/// # Errors
/// When a screen has two media or no edge, no ray reaches the target, a patch has too many modes, or the plan's numbers
/// are not finite.
pub fn plan(
    hop: &Hop,
    light: LightDirections,
    downstream: &Downstream,
    settings: &Settings,
) -> Result<Plan, PlanError> {
    for screen in [hop.from, hop.to] {
        if screen.behind.is_some() {
            return Err(PlanError::TwoMedia(screen.name.clone()));
        }
    }
    let plan = choose(hop, light, downstream, settings)?;
    match plan.is_finite() {
        true => Ok(plan),
        false => Err(PlanError::NotFinite {
            from: hop.from.name.clone(),
            to: hop.to.name.clone(),
        }),
    }
}

/// The plan of the chosen method, or of the one that suits best.
fn choose(
    hop: &Hop,
    light: LightDirections,
    downstream: &Downstream,
    settings: &Settings,
) -> Result<Plan, PlanError> {
    let pitch = pitch_of(hop.to);
    let bounds = |screen: &crate::optics::screen::Screen| {
        screen
            .bounds()
            .ok_or_else(|| PlanError::Boundless(screen.name.clone()))
    };
    let (from, to) = (bounds(hop.from)?, bounds(hop.to)?);
    if settings.method == Method::Auto
        && let Some(free) = free_hop(hop, from, to, light.chief, settings)
    {
        let plane = hop.from.is_plane() && hop.to.is_plane();
        let layers = if plane { 1 } else { CURVED_LAYERS };
        let cheap = cheap_directions(settings.target_error) / layers;
        let (free, mut plan) = widest(free, from, to, cheap);
        if !plane {
            plan.reach = plan.largest();
        }
        check_directions(hop, &plan, settings)?;
        return Ok(Plan::Free(free, plan));
    }
    if settings.method == Method::Plane && !hop.from.is_plane() {
        let screen = hop.from.name.clone();
        let method = "plane";
        return Err(PlanError::Curved { method, screen });
    }
    let search = search_directions(hop, from, to, [0.0; 2], SearchGoal::Rays);
    if search.is_dark() {
        return Err(dark(hop, &search));
    }
    let planner = Planner {
        hop,
        from,
        to,
        light,
        envelope: light.behind(hop.from, hop.wavelength),
        pitch,
        downstream,
        settings,
    };
    match settings.method {
        Method::Auto | Method::Beamlet => {
            let plan = planner.plan(&search)?;
            check_patches(&planner, plan.sigma, [plan.step; 2], &plan.bands)?;
            Ok(Plan::Beamlets(plan))
        }
        Method::Plane => {
            let plan = PlanePlan::new(&planner, &search);
            check_patches(&planner, plan.sigma, plan.step, &plan.bands)?;
            Ok(Plan::Planes(plan))
        }
        Method::Paper => paper(&planner),
        Method::LocalBands => Err(no_whole_field(hop)),
    }
}

/// The patches must be few enough to be numbered in memory, and one spectrum must fit.
fn check_patches(
    planner: &Planner,
    sigma: f64,
    step: [f64; 2],
    bands: &[Band; 2],
) -> Result<(), PlanError> {
    let allowed = planner.settings.samples_allowed();
    let screen = || planner.hop.from.name.clone();
    let fits = |[x, y]: [usize; 2]| x.saturating_mul(y) <= allowed;
    let modes = [bands[0].count, bands[1].count];
    if !fits(modes) {
        let screen = screen();
        return Err(PlanError::Modes {
            screen,
            modes,
            allowed,
        });
    }
    let along = |a: usize| {
        let length = planner.from[2 * a + 1] - planner.from[2 * a] + sigma;
        (length / step[a]) as usize
    };
    let patches = [along(0), along(1)];
    if !fits(patches) {
        let screen = screen();
        return Err(PlanError::Patches {
            screen,
            patches,
            allowed,
        });
    }
    Ok(())
}

/// Distance of sample points on a screen that is a sensor, in mm.
fn pitch_of(screen: &Screen) -> Option<[f64; 2]> {
    match &screen.kind {
        ScreenKind::Sensor(sensor) => Some(sensor.pitch),
        _ => None,
    }
}

/// Plane waves that cost little for an error of 1e-3: a free hop whose period may grow takes the widest one within
/// them.
const CHEAP_DIRECTIONS: f64 = 3e6;

/// Plane waves that cost little for an error: less exact fields are also to be quicker.
fn cheap_directions(target_error: f64) -> usize {
    (CHEAP_DIRECTIONS * (1e-3 / target_error).min(1.0).powi(2)) as usize
}

/// The least period between screens of which one is curved, over the sum of the half widths.
const LEAST_OF_CURVED: f64 = 4.0;

/// Transforms that a curved screen needs, roughly.
const CURVED_LAYERS: usize = 20;

/// Periods tried in turn, over the sum of the half widths.
const PADDINGS: [f64; 3] = [12.0, 8.0, 6.0];

/// The free hop with the widest period that is cheap, with nodes that resolve all its plane waves, or with its own.
fn widest(free: FreeHop, from: [f64; 4], to: [f64; 4], cheap: usize) -> (FreeHop, FreePlan) {
    for padding in PADDINGS {
        let wider = FreeHop {
            padding: padding.max(free.padding),
            ..free.clone()
        };
        let plan = wider.plan(from, to);
        if plan.bands[0].count.saturating_mul(plan.bands[1].count) <= cheap {
            let reach = plan.largest();
            return (wider, FreePlan { reach, ..plan });
        }
    }
    let plan = free.plan(from, to);
    (free, plan)
}

/// The plane waves of a free hop and one intermediate array must fit in memory.
fn check_directions(hop: &Hop, plan: &FreePlan, settings: &Settings) -> Result<(), PlanError> {
    let directions = [plan.bands[0].count, plan.bands[1].count];
    let allowed = settings.memory_limit / BYTES_OF_DIRECTION;
    if directions[0].saturating_mul(directions[1]) <= allowed {
        return Ok(());
    }
    Err(PlanError::Directions {
        from: hop.from.name.clone(),
        to: hop.to.name.clone(),
        directions,
        allowed,
    })
}

/// The source paper's plan, if one spectrum at a time fits the memory.
fn paper(planner: &Planner) -> Result<Plan, PlanError> {
    let plan = PaperPlan::new(planner);
    let modes = [plan.bands[0].count, plan.bands[1].count];
    let allowed = planner.settings.samples_allowed();
    if modes[0].saturating_mul(modes[1]) > allowed {
        return Err(PlanError::Modes {
            screen: planner.hop.from.name.clone(),
            modes,
            allowed,
        });
    }
    Ok(Plan::Paper(plan))
}

/// Local bands do not come here.
fn no_whole_field(hop: &Hop) -> PlanError {
    let (from, to) = (hop.from.name.clone(), hop.to.name.clone());
    PlanError::WholeField { from, to }
}

fn dark(hop: &Hop, search: &DirectionSearch) -> PlanError {
    let mut causes = String::new();
    for (loss, count) in &search.lost {
        let name = crate::engine::error::tally::Fate::Lost(*loss).name();
        causes += &format!("; {count} of {} rays tried: {name}", search.traced);
    }
    PlanError::Dark {
        from: hop.from.name.clone(),
        to: hop.to.name.clone(),
        causes,
    }
}

/// The free hop that this hop is, if nothing between its parallel screens has power or an edge.
pub(crate) fn free_hop(
    hop: &Hop,
    from: [f64; 4],
    to: [f64; 4],
    chief: [f64; 2],
    settings: &Settings,
) -> Option<FreeHop> {
    let frame = &hop.from.frame;
    if !frame.is_parallel(&hop.to.frame) || hop.from.leaves() != hop.to.arrives {
        return None;
    }
    // A curved screen must lie on its side of what follows, and not be so deep that rays are cheaper.
    let target = frame.to_local(hop.to.frame.origin);
    let next = hop
        .train
        .first()
        .map_or(target.z, |surface| frame.to_local(surface.frame.origin).z);
    if !clears(hop, next, target.z) {
        return None;
    }
    let open = |surface: &Surface| {
        let seen = |point| surface.frame.to_local(point);
        holds(&surface.aperture, seen(frame.origin), from)
            && holds(&surface.aperture, seen(hop.to.frame.origin), to)
    };
    if !hop.train.iter().all(open) {
        return None;
    }
    // What levels of height hold has directions of its own, which the rule for planes does not know.
    let plane = hop.from.is_plane() && hop.to.is_plane();
    let least = if plane { 2.0 } else { LEAST_OF_CURVED };
    Some(FreeHop {
        k: hop.wavenumber(),
        slabs: slabs(hop)?,
        offset: [target.x, target.y],
        chief,
        padding: settings.padding.max(least),
        clear: clear_for(settings.target_error),
    })
}

/// A free hop with the slabs and the offset of another hop of the same kind; nothing when that has power or
/// is tilted.
pub(crate) fn along(free: &FreeHop, hop: &Hop) -> Option<FreeHop> {
    let frame = &hop.from.frame;
    let target = frame.to_local(hop.to.frame.origin);
    let slabs = slabs(hop).filter(|_| frame.is_parallel(&hop.to.frame))?;
    Some(FreeHop {
        slabs,
        offset: [target.x, target.y],
        ..free.clone()
    })
}

/// The media between parallel screens, when only planes parallel to them part these.
fn slabs(hop: &Hop) -> Option<Vec<Slab>> {
    let frame = &hop.from.frame;
    let mut slabs = Vec::new();
    let mut depth = 0.0;
    for surface in hop.train {
        let plane = surface.shape == Shape::Plane
            && surface.interface == Interface::Refract
            && (surface.frame.z - frame.z).norm() < 1e-12;
        if !plane {
            return None;
        }
        let z = frame.to_local(surface.frame.origin).z;
        slabs.push(Slab {
            index: surface.index[0],
            thickness: z - depth,
            exit: Some(surface.coating),
        });
        depth = z;
    }
    let target = frame.to_local(hop.to.frame.origin);
    slabs.push(Slab {
        index: hop.to.index,
        thickness: target.z - depth,
        exit: None,
    });
    Some(slabs)
}

/// Deepest relief of a curved screen that is taken apart into levels, in wavelengths.
const DEEPEST: f64 = 60.0;

/// Whether curved screens keep clear of the first plane behind the first one, at `next`, and of each
/// other, and are shallow.
fn clears(hop: &Hop, next: f64, target: f64) -> bool {
    let (Some(from), Some(to)) = (hop.from.relief(), hop.to.relief()) else {
        return false;
    };
    let deepest = DEEPEST * hop.wavelength;
    let leaves = hop.from.leaves();
    let front = if leaves > 0.0 { from.high } else { -from.low };
    let back = if leaves > 0.0 { to.low } else { -to.high };
    let shallow = from.high - from.low <= deepest && to.high - to.low <= deepest;
    shallow && front <= leaves * next && front <= leaves * target + back
}

/// Whether an aperture is open all over a box that stands at `origin` in its coordinates.
fn holds(aperture: &Aperture, origin: crate::math::vec3::Vec3, bounds: [f64; 4]) -> bool {
    let [x0, x1, y0, y1] = bounds;
    let open = aperture.coverage(x0 + origin.x, x1 + origin.x, y0 + origin.y, y1 + origin.y);
    open > 1.0 - 1e-12
}
