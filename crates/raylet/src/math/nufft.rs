//! Fourier sums over scattered points, at a chosen tolerance: the non-uniform fast Fourier transform.
//!
//! Strengths are spread to a twice oversampled grid with a smooth bump, transformed, and divided by the
//! bump's transform (Barnett, Magland and af Klinteberg, "A parallel nonuniform fast Fourier transform
//! library based on an 'exponential of semicircle' kernel", SIAM J. Sci. Comput. 41, C479, 2019; here
//! with the Kaiser–Bessel bump). The error is the aliased tail of the bump; its size is an argument.

use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;
use raylet_fft::{Fft, Planner};

use crate::math::kaiser::Kaiser;
use crate::math::lines::{quick_length, transform_rows};
use crate::math::tiles::Tiles;

pub(crate) use crate::math::tiles::SortedPoints;

/// Why a transform cannot be planned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NufftError {
    /// The tolerance is outside of what double precision and two or more taps can give.
    #[error("tolerance {0} of a Fourier sum must lie between 1e-13 and 0.1")]
    Tolerance(f64),
    /// There are no modes along an axis, or more than can be counted.
    #[error("a Fourier sum needs between 1 and 2^24 modes along each axis, not {0:?}")]
    Shape([usize; 2]),
}

/// One axis of the plan: its modes among the frequencies of the grid.
#[derive(Clone)]
struct Modes {
    /// One over the transform of the bump, and over the phase of the bump's delay.
    factors: Vec<Complex64>,
    /// Length of the grid.
    length: usize,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

/// The plan of sums between scattered points (u, v) and modes, Σ exp(±i(m₁u + m₂v)).
///
/// Index j along an axis of N modes means the integer m = j − N/2 (division rounding down): −N/2 to
/// N/2 − 1 for even N, −(N−1)/2 to (N−1)/2 for odd. Points are angles in radians, \[u, v\] = \[along x,
/// along y\], of any size; they are wrapped.
#[derive(Clone)]
pub struct Nufft {
    tiles: Tiles,
    y: Modes,
    x: Modes,
}

impl fmt::Debug for Nufft {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [ny, nx] = self.shape();
        write!(
            f,
            "Nufft({ny} x {nx} modes, {} taps)",
            self.tiles.kernel.width
        )
    }
}

impl Modes {
    fn new(count: usize, length: usize, kernel: &Kaiser) -> Self {
        let mut planner = Planner::new();
        let factor = |j: usize| {
            let cycles = (j as f64 - (count / 2) as f64) / length as f64;
            Complex64::cis(-TAU * cycles * kernel.delay()) / kernel.transform(cycles)
        };
        Self {
            factors: (0..count).map(factor).collect(),
            length,
            forward: planner.forward(length),
            inverse: planner.inverse(length),
        }
    }

    /// Frequency of the grid that mode `j` is.
    fn frequency(&self, j: usize) -> usize {
        (j + self.length - self.factors.len() / 2) % self.length
    }

    /// Adds to `modes` the sums over one line of the grid.
    fn collect(&self, line: &[Complex64], modes: &mut [Complex64], scratch: &mut Vec<Complex64>) {
        let (work, spare) = self.split(scratch, &self.inverse);
        work.copy_from_slice(line);
        self.inverse.process_with_scratch(work, spare);
        for (j, (mode, factor)) in modes.iter_mut().zip(&self.factors).enumerate() {
            *mode += work[self.frequency(j)] * factor;
        }
    }

    /// The conjugate transpose of [`Modes::collect`].
    fn collect_adjoint(
        &self,
        modes: &[Complex64],
        line: &mut [Complex64],
        scratch: &mut Vec<Complex64>,
    ) {
        let (work, spare) = self.split(scratch, &self.forward);
        work.fill(Complex64::ZERO);
        // mode += work·factor
        for (j, (mode, factor)) in modes.iter().zip(&self.factors).enumerate() {
            work[self.frequency(j)] = mode * factor.conj();
        }
        // work = transform of line
        self.forward.process_with_scratch(work, spare);
        line.iter_mut()
            .zip(work)
            .for_each(|(value, work)| *value += *work);
    }

