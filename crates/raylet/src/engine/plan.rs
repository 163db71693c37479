//! The plan of a hop: method, beamlet width, positions and directions, and what they will cost.

use crate::engine::budget::aberration;
use crate::engine::fan::{Fan, FanRay, explore};
use crate::engine::settings::{Correction, Method, Settings};
use crate::math::complex::{Complex, Symmetric};
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::bend::Interface;
use crate::optics::shape::Shape;
use crate::optics::system::Hop;
use crate::wave::patch::Band;
use crate::wave::propagate::{FreeHop, FreePlan, Slab};
use crate::wave::wavelet::Arrival;
use crate::wave::window::Positions;

/// How one hop is carried.
#[derive(Clone, Debug)]
pub enum Plan {
    /// Without rays.
    Free(FreeHop, FreePlan),
    /// By beamlets.
    Beamlets(BeamletPlan),
}

/// The lattice of a beamlet sum.
#[derive(Clone, Debug, PartialEq)]
pub struct BeamletPlan {
    /// Width σ in mm.
    pub sigma: f64,
    /// Distance of windows in mm.
    pub step: f64,
    /// Period of a patch in mm.
    pub period: f64,
    /// Directions along x and y.
    pub bands: [Band; 2],
    /// Whether each beamlet's aberration is made good.
    pub correct: bool,
    /// Whether beamlets that land beside the target have tails that cannot be trusted unseen.
    pub doubtful_rim: bool,
    /// Estimated error from aberration at this σ, uncorrected.
    pub eta: f64,
    /// Estimated error after the correction.
    pub eta_corrected: f64,
    /// Half width of a typical footprint on the target, in mm.
    pub footprint: f64,
    /// Largest optical direction cosines on the receiving screen, along x and y.
    pub arriving: [f64; 2],
    /// Rays that the plan expects.
    pub rays: f64,
    /// Seconds on one core that it expects.
    pub seconds: f64,
}

/// Why no plan exists.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// No ray gets from one screen to the next.
    #[error("no ray from '{from}' reaches '{to}'{causes}")]
    Dark {
        /// Emitting screen.
        from: String,
        /// Receiving screen.
        to: String,
        /// How the rays of the fan were lost.
        causes: String,
    },
    /// A screen has no edge.
    #[error("screen '{0}' has no edge; give its element an aperture")]
    Boundless(String),
}

/// Measured on one core of a 3 GHz processor: seconds per beamlet traced, per ray of the aberration
/// estimate, and per value summed. They only shape predictions and the choice between equal errors.
const BEAMLET_SECONDS: f64 = 4e-7;
const ESTIMATE_SECONDS: f64 = 7e-6;
const VALUE_SECONDS: f64 = 6e-10;

/// Plans a hop whose incident light has direction `anchor` on the first screen; `pitch` is the distance
/// of sample points on the target when it is known.
///
/// # Errors
/// When a screen has no edge, or no ray reaches the target.
pub fn plan(
    hop: &Hop,
    anchor: [f64; 2],
    pitch: Option<[f64; 2]>,
    settings: &Settings,
) -> Result<Plan, PlanError> {
    let bounds = |screen: &crate::optics::screen::Screen| {
        screen
            .bounds()
            .ok_or_else(|| PlanError::Boundless(screen.name.clone()))
    };
    let (from, to) = (bounds(hop.from)?, bounds(hop.to)?);
    if settings.method == Method::Auto
        && let Some(free) = free_hop(hop, from, to, anchor, settings)
    {
        let plan = free.plan(from, to);
        return Ok(Plan::Free(free, plan));
    }
    plan_beamlets(hop, from, to, anchor, pitch, settings).map(Plan::Beamlets)
}

