//! What light that an edge sends to a sensor far beside its own way asks for: the width of windows, and work.

use std::f64::consts::{FRAC_PI_4, TAU};

use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::edge_band::{edge_power, normals, span_across_edge};
use crate::engine::local_bands::edge_light::MOST_WAVES;
use crate::engine::local_bands::emission::WEAKER_OF_EDGE;
use crate::engine::local_bands::hop_step::HopStep;
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::local_bands::settings::LocalBandSettings;
use crate::engine::local_bands::source::source_light::source_carrier;
use crate::engine::local_bands::window_directions::{WindowDirections, window_directions};
use crate::engine::local_bands::window_widths::{SIDE, behind, source_carriers};
use crate::engine::plan::cost_model::local_bands::{EDGE_WAVE, VALUE};
use crate::engine::plan::work::Work;
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::screen::ScreenKind;
use crate::optics::system::System;
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::edge_mask::PASSBAND;
use crate::wave::local_bands::element_phase::TileArea;
use crate::wave::local_bands::element_samples::{edge_pitch, resolves_edge};
use crate::wave::local_bands::local_band::window_half_band;
use crate::wave::local_bands::tiling::{CLEAR, REACH};

/// Largest kκsσ², in rad, of an edge of curvature κ that sends light into a direction s: there a plane wave of a window comes from
/// the whole edge under it. Wider windows have more plane waves, each from a part of their edge.
const BEND: f64 = 1.2;

/// Narrower windows are taken where wide ones leave out more light than this share of the target error.
const SHARE: f64 = 0.5;

/// Narrower windows are taken up to this many of them.
const MOST_WINDOWS: usize = 250_000;

/// A point of the rim, seen from which the directions that lead to the sensor are known.
struct RimPoint {
    /// The window there.
    start: ChirpedStart,
    /// From it to the next point, in mm.
    along: [f64; 2],
    directions: WindowDirections,
}

/// The rim of the element of a system with one hop, from which light goes to the sensor by an integral along the edge.
pub(crate) struct SeenRim<'a> {
    step: &'a HopStep<'a>,
    settings: &'a LocalBandSettings,
    curvature: f64,
    points: Vec<RimPoint>,
}

impl<'a> SeenRim<'a> {
    /// That of a step; nothing where there are more hops, pixels, or no edge that is seen.
    pub(crate) fn of(
        system: &System,
        step: &'a HopStep<'a>,
        settings: &'a LocalBandSettings,
    ) -> Option<Self> {
        let ends = matches!(step.hop.to.kind, ScreenKind::Sensor(_)) && system.trains.len() == 1;
        let element = step
            .element()
            .filter(|element| ends && element.pixels().is_none())?;
        let (rim, k) = (element.aperture().rim(), step.hop.wavenumber());
        let next = rim.iter().cycle().skip(1);
        let point = |(from, to): (&[f64; 2], &[f64; 2])| {
            let own = element.phase().carrier(*from, 0.0, k);
            let start = ChirpedStart {
                carrier: source_carrier(&system.source, step.hop.from, *from).times(own.p, own.q),
                sigma: step.plan().sigma,
            };
            let directions = window_directions(&step.hop, &start, &step.target)?;
            Some(RimPoint {
                start,
                along: [to[0] - from[0], to[1] - from[1]],
                directions,
            })
        };
        Some(Self {
            curvature: curvature(element.aperture())?,
            points: rim.iter().zip(next).filter_map(point).collect(),
            step,
            settings,
        })
    }

    /// Whether nodes resolve all that the edge sends from a point.
    fn is_resolved(&self, point: &RimPoint) -> bool {
        resolves_edge(&edge_area(
            self.step,
            self.settings,
            &point.directions.bounds,
        ))
    }

    /// The light that nodes do not resolve, as an error of the field on the sensor.
    fn unresolved(&self, system: &System) -> Result<f64, LocalBandError> {
        let hop = &self.step.hop;
        let k = hop.wavenumber();
        let power = |point: &RimPoint| {
            let area = edge_area(self.step, self.settings, &point.directions.bounds);
            let limit = [0, 1].map(|a| PASSBAND * TAU / (k * edge_pitch(&area, a)));
            edge_power(&point.directions, point.along, k, limit[0].min(limit[1]))
        };
        let left = self.points.iter().filter(|point| !self.is_resolved(point));
        let power: f64 = left.map(power).sum();
        if power == 0.0 {
            return Ok(0.0);
        }
        let open = behind(hop, &source_carriers(system)?)?;
        let lands = |at: [f64; 2], p: [f64; 2]| {
            let landing = hop.trace_along(at, p, &mut ());
            landing.is_ok_and(|landing| self.step.target.holds(landing.at))
        };
        let landing = open.iter().filter(|ray| lands(ray.at, ray.p)).count();
        let [x0, x1, y0, y1] = hop.from.bounds().unwrap_or_default();
        let cell = (x1 - x0) * (y1 - y0) / (SIDE * SIDE) as f64;
        Ok((power / (landing as f64 * cell)).sqrt())
    }

    /// The width of windows with which the light of the edge takes few plane waves, in mm.
    fn narrow(&self) -> f64 {
        let (plan, hop) = (self.step.plan(), &self.step.hop);
        let seen = self.points.iter().map(|point| {
            let [x0, x1, y0, y1] = point.directions.bounds;
            let far = x0.abs().max(x1.abs()).hypot(y0.abs().max(y1.abs()));
            (far, (x1 - x0) * (y1 - y0))
        });
        let (far, area) = seen.fold((0.0f64, 0.0f64), |(far, area), (f, a)| {
            (far.max(f), area.max(a))
        });
        let bent = (BEND / (hop.wavenumber() * far * self.curvature)).sqrt();
        let few = (0.5 * MOST_WAVES as f64 / area).sqrt() * hop.wavelength / plan.period;
        bent.min(few)
    }

