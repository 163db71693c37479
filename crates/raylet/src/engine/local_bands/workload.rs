//! What a run by local bands will take, and whether its windows are narrow enough, by rays of the source.

use std::f64::consts::TAU;

use crate::engine::error::error_budget::left_out;
use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::edge_workload::{SeenRim, edge_area};
use crate::engine::local_bands::hop_step::HopStep;
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::local_bands::onward_way::directions_onward;
use crate::engine::local_bands::passing_light::bare;
use crate::engine::local_bands::settings::LocalBandSettings;
use crate::engine::local_bands::window_widths::{expected_aberration, leaving_carriers};
use crate::engine::plan::cost_model::as_conics;
use crate::engine::plan::cost_model::local_bands::{
    NODE, OPERATION, PRODUCT, SMOOTH_WINDOW, SURFACE, VALUE, WAVE, WINDOW,
};
use crate::engine::plan::work::Work;
use crate::optics::screen::ScreenKind;
use crate::optics::system::System;
use crate::wave::beamlet::direction_sectors::Sectors;
use crate::wave::beamlet::wavelet::Tail;
use crate::wave::grid::raster::Raster;
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::edge_mask::PASSBAND;
use crate::wave::local_bands::element_samples::{edge_pitch, resolves_edge};
use crate::wave::local_bands::local_band::{sample_pitch, window_half_band};
use crate::wave::local_bands::tiling::REACH;

/// Nodes of a pixel along an axis.
const NODES: f64 = 2.0;

/// Widths of windows that are tried, as parts of the widest.
const NARROWER: [f64; 5] = [1.0, 0.7, 0.5, 0.35, 0.25];

/// What a hop by local bands will take.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalBandWorkload {
    /// Rays, values and seconds.
    pub work: Work,
    /// The error to expect from the aberration inside beamlets.
    pub aberration: f64,
    /// The error to expect from all causes but rims.
    pub error: f64,
}

/// q² and weights for means over the energy exp(−q²) of a window's plane waves in two dimensions.
const RADII: [(f64, f64); 2] = [(0.585_786, 0.853_553), (3.414_214, 0.146_447)];

/// Directions around that of the carrier.
const AROUND: u32 = 12;

/// The workload of each hop of a system.
///
/// # Errors
/// As a run, except that light which does not arrive is no error.
pub(crate) fn workload(
    system: &System,
    settings: &LocalBandSettings,
) -> Result<Vec<LocalBandWorkload>, LocalBandError> {
    let leaving = leaving_carriers(system, settings.aperture)?;
    let hops = system.hops().enumerate().zip(&leaving);
    let mut passes = false;
    hops.map(|((number, hop), carriers)| {
        let step = HopStep::new(system, settings, number, hop)?;
        let plan = step.plan();
        // The light of a smooth source passes bare apertures as it came, but for what their edges touch.
        passes = plan.smooth || (passes && bare(hop.from).is_some());
        let [inside, cut] = step.lit_windows();
        let windows = [if passes { 0 } else { inside }, cut];
        let aberration = expected_aberration(&hop, &system.source, carriers, &plan);
        // A smooth source has no plane waves to leave out.
        let (work, dropped) = match plan.smooth {
            true => {
                let windows = plan.windows.map(|count| count as f64).iter().product();
                let window = Work {
                    rays: 1.0,
                    values: 0.0,
                    seconds: SMOOTH_WINDOW,
                };
                (window * windows, 0.0)
            }
            false => {
                let dropped = settings.dropped.unwrap_or(settings.threshold)
                    * dropped_on_target(&step, carriers, settings);
                let share = match step.pixel_pitch() {
                    Some(_) if number == 0 => step.followed_share(),
                    _ => 1.0,
                };
                let edge = work_of_edge(system, &step, settings);
                (
                    work_of_hop(&step, carriers, settings, (windows, share)) + edge,
                    dropped,
                )
            }
        };
        Ok(LocalBandWorkload {
            work,
            aberration,
            error: aberration.hypot(plan.window_error(0.0)).hypot(dropped),
        })
    })
    .collect()
}

