//! Fourier sums between combs whose steps fit each other: one fast Fourier transform, without the convolution
//! of [`crate::math::chirp`].
//!
//! With xᵢ = x₀ + i·h and yₘ = y₀ + m·g, scale·h·g = ±2π/N for a whole N makes exp(i·scale·xᵢ·yₘ) the kernel
//! of a transform of length N, beside factors of i and of m alone.

use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

use fearless_simd::{Simd, dispatch};
use num_complex::Complex64;
use raylet_fft::{Fft, Planner};

use crate::math::chirp::Comb;
use crate::math::simd_level::level;

/// How far N may be from a whole number, for each of its units.
const TOLERANCE: f64 = 1e-14;

/// The largest prime factor of an N that is fast.
const LARGEST_FACTOR: usize = 13;

/// The plan of out\[m\] = Σᵢ in\[i\]·exp(i·scale·xᵢ·yₘ) between commensurate combs.
#[derive(Clone)]
pub(crate) struct CommensurateDft {
    /// By which each input is multiplied before the transform, and each output after it.
    before: Vec<Complex64>,
    after: Vec<Complex64>,
    transform: Arc<dyn Fft<f64>>,
}

impl fmt::Debug for CommensurateDft {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (from, to) = (self.before.len(), self.after.len());
        write!(
            f,
            "CommensurateDft({from} -> {to}, by length {})",
            self.transform.len()
        )
    }
}

impl CommensurateDft {
    /// Plans sums from the points of `from` to those of `to`; nothing when their steps do not fit, or a
    /// transform of that length is slow.
    pub(crate) fn new(from: Comb, to: Comb, scale: f64) -> Option<Self> {
        let turns = scale * from.step * to.step / TAU;
        let length = (1.0 / turns).abs().round();
        let fits = ((1.0 / turns).abs() - length).abs() <= TOLERANCE * length;
        let longest = from.count.max(to.count).max(1);
        if !fits || length < longest as f64 || length > 4.0 * longest as f64 {
            return None;
        }
        let length = length as usize;
        if !is_smooth(length) {
            return None;
        }
        let mut planner = Planner::new();
        let transform = if turns < 0.0 {
            planner.forward(length)
        } else {
            planner.inverse(length)
        };

        // scale·(x₀ + ih)(y₀ + mg) = scale·ih·y₀ + scale·x₀·(y₀ + mg) + scale·hg·im.
        let before = (0..from.count)
            .map(|i| Complex64::cis(scale * to.start * (i as f64 * from.step)))
            .collect();
        let after = (0..to.count)
            .map(|m| Complex64::cis(scale * from.start * to.at(m)))
            .collect();
        Some(Self {
            before,
            after,
            transform,
        })
    }

    /// The factor of each input before the transform.
    pub(crate) fn before(&self) -> &[Complex64] {
        &self.before
    }

    /// The factor of each output after the transform.
    pub(crate) fn after(&self) -> &[Complex64] {
        &self.after
    }

    /// Length of the transform.
    pub(crate) fn length(&self) -> usize {
        self.transform.len()
    }

    /// Adds sums to `out`, which may be shorter than its comb. `line` has the inputs with their factors
    /// [`CommensurateDft::before`] and zeros behind them, as long as the transform; what it holds afterwards has no
    /// meaning. `after` is [`CommensurateDft::after`] with what else outputs are multiplied by.
    pub(crate) fn apply(
        &self,
        line: &mut [Complex64],
        after: &[Complex64],
        out: &mut [Complex64],
        scratch: &mut Vec<Complex64>,
    ) {
        let spare = self.transform.get_inplace_scratch_len();
        scratch.resize(spare.max(scratch.len()), Complex64::ZERO);
        self.transform
            .process_with_scratch(line, &mut scratch[..spare]);
        dispatch!(level(), simd => add_product(simd, line, after, out));
    }
}

/// Adds the products of values and factors to sums.
#[inline(always)]
fn add_product<S: Simd>(_: S, values: &[Complex64], factors: &[Complex64], sums: &mut [Complex64]) {
    for ((sum, value), factor) in sums.iter_mut().zip(values).zip(factors) {
        *sum += value * factor;
    }
}

/// Whether all prime factors are small.
fn is_smooth(mut number: usize) -> bool {
    for factor in 2..=LARGEST_FACTOR {
        while number.is_multiple_of(factor) {
            number /= factor;
        }
    }
    number == 1
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use num_complex::Complex64;

    use crate::math::chirp::{Chirp, Comb};
    use crate::math::commensurate_dft::CommensurateDft;
    use crate::math::random::pair;

    #[test]
    fn sums_are_those_of_the_chirp() {
        let (k, pitch, length) = (TAU / 0.7e-3, 6.3e-3, 156.0);
        let from = Comb {
            start: -0.1234,
            step: pitch,
            count: 41,
        };
        let to = Comb {
            start: -0.0551,
            step: 0.7e-3 / (length * pitch),
            count: 150,
        };
        let input: Vec<Complex64> = (0..41)
            .map(|i| pair(1, [i, 0, 0, 0]).map(|u| u - 0.5))
            .map(|[re, im]| Complex64::new(re, im))
            .collect();
        for scale in [-k, k] {
            let dft = CommensurateDft::new(from, to, scale).unwrap();
            let chirp = Chirp::new(from, to, scale);
            let (mut ours, mut theirs) = (vec![Complex64::ONE; 150], vec![Complex64::ONE; 150]);
            let before = input.iter().zip(dft.before()).map(|(value, f)| value * f);
            let mut line: Vec<Complex64> = before.collect();
            line.resize(dft.length(), Complex64::ZERO);
            dft.apply(&mut line, dft.after(), &mut ours, &mut Vec::new());
            chirp.apply(&input, &mut theirs, &mut Vec::new());
            for (ours, theirs) in ours.iter().zip(&theirs) {
                assert!((ours - theirs).norm() < 1e-11, "{ours} {theirs}");
            }
        }

        // Steps that do not fit, and a length that is prime.
        let other = |step| Comb { step, ..to };
        assert!(CommensurateDft::new(from, other(1.001 * to.step), k).is_none());
        assert!(CommensurateDft::new(from, other(to.step * 156.0 / 157.0), k).is_none());
        assert!(CommensurateDft::new(from, other(to.step * 156.0 / 140.0), k).is_none());
    }
}