    /// A line of the grid with undefined values, and the scratch space of the transform.
    fn split<'a>(
        &self,
        scratch: &'a mut Vec<Complex64>,
        fft: &Arc<dyn Fft<f64>>,
    ) -> (&'a mut [Complex64], &'a mut [Complex64]) {
        scratch.resize(self.length + fft.get_inplace_scratch_len(), Complex64::ZERO);
        scratch.split_at_mut(self.length)
    }
}

impl Nufft {
    /// Plans sums for `shape` = \[modes along y, modes along x\].
    ///
    /// `tolerance` is the error relative to the norm of the result, for strengths without special order;
    /// 0.1 to 1e-13.
    pub fn new(shape: [usize; 2], tolerance: f64) -> Result<Self, NufftError> {
        if !shape.iter().all(|count| (1..=1 << 24).contains(count)) {
            return Err(NufftError::Shape(shape));
        }
        let fine = shape.map(|count| quick_length(2 * count));
        let kernel = Some(tolerance)
            .filter(|tolerance| (1e-13..=0.1).contains(tolerance))
            .and_then(|tolerance| Kaiser::within(tolerance, [0, 1].map(|i| [shape[i], fine[i]])))
            .ok_or(NufftError::Tolerance(tolerance))?;
        let [y, x] = [0, 1].map(|axis| Modes::new(shape[axis], fine[axis], &kernel));
        Ok(Self {
            tiles: Tiles::new(fine, kernel),
            y,
            x,
        })
    }

    /// Numbers of modes \[y, x\].
    pub(crate) fn shape(&self) -> [usize; 2] {
        [self.y.factors.len(), self.x.factors.len()]
    }

    /// Adds Σᵢ strengthᵢ·exp(+i(m₁uᵢ + m₂vᵢ)) to `out`\[m₂, m₁\] (the type-1 transform).
    ///
    /// Runs on the current rayon pool; the result is the same to the last bit for any number of threads.
    ///
    /// # Panics
    /// If there are not as many strengths as points, or `out` has another shape than the plan.
    pub fn type1(&self, points: &[[f64; 2]], strengths: &[Complex64], out: &mut Array2<Complex64>) {
        let mut grid = self.blank();
        self.spread(points, strengths, &mut grid);
        self.collect(&grid, out);
    }

    /// An empty grid: points of many calls are spread to it, and their modes collected once.
    pub(crate) fn blank(&self) -> Vec<f64> {
        self.tiles.blank()
    }

    /// The first part of [`Nufft::type1`]: adds points to a grid.
    pub(crate) fn spread(&self, points: &[[f64; 2]], strengths: &[Complex64], grid: &mut [f64]) {
        assert_eq!(points.len(), strengths.len(), "one strength for each point");
        self.tiles.spread(points, strengths, grid);
    }

    /// Puts points in the order in which [`Nufft::spread_sorted`] takes them.
    pub(crate) fn sort(
        &self,
        points: &[[f64; 2]],
        strengths: &[Complex64],
        sorted: &mut SortedPoints,
    ) {
        self.tiles.sort_into(points, strengths, sorted);
    }

    /// The same as [`Nufft::spread`], of points that are sorted already.
    pub(crate) fn spread_sorted(&self, parts: &[SortedPoints], grid: &mut [f64]) {
        self.tiles.spread_sorted(parts, grid);
    }

    /// The second part of [`Nufft::type1`]: adds the sums over what was spread to `out`.
    pub(crate) fn collect(&self, grid: &[f64], out: &mut Array2<Complex64>) {
        assert_eq!(out.shape(), self.shape(), "an output of the planned shape");
        let fine = self.tiles.fold(grid);
        // Along x on every grid row, keeping only the modes, then along y on what is left.
        let mut middle = Array2::zeros([self.y.length, self.x.factors.len()]);
        transform_rows(fine.view(), middle.view_mut(), |a, b, s| {
            self.x.collect(a, b, s)
        });
        let columns = out.view_mut().reversed_axes();
        transform_rows(middle.t(), columns, |a, b, s| self.y.collect(a, b, s));
    }

