//! The source paper's own method: patches anywhere, drawn modes, plain plane waves.
//!
//! At each position a square patch of the field is transformed with zeros around it; of its modes c a
//! given number N is drawn with probability π; each drawn mode is a ray that brings an infinite plane
//! wave of amplitude c/(Nπ). In free space the sum is an unbiased estimate of the field, within the modes
//! of the lattice and the copies of its period. Behind surfaces with power it is not: plane wavelets need
//! a prefactor there, which this method does not have.

use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use ndarray::{Array2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::error::tally::Tally;
use crate::engine::monte_carlo::batch_spread::BatchSpread;
use crate::engine::monte_carlo::drawn_rays::{DrawnRays, magnitudes};
use crate::engine::monte_carlo::paper_plan::{DrawAddress, PaperPlan};
use crate::engine::monte_carlo::tangent_patch::TangentPatch;
use crate::engine::plan::settings::{Density, Sag, Sampler};
use crate::engine::progress::{Cancelled, ShareDone};
use crate::engine::ray_block::hop_rays::HopRays;
use crate::math::draw::{draw_into, inclusion, systematic};
use crate::math::hilbert::hilbert_order;
use crate::math::nufft::SortedPoints;
use crate::math::random::{Purpose, uniform, uniforms};
use crate::optics::system::Hop;
use crate::wave::beamlet::plane::PlaneSum;
use crate::wave::grid::field::Field;
use crate::wave::grid::heights::Heights;
use crate::wave::patches::tile::{CutScratch, TileCutter, TileWindow};

/// Rays of a chunk: the unit of the sum, small enough for the cache.
const CHUNK: usize = 1 << 17;

/// Rays of a chunk at most, however large the receiving screen.
const LARGEST_CHUNK: usize = 1 << 22;

/// Rays that are sorted together: enough for each tile of the sum to get some.
const GROUP: usize = 1 << 13;

/// Groups of a chunk at least, where that is possible, for the threads to share.
const GROUPS: usize = 16;

/// Sums of windows below this count as no patch.
const DARK: f64 = 1e-9;

/// Batches whose differences give the standard error.
const BATCHES: usize = 16;

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
    /// Which modes do not propagate from a plane screen, where it is the same everywhere.
    barred: Option<Vec<usize>>,
    /// The hop made ready for rays, where it is the same for all patches.
    rays: Option<HopRays<'a>>,
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

/// Which modes of a patch do not propagate, row by row.
fn barred_modes(plan: &PaperPlan, tangent_patch: &TangentPatch) -> Vec<usize> {
    let [bx, by] = &plan.bands;
    let columns = bx.count.max(1);
    let propagates = |index: &usize| {
        let rates = [bx.at(index % columns), by.at(index / columns)];
        tangent_patch.cosines(rates).is_some()
    };
    (0..bx.count * by.count)
        .filter(|index| !propagates(index))
        .collect()
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
            barred: TangentPatch::new(hop.from, [0.0; 2], plan.along)
                .filter(|_| hop.from.is_plane())
                .map(|tangent_patch| barred_modes(plan, &tangent_patch)),
            rays: hop.from.is_plane().then(|| HopRays::new(&hop)),
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
        let mut memory = Memory::default();
        let mut spread = BatchSpread::default();
        let size = match plan.is_independent() && plan.positions > 1 {
            true => plan.positions.div_ceil(BATCHES),
            false => plan.positions.max(1),
        };
        let [chunk, group] = self.steps(size, to.samples());
        for start in (0..plan.positions).step_by(size) {
            let end = plan.positions.min(start + size);
            let before = (size < plan.positions).then(|| to.values().clone());
            for first in (start..end).step_by(chunk) {
                let last = end.min(first + chunk);
                self.add(first..last, group, to, &mut memory);
                Cancelled::check(progress(last as f64 / plan.positions as f64))?;
            }
            // Batches of one size are compared; a shorter last one is left out.
            if let Some(before) = before
                && end - start == size
            {
                spread.add(&before, to.values());
            }
        }
        let mut tally = memory.tally;
        if let Some((variance, square)) = spread.finish(plan.positions as f64 / size as f64) {
            tally.sampling = Some([variance.sum(), square]);
            tally.noise = Some(variance.mapv(|v| v.max(0.0).sqrt()));
        }
        Ok(tally)
    }

    /// Patches of a chunk, and of a group of it, in batches of this size on a screen of so many samples.
    fn steps(&self, batch: usize, samples: usize) -> [usize; 2] {
        let each = self.plan.rays_each().max(1);
        let most = CHUNK.max(samples).min(LARGEST_CHUNK);
        let chunk = (most / each).max((LARGEST_CHUNK / each).min(GROUPS)).max(1);
        let group = (samples / 16).clamp(GROUP, 4 * GROUP) / each;
        [chunk, group.clamp(1, chunk.min(batch).div_ceil(GROUPS))]
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

    /// Adds what a range of patches brings, `group` of which are sorted together.
    fn add(&self, patches: Range<usize>, group: usize, to: &mut PlaneSum, memory: &mut Memory) {
        let Memory {
            spare,
            sorted,
            tally,
        } = memory;
        let groups = patches.len().div_ceil(group);
        if sorted.len() < groups {
            sorted.resize_with(groups, SortedPoints::default);
        }
        let (spare, shared, sorted) = (&*spare, &*to, &mut sorted[..groups]);
        let tallies: Vec<Tally> = sorted
            .par_iter_mut()
            .enumerate()
            .map(|(number, sorted)| {
                let mut rays = taken(spare).pop().unwrap_or_default();
                let first = patches.start + number * group;
                let found = self.bring(first..patches.end.min(first + group), &mut rays, shared);
                rays.sort(shared, sorted);
                taken(spare).push(rays);
                found
            })
            .collect();
        to.add_sorted(sorted);
        tallies.iter().for_each(|found| tally.merge(found));
    }

    /// Draws and traces the rays of some patches.
    fn bring(&self, patches: Range<usize>, rays: &mut DrawnRays, to: &PlaneSum) -> Tally {
        rays.restart();
        for patch in patches {
            self.trace(patch as u32, rays);
        }
        let mut tally = Tally::default();
        rays.drop_lost(&mut tally);
        rays.count(to, &mut tally);
        if self.plan.obliquity {
            rays.weaken(self.hop.to.index);
        }
        tally
    }

    /// The rays of one patch.
    fn trace(&self, patch: u32, rays: &mut DrawnRays) {
        let at = self.plan.place(patch, self.address);
        let Some(tangent_patch) = TangentPatch::new(self.hop.from, at, self.plan.along) else {
            return;
        };
        self.cut(&tangent_patch, &mut rays.cut);
        match &self.barred {
            Some(barred) => self.weigh(barred, rays),
            None => self.weigh(&barred_modes(self.plan, &tangent_patch), rays),
        }
        self.draw(patch, rays);
        let (hop, start) = tangent_patch.start(&self.hop);
        rays.start(&self.plan.bands, start, self.share, |rates| {
            tangent_patch.on_plane(rates)
        });
        match &self.rays {
            Some(hop) => rays.follow(hop),
            None => rays.follow(&HopRays::new(&hop)),
        }
    }

    /// The modes of one patch.
    fn cut(&self, tangent_patch: &TangentPatch, cut: &mut CutScratch) {
        let (k, bands) = (self.hop.wavenumber(), &self.plan.bands);
        let (cutter, field) = (&self.cutter, &self.field);
        match &self.heights {
            None => tangent_patch.cut_plane(cutter, field, cut),
            Some(heights) => match self.plan.sag {
                Sag::True => tangent_patch.cut_true(cutter, (field, heights), (bands, k), cut),
                Sag::Incident => tangent_patch.cut_incident(cutter, field, cut),
                Sag::Tangent => {
                    let light = [self.plan.along, k];
                    tangent_patch.cut_tangent(cutter, (field, heights), light, cut);
                }
            },
        }
    }

    /// The weight of each mode; those that do not propagate are not drawn.
    fn weigh(&self, barred: &[usize], rays: &mut DrawnRays) {
        let DrawnRays { cut, weights, .. } = rays;
        weights.resize(cut.modes.len(), 0.0);
        match self.plan.density {
            Density::Amplitude => magnitudes(&cut.modes, weights),
            Density::Uniform => weights.fill(1.0),
        }
        barred.iter().for_each(|index| weights[*index] = 0.0);
    }

    /// Draws modes; equal draws become one ray. A mode's amplitude is c over the number of times that it is expected, for
    /// each time drawn.
    fn draw(&self, patch: u32, rays: &mut DrawnRays) {
        let DrawnRays {
            weights,
            drawn,
            numbers,
            draws,
            counts,
            ..
        } = rays;
        let DrawAddress { seed, hop } = self.address;
        let address = [hop, patch, 0, Purpose::PatchMode as u32];
        drawn.clear();
        match self.plan.sampler {
            Sampler::All => {
                let kept = (0..weights.len()).filter(|index| weights[*index] > 0.0);
                drawn.extend(kept.map(|index| (index as u32, 1.0)));
            }
            Sampler::Systematic => {
                let expected = inclusion(weights, self.plan.secondary);
                let found = systematic(&expected, &self.order, uniform(seed, address));
                let found = found.into_iter();
                drawn.extend(found.map(|index| (index as u32, 1.0 / expected[index])));
            }
            Sampler::Multinomial => {
                numbers.resize(self.plan.secondary, 0.0);
                uniforms(seed, address, numbers);
                let total = draw_into(weights, numbers, draws, counts);
                let each = total / self.plan.secondary as f64;
                let times = |(index, count): &(u32, u32)| {
                    f64::from(*count) * each / weights[*index as usize]
                };
                drawn.extend(counts.iter().map(|drawn| (drawn.0, times(drawn))));
            }
        }
    }
}

/// What is kept from one chunk of patches to the next.
#[derive(Default)]
struct Memory {
    /// Rays that no thread works on.
    spare: Mutex<Vec<DrawnRays>>,
    /// The plane waves of each group of patches.
    sorted: Vec<SortedPoints>,
    tally: Tally,
}

/// The value that a lock guards, also after a panic of another thread.
fn taken<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}
