//! The transmission of an element at the nodes of one tile, divided by the carrier that its smooth phase has there.

use std::f64::consts::FRAC_PI_2;

use ndarray::Array2;
use num_complex::Complex64;

use crate::optics::aperture::{Aperture, Outline};
use crate::optics::doe::Layer;
use crate::optics::pixels::pixel_grid::{PixelForm, Pixels};
use crate::optics::screen::{Screen, ScreenKind};
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::edge_mask::{PASSBAND, REACH};
use crate::wave::local_bands::element_phase::{ElementPhase, TileArea, is_phase};
use crate::wave::local_bands::fourier_axis::CellFilter;
use crate::wave::local_bands::open_nodes::OpenNodes;
use crate::wave::local_bands::pixel_parts::{NODES_OF_PART, gapped_cell};
use crate::wave::local_bands::reused_array;

/// An element, or the aperture of a stop, as local bands see it.
#[derive(Clone, Debug)]
pub(crate) struct Element<'a> {
    pub(super) phase: ElementPhase<'a>,
    pub(super) pixels: Option<&'a Pixels>,
}

/// Where the transmission of an element is sampled.
pub(crate) struct ElementNodes {
    /// The nodes along x and y.
    pub axes: [Axis; 2],
    /// Whether the nodes are the samples of the arriving light.
    pub at_samples: bool,
    /// Distance from the place of the carrier within which singular points of the phase are those of the tile, in mm.
    pub far: f64,
    /// What cells do along x and y.
    pub filter: [CellFilter; 2],
    /// Half the band of the light behind the element; nothing where it is not limited.
    pub half_band: Option<[f64; 2]>,
}

/// The transmission at the nodes of a tile.
pub(crate) struct ElementSamples {
    /// The nodes along x and y.
    pub nodes: [Axis; 2],
    /// Whether the nodes are the samples of the arriving light.
    pub at_samples: bool,
    /// The transmission over its carrier, [y, x]; nothing where it is one.
    pub values: Option<Array2<Complex64>>,
    /// Distance from the place of the carrier within which singular points of the phase are those of the tile, in mm.
    pub far: f64,
    /// What cells do along x and y.
    pub filter: [CellFilter; 2],
    /// Half the band of the light behind the element; nothing where it is not limited.
    pub half_band: Option<[f64; 2]>,
}

impl Drop for ElementSamples {
    fn drop(&mut self) {
        self.values.take().into_iter().for_each(reused_array::keep);
    }
}

/// Band of the light of a singular point, in turns from node to node.
const CORE_BAND: f64 = 0.45;

/// How much wider that band is than what the slopes of the phase ask for.
const CORE_SPARE: f64 = 1.2;

/// Largest phase of the steepest direction from node to node where an edge cuts pixels with single nodes, in rad. A cell counts by
/// its open share, so its spectrum is wrong by a quarter of this phase.
const EDGE_PHASE: f64 = 0.3;

/// The same where a part of a pixel has two nodes along each axis. They have the first moments of what is open: if the phase across
/// the part is φ, its spectrum is wrong by up to 0.008 φ².
const EDGE_PHASE_OF_PAIRS: f64 = 0.7;

/// Where an edge cuts a transmission without pixels, nodes are at most this many times finer than usual, however far the light
/// of the edge turns.
const FINEST_EDGE: f64 = 8.0;

/// How many times finer they are where that is not enough, and however many nodes it takes.
const LEAST_FINEST_EDGE: f64 = 2.0;

/// Directions that lead to the target with the width of beamlets beside it are farther than those to itself by up to this factor.
const REACH_SPARE: f64 = 2.0;

/// Otherwise nodes of a tile at an edge are no more than this.
const MOST_EDGE_NODES: f64 = 2e6;

/// Pitches from one to its half.
const PITCHES: f64 = 4.0;

/// Most parts of a pixel along each axis that its edges ask for; the light in it may ask for more.
const MOST_PARTS: f64 = 16.0;

