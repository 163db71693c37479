//! One tile: from the light that arrives to the beamlets that leave.

use std::ops::Range;

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;

use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::emission::{Emission, Emitted};
use crate::engine::local_bands::held_light::{ArrivingLight, TileLight};
use crate::engine::local_bands::settings::LocalBandSettings;
use crate::engine::local_bands::target::Target;
use crate::engine::local_bands::window_directions::window_directions;
use crate::math::part::part;
use crate::optics::system::Hop;
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::element_samples::{Element, ElementSamples, TileArea};
use crate::wave::local_bands::local_band::{WindowBlock, sample_pitch, window_half_band};
use crate::wave::local_bands::tiling::{Lie, REACH, Tile, Tiling, WindowShape};
use crate::wave::local_bands::window_transform::{
    Modes, NodeLine, SampleLine, WindowTransform, nodes_within,
};

/// Light that counts for the band of an element lies within this many σ of a window's centre.
const SEEN: f64 = 3.0;

/// What all tiles of a screen share.
pub(crate) struct TileRun<'a> {
    /// The hop from the screen.
    pub hop: &'a Hop<'a>,
    /// The light that arrives.
    pub light: &'a ArrivingLight<'a>,
    /// What stands there.
    pub element: &'a Element<'a>,
    /// Where its windows stand.
    pub tiling: &'a Tiling,
    /// How wide they are.
    pub shape: WindowShape,
    /// The target of the light.
    pub target: &'a Target,
    /// The settings of the run.
    pub settings: &'a LocalBandSettings,
}

/// A window that sends light to the target.
struct Aimed {
    window: [usize; 2],
    start: ChirpedStart,
    lie: Lie,
    /// Direction of its carrier beside that of the tile's.
    shift: [f64; 2],
    /// Directions that lead to the target.
    directions: [f64; 4],
}

/// What is summed and sampled once for all windows of a tile.
struct Prepared {
    samples: [Axis; 2],
    values: Array2<Complex64>,
    /// The carriers of the arriving light and of the element.
    carriers: [Carrier; 2],
    inside: Option<ElementSamples>,
    cut: Option<ElementSamples>,
}

/// The plane waves of one window.
struct Waves {
    modes: [Modes; 2],
    coefficients: Array2<Complex64>,
}