    /// Work on what the edge sends beyond directions that usual nodes resolve, where finer ones do not, with the seconds that a plane wave takes on its
    /// `way`, and the mean of the `values` that one takes, for windows and directions `[x_low, x_high, y_low, y_high]`.
    pub(crate) fn work(&self, way: f64, values: impl Fn(&ChirpedStart, &[f64; 4]) -> f64) -> Work {
        let plan = self.step.plan();
        let spacing = self.step.hop.wavelength / (plan.period * plan.sigma);
        let width = self.step.hop.wavenumber() * plan.sigma;
        let band = window_half_band(plan.step, self.settings.threshold);
        let dropped = self
            .settings
            .dropped
            .map(|error| error / plan.share_of_dropped());
        let weakest = WEAKER_OF_EDGE * dropped.unwrap_or(self.settings.threshold);
        let windows =
            self.step.lit_windows()[1] as f64 * SEEN as f64 / self.points.len().max(1) as f64;
        let resolved = self
            .settings
            .resolved(self.step.hop.wavenumber(), plan.sigma);
        let mut work = Work::default();
        let summed = |point: &&RimPoint| self.settings.edge_sums || !self.is_resolved(point);
        let left = self.points.iter().step_by(SEEN).filter(summed);
        for point in left {
            for normal in normals(point.along) {
                let span = span_across_edge(&point.directions, normal, resolved);
                let Some([near, far]) = span else { continue };
                // An edge at a depth of d σ sends exp(−d²/2)/(√(2π)·kσs) of the strongest plane wave of a whole window, and that
                // times exp(−q²/2) in directions q/kσ along itself.
                let mean = 0.5 * (near + far);
                let strongest = 1.0 / (TAU.sqrt() * width * mean * weakest);
                let kept = (2.0 * strongest.ln().max(0.0)).sqrt();
                let waves = |reach: f64| {
                    let turned = mean * self.curvature * reach * plan.sigma;
                    windows * (far - near) * 2.0 * (reach / width + turned) / (spacing * spacing)
                };
                let rays = FRAC_PI_4 * kept / CLEAR * waves(kept);
                let under = values(&point.start, &point.directions.bounds);
                work = work
                    + Work {
                        rays,
                        values: rays * under,
                        seconds: EDGE_WAVE * waves(band) + rays * (way + VALUE * under),
                    };
            }
        }
        work
    }
}

/// Every so many points of a rim stand for all in a forecast.
const SEEN: usize = 8;

/// A tile at an edge from which these directions `[x_low, x_high, y_low, y_high]` beside the carrier lead to the target.
pub(crate) fn edge_area(
    step: &HopStep,
    settings: &LocalBandSettings,
    directions: &[f64; 4],
) -> TileArea {
    let (plan, k) = (step.plan(), step.hop.wavenumber());
    let side = plan.sigma * ((settings.tile - 1) as f64 * plan.step + 2.0 * REACH);
    let far = |a: usize| directions[2 * a].abs().max(directions[2 * a + 1].abs());
    TileArea {
        bounds: [-side, side, -side, side].map(|side| 0.5 * side),
        samples: [0, 1].map(|_| Axis::uniform(1, side, 0.0)),
        half_band: [window_half_band(plan.step, settings.threshold) / (k * plan.sigma); 2],
        edge_pitch: plan.sigma / settings.edge_nodes,
        pixel_part: side,
        part_error: 1.0,
        spread: [0.0; 2],
        reach: [far(0), far(1)],
        k,
        values_allowed: settings.values_allowed() as f64,
    }
}

/// The largest curvature of an edge, in 1/mm; nothing without one.
fn curvature(aperture: &Aperture) -> Option<f64> {
    match &aperture.outline {
        Outline::Open => None,
        Outline::Disc { radius } | Outline::Annulus { inner: radius, .. } => Some(1.0 / radius),
        Outline::Rectangle { .. } | Outline::Polygon { .. } => Some(0.0),
        Outline::Blocked { open, by } => Some(curvature(open)?.max(curvature(by)?)),
    }
}

/// A narrower width of the windows of a system with one hop, in mm, where the edge of its element sends light to the sensor that
/// wide ones leave out; nothing where that is too little to matter.
///
/// # Errors
/// When a screen has no edge, or layers of another kind.
pub(crate) fn width_for_edge(
    system: &System,
    settings: &LocalBandSettings,
    error: f64,
) -> Result<Option<f64>, LocalBandError> {
    let Some(hop) = system.hops().next() else {
        return Ok(None);
    };
    let step = HopStep::new(system, settings, 0, hop)?;
    let Some(rim) = SeenRim::of(system, &step, settings) else {
        return Ok(None);
    };
    if rim.unresolved(system)? <= SHARE * error {
        return Ok(None);
    }
    let narrow = rim.narrow();
    let tried = LocalBandSettings {
        sigmas: vec![narrow],
        ..settings.clone()
    };
    let fits = HopStep::new(system, &tried, 0, hop).is_ok_and(|step| {
        let windows = step.plan().windows;
        windows[0].saturating_mul(windows[1]) <= MOST_WINDOWS
    });
    Ok((fits && narrow < step.plan().sigma).then_some(narrow))
}
