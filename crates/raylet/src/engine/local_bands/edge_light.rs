//! The light that the edge of an aperture sends to a sensor far beside its own way, where the nodes of a tile do not resolve it.
//!
//! `carry_kept_dot_product` (in `carry.rs`) tests the adjoint as a part of the whole run.

use std::f64::consts::TAU;

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::local_bands::emission::WindowWaves;
use crate::engine::local_bands::held_light::TileLight;
use crate::engine::local_bands::tile_plan::{TargetedWindow, TilePlan, TileRun, grown};
use crate::engine::local_bands::window_light::WindowLight;
use crate::optics::screen::ScreenKind;
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::edge_points::{EdgePoint, edge_points};
use crate::wave::local_bands::edge_sum::{EdgeBar, EdgeLight, EdgeModes, EdgeNode, EdgeSum};
use crate::wave::local_bands::element_phase::TileArea;
use crate::wave::local_bands::element_samples::resolves_edge;
use crate::wave::local_bands::fourier_axis::Modes;
use crate::wave::local_bands::tiling::{EdgeContact, REACH, Tile};

/// Distance of the points of an edge in σ, and the least distance.
const STEP: f64 = 0.5;
const LEAST_STEP: f64 = 0.1;

/// The band of the light behind the element is at most this part of what its nodes resolve: beyond them only the edge sends light.
const NARROW: f64 = 0.5;

/// Plane waves of a window at most.
pub(crate) const MOST_WAVES: usize = 1 << 16;

/// The angle from point to point of an edge beyond which it has a corner, in rad.
const CORNER: f64 = 0.45;

/// A window with the plane waves that its edge sends.
pub(crate) struct EdgeWindow {
    light: WindowLight,
    sum: EdgeSum,
    /// The element at the points of the edge, and their places among all of the tile.
    through: Vec<Complex64>,
    places: Vec<usize>,
    /// The plane waves.
    pub waves: WindowWaves,
}

impl TileRun<'_> {
    /// The edge under a tile whose light goes to a sensor, where nodes of the element do not resolve what it sends far; nothing behind
    /// pixels, whose own edges send light far, and where the edge has a corner.
    pub(crate) fn edge_light(
        &self,
        tile: &Tile,
        light: &TileLight,
        own: &Carrier,
        area: &TileArea,
        targeted: &[TargetedWindow],
    ) -> Option<EdgeLight> {
        let ends = matches!(self.hop.to.kind, ScreenKind::Sensor(_));
        let mut cut = targeted.iter().filter(|t| t.edge == EdgeContact::Cut);
        let few = |t: &TargetedWindow| self.modes(t, None).is_none_or(|m| count(&m) <= MOST_WAVES);
        let is_cut = cut.clone().next().is_some();
        if !ends || !is_cut || self.element.pixels().is_some() || !cut.all(few) {
            return None;
        }
        if !self.settings.edge_sums && resolves_edge(area) {
            return None;
        }
        let (k, sigma, phase) = (self.k(), self.shape.sigma, self.element.phase());
        let usual = TileArea {
            reach: [0.0; 2],
            ..area.clone()
        };
        let limit = (self.element.nodes_of(&usual, own, self.far(), true)).half_band?;
        let band = phase.band(area, own, self.far());
        if (0..2).any(|a| band[a] > NARROW * limit[a]) {
            return None;
        }
        let under = grown(self.tiling.centres(tile), REACH * sigma);
        let points_of = |step: f64| edge_points(self.element.aperture(), under, step);
        let mut points = points_of(STEP * sigma);
        let step = step_of(&points, k * area.reach[0].hypot(area.reach[1]), sigma);
        if has_corner(&points) || step < LEAST_STEP * sigma {
            return None;
        }
        points = points_of(step);
        let node = |point: &EdgePoint| {
            let EdgePoint { at, normal } = *point;
            let arrived = light.beside(at);
            let added = phase.beside(own, self.far(), at, k);
            let beside = [0, 1].map(|a| arrived[a] + added[a]);
            EdgeNode { at, normal, beside }
        };
        let through = |point: &EdgePoint| self.element.value_at(point.at, own, k);
        Some(EdgeLight {
            nodes: points.iter().map(node).collect(),
            through: points.iter().map(through).collect(),
        })
    }

    /// The plane waves of a window that its edge sends and the nodes of its tile do not resolve; nothing where all of them are
    /// weaker than `weakest`.
    pub(crate) fn edge_window(
        &self,
        plan: &TilePlan,
        targeted: &TargetedWindow,
        values: &Array2<Complex64>,
        weakest: f64,
    ) -> Option<EdgeWindow> {
        let edge = plan.edge.as_ref()?;
        let resolved = self.modes(targeted, plan.element(targeted)?.1.half_band);
        let modes = self.modes(targeted, None)?;
        let known = resolved.as_ref().map_or(0, count);
        if targeted.edge != EdgeContact::Cut || known == count(&modes) {
            return None;
        }
        let (at, sigma) = (targeted.start.carrier.at, self.shape.sigma);
        let near = |node: &EdgeNode| (0..2).all(|a| (node.at[a] - at[a]).abs() < REACH * sigma);
        let places: Vec<usize> = (0..edge.nodes.len())
            .filter(|place| near(&edge.nodes[*place]))
            .collect();
        let waves = EdgeModes {
            modes,
            resolved,
            half_band: self.window_half_band(),
            sigma,
        };
        let light = self.window_light(plan, targeted);
        let [x, y] = &light.lines(&plan.samples);
        let nodes = places.iter().map(|place| edge.nodes[*place]).collect();
        let sum = EdgeSum::new(nodes, [x, y], waves);
        let windowed = light.windowed(values);
        if sum.strongest(&windowed) <= weakest {
            return None;
        }
        let through: Vec<Complex64> = places.iter().map(|place| edge.through[*place]).collect();
        let waves = WindowWaves {
            start: targeted.start,
            curvature_change: plan.curvature_change,
            modes,
            coefficients: sum.apply(&windowed, &through),
        };
        Some(EdgeWindow {
            light,
            sum,
            through,
            places,
            waves,
        })
    }
}