/// What a hop takes: so many windows inside its aperture and at its edge, each with the mean over carriers. Of their plane waves a
/// `share` is strong enough to be followed.
fn work_of_hop(
    step: &HopStep,
    carriers: &[Carrier],
    settings: &LocalBandSettings,
    (windows, share): ([usize; 2], f64),
) -> Work {
    let [inside, cut] = windows.map(|count| count as f64);
    let one = |carrier: &Carrier| {
        let start = ChirpedStart {
            carrier: *carrier,
            sigma: step.plan().sigma,
        };
        let Some(waves) = Waves::of(step, &start, settings) else {
            let windows = inside + cut;
            return Work {
                seconds: windows * WINDOW,
                ..Work::default()
            };
        };
        let transforms = inside * waves.transform_seconds(step)
            + cut * waves.transform_seconds_at_edge(step, settings);
        let rays = share * (inside * waves.followed(false) + cut * waves.followed(true));
        let values = rays * values(step, &start, &waves.bounds);
        let traced = WAVE + SURFACE * (as_conics(step.hop.train) + 1.0);
        Work {
            rays,
            values,
            seconds: transforms + rays * traced + VALUE * values,
        }
    };
    carriers.iter().map(one).sum::<Work>() * (1.0 / carriers.len().max(1) as f64)
}

/// What the plane waves that are left out do on the target, over those that are followed there, as a ratio of amplitudes, at most
/// one; one behind pixels, which send light in all directions.
fn dropped_on_target(step: &HopStep, carriers: &[Carrier], settings: &LocalBandSettings) -> f64 {
    let (sigma, k) = (step.plan().sigma, step.hop.wavenumber());
    let (mut dropped, mut followed, mut orders) = (0.0, 0.0, 0.0);
    for carrier in carriers {
        let start = ChirpedStart {
            carrier: *carrier,
            sigma,
        };
        let Some(waves) = Waves::of(step, &start, settings) else {
            continue;
        };
        if waves.kept.is_infinite() {
            return 1.0;
        }

        // Beyond a radius q the mean of q'² is q² + 1.
        let on_target = |square: f64| {
            let radius = square.sqrt() / (k * sigma);
            share_on_target(step, &start, &waves.bounds, radius)
        };
        dropped += on_target((waves.kept * k * sigma).powi(2) + 1.0);
        let own: f64 = (RADII.iter())
            .map(|(square, weight)| weight * on_target(*square))
            .sum();
        followed += own;
        orders += own
            * step.beside().map_or(1.0, |beside| {
                (step.target).orders(&step.hop, &start, [0.0; 2], beside, own)
            });
    }
    match followed > 0.0 {
        true => (dropped / followed).min(1.0).sqrt() * left_out(orders / followed),
        false => 1.0,
    }
}

/// The mean share of the energy of plane waves that falls on the target, of those at a distance from the carrier's direction
/// that are transformed.
fn share_on_target(
    step: &HopStep,
    start: &ChirpedStart,
    [x0, x1, y0, y1]: &[f64; 4],
    distance: f64,
) -> f64 {
    let directions = (0..AROUND).map(|number| {
        let angle = TAU * f64::from(number) / f64::from(AROUND);
        [distance * angle.cos(), distance * angle.sin()]
    });
    let transformed = |[p, q]: &[f64; 2]| (*x0..=*x1).contains(p) && (*y0..=*y1).contains(q);
    let kept: Vec<[f64; 2]> = directions.filter(transformed).collect();
    let (target, k) = (step.target.bounds, step.hop.wavenumber());
    let landed = start.launch_all(&step.hop, &kept);
    let shares = landed
        .iter()
        .flatten()
        .map(|one| Tail::of(one, target, k).share);
    shares.sum::<f64>() / kept.len().max(1) as f64
}

/// What the light takes that an edge sends far beside its own way.
fn work_of_edge(system: &System, step: &HopStep, settings: &LocalBandSettings) -> Work {
    let Some(rim) = SeenRim::of(system, step, settings) else {
        return Work::default();
    };
    let way = WAVE + SURFACE * (as_conics(step.hop.train) + 1.0);
    rim.work(way, |start, bounds| values(step, start, bounds))
}

/// The plane waves of a window.
struct Waves {
    /// The directions that lead to the target, likewise.
    directions: [f64; 4],
    /// The directions that are transformed, `[x_low, x_high, y_low, y_high]`, from that of the carrier.
    bounds: [f64; 4],
    /// The distance of neighbouring ones.
    spacing: f64,
    /// Half width of a window's own spectrum, where its plane waves become too weak to be followed; without end for pixels,
    /// whose structure sends light in all directions.
    kept: f64,
    /// Samples along each axis of the light under the window.
    samples: f64,
}

