//! The source paper's own method: patches anywhere, drawn modes, plain plane waves.
//!
//! At each position a square patch of the field is transformed with zeros around it; of its modes c a
//! given number N is drawn with probability π; each drawn mode is a ray that brings an infinite plane
//! wave of amplitude c/(Nπ). In free space the sum is an unbiased estimate of the field, within the modes
//! of the lattice and the copies of its period. Behind surfaces with power it is not: plane wavelets need
//! a prefactor there, which this method does not have.

use std::ops::Range;

use ndarray::{Array2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::error::tally::{Fate, Tally};
use crate::engine::monte_carlo::paper_plan::{DrawAddress, PaperPlan};
use crate::engine::monte_carlo::tangent_patch::TangentPatch;
use crate::engine::plan::settings::{Density, Sag, Sampler};
use crate::engine::progress::{Cancelled, ShareDone};
use crate::engine::ray_block::hop_rays::{HopRays, LandingColumns};
use crate::math::draw::{draw, inclusion, systematic};
use crate::math::hilbert::hilbert_order;
use crate::math::lanes::phasors;
use crate::math::random::{Purpose, pair, uniform};
use crate::optics::system::Hop;
use crate::wave::beamlet::plane::{PlaneSum, PlaneWave};
use crate::wave::grid::field::Field;
use crate::wave::grid::heights::Heights;
use crate::wave::patches::tile::{TileCutter, TileWindow};

/// Rays of a chunk: the unit of the sum.
const CHUNK: usize = 1 << 19;

/// Rays of a chunk at most, however large the receiving screen: they take some 100 bytes each.
const LARGEST_CHUNK: usize = 1 << 22;

/// Sums of windows below this count as no patch.
const DARK: f64 = 1e-9;

/// Batches whose differences give the standard error.
const BATCHES: usize = 16;

/// A drawn mode: its indices, its amplitude over the number of draws, and its share of the energy.
struct Drawn {
    mode: [usize; 2],
    amplitude: Complex64,
    energy: f64,
}

/// A hop by drawn rays, with its plan.
pub struct PaperRun<'a> {
    hop: Hop<'a>,
    plan: &'a PaperPlan,
    address: DrawAddress,
    /// The field, divided by its coverage where the plan says so.
    field: Field,
    heights: Option<Heights>,
    cutter: TileCutter,
    /// Modes along Hilbert's curve.
    order: Vec<usize>,
    /// Which modes propagate from a plane screen, where it is the same everywhere.
    propagates: Option<Vec<bool>>,
    share: f64,
}

/// The sum of the windows over each node of a grid of this shape; the last row and column lie beyond it.
pub fn window_coverage(
    hop: &Hop,
    plan: &PaperPlan,
    address: DrawAddress,
    cutter: &TileCutter,
    [ny, nx]: [usize; 2],
) -> Array2<f64> {
    let mut coverage = Array2::zeros((ny + 1, nx + 1));
    for patch in 0..plan.positions {
        let at = plan.place(patch as u32, address);
        if TangentPatch::new(hop.from, at, plan.along).is_none() {
            continue;
        }
        match plan.window {
            TileWindow::Rectangle => mark(&mut coverage, &cutter.nodes(at)),
            TileWindow::Hann => lay(&mut coverage, cutter, at),
        }
    }
    if plan.window == TileWindow::Rectangle {
        for axis in [0, 1] {
            coverage.accumulate_axis_inplace(Axis(axis), |before, here| *here += before);
        }
    }
    coverage
}

/// Adds a rectangle, as the second difference that it has.
fn mark(coverage: &mut Array2<f64>, [x, y]: &[Range<usize>; 2]) {
    for (j, i, step) in [
        (y.start, x.start, 1.0),
        (y.start, x.end, -1.0),
        (y.end, x.start, -1.0),
        (y.end, x.end, 1.0),
    ] {
        coverage[[j, i]] += step;
    }
}

