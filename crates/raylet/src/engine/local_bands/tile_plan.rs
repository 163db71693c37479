//! What is known of one tile before its light goes on: carriers, samples, the element under it, and the windows that
//! see the target. Nothing of it is kept: the adjoint plans each tile again.
//!
//! `carry_kept_dot_product` (in `carry.rs`) tests the adjoint of a tile as a part of the whole run.

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;

use crate::engine::error::hop_statistics::HopStatistics;
use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::held_light::{ArrivingLight, TileLight};
use crate::engine::local_bands::onward_way::{OnwardWay, directions_onward};
use crate::engine::local_bands::settings::LocalBandSettings;
use crate::engine::local_bands::target::TargetRegion;
use crate::engine::local_bands::window_light::WindowLight;
use crate::math::part::part;
use crate::optics::system::Hop;
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::edge_sum::EdgeLight;
use crate::wave::local_bands::element_phase::TileArea;
use crate::wave::local_bands::element_samples::{Element, ElementNodes, ElementSamples};
use crate::wave::local_bands::fourier_axis::Modes;
use crate::wave::local_bands::local_band::{WindowBlock, sample_pitch, window_half_band};
use crate::wave::local_bands::tiling::{EdgeContact, LitWindow, REACH, Tile, Tiling, WindowShape};
use crate::wave::local_bands::window_transform::{NodeLine, WindowTransform, nodes_within};

/// Light that counts for the band of an element lies within this many σ of a window's centre.
const SEEN: f64 = 3.0;

/// Parts of pixels are at most this share of σ wide.
const PIXEL_PART: f64 = 0.16;

/// The error that light which is not linear over these parts may cause along each axis, as a share of that which plane waves that
/// are left out may cause.
const PART_ERROR: f64 = 0.5;

/// What all tiles of a screen share.
pub(crate) struct TileRun<'a> {
    /// The hop from the screen.
    pub hop: &'a Hop<'a>,
    /// The light that arrives.
    pub light: ArrivingLight<'a>,
    /// The element on the screen.
    pub element: &'a Element<'a>,
    /// The places of its windows, in tiles.
    pub tiling: &'a Tiling,
    /// The width, distance and period of the windows.
    pub shape: WindowShape,
    /// The target of the light.
    pub target: &'a TargetRegion,
    /// What stands behind it, where it is a bare aperture.
    pub onward: Option<&'a OnwardWay<'a>>,
    /// The settings of the run.
    pub settings: &'a LocalBandSettings,
}

/// A window that sends light to the target.
pub(crate) struct TargetedWindow {
    window: [usize; 2],
    /// Its carrier and width.
    pub start: ChirpedStart,
    /// Whether the aperture contains it, cuts it or blocks it.
    pub edge: EdgeContact,
    /// How deep its centre lies inside that edge, in σ.
    pub depth: f64,
    /// Direction of its carrier beside that of the tile's.
    pub shift: [f64; 2],
    /// Directions that lead to the target.
    pub directions: [f64; 4],
    /// The part of their sides that leads to the target itself.
    pub landing: [f64; 2],
}

/// A tile that sends light to the target.
pub(crate) struct TilePlan<'a> {
    /// The light that arrives.
    pub light: TileLight<'a>,
    /// The samples of that light along x and y, in mm.
    pub samples: [Axis; 2],
    /// The carriers of the arriving light and of the element.
    pub carriers: [Carrier; 2],
    /// How far the curvature changes to the next tile, in 1/mm.
    pub curvature_change: f64,
    /// The element under windows that see no edge, and under those that an edge cuts.
    pub elements: [Option<ElementSamples>; 2],
    /// The edge of the aperture, where light goes far beside its own way.
    pub edge: Option<EdgeLight>,
    /// The windows that see the target.
    pub targeted: Vec<TargetedWindow>,
}

/// A tile before anything is sampled.
pub(crate) struct TileOutline<'a> {
    light: TileLight<'a>,
    /// The carrier of the element.
    own: Carrier,
    targeted: Vec<TargetedWindow>,
    area: TileArea,
    edge: Option<EdgeLight>,
    /// The nodes of the element under windows that see no edge, and under those that an edge cuts.
    nodes: [Option<ElementNodes>; 2],
}

/// The linear map from the samples of a tile to the plane waves of one window.
pub(crate) struct WindowPlan {
    transform: WindowTransform,
    light: WindowLight,
    /// Nodes of the element along x and y.
    nodes: [(usize, usize); 2],
    /// Directions of the plane waves.
    pub modes: [Modes; 2],
}