impl Waves {
    /// Those of a window about a carrier; nothing where no direction leads to the target.
    fn of(step: &HopStep, start: &ChirpedStart, settings: &LocalBandSettings) -> Option<Self> {
        let (hop, plan) = (&step.hop, step.plan());
        let width = hop.wavenumber() * plan.sigma;
        let reach = window_half_band(plan.step, settings.threshold);
        let band = reach / width;
        let onward = step.onward.as_ref();
        let directions = directions_onward(hop, start, &step.target, onward, [band; 2])?.bounds;
        let limit = match step.pixel_pitch() {
            Some(_) => f64::INFINITY,
            None => band,
        };
        let bounds = [0, 1, 2, 3].map(|side| directions[side].clamp(-limit, limit));
        // Beyond the radius q (in 1/kσ) a Gaussian window has the share exp(-q²) of its energy.
        let radius = match settings.dropped {
            Some(error) => -2.0 * (error / plan.share_of_dropped()).ln(),
            None => -2.0 * settings.threshold.ln(),
        };
        let kept = match step.pixel_pitch() {
            Some(_) => f64::INFINITY,
            None => radius.max(0.0).sqrt() / width,
        };
        Some(Self {
            directions,
            bounds,
            spacing: hop.wavelength / (plan.period * plan.sigma),
            kept,
            samples: 2.0 * REACH * plan.sigma / sample_pitch(band, hop.wavelength),
        })
    }

    /// How many there are along an axis up to this half width.
    fn count(&self, axis: usize, limit: f64) -> f64 {
        let [low, high] =
            [2 * axis, 2 * axis + 1].map(|side| self.bounds[side].clamp(-limit, limit));
        ((high - low) / self.spacing).max(0.0) + 1.0
    }

    /// How many are strong enough to be followed. Those of a window inside the aperture fill an ellipse, as far as it lies
    /// in the bounds. An edge sends light across itself as far as the band goes, and along itself no farther than the window.
    fn followed(&self, is_cut: bool) -> f64 {
        let whole = [0, 1].map(|axis| self.count(axis, f64::INFINITY));
        let own = [0, 1].map(|axis| self.count(axis, self.kept));
        if is_cut || self.kept.is_infinite() {
            return 0.5 * (own[0] * whole[1] + whole[0] * own[1]);
        }
        let round = own.map(|count| count * self.spacing / (2.0 * self.kept));
        let corners = (1.0 - std::f64::consts::FRAC_PI_4) * (round[0] * round[1]).min(1.0);
        own[0] * own[1] * (1.0 - corners)
    }

    /// Seconds of the transform of a window to them, and of all else that a window takes.
    fn transform_seconds(&self, step: &HopStep) -> f64 {
        let [columns, rows] = [0, 1].map(|axis| self.count(axis, f64::INFINITY));
        let (samples, plan) = (self.samples, step.plan());
        let pixels = step.pixel_pitch();
        let Some(pitch) = pixels else {
            return WINDOW + PRODUCT * matrix_products([samples; 2], [columns, rows]);
        };
        let nodes = pitch.map(|pitch| NODES * 2.0 * REACH * plan.sigma / pitch);
        let folded = pitch.map(|pitch| NODES * plan.period * plan.sigma / pitch);
        let products = PRODUCT * matrix_products(nodes, [columns, rows]);
        WINDOW
            + self.to_nodes_seconds(nodes)
            + (OPERATION * folded_operations(folded, columns)).min(products)
    }

    /// The same of a window that an edge cuts. Without pixels its nodes are as fine as the light of the edge asks for, where that is
    /// not summed along the edge, and its plane waves as many as they resolve.
    fn transform_seconds_at_edge(&self, step: &HopStep, settings: &LocalBandSettings) -> f64 {
        if step.pixel_pitch().is_some() {
            return self.transform_seconds(step);
        }
        let (plan, k) = (step.plan(), step.hop.wavenumber());
        let mut area = edge_area(step, settings, &self.directions);
        if step.sums_along_edge() && (settings.edge_sums || !resolves_edge(&area)) {
            area.reach = [0.0; 2];
        }
        let pitch = [0, 1].map(|a| edge_pitch(&area, a));
        let waves = [0, 1].map(|a| {
            let limit = PASSBAND * std::f64::consts::TAU / (k * pitch[a]);
            let [low, high] =
                [2 * a, 2 * a + 1].map(|side| self.directions[side].clamp(-limit, limit));
            ((high - low) / self.spacing).max(0.0) + 1.0
        });
        let nodes = pitch.map(|pitch| 2.0 * REACH * plan.sigma / pitch);
        WINDOW + self.to_nodes_seconds(nodes) + PRODUCT * matrix_products(nodes, waves)
    }

