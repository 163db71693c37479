//! Plane waves that arrive on a screen, and their coherent sum on a uniform grid.
//!
//! An infinite plane wave per ray is a Fourier sum over scattered frequencies, done by a non-uniform
//! FFT: what a ray costs does not depend on the size of the screen.

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::math::nufft::{Nufft, NufftError};
use crate::wave::raster::Raster;
use crate::wave::wavelet::Arrival;

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

/// A sum of plane waves on a raster.
pub struct PlaneSum {
    raster: Raster,
    k: f64,
    transform: Nufft,
    values: Array2<Complex64>,
}

impl PlaneSum {
    /// An empty sum; `k` is the vacuum wavenumber, `tolerance` that of the non-uniform FFT.
    ///
    /// # Errors
    /// When the tolerance or the size of the raster is out of reach.
    pub fn new(raster: Raster, k: f64, tolerance: f64) -> Result<Self, NufftError> {
        let [nx, ny] = raster.size;
        Ok(Self {
            raster,
            k,
            transform: Nufft::new([ny, nx], tolerance)?,
            values: Array2::zeros((ny, nx)),
        })
    }

    /// Adds waves. Those that turn by more than half a cycle per sample are wrapped, which changes
    /// nothing at the sample points.
    pub fn add(&mut self, waves: &[PlaneWave]) {
        if waves.is_empty() {
            return;
        }
        // Mode zero of the transform is the sample in the middle.
        let (raster, k) = (self.raster, self.k);
        let middle = [0, 1].map(|a| {
            let half = (raster.size[a] / 2) as f64;
            raster.start[a] + half * raster.pitch[a]
        });
        let (points, strengths): (Vec<[f64; 2]>, Vec<Complex64>) = waves
            .par_iter()
            .map(|wave| {
                let turn = [0, 1].map(|a| k * raster.pitch[a] * wave.cosines[a]);
                let along = |a: usize| wave.cosines[a] * (middle[a] - wave.at[a]);
                (
                    turn,
                    wave.amplitude * Complex64::cis(k * (along(0) + along(1))),
                )
            })
            .unzip();
        self.transform.type1(&points, &strengths, &mut self.values);
    }

    /// Whether a point lies within the raster.
    pub fn contains(&self, point: [f64; 2]) -> bool {
        (0..2).all(|a| {
            let low = self.raster.start[a];
            let high = low + (self.raster.size[a] as f64 - 1.0) * self.raster.pitch[a];
            (low..=high).contains(&point[a])
        })
    }

    /// Number of samples of the raster.
    pub fn samples(&self) -> usize {
        self.values.len()
    }

    /// The sum so far, indexed [y, x].
    pub fn values(&self) -> &Array2<Complex64> {
        &self.values
    }

    /// The sum, indexed [y, x].
    pub fn finish(self) -> Array2<Complex64> {
        self.values
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::math::random::pair;
    use crate::wave::plane::{PlaneSum, PlaneWave};
    use crate::wave::raster::Raster;

    #[test]
    fn sum_matches_the_formula_beyond_the_nyquist_band() {
        // Half a cycle per sample is p = 0.25 along x and 0.19 along y; waves go up to 0.9.
        let k = std::f64::consts::TAU;
        let raster = Raster {
            start: [3.0, -40.0],
            pitch: [2.0, 2.6],
            size: [31, 24],
        };
        let waves: Vec<PlaneWave> = (0..200)
            .map(|i| {
                let draw = |what| pair(5, [i, what, 0, 0]).map(|u| u - 0.5);
                let [re, im] = draw(2);
                PlaneWave {
                    at: draw(0).map(|u| 80.0 * u),
                    cosines: draw(1).map(|u| 1.8 * u),
                    amplitude: Complex64::new(re, im),
                }
            })
            .collect();
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
}