impl EdgeWindow {
    /// The conjugate transpose: adds to the cotangents of the light at the samples of the tile, and of the edge.
    pub(crate) fn edge_window_adjoint(
        &self,
        values: &Array2<Complex64>,
        waves_bar: &Array2<Complex64>,
        values_bar: &mut Array2<Complex64>,
        edge_bar: &mut EdgeBar,
    ) {
        let windowed = self.light.windowed(values);
        let (light_bar, bars) = self.sum.apply_adjoint(&windowed, &self.through, waves_bar);
        self.light.windowed_adjoint(&light_bar, values_bar);
        for (n, place) in self.places.iter().enumerate() {
            edge_bar.through[*place] += bars.through[n];
            edge_bar.place[*place] += bars.place[n];
        }
    }
}

/// How many plane waves there are.
fn count([x, y]: &[Modes; 2]) -> usize {
    x.count.saturating_mul(y.count)
}

/// The distance of points at which an edge that bends under a window is summed in light of a wavenumber `aside` beside its own.
fn step_of(points: &[EdgePoint], aside: f64, sigma: f64) -> f64 {
    let curvature = neighbours(points).map(|[a, b]| {
        let distance = (b.at[0] - a.at[0]).hypot(b.at[1] - a.at[1]);
        turn(a, b) / distance
    });
    let curvature = curvature.fold(0.0, f64::max);
    // Along the edge, away from where it sends a plane wave, the phase of that runs faster.
    let along = aside * REACH * sigma * curvature;
    1.0 / (1.0 / (STEP * sigma) + along / TAU)
}

/// Whether an edge turns much from one point to the next.
fn has_corner(points: &[EdgePoint]) -> bool {
    neighbours(points).any(|[a, b]| turn(a, b) > CORNER)
}

/// Each point with the next one.
fn neighbours(points: &[EdgePoint]) -> impl Iterator<Item = [&EdgePoint; 2]> {
    points
        .iter()
        .zip(points.iter().skip(1))
        .map(|(a, b)| [a, b])
}

/// The angle between the normals at two points of an edge.
fn turn(a: &EdgePoint, b: &EdgePoint) -> f64 {
    let ([ax, ay], [bx, by]) = (a.normal, b.normal);
    (ax * by - ay * bx).atan2(ax * bx + ay * by).abs()
}

#[cfg(test)]
mod tests {
    use crate::engine::local_bands::edge_light::{has_corner, step_of};
    use crate::optics::aperture::Aperture;
    use crate::wave::local_bands::edge_points::edge_points;

    const EVERYWHERE: [f64; 4] = [-9.0, 9.0, -9.0, 9.0];

    /// Points of a whole circle stand as close as those of a part of it; along a line they stand half a width apart.
    #[test]
    fn points_stand_closer_where_an_edge_bends() {
        let (sigma, aside) = (0.1, 2e3);
        let whole = edge_points(&Aperture::disc(0.7), EVERYWHERE, 0.5 * sigma);
        let part = edge_points(&Aperture::disc(0.7), [0.2, 9.0, 0.1, 9.0], 0.5 * sigma);
        let [whole, part] = [whole, part].map(|points| step_of(&points, aside, sigma));
        let expected = 1.0 / (20.0 + aside * 4.3 * sigma / 0.7 / std::f64::consts::TAU);
        assert!((part / expected - 1.0).abs() < 1e-2, "{part} {expected}");
        assert!((whole / expected - 1.0).abs() < 1e-2, "{whole} {expected}");
        let square = Aperture::turned_rectangle(0.5, 0.5, 0.0, [0.0; 2]);
        let side = edge_points(&square, [0.4, 0.6, -0.4, 0.4], 0.5 * sigma);
        assert_eq!(step_of(&side, aside, sigma), 0.5 * sigma);
    }

    #[test]
    fn corners_are_seen_and_arcs_have_none() {
        let square = Aperture::turned_rectangle(0.5, 0.5, 0.0, [0.0; 2]);
        assert!(has_corner(&edge_points(&square, EVERYWHERE, 0.05)));
        assert!(!has_corner(&edge_points(
            &square,
            [0.4, 0.6, -0.4, 0.4],
            0.05
        )));
        assert!(!has_corner(&edge_points(
            &Aperture::disc(0.7),
            EVERYWHERE,
            0.05
        )));
        let blocked =
            Aperture::disc(0.7).blocked(Aperture::turned_rectangle(0.9, 0.05, 0.3, [0.0; 2]));
        assert!(has_corner(&edge_points(&blocked, EVERYWHERE, 0.05)));
    }
}