    /// Seconds in which the light under a window comes from its samples to nodes.
    fn to_nodes_seconds(&self, nodes: [f64; 2]) -> f64 {
        let products = 0.5 * self.samples * nodes[0] * (self.samples + nodes[1]);
        PRODUCT * products + NODE * nodes[0] * nodes[1]
    }
}

/// Products of the matrices that lead from nodes along x and y to plane waves.
fn matrix_products(nodes: [f64; 2], [columns, rows]: [f64; 2]) -> f64 {
    rows * nodes[0] * nodes[1] + columns * rows * nodes[0]
}

/// Operations of the fast transforms of a window with so many folded nodes along x and y and plane waves along x.
fn folded_operations([x, y]: [f64; 2], waves: f64) -> f64 {
    let line = |folded: f64| 5.0 * folded * folded.log2().max(1.0);
    y * line(x) + waves * line(y)
}

/// Narrower windows in place of these widths, for elements of pixels that send light to a wide target, where that takes less
/// time: they send fewer plane waves past the element's edges. The aberration inside beamlets, which grows where windows are only
/// wavelengths wide, stays within a target error of each hop.
///
/// # Errors
/// When a screen has no edge or layers of another kind, or no ray of the source meets an aperture.
pub(crate) fn quickest_widths(
    system: &System,
    settings: &LocalBandSettings,
    error: f64,
) -> Result<Vec<f64>, LocalBandError> {
    let leaving = leaving_carriers(system, settings.aperture)?;
    let mut sigmas = settings.sigmas.clone();
    for ((number, hop), carriers) in system.hops().enumerate().zip(&leaving) {
        let mut best = f64::INFINITY;
        for narrower in NARROWER {
            let mut tried = settings.clone();
            let Some(sigma) = tried.sigmas.get_mut(number) else {
                continue;
            };
            *sigma *= narrower;
            let sigma = *sigma;
            // Narrower windows may be too many.
            let Ok(step) = HopStep::new(system, &tried, number, hop) else {
                break;
            };
            if step.pixel_pitch().is_none() {
                break;
            }
            let aberration = expected_aberration(&hop, &system.source, carriers, &step.plan());
            if narrower < 1.0 && aberration > error {
                break;
            }
            let all = (step.lit_windows(), 1.0);
            let seconds = work_of_hop(&step, carriers, &tried, all).seconds;
            if seconds < best {
                best = seconds;
                if let Some(chosen) = sigmas.get_mut(number) {
                    *chosen = sigma;
                }
            }
        }
    }
    Ok(sigmas)
}

/// Directions along each axis whose beamlets stand for all.
const DIRECTIONS: usize = 3;

/// Values of one beamlet on the sensor, as the mean over directions; none where it goes to another screen.
fn values(step: &HopStep, start: &ChirpedStart, [x0, x1, y0, y1]: &[f64; 4]) -> f64 {
    let ScreenKind::Sensor(sensor) = &step.hop.to.kind else {
        return 0.0;
    };
    let (sectors, k) = (Sectors::of(Raster::of(sensor)), step.hop.wavenumber());
    let under = |p: [f64; 2]| match start.launch(&step.hop, p) {
        Ok(arrival) => sectors.values(&arrival, k, step.target.edge),
        Err(_) => 0.0,
    };
    let place =
        |i: usize, low: f64, high: f64| low + (high - low) * (i as f64 + 0.5) / DIRECTIONS as f64;
    let all = (0..DIRECTIONS * DIRECTIONS).map(|i| {
        let (column, row) = (i % DIRECTIONS, i / DIRECTIONS);
        under([place(column, *x0, *x1), place(row, *y0, *y1)])
    });
    all.sum::<f64>() / (DIRECTIONS * DIRECTIONS) as f64
}
