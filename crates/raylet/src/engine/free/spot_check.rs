//! The error of a free hop, measured: what it brought to a few points against the direct sum of samples of the
//! field there, other samples than those that were carried.
//!
//! The first Rayleigh–Sommerfeld integral knows neither periods nor tapers nor levels, so the difference is
//! what these cost, with what the samples of the run miss of edges and of steep light. The points are drawn half evenly and half by intensity, so that neither faint light over
//! the whole screen nor a bright focus escapes; each counts for the inverse of its chance.

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::math::random::{Purpose, pair};
use crate::math::vec3::Vec3;
use crate::optics::system::Hop;
use crate::wave::free::propagate::FreeHop;
use crate::wave::free::rayleigh::{Emitter, Emitters};
use crate::wave::grid::field::Field;
use crate::wave::grid::heights::Heights;
use crate::wave::grid::raster::Raster;

/// Fewest and most points, and the node–point pairs up to which more than the fewest are taken.
const POINTS: [usize; 2] = [8, 32];
const PAIRS: usize = 100_000_000;

/// Rows of nodes summed at once.
const ROWS: usize = 64;

/// Nearer than this many wavelengths of the medium the nodes do not resolve the kernel.
const NEAR: f64 = 3.0;

/// A free hop that was run.
pub(crate) struct SpotCheck<'a> {
    /// Its screens.
    pub hop: &'a Hop<'a>,
    /// How it was carried.
    pub free: &'a FreeHop,
    /// What left the first screen, on samples of its own.
    pub field: &'a Field,
    /// Where it was summed.
    pub raster: &'a Raster,
    /// What was found there, indexed [y, x].
    pub values: &'a Array2<Complex64>,
}

impl SpotCheck<'_> {
    /// The relative error of what was found; nothing through plates, very near the screen or in the dark.
    pub(crate) fn error(&self, seed: u64) -> Option<f64> {
        let wavelength = self.hop.wavelength / self.hop.from.index_behind();
        let near = self.nearest()? < NEAR * wavelength;
        let total: f64 = self.values.iter().map(|u| u.norm_sqr()).sum();
        if near || self.free.slabs.len() != 1 || total <= 0.0 {
            return None;
        }
        let drawn = self.draw(seed, total);
        let points: Vec<[f64; 3]> = drawn.iter().map(|(at, _)| self.point(*at)).collect();
        let sums = self.sums(&points, wavelength);
        let squares = drawn.iter().zip(&sums).map(|(([j, i], chance), sum)| {
            (self.values[[*j, *i]] - sum).norm_sqr() / (chance * drawn.len() as f64)
        });
        Some((squares.sum::<f64>() / total).sqrt())
    }

    /// How close the second screen comes to the first.
    fn nearest(&self) -> Option<f64> {
        let relief = self.hop.from.relief()?;
        let leaves = self.hop.from.leaves();
        let front = if leaves > 0.0 {
            relief.high
        } else {
            -relief.low
        };
        let target = self.hop.from.frame.to_local(self.hop.to.frame.origin).z;
        Some(leaves * target - front)
    }

    /// Points of the raster with the chance of each to be drawn.
    fn draw(&self, seed: u64, total: f64) -> Vec<([usize; 2], f64)> {
        let count = (PAIRS / self.field.values.len().max(1)).clamp(POINTS[0], POINTS[1]);
        let (ny, nx) = self.values.dim();
        let even = 1.0 / (nx * ny) as f64;

        // Where the intensity, added up point by point, passes what is drawn.
        let mut levels: Vec<f64> = (0..count as u32 / 2)
            .map(|n| pair(seed, [n, 0, 1, Purpose::SpotCheck as u32])[0] * total)
            .collect();
        levels.sort_by(f64::total_cmp);
        let (mut below, mut next) = (0.0, 0);
        let mut places = Vec::new();
        for (at, value) in self.values.indexed_iter() {
            below += value.norm_sqr();
            while next < levels.len() && levels[next] < below {
                places.push([at.0, at.1]);
                next += 1;
            }
        }
        let rest = count - places.len();
        places.extend((0..rest as u32).map(|n| {
            let [u, v] = pair(seed, [n, 0, 0, Purpose::SpotCheck as u32]);
            [(v * ny as f64) as usize, (u * nx as f64) as usize]
        }));
        let chance = |[j, i]: [usize; 2]| 0.5 * (even + self.values[[j, i]].norm_sqr() / total);
        places.into_iter().map(|at| (at, chance(at))).collect()
    }

    /// A point of the raster as the first screen's own light sees it, which leaves towards +z.
    fn point(&self, [j, i]: [usize; 2]) -> [f64; 3] {
        let at = |a: usize, n: usize| self.raster.start[a] + n as f64 * self.raster.pitch[a];
        let there = Vec3::new(at(0, i), at(1, j), 0.0);
        let here = self.hop.to.frame.to_global(there);
        let local = self.hop.from.frame.to_local(here);
        [local.x, local.y, local.z * self.hop.from.leaves()]
    }

    /// The direct sum at some points, a band of rows at a time and in their order.
    fn sums(&self, points: &[[f64; 3]], wavelength: f64) -> Vec<Complex64> {
        let grid = &self.field.grid;
        let from = self.hop.from;
        let leaves = from.leaves();
        let heights = (!from.is_plane()).then(|| Heights::on(from, grid));
        let emitter = |j: usize, i: usize| {
            let (mut z, mut slope) = (0.0, [0.0; 2]);
            if let Some(heights) = &heights {
                z = leaves * heights.z[[j, i]];
                slope = [0, 1].map(|a| leaves * heights.slope[a][[j, i]]);
            }
            let strength = self.field.values[[j, i]] * (grid.x.weight(i) * grid.y.weight(j));
            Emitter {
                at: [grid.x.node(i), grid.y.node(j), z],
                slope,
                strength,
            }
        };
        let (ny, nx) = self.field.values.dim();
        let band = |b: usize| {
            let rows = b * ROWS..ny.min((b + 1) * ROWS);
            let nodes = rows.flat_map(|j| (0..nx).map(move |i| (j, i)));
            let lit = nodes.filter(|(j, i)| self.field.values[[*j, *i]] != Complex64::ZERO);
            Emitters::of_nodes(lit.map(|(j, i)| emitter(j, i))).field_at(points, wavelength)
        };
        let parts: Vec<Vec<Complex64>> = (0..ny.div_ceil(ROWS)).into_par_iter().map(band).collect();
        let mut sums = vec![Complex64::ZERO; points.len()];
        for part in parts {
            sums.iter_mut()
                .zip(part)
                .for_each(|(sum, value)| *sum += value);
        }
        sums
    }
}