impl<'a> TileRun<'a> {
    /// Plans a tile; nothing where no light of it leads to the target, and where an array of it is too large.
    pub(crate) fn plan(&self, tile: &Tile, statistics: &mut HopStatistics) -> Option<TilePlan<'a>> {
        let TileOutline {
            light,
            own,
            targeted,
            area,
            edge,
            nodes,
        } = self.outline(tile, statistics)?;
        if statistics.largest_array > self.settings.values_allowed() {
            return None;
        }
        Some(TilePlan {
            carriers: [light.carrier, own],
            curvature_change: self.curvature_change(&light, &own),
            edge,
            samples: area.samples,
            light,
            elements: nodes.map(|nodes| Some(self.element.samples(nodes?, &own, self.k()))),
            targeted,
        })
    }

    /// What a tile is made of before anything is sampled; notes how large its arrays are.
    pub(crate) fn outline(
        &self,
        tile: &Tile,
        statistics: &mut HopStatistics,
    ) -> Option<TileOutline<'a>> {
        let lit = self.tiling.lit(tile, self.element.aperture());
        if lit.is_empty() {
            return None;
        }
        let light = self.light_under(tile)?;
        statistics.windows += lit.len() as u64;
        let own = self
            .element
            .phase()
            .carrier(light.carrier.at, self.far(), self.k());
        let leaving = light.carrier.times(own.p, own.q);
        let windows = lit.into_iter();
        let targeted: Vec<TargetedWindow> = windows
            .filter_map(|lit| self.targeted(lit, &leaving, &light, &own))
            .collect();
        if targeted.is_empty() {
            return None;
        }
        let mut area = self.area(tile, &light, &targeted);
        let edge = self.edge_light(tile, &light, &own, &area, &targeted);
        if edge.is_some() {
            area.reach = [0.0; 2];
        }
        let nodes = [EdgeContact::Inside, EdgeContact::Cut].map(|edge| {
            let needed = targeted.iter().any(|targeted| targeted.edge == edge);
            needed
                .then(|| (self.element).nodes_of(&area, &own, self.far(), edge == EdgeContact::Cut))
        });
        statistics.note_array(count(&area.samples));
        nodes
            .iter()
            .flatten()
            .for_each(|nodes| statistics.note_array(count(&nodes.axes)));
        for targeted in &targeted {
            let nodes = nodes[usize::from(targeted.edge != EdgeContact::Inside)].as_ref();
            let modes = nodes.and_then(|nodes| self.modes(targeted, nodes.half_band));
            statistics.note_array(modes.map_or(0, |[x, y]| x.count as u64 * y.count as u64));
        }
        Some(TileOutline {
            light,
            own,
            targeted,
            area,
            edge,
            nodes,
        })
    }

    /// Energy of the plane waves of a window under a unit plane wave.
    pub(crate) fn unit(&self) -> f64 {
        let WindowShape { step, period, .. } = self.shape;
        step.powi(4) / (period * period * std::f64::consts::PI)
    }

    pub(crate) fn k(&self) -> f64 {
        self.hop.wavenumber()
    }

    /// Half the diagonal of the light under a tile.
    pub(crate) fn far(&self) -> f64 {
        let side = self.settings.tile as f64 * self.shape.step + 2.0 * REACH;
        side * self.shape.sigma * std::f64::consts::FRAC_1_SQRT_2
    }

    /// How far the curvature of what leaves changes from a tile to the next ones, as the root mean square over both axes, in 1/mm.
    /// How that of beamlets that arrive changes is not known.
    fn curvature_change(&self, light: &TileLight, own: &Carrier) -> f64 {
        let leaving = light.carrier.times(own.p, own.q);
        let next = self.settings.tile as f64 * self.shape.step * self.shape.sigma;
        let phase = self.element.phase();
        let [x, y] = own.at;
        let squares = [[x + next, y], [x, y + next]].map(|at| {
            let own = phase.carrier(at, self.far(), self.k());
            let there = light
                .carrier_about(at, phase.within(at))
                .times(own.p, own.q);
            there.curvature_change(&leaving).powi(2)
        });
        (0.5 * (squares[0] + squares[1])).sqrt()
    }

    /// The light under a tile, with its carrier; nothing where it is dark.
    fn light_under(&self, tile: &Tile) -> Option<TileLight<'a>> {
        let centres = self.tiling.centres(tile);
        let sigma = self.shape.sigma;
        let block = WindowBlock {
            centres,
            sigma,
            threshold: self.settings.threshold,
            bright: 0.0,
        };
        let half = 0.5 * (centres[1] - centres[0]).max(centres[3] - centres[2]);
        let area = grown(centres, REACH * sigma);
        let open = |at| self.element.phase().within(at);
        self.light.under(&block, area, half + sigma, open)
    }

    /// A window's carrier, and the directions that lead from it to the target; nothing where none does.
    fn targeted(
        &self,
        lit: LitWindow,
        leaving: &Carrier,
        light: &TileLight,
        own: &Carrier,
    ) -> Option<TargetedWindow> {
        let LitWindow {
            window,
            at,
            edge,
            depth,
        } = lit;
        let phase = self.element.phase();
        let arrived = light.beside(phase.within(at));
        let added = phase.beside(own, self.far(), at, self.k());
        let shift = [0, 1].map(|a| arrived[a] + added[a]);
        let start = ChirpedStart {
            carrier: leaving.about(at).times(shift, [0.0; 3]),
            sigma: self.shape.sigma,
        };
        let band = self.window_half_band();
        let own = [0, 1].map(|a| light.spread.largest[a] + shift[a].abs() + band);
        let found = directions_onward(self.hop, &start, self.target, self.onward, own)?;
        Some(TargetedWindow {
            window,
            start,
            edge,
            depth,
            shift,
            directions: found.bounds,
            landing: found.landing,
        })
    }

    /// Half the band of a window itself.
    pub(crate) fn window_half_band(&self) -> f64 {
        let WindowShape { step, sigma, .. } = self.shape;
        window_half_band(step, self.settings.threshold) / (self.k() * sigma)
    }

    /// The samples of a tile's light, and what its element needs to know.
    fn area(&self, tile: &Tile, light: &TileLight, targeted: &[TargetedWindow]) -> TileArea {
        let (k, sigma) = (self.k(), self.shape.sigma);
        let window = self.window_half_band();
        let half_band = light.spread.largest.map(|spread| spread + window);
        let pitch = half_band.map(|band| sample_pitch(band, self.hop.wavelength));
        TileArea {
            bounds: grown(self.tiling.centres(tile), SEEN * sigma),
            samples: self.tiling.samples(tile, pitch),
            half_band,
            edge_pitch: sigma / self.settings.edge_nodes,
            pixel_part: PIXEL_PART * sigma,
            part_error: PART_ERROR * self.settings.dropped.unwrap_or(self.settings.threshold),
            spread: light.spread.usual,
            reach: reach_of(targeted, self.settings.seen_edge()),
            k,
            values_allowed: self.settings.values_allowed() as f64,
        }
    }

    /// The plane waves of a window to be computed; nothing where no direction of the light leads to the target.
    pub(crate) fn modes(
        &self,
        targeted: &TargetedWindow,
        half_band: Option<[f64; 2]>,
    ) -> Option<[Modes; 2]> {
        let spacing = self.hop.wavelength / (self.shape.period * self.shape.sigma);
        let modes = [0, 1].map(|a| {
            let limit = half_band.map_or(f64::INFINITY, |band| band[a]);
            let low = targeted.directions[2 * a].max(-limit - targeted.shift[a]);
            let high = targeted.directions[2 * a + 1].min(limit - targeted.shift[a]);
            Modes::between(low, high, spacing, targeted.shift[a])
        });
        modes.iter().all(|modes| modes.count > 0).then_some(modes)
    }

    /// The light under a window of a tile.
    pub(crate) fn window_light(&self, plan: &TilePlan, targeted: &TargetedWindow) -> WindowLight {
        let positions = &self.tiling.positions;
        let window = targeted.window;
        WindowLight::new(positions, &plan.samples, window, &plan.carriers, self.k())
    }

    /// Plans a window of a tile; nothing where no direction of its light leads to the target.
    pub(crate) fn window(&self, plan: &TilePlan, targeted: &TargetedWindow) -> Option<WindowPlan> {
        let (_, element) = plan.element(targeted)?;
        let modes = self.modes(targeted, element.half_band)?;
        let at = targeted.start.carrier.at;
        let light = self.window_light(plan, targeted);
        let samples = light.lines(&plan.samples);
        let reach = REACH * self.shape.sigma;
        let lines = [0, 1].map(|a| NodeLine {
            axis: &element.nodes[a],
            range: nodes_within(&element.nodes[a], at[a] - reach, at[a] + reach),
            filter: element.filter[a],
        });
        let nodes = match element.at_samples {
            true => samples.map(|line| line.range),
            false => lines.map(|line| line.range),
        };
        if nodes.iter().any(|(low, high)| low >= high) {
            return None;
        }
        let lines = (!element.at_samples).then_some([&lines[0], &lines[1]]);
        let modes_of = [&modes[0], &modes[1]];
        let transform = WindowTransform::new([&samples[0], &samples[1]], lines, modes_of);
        Some(WindowPlan {
            transform,
            light,
            nodes,
            modes,
        })
    }
}