/// Adds the window about a point to the nodes that it has.
fn lay(coverage: &mut Array2<f64>, cutter: &TileCutter, at: [f64; 2]) {
    let [x, y] = cutter.nodes(at);
    for j in y {
        for i in x.clone() {
            let [along_x, along_y] = cutter.window(at, [i, j]);
            coverage[[j, i]] += along_x * along_y;
        }
    }
}

/// Which modes of a patch propagate, row by row.
fn propagating(plan: &PaperPlan, tangent_patch: &TangentPatch) -> Vec<bool> {
    let [bx, by] = &plan.bands;
    let row = |my: usize| {
        (0..bx.count).map(move |mx| tangent_patch.cosines([bx.at(mx), by.at(my)]).is_some())
    };
    (0..by.count).flat_map(row).collect()
}

/// Sums over equal, independent batches.
#[derive(Default)]
struct Spread {
    count: usize,
    /// Σ|f|² of the batches f, and |F|² of their sum, at each sample.
    sums: Option<[Array2<f64>; 2]>,
}

impl Spread {
    /// Takes note of one batch, given what was summed before and after it.
    fn add(&mut self, before: &Array2<Complex64>, after: &Array2<Complex64>) {
        self.count += 1;
        let zeros = || [0; 2].map(|_| Array2::zeros(after.raw_dim()));
        let [squares, total] = self.sums.get_or_insert_with(zeros);
        ndarray::Zip::from(squares)
            .and(total)
            .and(before)
            .and(after)
            .for_each(|square, total, b, a| {
                *square += (a - b).norm_sqr();
                *total = a.norm_sqr();
            });
    }

    /// Variance of the field at each sample, and Σ|U|², of the sum over `batches` of them: Σ|f − F/B|² over
    /// B batches f of sum F has the mean (B − 1)·var(f).
    fn finish(self, batches: f64) -> Option<(Array2<f64>, f64)> {
        let count = self.count as f64;
        let [squares, total] = self.sums.filter(|_| count > 1.0)?;
        let size = batches / count;
        let square = total.sum() * size * size;
        let each = (squares - total / count) / (count - 1.0);
        Some((each * batches, square))
    }
}

impl<'a> PaperRun<'a> {
    /// A run from the field behind the first screen; `address` is the address of the random numbers of the hop.
    pub fn new(hop: Hop<'a>, plan: &'a PaperPlan, address: DrawAddress, field: &Field) -> Self {
        let axes = [&field.grid.x, &field.grid.y];
        let cutter = TileCutter::new(axes, &plan.bands, hop.wavenumber(), &plan.tile());
        let order = match plan.sampler {
            Sampler::Systematic => hilbert_order([plan.bands[0].count, plan.bands[1].count]),
            Sampler::Multinomial | Sampler::All => Vec::new(),
        };
        let mut run = Self {
            hop,
            plan,
            address,
            field: field.clone(),
            heights: (!hop.from.is_plane()).then(|| Heights::on(hop.from, &field.grid)),
            cutter,
            order,
            propagates: TangentPatch::new(hop.from, [0.0; 2], plan.along)
                .filter(|_| hop.from.is_plane())
                .map(|tangent_patch| propagating(plan, &tangent_patch)),
            share: plan.share(),
        };
        if plan.coverage {
            run.divide();
        }
        run
    }