    /// Σₘ modes\[m₂, m₁\]·exp(−i(m₁uᵢ + m₂vᵢ)) at each point (the type-2 transform): the exact conjugate
    /// transpose of [`Nufft::type1`], approximations included.
    ///
    /// # Panics
    /// If `modes` has another shape than the plan.
    pub fn type2(&self, modes: ArrayView2<'_, Complex64>, points: &[[f64; 2]]) -> Vec<Complex64> {
        assert_eq!(modes.shape(), self.shape(), "modes of the planned shape");
        // middle to modes
        let mut middle = Array2::zeros([self.y.length, self.x.factors.len()]);
        let columns = middle.view_mut().reversed_axes();
        transform_rows(modes.reversed_axes(), columns, |a, b, s| {
            self.y.collect_adjoint(a, b, s)
        });
        // grid to middle
        let mut fine = Array2::zeros(self.tiles.shape);
        transform_rows(middle.view(), fine.view_mut(), |a, b, s| {
            self.x.collect_adjoint(a, b, s)
        });
        // points to grid
        self.tiles.interpolate(&self.tiles.unfold(&fine), points)
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;
    use rayon::ThreadPoolBuilder;

    use crate::fixtures::noise::complex_noise;
    use crate::math::nufft::{Nufft, NufftError};

    /// Points over several periods, and strengths.
    fn sources(count: usize, purpose: u32) -> (Vec<[f64; 2]>, Vec<Complex64>) {
        let drawn = complex_noise((count, 2), 3, [0, purpose]);
        let angles = |v: &Complex64| [20.0 * v.re, 20.0 * v.im];
        (
            drawn.column(0).iter().map(angles).collect(),
            drawn.column(1).to_vec(),
        )
    }

    /// exp(i·m·angle) for every mode of an axis.
    fn phasors(count: usize, angle: f64) -> Vec<Complex64> {
        (0..count)
            .map(|j| Complex64::cis((j as f64 - (count / 2) as f64) * angle))
            .collect()
    }

    /// The type-1 sum as written.
    fn direct(
        shape: [usize; 2],
        points: &[[f64; 2]],
        strengths: &[Complex64],
    ) -> Array2<Complex64> {
        let mut sum = Array2::zeros(shape);
        for (&[u, v], strength) in points.iter().zip(strengths) {
            let (along_x, along_y) = (phasors(shape[1], u), phasors(shape[0], v));
            for ((m2, m1), value) in sum.indexed_iter_mut() {
                *value += strength * along_y[m2] * along_x[m1];
            }
        }
        sum
    }

    /// The type-2 sum as written.
    fn direct_adjoint(modes: &Array2<Complex64>, points: &[[f64; 2]]) -> Vec<Complex64> {
        let at = |&[u, v]: &[f64; 2]| {
            let (along_x, along_y) = (phasors(modes.ncols(), u), phasors(modes.nrows(), v));
            let mut sum = Complex64::ZERO;
            for ((m2, m1), value) in modes.indexed_iter() {
                sum += value * (along_y[m2] * along_x[m1]).conj();
            }
            sum
        };
        points.iter().map(at).collect()
    }

    fn inner<'a>(
        a: impl IntoIterator<Item = &'a Complex64>,
        b: impl IntoIterator<Item = &'a Complex64>,
    ) -> Complex64 {
        a.into_iter().zip(b).map(|(a, b)| a.conj() * b).sum()
    }