impl TilePlan<'_> {
    /// The element as a window sees it, and its place in the list.
    pub(crate) fn element(&self, targeted: &TargetedWindow) -> Option<(usize, &ElementSamples)> {
        let place = usize::from(targeted.edge != EdgeContact::Inside);
        Some((place, self.elements[place].as_ref()?))
    }
}

impl WindowPlan {
    /// The transmission under the window.
    fn transmission<'a>(&self, element: &'a ElementSamples) -> Option<ArrayView2<'a, Complex64>> {
        let [x, y] = self.nodes;
        let values = element.values.as_ref()?;
        Some(part(values.view(), y.0..y.1, x.0..x.1))
    }

    /// The plane waves of the window, [m_y, m_x], from the light at the samples of its tile.
    pub(crate) fn apply(
        &self,
        values: &Array2<Complex64>,
        element: &ElementSamples,
    ) -> Array2<Complex64> {
        let through = self.transmission(element);
        self.transform.apply(&self.light.windowed(values), through)
    }

    /// The conjugate transpose: adds to the cotangents of the light at the samples, and of the transmission.
    pub(crate) fn apply_adjoint(
        &self,
        values: &Array2<Complex64>,
        element: &ElementSamples,
        waves_bar: &Array2<Complex64>,
        values_bar: &mut Array2<Complex64>,
        element_bar: &mut Array2<Complex64>,
    ) {
        let through = self.transmission(element);
        let (light_bar, through_bar) =
            self.transform
                .apply_adjoint(&self.light.windowed(values), through, waves_bar);
        let [x, y] = self.nodes;
        let mut under = part(element_bar.view_mut(), y.0..y.1, x.0..x.1);
        under += &through_bar;
        self.light.windowed_adjoint(&light_bar, values_bar);
    }
}