    /// Adds what drawn rays bring to the receiving screen. Runs in chunks on the current rayon pool; the sum
    /// has the same bits for any number of threads. The tally holds the standard error where positions are
    /// independent.
    ///
    /// # Errors
    /// When `progress` cancels the work.
    pub fn carry(&self, to: &mut PlaneSum, progress: &ShareDone) -> Result<Tally, Cancelled> {
        let plan = self.plan;
        let most = CHUNK.max(to.samples()).min(LARGEST_CHUNK);
        let chunk = (most / plan.rays_each().max(1)).max(1);
        let mut tally = Tally::default();
        let mut spread = Spread::default();
        let size = match plan.is_independent() && plan.positions > 1 {
            true => plan.positions.div_ceil(BATCHES),
            false => plan.positions.max(1),
        };
        for start in (0..plan.positions).step_by(size) {
            let end = plan.positions.min(start + size);
            let before = (size < plan.positions).then(|| to.values().clone());
            for first in (start..end).step_by(chunk) {
                let last = end.min(first + chunk);
                self.add(first..last, to, &mut tally);
                Cancelled::check(progress(last as f64 / plan.positions as f64))?;
            }
            // Batches of one size are compared; a shorter last one is left out.
            if let Some(before) = before
                && end - start == size
            {
                spread.add(&before, to.values());
            }
        }
        if let Some((variance, square)) = spread.finish(plan.positions as f64 / size as f64) {
            tally.sampling = Some([variance.sum(), square]);
            tally.noise = Some(variance.mapv(|v| v.max(0.0).sqrt()));
        }
        Ok(tally)
    }

    /// Divides the field by the sum of the windows over each node; what none covers stays dark.
    fn divide(&mut self) {
        let shape = self.field.grid.shape();
        let coverage = window_coverage(&self.hop, self.plan, self.address, &self.cutter, shape);
        for ((j, i), value) in self.field.values.indexed_iter_mut() {
            let over = coverage[[j, i]];
            *value = if over > DARK {
                *value / over
            } else {
                Complex64::ZERO
            };
        }
        self.share = 1.0;
    }

    /// Adds what a range of patches brings.
    fn add(&self, patches: std::ops::Range<usize>, to: &mut PlaneSum, tally: &mut Tally) {
        let parts: Vec<(Vec<PlaneWave>, Tally)> = patches
            .into_par_iter()
            .map(|patch| self.spread(patch as u32, to))
            .collect();
        let mut waves = Vec::with_capacity(parts.iter().map(|(part, _)| part.len()).sum());
        for (part, counts) in parts {
            waves.extend(part);
            tally.merge(&counts);
        }
        to.add(&waves);
    }

    /// The plane waves of one patch.
    fn spread(&self, patch: u32, to: &PlaneSum) -> (Vec<PlaneWave>, Tally) {
        let mut tally = Tally::default();
        let mut waves = Vec::new();
        let at = self.plan.place(patch, self.address);
        let Some(tangent_patch) = TangentPatch::new(self.hop.from, at, self.plan.along) else {
            return (waves, tally);
        };
        let (k, bands) = (self.hop.wavenumber(), &self.plan.bands);
        let spectrum = match &self.heights {
            None => tangent_patch.cut_plane(&self.cutter, &self.field),
            Some(heights) => match self.plan.sag {
                Sag::True => tangent_patch.cut_true(&self.cutter, &self.field, heights, bands, k),
                Sag::Incident => tangent_patch.cut_incident(&self.cutter, &self.field),
                Sag::Tangent => {
                    let light = [self.plan.along, k];
                    tangent_patch.cut_tangent(&self.cutter, &self.field, heights, light)
                }
            },
        };
        let (hop, start) = tangent_patch.start(&self.hop);
        let drawn = self.draw(&spectrum, &tangent_patch, patch);
        let starts: Vec<[f64; 4]> = drawn
            .iter()
            .map(|drawn| [bands[0].at(drawn.mode[1]), bands[1].at(drawn.mode[0])])
            .map(|rates| tangent_patch.cosines(rates).unwrap_or(rates))
            .map(|[p, q]| [start[0], start[1], p, q])
            .collect();
        let mut landings = LandingColumns::default();
        HopRays::new(&hop).trace_into(&starts, &mut landings);
        let phases = self.phases(&landings.path);
        for (i, (drawn, phase)) in drawn.iter().zip(phases).enumerate() {
            let fate = match landings.lost[i] {
                None => {
                    let wave = self.wave(&landings, i, phase * (drawn.amplitude * self.share));
                    waves.push(wave);
                    if to.contains(wave.at) {
                        Fate::Arrived
                    } else {
                        Fate::Outside
                    }
                }
                Some(loss) => Fate::Lost(loss),
            };
            tally.count(fate, drawn.energy);
        }
        (waves, tally)
    }

