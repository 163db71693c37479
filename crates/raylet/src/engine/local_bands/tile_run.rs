//! One tile: from the light that arrives to the beamlets that leave, and back.
//!
//! `carry_kept_dot_product` (in `carry.rs`) tests the adjoint of a tile as a part of the whole run.

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::beamlet::mode_histogram::ModeHistogram;
use crate::engine::error::hop_statistics::HopStatistics;
use crate::engine::local_bands::edge_band::CutWindow;
use crate::engine::local_bands::emission::{Emission, Emitted, WindowWaves};
use crate::engine::local_bands::held_light::ArrivingLight;
use crate::engine::local_bands::hop_changes::{HopChanges, SourceSamples};
use crate::engine::local_bands::tile_plan::{TargetedWindow, TilePlan, TileRun, WindowPlan};
use crate::wave::beamlet::beamlet_kernel::Moments;
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::local_bands::edge_sum::EdgeBar;
use crate::wave::local_bands::element_samples::ElementSamples;
use crate::wave::local_bands::tiling::{EdgeContact, Tile};

/// Of so many windows of a tile one is looked at to find how strong plane waves are.
const SAMPLED: usize = 5;

/// The result of the adjoint of a tile.
#[derive(Default)]
pub(crate) struct TileBar {
    /// Moments of the cotangent under arriving beamlets, by their places among all.
    pub arriving: Vec<(usize, Moments)>,
    /// Cotangents of the element's pixels, by row and column.
    pub pixels: Vec<([usize; 2], Complex64)>,
    /// Derivatives with respect to parameters.
    pub parameters: Vec<f64>,
}

/// A window whose plane waves are known.
struct Transformed<'a> {
    plan: WindowPlan,
    element: &'a ElementSamples,
    edge: usize,
    waves: WindowWaves,
}

/// The light that arrives at the samples of a tile, [y, x], and how many values of beamlets were evaluated for it.
pub(crate) type TileValues = (Array2<Complex64>, u64);