    fn norm<'a>(a: impl IntoIterator<Item = &'a Complex64>) -> f64 {
        a.into_iter().map(|a| a.norm_sqr()).sum::<f64>().sqrt()
    }

    #[test]
    fn tolerance_is_met_against_the_direct_sum() {
        // With few modes the random weight of the outermost, which are the worst, counts.
        for (shape, luck) in [([48, 61], 1.0), ([1, 40], 1.5), ([7, 2], 1.5)] {
            let (points, strengths) = sources(2000, 1);
            let expected = direct(shape, &points, &strengths);
            let bar = complex_noise(shape, 3, [0, 2]);
            let expected_back = direct_adjoint(&bar, &points);
            for tolerance in [
                1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12,
            ] {
                let plan = Nufft::new(shape, tolerance).unwrap();
                let mut out = Array2::zeros(shape);
                plan.type1(&points, &strengths, &mut out);
                let error = norm(&(out - &expected)) / norm(&expected);
                let back = plan.type2(bar.view(), &points);
                let off: Vec<_> = back
                    .iter()
                    .zip(&expected_back)
                    .map(|(a, b)| a - b)
                    .collect();
                let error_back = norm(&off) / norm(&expected_back);

                assert!(
                    error < luck * tolerance,
                    "{shape:?} {tolerance:e}: {error:e}"
                );
                assert!(
                    error_back < luck * tolerance,
                    "{shape:?} {tolerance:e}: {error_back:e}"
                );
            }
        }
    }

    #[test]
    fn sums_add_and_edges_of_the_period_are_one_point() {
        use std::f64::consts::PI;
        let plan = Nufft::new([5, 6], 1e-12).unwrap();
        let points = [
            [-PI, PI],
            [PI, -PI],
            [-1e-300, 0.0],
            [0.0, -1e-17],
            [3.0 * PI, -5.0 * PI],
        ];
        let mut out = Array2::from_elem([5, 6], Complex64::ONE);
        plan.type1(&points, &[Complex64::ONE; 5], &mut out);
        for ((j, i), value) in out.indexed_iter() {
            let sign = if (i + j + 5).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            };
            assert!((value - 3.0 - 3.0 * sign).norm() < 1e-11);
        }
        plan.type1(&[], &[], &mut out);
        assert!(plan.type2(out.view(), &[]).is_empty());
    }

    #[test]
    fn type1_dot_product() {
        for (tolerance, shape) in [
            (1e-2, [40, 33]),
            (1e-6, [64, 20]),
            (1e-9, [21, 50]),
            (1e-12, [30, 30]),
        ] {
            let plan = Nufft::new(shape, tolerance).unwrap();
            let (points, strengths) = sources(30_000, 4);
            let out_bar = complex_noise(shape, 3, [0, 5]);
            let mut out = Array2::zeros(shape);
            plan.type1(&points, &strengths, &mut out);
            let strengths_bar = plan.type2(out_bar.view(), &points);
            let (a, b) = (inner(&out_bar, &out), inner(&strengths_bar, &strengths));
            let off = (a - b).norm() / (norm(&out_bar) * norm(&out));

            assert!(off < 1e-14, "{off:e}");
        }
    }

    #[test]
    fn same_bits_for_any_number_of_threads() {
        // More points than one batch holds.
        let plan = Nufft::new([20, 50], 1e-6).unwrap();
        let (points, strengths) = sources(300_000, 6);
        let run = |threads| {
            let pool = ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let mut out = Array2::zeros([20, 50]);
                plan.type1(&points, &strengths, &mut out);
                let back = plan.type2(out.view(), &points);
                (out, back)
            })
        };
        let one = run(1);
        assert!([2, 3, 7].into_iter().all(|threads| run(threads) == one));
    }

    #[test]
    fn impossible_plans_are_errors() {
        assert_eq!(
            Nufft::new([0, 3], 1e-6).unwrap_err(),
            NufftError::Shape([0, 3])
        );
        for tolerance in [0.0, 1e-15, 0.5] {
            assert_eq!(
                Nufft::new([3, 3], tolerance).unwrap_err(),
                NufftError::Tolerance(tolerance)
            );
        }
        assert!(matches!(
            Nufft::new([3, 3], f64::NAN),
            Err(NufftError::Tolerance(_))
        ));
    }
}