/// The free hop that this hop is, if nothing between its parallel screens has power or an edge.
pub fn free_hop(
    hop: &Hop,
    from: [f64; 4],
    to: [f64; 4],
    anchor: [f64; 2],
    settings: &Settings,
) -> Option<FreeHop> {
    let frame = &hop.from.frame;
    if !frame.is_parallel(&hop.to.frame) || hop.from.leaves() != hop.to.arrives {
        return None;
    }
    let target = frame.to_local(hop.to.frame.origin);
    let mut slabs = Vec::new();
    let mut depth = 0.0;
    for surface in hop.train {
        let plane = surface.shape == Shape::Plane
            && surface.interface == Interface::Refract
            && (surface.frame.z - frame.z).norm() < 1e-12
            && holds(
                &surface.aperture,
                surface.frame.to_local(frame.origin),
                from,
            )
            && holds(
                &surface.aperture,
                surface.frame.to_local(hop.to.frame.origin),
                to,
            );
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
    slabs.push(Slab {
        index: hop.to.index,
        thickness: target.z - depth,
        exit: None,
    });
    Some(FreeHop {
        k: hop.wavenumber(),
        slabs,
        offset: [target.x, target.y],
        anchor,
        padding: settings.padding.max(4.0),
    })
}

/// Whether an aperture is open all over a box that stands at `origin` in its coordinates.
fn holds(aperture: &Aperture, origin: crate::math::vec3::Vec3, bounds: [f64; 4]) -> bool {
    if aperture.outline == Outline::Open {
        return true;
    }
    if let Outline::Annulus { .. } = aperture.outline {
        return false;
    }
    let corners = [(0, 2), (0, 3), (1, 2), (1, 3)];
    corners
        .iter()
        .all(|&(i, j)| aperture.contains(bounds[i] + origin.x, bounds[j] + origin.y))
}

/// The widths tried, σ₀·2^{j/4}.
const WIDTHS: std::ops::RangeInclusive<i32> = -6..=4;

/// Rays of the fan on which each width is judged.
const JUDGES: usize = 300;

fn plan_beamlets(
    hop: &Hop,
    from: [f64; 4],
    to: [f64; 4],
    anchor: [f64; 2],
    pitch: Option<[f64; 2]>,
    settings: &Settings,
) -> Result<BeamletPlan, PlanError> {
    let fan = explore(hop, from, to, [0.0; 2]);
    if fan.is_dark() {
        return Err(dark(hop, &fan));
    }
    let stride = fan.rays.len().div_ceil(JUDGES);
    let judges: Vec<FanRay> = fan.rays.iter().copied().step_by(stride).collect();
    let widths: Vec<f64> = match settings.sigma {
        Some(sigma) => vec![sigma],
        None => {
            let start = starting_width(hop, &judges, from);
            WIDTHS
                .map(|j| start * 2f64.powf(0.25 * f64::from(j)))
                .collect()
        }
    };
    let candidates: Vec<BeamletPlan> = widths
        .iter()
        .map(|&sigma| judge(hop, &fan, &judges, sigma, from, anchor, pitch, settings))
        .collect();
    let mut chosen = choose(candidates, settings);

    // With the footprint known, take in the directions that only its rim brings to the target.
    let margin = [chosen.footprint; 2];
    let wider = explore(hop, from, to, margin);
    chosen.bands = bands(&wider, anchor, hop.wavelength / chosen.period);
    chosen.doubtful_rim = is_doubtful(hop, &wider, chosen.sigma);
    Ok(chosen)
}

/// Largest η that a beamlet beside the target may have for its tail on the target to be believed.
pub const TRUSTED_TAIL: f64 = 0.1;

/// Whether some ray that lands beside the target has more aberration than its tail may have.
fn is_doubtful(hop: &Hop, fan: &Fan, sigma: f64) -> bool {
    let stride = fan.rim.len().div_ceil(JUDGES).max(1);
    fan.rim.iter().step_by(stride).any(|ray| {
        aberration(hop, ray.at, ray.p, sigma, hop.wavenumber())
            .is_none_or(|found| found.eta() > TRUSTED_TAIL)
    })
}

fn dark(hop: &Hop, fan: &Fan) -> PlanError {
    let mut causes = String::new();
    for (loss, count) in &fan.lost {
        let name = crate::engine::tally::Fate::Lost(*loss).name();
        causes += &format!("; {count} of {} rays tried: {name}", fan.traced);
    }
    PlanError::Dark {
        from: hop.from.name.clone(),
        to: hop.to.name.clone(),
        causes,
    }
}

fn bands(fan: &Fan, anchor: [f64; 2], spacing: f64) -> [Band; 2] {
    let n = fan.band.map(|p| if p.is_finite() { p } else { 0.0 });
    [
        Band::between(anchor[0], spacing, n[0], n[1]),
        Band::between(anchor[1], spacing, n[2], n[3]),
    ]
}

/// σ₀ = (k‖∂p′/∂x‖)^{−1/2}, the width whose beamlets spread least behind the train's power, by the
/// median of the fan; without power √(‖∂s/∂p‖/k), and never more than a quarter of the screen.
fn starting_width(hop: &Hop, judges: &[FanRay], from: [f64; 4]) -> f64 {
    let k = hop.wavenumber();
    let norm = |ray: &FanRay, row: usize, column: usize| {
        let j = &ray.jacobian;
        let squares = (0..2).flat_map(|a| (0..2).map(move |b| j[row + a][column + b].powi(2)));
        (0.5 * squares.sum::<f64>()).sqrt()
    };
    let median = |row: usize, column: usize| {
        let mut values: Vec<f64> = judges.iter().map(|ray| norm(ray, row, column)).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (power, throw) = (median(2, 0), median(0, 2));
    let by_power = (k * power).powf(-0.5);
    let by_throw = (throw / k).sqrt().max(3.0 * hop.wavelength);
    let largest = 0.25 * (from[1] - from[0]).max(from[3] - from[2]);
    let start = if power * throw > 1e-3 {
        by_power
    } else {
        by_power.min(by_throw)
    };
    start.min(largest).max(1.5 * hop.wavelength)
}

/// What a width would give: its error on the judges, and its cost.
#[expect(clippy::too_many_arguments, reason = "one private step of the planner")]
fn judge(
    hop: &Hop,
    fan: &Fan,
    judges: &[FanRay],
    sigma: f64,
    from: [f64; 4],
    anchor: [f64; 2],
    pitch: Option<[f64; 2]>,
    settings: &Settings,
) -> BeamletPlan {
    let k = hop.wavenumber();
    let period = settings.period * sigma;
    let step = settings.step * sigma;

    // Errors: mean squares over the judges; a judge whose neighbours are lost counts in full.
    let (mut eta, mut cubic) = (0.0, 0.0);
    for ray in judges {
        match aberration(hop, ray.at, ray.p, sigma, k) {
            Some(a) => {
                eta += a.eta().powi(2);
                cubic += a.cubic.min(1.0);
            }
            None => {
                eta += 1.0;
                cubic += 1.0;
            }
        }
    }
    let count = judges.len() as f64;
    let (eta, cubic) = ((eta / count).sqrt(), (cubic / count).sqrt());
    let eta_corrected = eta * (cubic + eta);

    // Footprints and directions on arrival.
    let arrivals: Vec<Arrival> = judges
        .iter()
        .filter_map(|ray| arrive(hop, ray.at, ray.p, sigma))
        .collect();
    let mut footprints: Vec<f64> = arrivals
        .iter()
        .map(|a| {
            let [x, y] = a.footprint(k, settings.footprint_threshold);
            x.max(y)
        })
        .collect();
    footprints.sort_by(f64::total_cmp);
    let footprint = footprints
        .get(footprints.len() * 9 / 10)
        .copied()
        .unwrap_or(0.0);
    let mut arriving = [0.0f64; 2];
    for a in &arrivals {
        let spread = a.spread(k, settings.footprint_threshold);
        for axis in 0..2 {
            arriving[axis] = arriving[axis].max(a.cosines[axis].abs() + spread[axis]);
        }
    }
    let arriving = arriving.map(|p| p.min(hop.to.index));

    // Cost: positions × directions, each traced once and summed over its footprint.
    let bands = bands(fan, anchor, hop.wavelength / period);
    let positions = |a: usize| {
        Positions::cover([from[2 * a], from[2 * a + 1]], sigma, step, 0.5 * period).count
    };
    let rays = (positions(0) * positions(1) * bands[0].count * bands[1].count) as f64;
    let correct = match settings.correction {
        Correction::On => true,
        Correction::Off => false,
        Correction::Auto => eta > 0.1 * settings.target_error,
    };
    let spacing = pitch.unwrap_or(arriving.map(|p| hop.wavelength / (3.0 * p.max(1e-3))));
    let values = std::f64::consts::PI * footprint * footprint / (spacing[0] * spacing[1]);
    let estimate = if correct { ESTIMATE_SECONDS } else { 0.0 };
    BeamletPlan {
        sigma,
        step,
        period,
        bands,
        correct,
        doubtful_rim: true,
        eta,
        eta_corrected,
        footprint,
        arriving,
        rays,
        seconds: rays * (BEAMLET_SECONDS + estimate + values * VALUE_SECONDS),
    }
}

impl BeamletPlan {
    /// The error to expect from aberration inside beamlets, with the correction if it is applied.
    pub fn expected_error(&self) -> f64 {
        if self.correct {
            self.eta_corrected
        } else {
            self.eta
        }
    }
}

/// The cheapest plan within a quarter of the target error, or else the most accurate one.
fn choose(candidates: Vec<BeamletPlan>, settings: &Settings) -> BeamletPlan {
    let limit = 0.25 * settings.target_error;
    let best = |by: &dyn Fn(&BeamletPlan) -> f64, from: Vec<BeamletPlan>| {
        from.into_iter().min_by(|a, b| by(a).total_cmp(&by(b)))
    };
    let (good, rest): (Vec<_>, Vec<_>) = candidates
        .into_iter()
        .partition(|c| c.expected_error() <= limit);
    let chosen = if good.is_empty() {
        best(&BeamletPlan::expected_error, rest)
    } else {
        best(&|c| c.seconds, good)
    };
    match chosen {
        Some(plan) => plan,
        None => unreachable!("at least one width is always judged"),
    }
}

/// A beamlet of width σ at the end of a hop, with unit coefficient; nothing when its ray is lost.
#[inline]
pub fn arrive(hop: &Hop, at: [f64; 2], p: [f64; 2], sigma: f64) -> Option<Arrival> {
    launch(hop, at, p, sigma).ok()
}

/// The same, telling how the ray was lost.
///
/// # Errors
/// The cause of the loss.
#[inline]
pub fn launch(
    hop: &Hop,
    at: [f64; 2],
    p: [f64; 2],
    sigma: f64,
) -> Result<Arrival, crate::optics::ray::Loss> {
    let k = hop.wavenumber();
    let zero = Complex::new(0.0, 0.0);
    let q = Complex::new(0.0, 1.0 / (k * sigma * sigma));
    let start = Symmetric {
        xx: q,
        xy: zero,
        yy: q,
    };
    let carried = hop.carry_beamlet(at, p, start)?;
    let (landing, g) = (carried.landing, carried.curvature);
    Ok(Arrival {
        at: landing.at,
        cosines: landing.cosines,
        amplitude: carried.amplitude.value() * num_complex::Complex64::cis(k * landing.path),
        curvature: [g.xx.value(), g.xy.value(), g.yy.value()],
    })
}
