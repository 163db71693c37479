//! The source paper's own method: random patches, drawn modes, plain plane waves.
//!
//! At random positions a square patch of the field is transformed with zeros around it; of its modes a
//! given number is drawn with probability π ∝ |c|, with replacement; each drawn mode is a ray that
//! brings an infinite plane wave of amplitude c/(Nπ). In free space the sum is an unbiased estimate of
//! the field, within the modes of the lattice and the copies of its period. Behind surfaces with power
//! it is not: plane wavelets need a prefactor there, which this method does not have.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::beamlets::Planner;
use crate::engine::fan::explore;
use crate::engine::tally::{Fate, Tally};
use crate::math::draw::draw;
use crate::math::random::pair;
use crate::optics::ray::Loss;
use crate::optics::screen::Act;
use crate::optics::system::Hop;
use crate::wave::field::Field;
use crate::wave::patch::Band;
use crate::wave::plane::{PlaneSum, PlaneWave};
use crate::wave::tile::TileCutter;

/// What is drawn, and from what.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperPlan {
    /// Number of random positions.
    pub positions: usize,
    /// Modes drawn at each.
    pub secondary: usize,
    /// Where positions are drawn, `[x_min, x_max, y_min, y_max]` in mm.
    pub area: [f64; 4],
    /// Side of the square patch, in mm.
    pub side: f64,
    /// Its period, in mm.
    pub period: f64,
    /// Lattice of modes along x and y; those that do not propagate are never drawn.
    pub bands: [Band; 2],
    /// Whether each wave is multiplied by the cosine of its direction on the receiving screen.
    pub obliquity: bool,
    /// Largest optical direction cosines on the receiving screen, along x and y.
    pub arriving: [f64; 2],
}

/// Where the random numbers of a hop are found.
#[derive(Clone, Copy, Debug)]
pub struct Address {
    /// Seed of the run.
    pub seed: u64,
    /// Number of the hop.
    pub hop: u32,
}

/// What random numbers are drawn for.
const POSITION: u32 = 1;
const MODE: u32 = 2;

/// Rays of a chunk: the unit of the sum.
const CHUNK: usize = 1 << 19;

impl PaperPlan {
    /// The plan that the knobs ask for.
    pub fn new(planner: &Planner) -> Self {
        let (hop, knobs) = (planner.hop, &planner.settings.paper);
        let [x0, x1, y0, y1] = planner.from;
        let side = knobs.patch.unwrap_or(0.25 * (x1 - x0).min(y1 - y0));
        let period = side * knobs.padding.max(1.0);
        let beside = if knobs.inside { 0.0 } else { 0.5 * side };
        let plan = Self {
            positions: knobs.rays,
            secondary: knobs.secondary,
            area: [x0 - beside, x1 + beside, y0 - beside, y1 + beside],
            side,
            period,
            bands: lattice(planner, side, period),
            obliquity: knobs.obliquity,
            arriving: [0.0; 2],
        };
        Self {
            arriving: plan.reach(hop),
            ..plan
        }
    }

    /// The largest direction cosines on arrival, from a coarse set of positions and modes.
    fn reach(&self, hop: &Hop) -> [f64; 2] {
        let [x0, x1, y0, y1] = self.area;
        let between = |low: f64, high: f64, i: usize, n: usize| {
            low + (high - low) * i as f64 / (n - 1) as f64
        };
        let ends = |a: usize| {
            let band = &self.bands[a];
            [band.at(0), band.at(band.count.max(1) - 1)]
        };
        let ([px0, px1], [py0, py1]) = (ends(0), ends(1));
        let mut reach = [0.0f64; 2];
        for place in 0..25 {
            let at = [between(x0, x1, place % 5, 5), between(y0, y1, place / 5, 5)];
            for mode in 0..225 {
                let p = [
                    between(px0, px1, mode % 15, 15),
                    between(py0, py1, mode / 15, 15),
                ];
                if let Ok(landing) = hop.trace(at, p, &mut ()) {
                    reach = [0, 1].map(|a| reach[a].max(landing.cosines[a].abs()));
                }
            }
        }
        reach
    }
}

/// The modes of a patch: those of the FFT of its pixels, as many bands of it as asked for; without
/// pixels those that lead to the target. Never beyond the index.
fn lattice(planner: &Planner, side: f64, period: f64) -> [Band; 2] {
    let hop = planner.hop;
    let pixels = match &hop.from.act {
        Act::Doe(doe) => doe.pixels(),
        Act::Stop(_) | Act::Sensor(_) => None,
    };
    let Some(pixels) = pixels else {
        let fan = explore(hop, planner.from, planner.to, [side; 2]);
        return planner.bands(&fan, period);
    };
    let n = hop.from.index;
    [0, 1].map(|a| {
        let orders = planner.settings.paper.orders.max(1) as f64;
        let half = 0.5 * orders * hop.wavelength / pixels.pitch[a];
        let centre = planner.light.anchor[a];
        let (low, high) = ((centre - half).max(-n), (centre + half).min(n));
        // Like an FFT's, the band holds one of its two ends.
        let spacing = hop.wavelength / period;
        Band::between(centre, spacing, low, high - 1e-9 * spacing)
    })
}