    /// exp(ik·path) of rays; those of lost rays are not used.
    fn phases(&self, paths: &[f64]) -> Vec<Complex64> {
        let turns: Vec<f64> = paths
            .iter()
            .map(|path| path / self.hop.wavelength)
            .collect();
        let mut phases = vec![Complex64::ZERO; turns.len()];
        phasors(&turns, &mut phases);
        phases
    }

    /// Draws modes that propagate; equal draws become one ray.
    fn draw(
        &self,
        spectrum: &Array2<Complex64>,
        tangent_patch: &TangentPatch,
        patch: u32,
    ) -> Vec<Drawn> {
        let own = match &self.propagates {
            Some(_) => Vec::new(),
            None => propagating(self.plan, tangent_patch),
        };
        let weight = |(c, propagates): (&Complex64, &bool)| match self.plan.density {
            _ if !propagates => 0.0,
            Density::Amplitude => c.norm_sqr().sqrt(),
            Density::Uniform => 1.0,
        };
        let propagates = self.propagates.as_ref().unwrap_or(&own);
        let weights: Vec<f64> = spectrum.iter().zip(propagates).map(weight).collect();
        // A mode's amplitude is c over the number of times that it is expected, for each time drawn.
        let columns = self.plan.bands[0].count;
        let drawn = |index: usize, times: f64| {
            let mode = [index / columns, index % columns];
            let c = spectrum[mode];
            Drawn {
                mode,
                amplitude: c * times,
                energy: c.norm_sqr() * times,
            }
        };
        let DrawAddress { seed, hop } = self.address;
        match self.plan.sampler {
            Sampler::All => (0..weights.len())
                .filter(|index| weights[*index] > 0.0)
                .map(|index| drawn(index, 1.0))
                .collect(),
            Sampler::Systematic => {
                let expected = inclusion(&weights, self.plan.secondary);
                let offset = uniform(seed, [hop, patch, 0, Purpose::PatchMode as u32]);
                systematic(&expected, &self.order, offset)
                    .into_iter()
                    .map(|index| drawn(index, 1.0 / expected[index]))
                    .collect()
            }
            Sampler::Multinomial => {
                let each = weights.iter().sum::<f64>() / self.plan.secondary as f64;
                draw(&weights, &self.numbers(patch))
                    .into_iter()
                    .map(|(index, count)| drawn(index, f64::from(count) * each / weights[index]))
                    .collect()
            }
        }
    }

    /// The random numbers of a patch, one for each draw.
    fn numbers(&self, patch: u32) -> Vec<f64> {
        let DrawAddress { seed, hop } = self.address;
        (0..self.plan.secondary.div_ceil(2) as u32)
            .flat_map(|sample| pair(seed, [hop, patch, sample, Purpose::PatchMode as u32]))
            .take(self.plan.secondary)
            .collect()
    }

    /// What a ray of this amplitude brings to the receiving screen, wherever it lands.
    fn wave(&self, landings: &LandingColumns, ray: usize, amplitude: Complex64) -> PlaneWave {
        let [at, cosines] =
            [&landings.at, &landings.cosines].map(|columns| [columns[0][ray], columns[1][ray]]);
        let [px, py] = cosines;
        let n = self.hop.to.index;
        let size = if self.plan.obliquity {
            (1.0 - (px * px + py * py) / (n * n)).max(0.0).sqrt()
        } else {
            1.0
        };
        PlaneWave {
            at,
            cosines,
            amplitude: size * amplitude,
        }
    }
}
