//! Rays of drawn modes, in columns: their starts, where they land, and what they bring.

use fearless_simd::{Simd, dispatch};
use num_complex::Complex64;

use crate::engine::error::tally::{Fate, Tally};
use crate::engine::ray_block::hop_rays::{HopRays, LandingColumns, RayStart};
use crate::math::draw::DrawScratch;
use crate::math::lanes::{LANES, Lanes};
use crate::math::nufft::SortedPoints;
use crate::math::simd_level::level;
use crate::wave::beamlet::plane::{PlaneSum, SortScratch, WaveColumns};
use crate::wave::patches::patch::Band;
use crate::wave::patches::tile::CutScratch;

/// Rays of some patches, with the memory to draw and trace others.
#[derive(Default)]
pub(crate) struct DrawnRays {
    /// The modes of the last patch.
    pub cut: CutScratch,
    /// Their weights.
    pub weights: Vec<f64>,
    /// The modes that were drawn: their indices, and the factors of their amplitudes.
    pub drawn: Vec<(u32, f64)>,
    /// The random numbers of its draws.
    pub numbers: Vec<f64>,
    /// Memory for drawing.
    pub draws: DrawScratch,
    /// The index of each drawn mode, and how often it was drawn.
    pub counts: Vec<(u32, u32)>,
    starts: Vec<RayStart>,
    /// The amplitude of each ray at its start, and its share of the energy.
    amplitudes: Vec<Complex64>,
    energies: Vec<f64>,
    landings: LandingColumns,
    order: SortScratch,
}

impl DrawnRays {
    /// Removes all rays and keeps the memory.
    pub(crate) fn restart(&mut self) {
        self.amplitudes.clear();
        self.energies.clear();
        self.landings.restart(0);
    }

    /// Lets the drawn modes start from a point. Each brings `share` of what it is multiplied by, along the cosines that
    /// belong to its rates.
    pub(crate) fn start(
        &mut self,
        [bx, by]: &[Band; 2],
        [x, y]: [f64; 2],
        share: f64,
        cosines: impl Fn([f64; 2]) -> [f64; 2],
    ) {
        let columns = bx.count.max(1) as u32;
        let [along_x, along_y] =
            [bx, by].map(|b| (0..b.count).map(|m| b.at(m)).collect::<Vec<_>>());
        let (before, count) = (self.amplitudes.len(), self.drawn.len());
        self.starts.resize(count, [0.0; 4]);
        self.amplitudes.resize(before + count, Complex64::ZERO);
        self.energies.resize(before + count, 0.0);
        let brought = self.amplitudes[before..]
            .iter_mut()
            .zip(&mut self.energies[before..]);
        let rays = self.starts.iter_mut().zip(brought);
        for ((start, (amplitude, energy)), (index, times)) in rays.zip(&self.drawn) {
            let (mx, my) = (index % columns, index / columns);
            let [p, q] = cosines([along_x[mx as usize], along_y[my as usize]]);
            let c = self.cut.modes[*index as usize];
            *start = [x, y, p, q];
            *amplitude = c * (times * share);
            *energy = c.norm_sqr() * times;
        }
    }

    /// Follows the rays that started last.
    pub(crate) fn follow(&mut self, hop: &HopRays) {
        hop.trace_more(&self.starts, &mut self.landings);
    }

    /// Counts lost rays in the tally, and removes them.
    pub(crate) fn drop_lost(&mut self, tally: &mut Tally) {
        let LandingColumns {
            at: [x, y],
            cosines: [p, q],
            path,
            lost,
        } = &mut self.landings;
        if lost.iter().all(Option::is_none) {
            return;
        }
        let mut kept = 0;
        for (i, loss) in lost.iter().enumerate() {
            if let Some(loss) = loss {
                tally.count(Fate::Lost(*loss), self.energies[i]);
                continue;
            }
            for column in [&mut *x, y, p, q, path, &mut self.energies] {
                column[kept] = column[i];
            }
            self.amplitudes[kept] = self.amplitudes[i];
            kept += 1;
        }
        for column in [x, y, p, q, path, &mut self.energies] {
            column.truncate(kept);
        }
        self.amplitudes.truncate(kept);
        lost.clear();
    }

    /// Counts rays that landed on a screen, and those beside it.
    pub(crate) fn count(&self, to: &PlaneSum, tally: &mut Tally) {
        let [x, y] = &self.landings.at;
        let (arrived, [inside, outside]) =
            dispatch!(level(), simd => landed(simd, to, [x, y], &self.energies));
        tally.count_many(Fate::Arrived, arrived, inside);
        tally.count_many(Fate::Outside, x.len() as u64 - arrived, outside);
    }

    /// Multiplies each ray by the cosine of its direction on a screen in a medium of index `n`.
    pub(crate) fn weaken(&mut self, n: f64) {
        let [p, q] = &self.landings.cosines;
        for (amplitude, (p, q)) in self.amplitudes.iter_mut().zip(p.iter().zip(q)) {
            *amplitude *= (1.0 - (p * p + q * q) / (n * n)).max(0.0).sqrt();
        }
    }

    /// Makes the waves of the rays ready for the sum.
    pub(crate) fn sort(&mut self, to: &PlaneSum, sorted: &mut SortedPoints) {
        let LandingColumns {
            at: [x, y],
            cosines: [p, q],
            path,
            ..
        } = &self.landings;
        let waves = WaveColumns {
            at: [x, y],
            cosines: [p, q],
            path,
            amplitudes: &self.amplitudes,
        };
        to.sort(&waves, &mut self.order, sorted);
    }
}

/// How many rays arrive on a screen, and the energy of those that do and of those that land beside it.
#[inline(always)]
fn landed<S: Simd>(_: S, to: &PlaneSum, [x, y]: [&[f64]; 2], energies: &[f64]) -> (u64, [f64; 2]) {
    let mut energy = [[0.0; LANES]; 2];
    let mut arrived = [0.0; LANES];
    let groups = x.chunks(LANES).zip(y.chunks(LANES));
    for ((x, y), energies) in groups.zip(energies.chunks(LANES)) {
        // Rays that are not there have no energy and no place.
        let [x, y] = [x, y].map(|column| eight(column, f64::NAN));
        let energies = eight(energies, 0.0);
        for i in 0..LANES {
            let inside = f64::from(u8::from(to.contains([x[i], y[i]])));
            arrived[i] += inside;
            energy[0][i] += energies[i] * inside;
            energy[1][i] += energies[i] * (1.0 - inside);
        }
    }
    let sum = |lanes: [f64; LANES]| lanes.iter().sum::<f64>();
    (sum(arrived) as u64, energy.map(sum))
}

/// Up to eight numbers, and `others` in the place of those that are missing.
#[inline(always)]
fn eight(numbers: &[f64], others: f64) -> Lanes {
    numbers.first_chunk().copied().unwrap_or_else(|| {
        let mut lanes = [others; LANES];
        lanes[..numbers.len()].copy_from_slice(numbers);
        lanes
    })
}

/// |c| of each mode.
pub(crate) fn magnitudes(modes: &[Complex64], sizes: &mut [f64]) {
    dispatch!(level(), simd => magnitudes_in(simd, modes, sizes));
}

#[inline(always)]
fn magnitudes_in<S: Simd>(_: S, modes: &[Complex64], sizes: &mut [f64]) {
    for (size, mode) in sizes.iter_mut().zip(modes) {
        *size = mode.norm_sqr().sqrt();
    }
}