/// A drawn mode: its indices, how often it was drawn, and its share of the patch's field.
struct Drawn {
    mode: [usize; 2],
    amplitude: Complex64,
    energy: f64,
}

/// One hop being carried.
struct Carrier<'a> {
    hop: Hop<'a>,
    plan: &'a PaperPlan,
    address: Address,
    field: &'a Field,
    cutter: TileCutter,
    /// One over the number of patches that are expected to cover a point.
    share: f64,
}

/// Adds what drawn rays bring to the receiving screen. Runs in chunks on the current rayon pool; the sum
/// has the same bits for any number of threads.
pub fn carry(
    hop: Hop,
    plan: &PaperPlan,
    address: Address,
    field: &Field,
    to: &mut PlaneSum,
    progress: &(dyn Fn(f64) + Sync),
) -> Tally {
    let axes = [&field.grid.x, &field.grid.y];
    let cutter = TileCutter::new(
        axes,
        &plan.bands,
        hop.wavenumber(),
        [plan.side, plan.period],
    );
    let [x0, x1, y0, y1] = plan.area;
    let carrier = Carrier {
        hop,
        plan,
        address,
        field,
        cutter,
        share: (x1 - x0) * (y1 - y0) / (plan.positions as f64 * plan.side * plan.side),
    };
    let chunk = (CHUNK.max(to.samples()) / plan.secondary.max(1)).max(1);
    let mut tally = Tally::default();
    for first in (0..plan.positions).step_by(chunk) {
        let last = plan.positions.min(first + chunk);
        let parts: Vec<(Vec<PlaneWave>, Tally)> = (first..last)
            .into_par_iter()
            .map(|patch| carrier.spread(patch as u32, to))
            .collect();
        let mut waves = Vec::new();
        for (part, counts) in parts {
            waves.extend(part);
            tally.merge(&counts);
        }
        to.add(&waves);
        progress(last as f64 / plan.positions as f64);
    }
    tally
}

impl Carrier<'_> {
    /// The plane waves of one random patch.
    fn spread(&self, patch: u32, to: &PlaneSum) -> (Vec<PlaneWave>, Tally) {
        let Address { seed, hop } = self.address;
        let [u, v] = pair(seed, [hop, patch, 0, POSITION]);
        let [x0, x1, y0, y1] = self.plan.area;
        let at = [x0 + (x1 - x0) * u, y0 + (y1 - y0) * v];
        let spectrum = self.cutter.cut(self.field, at);
        let drawn = self.draw(&spectrum, patch);

        let mut tally = Tally::default();
        let mut waves = Vec::new();
        for Drawn {
            mode: [my, mx],
            amplitude,
            energy,
        } in drawn
        {
            let p = [self.plan.bands[0].at(mx), self.plan.bands[1].at(my)];
            let fate = match self.follow(at, p) {
                Ok(mut wave) => {
                    wave.amplitude *= amplitude * self.share;
                    waves.push(wave);
                    if to.contains(wave.at) {
                        Fate::Arrived
                    } else {
                        Fate::Outside
                    }
                }
                Err(loss) => Fate::Lost(loss),
            };
            tally.count(fate, energy);
        }
        (waves, tally)
    }

    /// Draws modes with probability ∝ |c|; equal draws become one ray.
    fn draw(&self, spectrum: &ndarray::Array2<Complex64>, patch: u32) -> Vec<Drawn> {
        let [bx, by] = &self.plan.bands;
        let n = self.hop.from.index;
        let weight = |((my, mx), c): ((usize, usize), &Complex64)| {
            if bx.at(mx).hypot(by.at(my)) < n {
                c.norm()
            } else {
                0.0
            }
        };
        let weights: Vec<f64> = spectrum.indexed_iter().map(weight).collect();
        let Address { seed, hop } = self.address;
        let mut numbers: Vec<f64> = (0..self.plan.secondary.div_ceil(2) as u32)
            .flat_map(|sample| pair(seed, [hop, patch, sample, MODE]))
            .take(self.plan.secondary)
            .collect();
        let total: f64 = weights.iter().sum();
        let each = total / self.plan.secondary as f64;
        draw(&weights, &mut numbers)
            .into_iter()
            .map(|(index, count)| {
                // count·c/(Nπ) with π = |c|/total.
                let mode = [index / bx.count, index % bx.count];
                let (c, size) = (spectrum[mode], weights[index]);
                Drawn {
                    mode,
                    amplitude: c / size * (f64::from(count) * each),
                    energy: f64::from(count) * each * size,
                }
            })
            .collect()
    }

    /// Follows one ray to the receiving screen, wherever it lands.
    fn follow(&self, at: [f64; 2], p: [f64; 2]) -> Result<PlaneWave, Loss> {
        let landing = self.hop.trace(at, p, &mut ())?;
        let phase = Complex64::cis(self.hop.wavenumber() * landing.path);
        let [px, py] = landing.cosines;
        let n = self.hop.to.index;
        let size = if self.plan.obliquity {
            (1.0 - (px * px + py * py) / (n * n)).max(0.0).sqrt()
        } else {
            1.0
        };
        Ok(PlaneWave {
            at: landing.at,
            cosines: landing.cosines,
            amplitude: phase * size,
        })
    }
}