impl TileRun<'_> {
    /// The beamlets that leave a tile and reach the target.
    pub(crate) fn send(&self, tile: &Tile, emission: &Emission) -> Emitted {
        let mut out = Emitted::default();
        self.for_windows(tile, &mut out, |aimed, waves, out| {
            let modes = [&waves.modes[0], &waves.modes[1]];
            emission.send(&aimed.start, modes, &waves.coefficients, out);
        });
        out
    }

    /// Energy of the plane waves of a tile that may reach the target, in units of one window of a unit plane wave, and
    /// the number of its windows with light.
    pub(crate) fn energy(&self, tile: &Tile) -> [f64; 2] {
        let (mut out, mut energy) = (Emitted::default(), 0.0);
        self.for_windows(tile, &mut out, |_, waves, _| {
            energy += waves.coefficients.iter().map(|c| c.norm_sqr()).sum::<f64>();
        });
        [energy / self.unit(), out.account.windows as f64]
    }

    /// Energy of the plane waves of a window under a unit plane wave.
    pub(crate) fn unit(&self) -> f64 {
        let WindowShape { step, period, .. } = self.shape;
        step.powi(4) / (period * period * std::f64::consts::PI)
    }

    /// The strongest plane wave of a window under a unit plane wave.
    pub(crate) fn strongest(&self) -> f64 {
        2.0 * (self.shape.step / self.shape.period).powi(2)
    }

    /// Finds the plane waves of each window of a tile that sees the target.
    fn for_windows(
        &self,
        tile: &Tile,
        out: &mut Emitted,
        mut then: impl FnMut(&Aimed, &Waves, &mut Emitted),
    ) {
        let lit = self.tiling.lit(tile, self.element.opening());
        if lit.is_empty() {
            return;
        }
        let Some(light) = self.light_under(tile) else {
            return;
        };
        out.account.windows += lit.len() as u64;
        let own = self.element.carrier(light.carrier.at, self.far(), self.k());
        let leaving = light.carrier.times(own.p, own.q);
        let aimed: Vec<Aimed> = lit
            .into_iter()
            .filter_map(|lit| self.aim(lit, &leaving, &own))
            .collect();
        if aimed.is_empty() {
            return;
        }
        let prepared = self.prepare(tile, &light, &own, &aimed);
        out.account.largest_tile = prepared.0.values.len() as u64;
        out.account.evaluations += prepared.1;
        for aimed in &aimed {
            if let Some(waves) = self.waves(aimed, &prepared.0) {
                then(aimed, &waves, out);
            }
        }
    }

    fn k(&self) -> f64 {
        self.hop.wavenumber()
    }

    /// Half the diagonal of the light under a tile.
    fn far(&self) -> f64 {
        let side = self.settings.tile as f64 * self.shape.step + 2.0 * REACH;
        side * self.shape.sigma * std::f64::consts::FRAC_1_SQRT_2
    }

    /// The light under a tile, with its carrier; nothing where it is dark.
    fn light_under(&self, tile: &Tile) -> Option<TileLight<'_>> {
        let centres = self.tiling.centres(tile);
        let sigma = self.shape.sigma;
        let block = WindowBlock {
            centres,
            sigma,
            threshold: self.settings.threshold,
            bright: 0.0,
        };
        let half = 0.5 * (centres[1] - centres[0]).max(centres[3] - centres[2]);
        self.light
            .under(&block, grown(centres, REACH * sigma), half + sigma)
    }

    /// A window's carrier, and the directions that lead from it to the target; nothing where none does.
    fn aim(
        &self,
        (window, at, lie): ([usize; 2], [f64; 2], Lie),
        leaving: &Carrier,
        own: &Carrier,
    ) -> Option<Aimed> {
        let shift = self.element.beside(own, self.far(), at, self.k());
        let start = ChirpedStart {
            carrier: leaving.about(at).times(shift, [0.0; 3]),
            sigma: self.shape.sigma,
        };
        let directions = window_directions(self.hop, &start, self.target)?;
        Some(Aimed {
            window,
            start,
            lie,
            shift,
            directions,
        })
    }

    /// The light of a tile and the transmission of the element under it, and how many values were evaluated.
    fn prepare(
        &self,
        tile: &Tile,
        light: &TileLight,
        own: &Carrier,
        aimed: &[Aimed],
    ) -> (Prepared, u64) {
        let (k, sigma) = (self.k(), self.shape.sigma);
        let window = window_half_band(self.shape.step, self.settings.threshold) / (k * sigma);
        let half_band = light.spread.map(|spread| spread + window);
        let pitch = half_band.map(|band| sample_pitch(band, self.hop.wavelength));
        let samples = self.tiling.samples(tile, pitch);
        let (values, evaluations) = light.at(&samples);
        let area = TileArea {
            bounds: grown(self.tiling.centres(tile), SEEN * sigma),
            samples: samples.clone(),
            half_band,
            edge_pitch: sigma / self.settings.edge_nodes,
            k,
        };
        let for_lie = |lie: Lie| {
            let needed = aimed.iter().any(|aimed| aimed.lie == lie);
            needed.then(|| {
                self.element
                    .samples(&area, own, self.far(), lie == Lie::Cut)
            })
        };
        let prepared = Prepared {
            samples,
            values,
            carriers: [light.carrier, *own],
            inside: for_lie(Lie::Inside),
            cut: for_lie(Lie::Cut),
        };
        (prepared, evaluations)
    }

    /// The plane waves of a window to be computed; nothing where no direction of the light leads to the target.
    fn modes(&self, aimed: &Aimed, element: &ElementSamples) -> Option<[Modes; 2]> {
        let spacing = self.hop.wavelength / (self.shape.period * self.shape.sigma);
        let modes = [0, 1].map(|a| {
            let limit = element.half_band.map_or(f64::INFINITY, |band| band[a]);
            let low = aimed.directions[2 * a].max(-limit - aimed.shift[a]);
            let high = aimed.directions[2 * a + 1].min(limit - aimed.shift[a]);
            Modes::between(low, high, spacing, aimed.shift[a])
        });
        modes.iter().all(|modes| modes.count > 0).then_some(modes)
    }

    /// The plane waves of a window.
    fn waves(&self, aimed: &Aimed, prepared: &Prepared) -> Option<Waves> {
        let element = match aimed.lie {
            Lie::Inside => prepared.inside.as_ref()?,
            Lie::Cut | Lie::Outside => prepared.cut.as_ref()?,
        };
        let modes = self.modes(aimed, element)?;
        let at = aimed.start.carrier.at;
        let weights = [0, 1].map(|a| {
            let axis = &prepared.samples[a];
            self.tiling.positions[a].analysis(axis, aimed.window[a])
        });
        let samples = [0, 1].map(|a| SampleLine {
            axis: &prepared.samples[a],
            range: (weights[a].0.start, weights[a].0.end),
            centre: at[a],
            k: self.k(),
        });
        let reach = REACH * self.shape.sigma;
        let nodes = [0, 1].map(|a| NodeLine {
            axis: &element.nodes[a],
            range: nodes_within(&element.nodes[a], at[a] - reach, at[a] + reach),
            filter: element.filter[a],
        });
        let ranges = match element.at_samples {
            true => samples.map(|line| line.range),
            false => nodes.map(|line| line.range),
        };
        if ranges.iter().any(|(low, high)| low >= high) {
            return None;
        }
        let transform = WindowTransform::new(
            [&samples[0], &samples[1]],
            (!element.at_samples).then_some([&nodes[0], &nodes[1]]),
            [&modes[0], &modes[1]],
        );
        let light = self.windowed(prepared, &weights, at);
        let transmission = element.values.as_ref().map(|values| under(values, ranges));
        let coefficients = transform.apply(&light, transmission);
        Some(Waves {
            modes,
            coefficients,
        })
    }

    /// The light under a window times ĝ, over the carriers about its centre.
    fn windowed(
        &self,
        prepared: &Prepared,
        [x, y]: &[(Range<usize>, Vec<f64>); 2],
        at: [f64; 2],
    ) -> Array2<Complex64> {
        let view = part(prepared.values.view(), y.0.clone(), x.0.clone());
        let mut light = view.to_owned();
        let cell = prepared.samples[0].pitch * prepared.samples[1].pitch;
        let [arrived, own] = prepared.carriers.map(|c| c.removed(at, self.k()).conj());
        let carried = arrived * own / cell;
        for ((j, i), value) in light.indexed_iter_mut() {
            *value *= carried * (x.1[i] * y.1[j]);
        }
        light
    }
}

/// A box with a margin around it.
fn grown([x0, x1, y0, y1]: [f64; 4], margin: f64) -> [f64; 4] {
    [x0 - margin, x1 + margin, y0 - margin, y1 + margin]
}

/// The part of an array on ranges along x and y.
fn under(values: &Array2<Complex64>, [x, y]: [(usize, usize); 2]) -> ArrayView2<'_, Complex64> {
    part(values.view(), y.0..y.1, x.0..x.1)
}
