//! Plane waves that arrive on a screen, and their coherent sum on a uniform grid.
//!
//! An infinite plane wave per ray is a Fourier sum over scattered frequencies, done by a non-uniform
//! FFT: what a ray costs does not depend on the size of the screen.

use std::f64::consts::TAU;

use fearless_simd::{Simd, SimdBase, SimdFrom, dispatch, f64x8};
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::math::lanes::{LANES, cis_turns, phasors};
use crate::math::nufft::{Nufft, NufftError, SortedPoints};
use crate::math::simd_level::level;
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::raster::Raster;

/// Waves whose phases are found together.
const GROUP: usize = 256;

/// A plane wave amplitude·exp(ik p·(x − at)) on a receiving screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneWave {
    /// Where its ray lands, in mm, screen coordinates.
    pub at: [f64; 2],
    /// Optical direction cosines p along the screen's axes.
    pub cosines: [f64; 2],
    /// Complex amplitude where the ray lands, optical path included.
    pub amplitude: Complex64,
}

impl PlaneWave {
    /// The plane wavelet of a ray, from the beamlet of width σ that travelled with it.
    ///
    /// Its prefactor √det(D + ikσ²C), with J = \[\[A, B\], \[C, D\]\] the ray's Jacobian ∂(s, p′)/∂(x, p)
    /// (Herman and Kluk, Chem. Phys. 91, 27, 1984, in the limit of final waves without width), follows
    /// from the beamlet's det(A + Bq₀)^{−1/2} and G = (C + Dq₀)(A + Bq₀)⁻¹, q₀ = i/kσ²: it is
    /// conj √det(G/q₀) over the conjugate of that root, whose modulus is known from Im G because J is
    /// symplectic. −iG has a positive definite real part, so the principal root of det(−iG) is the
    /// continuous one, and the beamlet's root was continued flight by flight: the branch is right behind
    /// any number of foci and images. Interfaces and cosines are in the beamlet's amplitude already.
    #[inline]
    pub fn from_beamlet(beamlet: &Arrival) -> Self {
        let [xx, xy, yy] = beamlet.curvature;
        let spread = (xx.im * yy.im - xy.im * xy.im).sqrt();
        let root = (xy * xy - xx * yy).sqrt();
        Self {
            at: beamlet.at,
            cosines: beamlet.cosines,
            amplitude: beamlet.amplitude * root.conj() / spread,
        }
    }
}