impl<'a> Element<'a> {
    /// The element of a screen; nothing where layers are of a kind that has no local samples.
    pub(crate) fn of(screen: &'a Screen) -> Option<Self> {
        let doe = match &screen.kind {
            ScreenKind::Stop(aperture) => {
                return Some(Self {
                    phase: ElementPhase {
                        doe: None,
                        aperture: aperture.clone(),
                    },
                    pixels: None,
                });
            }
            ScreenKind::Sensor(_) => return None,
            ScreenKind::Doe(doe) => doe,
        };
        let known = |layer: &Layer| match layer {
            Layer::Phase(_) | Layer::Pixels(_) => true,
            Layer::Sum(terms) => terms.iter().all(|(_, layers)| layers.iter().all(is_phase)),
            Layer::OnSurface(..) => false,
        };
        if !(doe.layers.iter().all(known) && doe.shares_lattice()) {
            return None;
        }
        Some(Self {
            phase: ElementPhase {
                doe: Some(doe),
                aperture: doe.aperture.clone(),
            },
            pixels: doe.pixels(),
        })
    }

    /// Its smooth phase.
    pub(crate) fn phase(&self) -> &ElementPhase<'a> {
        &self.phase
    }

    /// Its aperture.
    pub(crate) fn aperture(&self) -> &Aperture {
        &self.phase.aperture
    }

    /// Its pixels, if it has any.
    pub(crate) fn pixels(&self) -> Option<&'a Pixels> {
        self.pixels
    }

    /// The transmission at nodes of a tile over the element's own `carrier` there.
    pub(crate) fn samples(&self, nodes: ElementNodes, carrier: &Carrier, k: f64) -> ElementSamples {
        let needed = !nodes.at_samples || self.phase.doe.is_some();
        let mut samples = ElementSamples {
            values: None,
            nodes: nodes.axes,
            at_samples: nodes.at_samples,
            far: nodes.far,
            filter: nodes.filter,
            half_band: nodes.half_band,
        };
        samples.values = needed.then(|| self.values_at(&samples, carrier, k));
        samples
    }

    /// The transmission over a `carrier` at the nodes at which it was sampled: of this element in place of another.
    pub(crate) fn values_at(
        &self,
        samples: &ElementSamples,
        carrier: &Carrier,
        k: f64,
    ) -> Array2<Complex64> {
        let mut values = self.values(&samples.nodes, carrier, k, !samples.at_samples);
        self.singular_nodes(&samples.nodes, carrier.at, samples.far)
            .apply(&mut values);
        values
    }

    /// The transmission over a `carrier` at one point, as if there were no aperture.
    pub(crate) fn value_at(&self, at: [f64; 2], carrier: &Carrier, k: f64) -> Complex64 {
        self.transmission(at) * carrier.removed(at, k)
    }

    /// The nodes of a tile at which the transmission over the element's own `carrier` is to be sampled; `cut` where an edge of
    /// the aperture crosses windows of the tile.
    pub(crate) fn nodes_of(
        &self,
        area: &TileArea,
        carrier: &Carrier,
        far: f64,
        cut: bool,
    ) -> ElementNodes {
        let core = self.phase.has_core(carrier, far);
        let vortex = self.phase.has_vortex(carrier, far);
        let rough = cut && self.cuts_cells() || core;
        let band = self.phase.band(area, carrier, far);
        let share = if cut { PASSBAND } else { CORE_BAND };
        let turns = match (core, cut) {
            (true, _) => share / CORE_SPARE,
            (false, true) => share,
            (false, false) => 0.5,
        };
        let needed = [0, 1].map(|a| {
            let pitch = turns * std::f64::consts::TAU / (area.k * band[a]);
            match rough {
                true => pitch.min(self.rough_pitch(area, a, cut || vortex)),
                false => pitch,
            }
        });
        let fits = (0..2).all(|a| area.samples[a].pitch <= needed[a]);
        if !rough && self.pixels.is_none() && fits {
            return ElementNodes {
                axes: area.samples.clone(),
                at_samples: true,
                far,
                filter: [CellFilter::Points; 2],
                half_band: Some(band),
            };
        }
        // The pass band about a core is round.
        let needed = match vortex && self.pixels.is_none() {
            true => [needed[0].min(needed[1]); 2],
            false => needed,
        };
        let axes = [0, 1].map(|a| self.nodes(area, a, needed[a]));
        let filter = [self.filter(); 2];
        let limit = axes
            .each_ref()
            .map(|axis| share * std::f64::consts::TAU / (area.k * axis.pitch));
        ElementNodes {
            axes,
            at_samples: false,
            far,
            filter,
            half_band: match (self.pixels, rough) {
                (Some(_), _) => None,
                (None, true) => Some(limit),
                (None, false) => Some(band),
            },
        }
    }

    /// The pitch of nodes that an edge or a singular point asks for; `far` where its light far aside counts.
    fn rough_pitch(&self, area: &TileArea, a: usize, far: bool) -> f64 {
        if self.pixels.is_none() {
            return match far {
                true => edge_pitch(area, a),
                false => area.edge_pitch,
            };
        }
        let phase = match self.filter() {
            CellFilter::Points => EDGE_PHASE,
            CellFilter::Pairs => EDGE_PHASE_OF_PAIRS,
        };
        area.edge_pitch.min(phase / (area.k * area.reach[a]))
    }

    /// The conjugate transpose of [`Element::samples`] with respect to the pixels: their cotangents by row and column, from
    /// those of the transmission at the nodes.
    pub(crate) fn samples_adjoint(
        &self,
        samples: &ElementSamples,
        carrier: &Carrier,
        k: f64,
        bar: &Array2<Complex64>,
    ) -> Vec<([usize; 2], Complex64)> {
        let (Some(doe), Some(_)) = (self.phase.doe, self.pixels) else {
            return Vec::new();
        };
        let [columns, rows] = &samples.nodes;
        let mut open = OpenNodes::new(&self.phase.aperture, &samples.nodes, self.filter());
        let mut pixels = Vec::new();
        let mut bar = bar.clone();
        self.singular_nodes(&samples.nodes, carrier.at, samples.far)
            .apply_adjoint(&mut bar);
        for (j, bars) in bar.outer_iter().enumerate() {
            let each = bars.iter().zip(open.row(j)).enumerate();
            for (i, (bar, open)) in each.filter(|(_, (bar, _))| **bar != Complex64::ZERO) {
                let at = [columns.node(i), rows.node(j)];
                // value = transmission·removed·open
                let cell = [columns.span(i), rows.span(j)];
                let factor = carrier.removed(at, k) * open;
                doe.visit_pixels(at, cell, &mut |pixel, by| {
                    pixels.push((pixel, bar * (by * factor).conj()));
                });
            }
        }
        pixels
    }

    /// Whether the edge of the aperture cuts pixels: a rectangle along their sides does not. Without pixels it cuts the cells of
    /// any nodes.
    fn cuts_cells(&self) -> bool {
        let (Some(pixels), Outline::Rectangle { half_x, half_y }) =
            (self.pixels, &self.phase.aperture.outline)
        else {
            return true;
        };
        let counts = [pixels.values.ncols(), pixels.values.nrows()];
        [*half_x, *half_y].iter().enumerate().any(|(a, half)| {
            let cuts = |side: f64| {
                let edge = self.phase.aperture.centre[a] + side * half;
                let place = edge / pixels.pitch[a] + 0.5 * counts[a] as f64;
                let inside = 0.0 < place && place < counts[a] as f64;
                inside && (place - place.round()).abs() > 1e-6
            };
            cuts(-1.0) || cuts(1.0)
        })
    }

    /// The nodes along one axis of a tile: parts of the pixels, or equal cells over the aperture.
    fn nodes(&self, area: &TileArea, a: usize, pitch: f64) -> Axis {
        let [low, high] = area.samples[a].edges();
        if let Some(pixels) = self.pixels {
            let own = pixels.pitch[a];
            let count = [pixels.values.ncols(), pixels.values.nrows()][a];
            let half = 0.5 * count as f64;
            let first = (low / own + half).floor().clamp(0.0, count as f64);
            let last = (high / own + half).ceil().clamp(0.0, count as f64);
            let middle = (0.5 * (first + last) - half) * own;
            let side = self.phase.doe.map_or(1.0, |doe| doe.active_sides()[a]);
            let fine = (NODES_OF_PART as f64 * pitch).max(own / MOST_PARTS);
            let light = area.over_parts(a);
            let linear = match pixels.form {
                // Its own band, of samples at twice the Nyquist rate: a quarter of a turn from pixel to pixel.
                PixelForm::BandLimited => light.times_band(FRAC_PI_2 / (area.k * own)),
                PixelForm::Box | PixelForm::Point | PixelForm::Bilinear => light,
            };
            let linear = own / linear.parts(own);
            let part = area.pixel_part.min(fine).min(linear);
            let (parts, nodes) = match pixels.form {
                PixelForm::Point => (1.0, 1),
                PixelForm::Box if side < 1.0 => {
                    let cell = gapped_cell(own, side, part);
                    return Axis::of_parts((last - first) as usize, own, middle, &cell);
                }
                PixelForm::Box | PixelForm::BandLimited => ((own / part).ceil(), NODES_OF_PART),
                // A bilinear transmission has its kinks at the centres of pixels: between two parts.
                PixelForm::Bilinear => (2.0 * (0.5 * own / part).ceil(), NODES_OF_PART),
            };
            let cells = ((last - first) * parts) as usize;
            return Axis::gauss(cells, own / parts, middle, nodes);
        }
        let bounds = self
            .phase
            .aperture
            .bounds()
            .unwrap_or([low, high, low, high]);
        let beside = REACH as f64 * pitch;
        let low = low.max(bounds[2 * a] - beside);
        let high = high.min(bounds[2 * a + 1] + beside).max(low);
        let count = ((high - low) / pitch).ceil();
        Axis::uniform(count as usize, pitch, 0.5 * (low + high))
    }

    /// What the parts of cells do.
    pub(super) fn filter(&self) -> CellFilter {
        match self.pixels.map(|pixels| pixels.form) {
            Some(PixelForm::Box | PixelForm::Bilinear | PixelForm::BandLimited) => {
                CellFilter::Pairs
            }
            Some(PixelForm::Point) | None => CellFilter::Points,
        }
    }
}