impl TileRun<'_> {
    /// The beamlets that leave a tile and reach the target; the light that arrives there may be known.
    pub(crate) fn send(
        &self,
        tile: &Tile,
        emission: &Emission,
        known: Option<&TileValues>,
    ) -> Emitted {
        let mut out = Emitted::default();
        let Some(plan) = self.plan(tile, &mut out.statistics) else {
            return out;
        };
        let found = known.is_none().then(|| plan.light.at(&plan.samples));
        let Some((values, evaluations)) = known.or(found.as_ref()) else {
            return out;
        };
        out.statistics.evaluations += evaluations;
        let of_edge = emission.of_edge();
        for targeted in &plan.targeted {
            if let Some(window) = self.transformed(&plan, targeted, values) {
                emission.send(&window.waves, &mut out);
            }
            match self.edge_window(&plan, targeted, values, of_edge.weakest) {
                Some(window) => of_edge.send(&window.waves, &mut out),
                None => {
                    let left_out = self.unresolved_edge(&plan, targeted, values);
                    out.statistics.tally.unresolved_edges += left_out;
                }
            }
        }
        out
    }

    /// The conjugate transpose, for the plane waves that are kept: from the moments that the cotangent has under the
    /// beamlets that leave, which `bars` gives window by window for beamlets of coefficient one, to those under the
    /// beamlets that arrive, to the cotangents of the element's pixels, and to the parameters with which the hop
    /// changes.
    pub(crate) fn send_adjoint(
        &self,
        tile: &Tile,
        emission: &Emission,
        changes: &HopChanges,
        mut bars: impl FnMut(&[Arrival]) -> Vec<Moments>,
    ) -> TileBar {
        let Some(plan) = self.plan(tile, &mut HopStatistics::default()) else {
            return TileBar::default();
        };
        let (values, _) = plan.light.at(&plan.samples);
        let mut values_bar = Array2::zeros(values.dim());
        let mut element_bars = plan.elements.each_ref().map(|element| {
            let shape = |e: &ElementSamples| (e.nodes[1].len(), e.nodes[0].len());
            Array2::zeros(element.as_ref().map_or((0, 0), shape))
        });
        let points = plan.edge.as_ref().map_or(0, |edge| edge.nodes.len());
        let of_edge = emission.of_edge();
        let mut edge_bar = EdgeBar::zeros(points);
        let mut parameters = vec![0.0; changes.count];
        for targeted in &plan.targeted {
            if let Some(window) = self.transformed(&plan, targeted, &values) {
                let waves_bar =
                    emission.send_adjoint(&window.waves, changes, &mut bars, &mut parameters);
                let element_bar = &mut element_bars[window.edge];
                let Transformed { plan, element, .. } = window;
                plan.apply_adjoint(&values, element, &waves_bar, &mut values_bar, element_bar);
            }
            if let Some(window) = self.edge_window(&plan, targeted, &values, of_edge.weakest) {
                let waves_bar =
                    of_edge.send_adjoint(&window.waves, changes, &mut bars, &mut parameters);
                window.edge_window_adjoint(&values, &waves_bar, &mut values_bar, &mut edge_bar);
            }
        }
        if let Some(edge) = &plan.edge {
            changes.pull_edge(edge, &plan.carriers[1], &edge_bar, &mut parameters);
        }
        let mut pixels = Vec::new();
        for (element, bar) in plan.elements.iter().zip(&element_bars) {
            let Some(element) = element else { continue };
            let (own, k) = (&plan.carriers[1], self.hop.wavenumber());
            pixels.extend(self.element.samples_adjoint(element, own, k, bar));
            changes.pull_element(element, own, bar, &mut parameters);
        }
        if let ArrivingLight::Source(..) = self.light {
            let light = SourceSamples {
                samples: &plan.samples,
                carrier: &plan.light.carrier,
                values: &values,
                bar: &values_bar,
            };
            changes.pull_light(&light, &mut parameters);
        }
        TileBar {
            arriving: plan.light.at_adjoint(&plan.samples, &values_bar),
            pixels,
            parameters,
        }
    }

    /// How strong the plane waves of a tile are that may reach the target, by some of its windows, and the light that
    /// arrives there; nothing where none leads to the target.
    pub(crate) fn histogram(&self, tile: &Tile) -> Option<(ModeHistogram, TileValues)> {
        let plan = self.plan(tile, &mut HopStatistics::default())?;
        let found = plan.light.at(&plan.samples);
        let counted = |waves: Option<&WindowWaves>| {
            waves.map_or_else(ModeHistogram::default, |waves| {
                ModeHistogram::of(waves.coefficients.iter())
            })
        };
        let mut all = ModeHistogram::default();
        for targeted in plan.targeted.iter().step_by(SAMPLED) {
            let window = self.transformed(&plan, targeted, &found.0);
            let edge = self.edge_window(&plan, targeted, &found.0, 0.0);
            all = all.merge(counted(window.as_ref().map(|w| &w.waves)));
            all = all.merge(counted(edge.as_ref().map(|w| &w.waves)));
        }
        Some((all, found))
    }

    /// What an edge under a window sends to the target in directions that its nodes do not resolve.
    fn unresolved_edge(
        &self,
        plan: &TilePlan,
        targeted: &TargetedWindow,
        values: &Array2<Complex64>,
    ) -> f64 {
        let element = plan.element(targeted).map(|(_, element)| element);
        let Some(limit) = element.and_then(|element| element.half_band) else {
            return 0.0;
        };
        if targeted.edge != EdgeContact::Cut {
            return 0.0;
        }
        let at = targeted.start.carrier.at;
        let nearest = [0, 1].map(|a| {
            let axis = &plan.samples[a];
            let place = ((at[a] - axis.start) / axis.pitch).round().max(0.0);
            (place as usize).min(axis.cells.saturating_sub(1))
        });
        let cut = CutWindow {
            at,
            sigma: self.shape.sigma,
            intensity: values[[nearest[1], nearest[0]]].norm_sqr(),
            directions: targeted.directions,
            landing: targeted.landing,
            limit: [0, 1].map(|a| (limit[a] - targeted.shift[a].abs()).max(0.0)),
        };
        cut.missing(self.element.aperture(), self.hop.wavenumber())
    }

    /// The plane waves of a window; nothing where none leads to the target.
    fn transformed<'a>(
        &self,
        plan: &'a TilePlan,
        targeted: &TargetedWindow,
        values: &Array2<Complex64>,
    ) -> Option<Transformed<'a>> {
        let window = self.window(plan, targeted)?;
        let (edge, element) = plan.element(targeted)?;
        let waves = WindowWaves {
            start: targeted.start,
            curvature_change: plan.curvature_change,
            modes: window.modes,
            coefficients: window.apply(values, element),
        };
        Some(Transformed {
            plan: window,
            element,
            edge,
            waves,
        })
    }
}