/// Plane waves in columns, with an entry for each.
pub(crate) struct WaveColumns<'a> {
    /// Where the rays land, along x and y.
    pub at: [&'a [f64]; 2],
    /// Their optical direction cosines along x and y.
    pub cosines: [&'a [f64]; 2],
    /// Their optical paths in mm.
    pub path: &'a [f64],
    /// Their amplitudes where the rays start.
    pub amplitudes: &'a [Complex64],
}

/// Memory for sorting waves.
#[derive(Default)]
pub(crate) struct SortScratch {
    points: Vec<[f64; 2]>,
    strengths: Vec<Complex64>,
}

/// A sum of plane waves on a raster.
pub struct PlaneSum {
    raster: Raster,
    k: f64,
    transform: Nufft,
    /// The fine grid of the waves that were added since the values were last read.
    grid: Vec<f64>,
    /// Whether that grid is all zeros.
    is_blank: bool,
    values: Array2<Complex64>,
}

impl PlaneSum {
    /// An empty sum; `k` is the vacuum wavenumber, `tolerance` that of the non-uniform FFT.
    ///
    /// # Errors
    /// When the tolerance or the size of the raster is out of reach.
    pub fn new(raster: Raster, k: f64, tolerance: f64) -> Result<Self, NufftError> {
        let [nx, ny] = raster.size;
        let transform = Nufft::new([ny, nx], tolerance)?;
        Ok(Self {
            raster,
            k,
            grid: transform.blank(),
            is_blank: true,
            transform,
            values: Array2::zeros((ny, nx)),
        })
    }

    /// Adds waves. Those that turn by more than half a cycle per sample are wrapped, which changes
    /// nothing at the sample points.
    pub fn add(&mut self, waves: &[PlaneWave]) {
        if waves.is_empty() {
            return;
        }
        let (points, mut strengths) = self.places(waves);
        let pairs = strengths.par_iter_mut().zip(waves);
        pairs.for_each(|(strength, wave)| *strength *= wave.amplitude);
        self.transform.spread(&points, &strengths, &mut self.grid);
        self.is_blank = false;
    }

    /// Makes waves ready for [`PlaneSum::add_sorted`], in place of what `sorted` holds.
    pub(crate) fn sort(
        &self,
        waves: &WaveColumns,
        scratch: &mut SortScratch,
        sorted: &mut SortedPoints,
    ) {
        let SortScratch { points, strengths } = scratch;
        points.resize(waves.path.len(), [0.0; 2]);
        strengths.resize(waves.path.len(), Complex64::ZERO);
        dispatch!(level(), simd => self.place_columns(simd, waves, points, strengths));
        self.transform.sort(points, strengths, sorted);
    }

    /// Adds waves that are sorted.
    pub(crate) fn add_sorted(&mut self, parts: &[SortedPoints]) {
        self.transform.spread_sorted(parts, &mut self.grid);
        self.is_blank = false;
    }

    /// Angles per sample of waves in columns, and their amplitudes at the sample in the middle.
    #[inline(always)]
    fn place_columns<S: Simd>(
        &self,
        simd: S,
        waves: &WaveColumns,
        points: &mut [[f64; 2]],
        strengths: &mut [Complex64],
    ) {
        let (middle, step) = (self.middle(), self.raster.pitch.map(|pitch| self.k * pitch));
        let groups = points
            .chunks_mut(LANES)
            .zip(strengths.chunks_mut(LANES))
            .zip(waves.amplitudes.chunks(LANES));
        for (group, ((points, strengths), amplitudes)) in groups.enumerate() {
            let first = group * LANES;
            let taken = |column: &[f64]| taken(simd, &column[first..], points.len());
            let ([x, y], [p, q]) = (waves.at.map(taken), waves.cosines.map(taken));
            let along = p * (middle[0] - x) + q * (middle[1] - y);
            let (cos, sin) = cis_turns((taken(waves.path) + along) * (self.k / TAU));
            let [u, v] = [*(p * step[0]).as_array(), *(q * step[1]).as_array()];
            let (cos, sin) = (*cos.as_array(), *sin.as_array());
            let amplitudes = amplitudes.first_chunk().copied().unwrap_or_else(|| {
                let mut eight = [Complex64::ZERO; LANES];
                eight[..amplitudes.len()].copy_from_slice(amplitudes);
                eight
            });
            let all: [Complex64; LANES] =
                std::array::from_fn(|i| amplitudes[i] * Complex64::new(cos[i], sin[i]));
            let angles: [[f64; 2]; LANES] = std::array::from_fn(|i| [u[i], v[i]]);
            give(all, strengths);
            give(angles, points);
        }
    }

    /// The conjugate transpose of [`PlaneSum::add`] for waves of amplitude one, and the same of values times
    /// distances: given cotangents of the samples, indexed [y, x], Σ conj(W)·bar, and that with the bar
    /// times u and v, (u, v) = x − at, for each wave W.
    pub(crate) fn add_adjoint(
        &self,
        bar: &Array2<Complex64>,
        waves: &[PlaneWave],
    ) -> Vec<[Complex64; 3]> {
        let (points, phases) = self.places(waves);
        let middle = self.middle();
        let [nx, ny] = self.raster.size;
        let away = |a: usize, index: usize| {
            let half = [nx / 2, ny / 2][a] as f64;
            (index as f64 - half) * self.raster.pitch[a]
        };
        let mut along = [bar.clone(), bar.clone()];
        for (a, part) in along.iter_mut().enumerate() {
            for ((j, i), value) in part.indexed_iter_mut() {
                *value *= away(a, [i, j][a]);
            }
        }
        // values += type1(strengths), strengths = amplitude·phase
        let [x, y] = along.map(|part| self.transform.type2(part.view(), &points));
        let one = self.transform.type2(bar.view(), &points);
        (0..waves.len())
            .map(|i| {
                let back = phases[i].conj();
                let one = one[i] * back;
                let [dx, dy] = [0, 1].map(|a| middle[a] - waves[i].at[a]);
                [one, x[i] * back + one * dx, y[i] * back + one * dy]
            })
            .collect()
    }

    /// The sample that is mode zero of the transform.
    fn middle(&self) -> [f64; 2] {
        [0, 1].map(|a| {
            let half = (self.raster.size[a] / 2) as f64;
            self.raster.start[a] + half * self.raster.pitch[a]
        })
    }

    /// Angles per sample of waves, and their phases at the sample in the middle.
    fn places(&self, waves: &[PlaneWave]) -> (Vec<[f64; 2]>, Vec<Complex64>) {
        let (pitch, k, middle) = (self.raster.pitch, self.k, self.middle());
        let mut points = vec![[0.0; 2]; waves.len()];
        let mut phases = vec![Complex64::ZERO; waves.len()];
        let parts = points
            .par_chunks_mut(GROUP)
            .zip(phases.par_chunks_mut(GROUP));
        parts
            .zip(waves.par_chunks(GROUP))
            .for_each(|((points, phases), waves)| {
                let mut turns = [0.0; GROUP];
                for ((point, turn), wave) in points.iter_mut().zip(&mut turns).zip(waves) {
                    *point = [0, 1].map(|a| k * pitch[a] * wave.cosines[a]);
                    let along = |a: usize| wave.cosines[a] * (middle[a] - wave.at[a]);
                    *turn = k / TAU * (along(0) + along(1));
                }
                phasors(&turns[..waves.len()], phases);
            });
        (points, phases)
    }

    /// Whether a point lies within the raster.
    #[inline(always)]
    pub(crate) fn contains(&self, point: [f64; 2]) -> bool {
        let within = [0, 1].map(|a| {
            let low = self.raster.start[a];
            let high = low + (self.raster.size[a] as f64 - 1.0) * self.raster.pitch[a];
            (point[a] >= low) & (point[a] <= high)
        });
        within[0] & within[1]
    }

    /// Number of samples of the raster.
    pub(crate) fn samples(&self) -> usize {
        self.values.len()
    }

    /// The sum so far, indexed [y, x]. The fine grid is transformed, added to it, and emptied.
    pub(crate) fn values(&mut self) -> &Array2<Complex64> {
        if !self.is_blank {
            self.transform.collect(&self.grid, &mut self.values);
            self.grid.fill(0.0);
            self.is_blank = true;
        }
        &self.values
    }

    /// The sum, indexed [y, x].
    pub fn finish(mut self) -> Array2<Complex64> {
        self.values();
        self.values
    }
}

/// Writes eight values, or as many as there are places.
#[inline(always)]
fn give<T: Copy>(eight: [T; LANES], to: &mut [T]) {
    match <&mut [T; LANES]>::try_from(&mut *to) {
        Ok(all) => *all = eight,
        Err(_) => to.copy_from_slice(&eight[..to.len()]),
    }
}

/// The first `count` of some numbers, eight at most, and zeros behind them.
#[inline(always)]
fn taken<S: Simd>(simd: S, numbers: &[f64], count: usize) -> f64x8<S> {
    if let Some(eight) = numbers.first_chunk::<LANES>() {
        return f64x8::simd_from(simd, *eight);
    }
    let mut eight = [0.0; LANES];
    eight[..count].copy_from_slice(&numbers[..count]);
    f64x8::simd_from(simd, eight)
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::math::random::pair;
    use crate::wave::beamlet::plane::{PlaneSum, PlaneWave};
    use crate::wave::grid::raster::Raster;

    fn waves() -> Vec<PlaneWave> {
        (0..200)
            .map(|i| {
                let draw = |what| pair(5, [i, what, 0, 0]).map(|u| u - 0.5);
                let [re, im] = draw(2);
                PlaneWave {
                    at: draw(0).map(|u| 80.0 * u),
                    cosines: draw(1).map(|u| 1.8 * u),
                    amplitude: Complex64::new(re, im),
                }
            })
            .collect()
    }

    #[test]
    fn sum_matches_the_formula_beyond_the_nyquist_band() {
        // Half a cycle per sample is p = 0.25 along x and 0.19 along y; waves go up to 0.9.
        let k = std::f64::consts::TAU;
        let raster = Raster {
            start: [3.0, -40.0],
            pitch: [2.0, 2.6],
            size: [31, 24],
        };
        let waves = waves();
        let mut sum = PlaneSum::new(raster, k, 1e-11).unwrap();
        sum.add(&waves[..70]);
        sum.add(&waves[70..]);
        let values = sum.finish();
        let (mut error, mut norm) = (0.0, 0.0);
        for ((j, i), value) in values.indexed_iter() {
            let (x, y) = (3.0 + 2.0 * i as f64, -40.0 + 2.6 * j as f64);
            let mut exact = Complex64::ZERO;
            for wave in &waves {
                let ([p, q], [a, b]) = (wave.cosines, wave.at);
                exact += wave.amplitude * Complex64::cis(k * (p * (x - a) + q * (y - b)));
            }
            error += (value - exact).norm_sqr();
            norm += exact.norm_sqr();
        }
        assert!((error / norm).sqrt() < 2e-11, "{:e}", (error / norm).sqrt());
    }
    #[test]
    fn add_dot_product() {
        let k = std::f64::consts::TAU;
        let raster = Raster {
            start: [3.0, -40.0],
            pitch: [2.0, 2.6],
            size: [31, 24],
        };
        let bar = Array2::from_shape_fn((24, 31), |(j, i)| {
            let [re, im] = pair(6, [i as u32, j as u32, 0, 0]);
            Complex64::new(re - 0.5, im - 0.5)
        });
        let mut sum = PlaneSum::new(raster, k, 1e-6).unwrap();
        sum.add(&waves());
        let back = sum.add_adjoint(&bar, &waves());
        let values = sum.values().clone();
        let forward: Complex64 = bar.iter().zip(&values).map(|(a, b)| a.conj() * b).sum();
        let reverse: Complex64 = back
            .iter()
            .zip(waves())
            .map(|(back, wave)| back[0].conj() * wave.amplitude)
            .sum();
        let norm = |values: &Array2<Complex64>| values.iter().map(|v| v.norm_sqr()).sum::<f64>();
        let size = (norm(&bar) * norm(&values)).sqrt();
        assert!((forward - reverse).norm() < 1e-13 * size);

        // The distances as written, at the tolerance of the transform.
        for (found, wave) in back.iter().zip(waves()).take(20) {
            let mut exact = [Complex64::ZERO; 3];
            for ((j, i), bar) in bar.indexed_iter() {
                let u = 3.0 + 2.0 * i as f64 - wave.at[0];
                let v = -40.0 + 2.6 * j as f64 - wave.at[1];
                let part = bar * Complex64::cis(-k * (wave.cosines[0] * u + wave.cosines[1] * v));
                for (e, power) in exact.iter_mut().zip([1.0, u, v]) {
                    *e += part * power;
                }
            }
            for (found, exact) in found.iter().zip(exact) {
                assert!((found - exact).norm() < 1e-3, "{found} {exact}");
            }
        }
    }
}