/// The pitch of nodes along an axis at which the light of an edge is computed in all directions that lead to the target. It
/// has steps, so that it stays the same where a system changes a little.
pub(crate) fn edge_pitch(area: &TileArea, a: usize) -> f64 {
    let needed = area.reach[a] + area.half_band[a];
    let fine = PASSBAND * std::f64::consts::TAU / (area.k * needed);
    let usual: f64 = { area.samples.iter() }
        .map(|axis| axis.cells as f64 * axis.pitch / area.edge_pitch)
        .product();
    let finest = (area.values_allowed.min(MOST_EDGE_NODES) / usual).sqrt();
    let finest = finest.clamp(LEAST_FINEST_EDGE, FINEST_EDGE);
    let asked = area.edge_pitch / fine;
    let finer = match asked <= REACH_SPARE * finest {
        true => asked.clamp(1.0, finest),
        // Nodes that do not resolve the light need not be fine.
        false => LEAST_FINEST_EDGE,
    };
    area.edge_pitch * 2f64.powf(-(PITCHES * finer.log2()).ceil() / PITCHES)
}

/// Whether nodes of the pitch that [`edge_pitch`] gives resolve the light of an edge in all directions that lead to the target.
pub(crate) fn resolves_edge(area: &TileArea) -> bool {
    (0..2).all(|a| {
        let limit = PASSBAND * std::f64::consts::TAU / (area.k * edge_pitch(area, a));
        area.reach[a] + area.half_band[a] <= limit * (1.0 + 1e-9)
    })
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{element, pixel_layer, screen};
    use crate::optics::aperture::{Aperture, Outline};
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::profile::Profile;
    use crate::optics::pixels::pixel_grid::PixelForm;
    use crate::optics::screen::ScreenKind;
    use crate::wave::grid::field::Axis;
    use crate::wave::local_bands::element_phase::TileArea;
    use crate::wave::local_bands::element_samples::Element;

    #[test]
    fn a_rectangle_along_pixels_cuts_none() {
        let layer = || pixel_layer(noise((20, 30), 0), 0.1, PixelForm::Box);
        let rectangle = |half_x: f64, half_y: f64| Aperture {
            outline: Outline::Rectangle { half_x, half_y },
            centre: [0.0; 2],
        };
        // Of 30 × 20 pixels of 0.1: their own box, one along pixels, one through pixels, one wider than all, a disc.
        let cases = [
            (rectangle(1.5, 1.0), false),
            (rectangle(1.2, 0.7), false),
            (rectangle(1.25, 1.0), true),
            (rectangle(2.0, 2.0), false),
            (Aperture::disc(0.9), true),
        ];
        for (aperture, expected) in cases {
            let screen = screen(Frame::GLOBAL, ScreenKind::Doe(element(layer(), aperture)));
            let element = Element::of(&screen).unwrap();
            assert_eq!(element.cuts_cells(), expected);
        }
    }

    /// A line grating has pixels as long as the element: the light in them is still resolved.
    #[test]
    fn long_pixels_have_parts_over_which_light_is_linear() {
        let mut layer = pixel_layer(noise((1, 30), 0), 0.1, PixelForm::Box);
        if let Layer::Pixels(pixels) = &mut layer {
            pixels.pitch = [0.1, 9.0];
        }
        let screen = screen(
            Frame::GLOBAL,
            ScreenKind::Doe(element(layer, Aperture::disc(1.5))),
        );
        let element = Element::of(&screen).unwrap();
        let area = area();
        let own = element.phase.carrier([0.4, 0.5], 2.0, area.k);
        for cut in [false, true] {
            let nodes = element.nodes_of(&area, &own, 2.0, cut);
            for axis in &nodes.axes {
                assert!(axis.pitch <= area.pixel_part, "{cut}: {}", axis.pitch);
            }
        }
    }

    /// A tile of light beside the middle.
    fn area() -> TileArea {
        TileArea {
            bounds: [-0.2, 1.0, 0.0, 1.1],
            samples: [Axis::uniform(20, 0.09, 0.4), Axis::uniform(22, 0.08, 0.5)],
            half_band: [0.01; 2],
            edge_pitch: 0.04,
            pixel_part: 0.06,
            part_error: 1e-3,
            spread: [1e-3; 2],
            reach: [0.02; 2],
            k: 6e3,
            values_allowed: 1e6,
        }
    }

    #[test]
    fn samples_dot_product() {
        for form in [
            PixelForm::Box,
            PixelForm::Point,
            PixelForm::Bilinear,
            PixelForm::BandLimited,
        ] {
            let pixels = noise((20, 30), 0);
            let layer = pixel_layer(pixels.clone(), 0.1, form);
            let mut doe = element(layer, Aperture::disc(0.9));
            let gradient = [40.0, -20.0];
            doe.layers.push(Layer::Phase(Profile::Linear { gradient }));
            doe.layers.push(Layer::Phase(Profile::Vortex { charge: 2 }));
            let screen = screen(Frame::GLOBAL, ScreenKind::Doe(doe));
            let element = Element::of(&screen).unwrap();
            let area = area();
            let own = element.phase.carrier([0.4, 0.5], 2.0, area.k);
            let nodes = element.nodes_of(&area, &own, 2.0, true);
            let samples = element.samples(nodes, &own, area.k);
            let there = samples.values.as_ref().unwrap();
            let bar = noise(there.dim(), 1);
            let mut back: Array2<Complex64> = Array2::zeros(pixels.dim());
            for (pixel, value) in element.samples_adjoint(&samples, &own, area.k, &bar) {
                back[pixel] += value;
            }
            let inner = |a: &Array2<Complex64>, b: &Array2<Complex64>| -> Complex64 {
                a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
            };
            let (forward, reverse) = (inner(&bar, there), inner(&back, &pixels));
            assert!((forward - reverse).norm() < 1e-11, "{forward} {reverse}");
            assert!(forward.norm() > 1e-3);
        }
    }
}