/// Largest direction beside the arriving light's that leads to the target from one of some windows, of those with an edge within
/// `seen` (in σ) of their centres: what an edge farther away sends in directions that usual nodes leave out does not count.
fn reach_of(targeted: &[TargetedWindow], seen: f64) -> [f64; 2] {
    let near = |targeted: &&TargetedWindow| {
        targeted.edge == EdgeContact::Inside || targeted.depth.abs() < seen
    };
    [0, 1].map(|a| {
        let furthest = |targeted: &TargetedWindow| {
            let sides = [targeted.directions[2 * a], targeted.directions[2 * a + 1]];
            sides.map(f64::abs).into_iter().fold(0.0, f64::max) + targeted.shift[a].abs()
        };
        targeted
            .iter()
            .filter(near)
            .map(furthest)
            .fold(0.0, f64::max)
    })
}

/// Points of a lattice.
fn count([x, y]: &[Axis; 2]) -> u64 {
    (x.len() as u64).saturating_mul(y.len() as u64)
}

/// A box with a margin around it.
pub(crate) fn grown([x0, x1, y0, y1]: [f64; 4], margin: f64) -> [f64; 4] {
    [x0 - margin, x1 + margin, y0 - margin, y1 + margin]
}

#[cfg(test)]
mod tests {
    use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
    use crate::engine::local_bands::tile_plan::{TargetedWindow, reach_of};
    use crate::wave::local_bands::carrier::Carrier;
    use crate::wave::local_bands::tiling::EdgeContact;

    /// A window three σ outside an edge has little light to send far. Its directions asked for nodes so fine that a lens of
    /// many aspheres took five times as long at a target of 1e-2.
    #[test]
    fn a_window_far_outside_an_edge_asks_for_no_finer_nodes() {
        let window = |edge, depth, reach: f64| TargetedWindow {
            window: [0; 2],
            start: ChirpedStart {
                carrier: Carrier {
                    at: [0.0; 2],
                    p: [0.0; 2],
                    q: [0.0; 3],
                },
                sigma: 0.05,
            },
            edge,
            depth,
            shift: [0.0; 2],
            directions: [-reach, reach, -reach, reach],
            landing: [1.0; 2],
        };
        let inside = || window(EdgeContact::Inside, 6.0, 0.02);
        let far = window(EdgeContact::Cut, -3.0, 0.3);
        assert_eq!(reach_of(&[inside(), far], 2.5), [0.02; 2]);
        let near = window(EdgeContact::Cut, -1.0, 0.3);
        assert_eq!(reach_of(&[inside(), near], 2.5), [0.3; 2]);
    }
}
