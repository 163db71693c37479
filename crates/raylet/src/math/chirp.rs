//! Exact Fourier sums between uniform combs of points, of any pitch on either side.
//!
//! The chirp-z transform: i·m = (i² + m² − (m−i)²)/2 turns the sum into a convolution with a chirp, done
//! by fast Fourier transforms (Bluestein, "A linear filtering approach to the computation of the discrete
//! Fourier transform", IEEE Trans. Audio Electroacoust. 18, 451, 1970). Unlike a fast Fourier transform
//! it leaves both pitches and both positions free; unlike interpolation it is exact to rounding.

use std::fmt;
use std::sync::Arc;

use fearless_simd::{Simd, dispatch};
use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;
use raylet_fft::{Fft, Planner};

use crate::math::double::Double;
use crate::math::lines::{quick_length, transform_rows};
use crate::math::simd_level::level;

/// Uniformly spaced points start + i·step, i = 0 … count − 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comb {
    /// The first point.
    pub start: f64,
    /// From each point to the next; may be negative.
    pub step: f64,
    /// Number of points.
    pub count: usize,
}

impl Comb {
    /// Point `i`.
    pub fn at(&self, i: usize) -> f64 {
        self.start + i as f64 * self.step
    }

    /// The index that chirps are counted from, the middle of the comb.
    fn middle(&self) -> f64 {
        (self.count / 2) as f64
    }

    /// The point at that index, to twice the usual precision.
    fn centre(&self) -> Double {
        Double::product(self.step, self.middle()).plus(Double::from(self.start))
    }
}

/// The plan of out\[m\] = Σᵢ in\[i\]·exp(i·scale·xᵢ·yₘ) for xᵢ in one comb and yₘ in another.
#[derive(Clone)]
pub(crate) struct Chirp {
    /// By which each input is multiplied before the convolution.
    before: Vec<Complex64>,
    /// By which each output is multiplied after it, the transforms' normalisation included.
    after: Vec<Complex64>,
    /// Transform of the chirp convolved with.
    kernel: Vec<Complex64>,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

impl fmt::Debug for Chirp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (from, to) = (self.before.len(), self.after.len());
        write!(f, "Chirp({from} -> {to}, by length {})", self.kernel.len())
    }
}

impl Chirp {
    /// Plans sums from the points of `from` to the points of `to`.
    ///
    /// `scale` is any real number; its sign is the sign of the exponent. Exact to rounding (1e-14 of the
    /// output's norm) however large the phases, with the combs taken at their face value, each a uniform
    /// comb of exactly the given numbers.
    pub(crate) fn new(from: Comb, to: Comb, scale: f64) -> Self {
        let length = quick_length(from.count.max(1) + to.count.max(1) - 1);
        let mut planner = Planner::new();
        let forward = planner.forward(length);
        let inverse = planner.inverse(length);

        // With indices p and q counted from the combs' middles, the phase in turns is
        // rate·(X + p·h)·(Y + q·g) = rate·(XY + Yh·p + Xg·q + hg·(p² + q² − (q−p)²)/2).
        let rate = Double::TURNS_PER_RADIAN.times(Double::from(scale));
        let (x, y) = (from.centre(), to.centre());
        let (h, g) = (Double::from(from.step), Double::from(to.step));
        let [along_p, along_q] = [rate.times(y).times(h), rate.times(x).times(g)];
        let bend = rate.times(h).times(g).times(Double::from(0.5));
        let quadratic = |p: f64| bend.times(Double::from(p * p));
        let linear = |slope: Double, p: f64| slope.times(Double::from(p)).plus(quadratic(p));

        let constant = rate.times(x).times(y);
        let before = (0..from.count)
            .map(|i| linear(along_p, i as f64 - from.middle()).phasor())
            .collect();
        let after = (0..to.count)
            .map(|m| {
                linear(along_q, m as f64 - to.middle())
                    .plus(constant)
                    .phasor()
            })
            .map(|phasor| phasor / length as f64)
            .collect();

        let shift = from.middle() - to.middle();
        let chirp = |difference: f64| quadratic(difference + shift).phasor().conj();
        let mut kernel = wrapped(length, from.count, to.count, chirp);
        forward.process(&mut kernel);
        Self {
            before,
            after,
            kernel,
            forward,
            inverse,
        }
    }

    /// Adds the sums over `input` to `out`. `scratch` is resized as needed and may be shared by plans.
    ///
    /// # Panics
    /// If the slices do not have the lengths of the two combs.
    pub(crate) fn apply(
        &self,
        input: &[Complex64],
        out: &mut [Complex64],
        scratch: &mut Vec<Complex64>,
    ) {
        self.check(input.len(), out.len());
        let (work, spare) = self.split(scratch);
        let level = level();
        dispatch!(level, simd => product(simd, input, Factors::of(&self.before), work));
        self.forward.process_with_scratch(work, spare);
        dispatch!(level, simd => multiply(simd, work, Factors::of(&self.kernel)));
        self.inverse.process_with_scratch(work, spare);
        dispatch!(level, simd => add_product(simd, work, Factors::of(&self.after), out));
    }

    /// The conjugate transpose: adds Σₘ out_bar\[m\]·exp(−i·scale·xᵢ·yₘ) to `input_bar`\[i\].
    ///
    /// # Panics
    /// If the slices do not have the lengths of the two combs.
    pub(crate) fn apply_adjoint(
        &self,
        out_bar: &[Complex64],
        input_bar: &mut [Complex64],
        scratch: &mut Vec<Complex64>,
    ) {
        self.check(input_bar.len(), out_bar.len());
        let (work, spare) = self.split(scratch);
        let level = level();
        // out += work·after
        dispatch!(level, simd => product(simd, out_bar, Factors::conjugate(&self.after), work));
        // convolution with the chirp: correlation with it
        self.forward.process_with_scratch(work, spare);
        dispatch!(level, simd => multiply(simd, work, Factors::conjugate(&self.kernel)));
        self.inverse.process_with_scratch(work, spare);
        // work = input·before
        dispatch!(level, simd => add_product(simd, work, Factors::conjugate(&self.before), input_bar));
    }

    fn check(&self, inputs: usize, outputs: usize) {
        assert_eq!(
            inputs,
            self.before.len(),
            "one input for each point of the first comb"
        );
        assert_eq!(
            outputs,
            self.after.len(),
            "one output for each point of the second comb"
        );
    }

    /// The line of the convolution, which still holds the last values, and the scratch space of the transforms.
    fn split<'a>(
        &self,
        scratch: &'a mut Vec<Complex64>,
    ) -> (&'a mut [Complex64], &'a mut [Complex64]) {
        let [a, b] = [&self.forward, &self.inverse].map(|fft| fft.get_inplace_scratch_len());
        scratch.resize(self.kernel.len() + a.max(b), Complex64::ZERO);
        scratch.split_at_mut(self.kernel.len())
    }

    /// Relative cost of one line.
    fn cost(&self) -> f64 {
        let length = self.kernel.len() as f64;
        length * length.log2().max(1.0)
    }
}

/// What values are multiplied by.
#[derive(Clone, Copy)]
struct Factors<'a> {
    values: &'a [Complex64],
    /// −1 for the conjugates.
    sign: f64,
}

impl<'a> Factors<'a> {
    fn of(values: &'a [Complex64]) -> Self {
        Self { values, sign: 1.0 }
    }

    fn conjugate(values: &'a [Complex64]) -> Self {
        Self { values, sign: -1.0 }
    }

    /// The factors in order.
    #[inline(always)]
    fn iter(self) -> impl Iterator<Item = Complex64> {
        let factor = move |f: &Complex64| Complex64::new(f.re, self.sign * f.im);
        self.values.iter().map(factor)
    }
}

/// The products of values and factors, behind them zeros.
#[inline(always)]
fn product<S: Simd>(_: S, values: &[Complex64], factors: Factors, products: &mut [Complex64]) {
    let (products, rest) = products.split_at_mut(values.len());
    for ((product, value), factor) in products.iter_mut().zip(values).zip(factors.iter()) {
        *product = value * factor;
    }
    rest.fill(Complex64::ZERO);
}

/// Multiplies values by factors.
#[inline(always)]
fn multiply<S: Simd>(_: S, values: &mut [Complex64], factors: Factors) {
    for (value, factor) in values.iter_mut().zip(factors.iter()) {
        *value *= factor;
    }
}

/// Adds the products of values and factors to sums.
#[inline(always)]
fn add_product<S: Simd>(_: S, values: &[Complex64], factors: Factors, sums: &mut [Complex64]) {
    for ((sum, value), factor) in sums.iter_mut().zip(values).zip(factors.iter()) {
        *sum += value * factor;
    }
}

/// f(m − i) for every index i of the inputs and m of the outputs, negative differences from the end.
fn wrapped(
    length: usize,
    inputs: usize,
    outputs: usize,
    f: impl Fn(f64) -> Complex64,
) -> Vec<Complex64> {
    let mut values = vec![Complex64::ZERO; length];
    for (m, value) in values[..outputs].iter_mut().enumerate() {
        *value = f(m as f64);
    }
    for (i, value) in (1..inputs).zip(values.iter_mut().rev()) {
        *value = f(-(i as f64));
    }
    values
}

/// The plan of out\[n, m\] = Σⱼᵢ in\[j, i\]·exp(i·scale·(xᵢ·x′ₘ + yⱼ·y′ₙ)): a `Chirp` along each axis.
#[derive(Clone, Debug)]
pub struct Chirp2 {
    x: Chirp,
    y: Chirp,
    x_first: bool,
}

impl Chirp2 {
    /// Plans sums from the grid `from_y` × `from_x` to the grid `to_y` × `to_x`.
    pub fn new(from_y: Comb, from_x: Comb, to_y: Comb, to_x: Comb, scale: f64) -> Self {
        let x = Chirp::new(from_x, to_x, scale);
        let y = Chirp::new(from_y, to_y, scale);
        // The first axis is transformed on all input lines, the second on all output lines.
        let x_then_y = from_y.count as f64 * x.cost() + to_x.count as f64 * y.cost();
        let y_then_x = from_x.count as f64 * y.cost() + to_y.count as f64 * x.cost();
        Self {
            x,
            y,
            x_first: x_then_y <= y_then_x,
        }
    }

    /// The sums over `input`, shape \[from_y, from_x\], as an array of shape \[to_y, to_x\].
    ///
    /// Runs on the current rayon pool; the result is the same to the last bit for any number of threads.
    ///
    /// # Panics
    /// If `input` has another shape.
    pub fn apply(&self, input: ArrayView2<'_, Complex64>) -> Array2<Complex64> {
        let shape = [self.y.after.len(), self.x.after.len()];
        let along = |chirp: &Chirp, line: &[_], out: &mut [_], scratch: &mut _| {
            chirp.apply(line, out, scratch);
        };
        self.both(input, shape, self.x_first, along)
    }

    /// The conjugate transpose of [`Chirp2::apply`]: from shape \[to_y, to_x\] to \[from_y, from_x\].
    ///
    /// # Panics
    /// If `out_bar` has another shape.
    pub(crate) fn apply_adjoint(&self, out_bar: ArrayView2<'_, Complex64>) -> Array2<Complex64> {
        let shape = [self.y.before.len(), self.x.before.len()];
        let along = |chirp: &Chirp, line: &[_], bar: &mut [_], scratch: &mut _| {
            chirp.apply_adjoint(line, bar, scratch);
        };
        self.both(out_bar, shape, !self.x_first, along)
    }

    /// One axis after the other, into an array of the given shape.
    fn both<F>(
        &self,
        input: ArrayView2<'_, Complex64>,
        shape: [usize; 2],
        x_first: bool,
        along: F,
    ) -> Array2<Complex64>
    where
        F: Fn(&Chirp, &[Complex64], &mut [Complex64], &mut Vec<Complex64>) + Sync,
    {
        let along_x = |a: &[_], b: &mut [_], s: &mut Vec<_>| along(&self.x, a, b, s);
        let along_y = |a: &[_], b: &mut [_], s: &mut Vec<_>| along(&self.y, a, b, s);
        let mut out = Array2::zeros(shape);
        if x_first {
            let mut middle = Array2::zeros([input.nrows(), shape[1]]);
            transform_rows(input, middle.view_mut(), along_x);
            transform_rows(middle.t(), out.view_mut().reversed_axes(), along_y);
        } else {
            let mut middle = Array2::zeros([shape[0], input.ncols()]);
            transform_rows(
                input.reversed_axes(),
                middle.view_mut().reversed_axes(),
                along_y,
            );
            transform_rows(middle.view(), out.view_mut(), along_x);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;
    use rayon::ThreadPoolBuilder;

    use crate::fixtures::noise::complex_noise;
    use crate::math::chirp::{Chirp, Chirp2, Comb};

    fn values(count: usize, purpose: u32) -> Vec<Complex64> {
        let drawn = complex_noise((count, 1), 7, [0, purpose]);
        drawn.into_iter().collect()
    }

    fn inner<'a>(
        a: impl IntoIterator<Item = &'a Complex64>,
        b: impl IntoIterator<Item = &'a Complex64>,
    ) -> Complex64 {
        a.into_iter().zip(b).map(|(a, b)| a.conj() * b).sum()
    }

    /// Root of the summed squares of the differences over that of the expected values.
    fn error(got: &[Complex64], expected: &[Complex64]) -> f64 {
        let off: f64 = got
            .iter()
            .zip(expected)
            .map(|(a, b)| (a - b).norm_sqr())
            .sum();
        (off / expected.iter().map(|b| b.norm_sqr()).sum::<f64>()).sqrt()
    }

    /// The sum as written. With combs and scale of few binary digits its phases are exact.
    fn direct(from: Comb, input: &[Complex64], scale: f64, y: f64) -> Complex64 {
        let term = |(i, value): (usize, &Complex64)| value * Complex64::cis(scale * from.at(i) * y);
        input.iter().enumerate().map(term).sum()
    }

    #[test]
    fn large_phases_far_combs_and_both_signs() {
        let far = Comb {
            start: 37.0 + 1.0 / 1024.0,
            step: 1.0 / 512.0,
            count: 4000,
        };
        let near = Comb {
            start: -3.875,
            step: 3.0 / 1024.0,
            count: 4000,
        };
        let falling = Comb {
            start: 21.5,
            step: -5.0 / 256.0,
            count: 3001,
        };
        for (from, to, scale) in [
            (far, near, -64.375),
            (near, far, 50.5),
            (far, falling, 12.0),
            (falling, near, -0.25),
            (falling, Comb { count: 1, ..far }, 8.0),
            (Comb { count: 1, ..far }, falling, 8.0),
        ] {
            let input = values(from.count, 1);
            let mut out = vec![Complex64::ZERO; to.count];
            Chirp::new(from, to, scale).apply(&input, &mut out, &mut Vec::new());
            let (mut got, mut expected) = (Vec::new(), Vec::new());
            for m in (0..to.count).step_by(57) {
                got.push(out[m]);
                expected.push(direct(from, &input, scale, to.at(m)));
            }
            let error = error(&got, &expected);
            assert!(error < 5e-15, "{from:?} {to:?} {scale}: {error:e}");
        }
    }

    #[test]
    fn sums_add_and_empty_combs_are_harmless() {
        let from = Comb {
            start: 0.5,
            step: 0.25,
            count: 3,
        };
        let none = Comb { count: 0, ..from };
        let (mut out, mut scratch) = (vec![Complex64::ONE; 3], Vec::new());
        Chirp::new(none, from, 1.0).apply(&[], &mut out, &mut scratch);
        Chirp::new(from, none, 1.0).apply(&out.clone(), &mut [], &mut scratch);
        assert_eq!(out, [Complex64::ONE; 3]);
        Chirp::new(from, from, 0.0).apply(&[Complex64::ONE; 3], &mut out, &mut scratch);
        assert!(out.iter().all(|value| (value - 4.0).norm() < 1e-14));
    }

    #[test]
    fn apply_dot_product() {
        let from = Comb {
            start: 0.3,
            step: 0.017,
            count: 401,
        };
        let to = Comb {
            start: -9.1,
            step: -0.023,
            count: 733,
        };
        let chirp = Chirp::new(from, to, -7.3);
        let (input, out_bar) = (values(from.count, 1), values(to.count, 2));
        let (mut out, mut input_bar) = (values(to.count, 3), values(from.count, 3));
        out.fill(Complex64::ZERO);
        input_bar.fill(Complex64::ZERO);
        chirp.apply(&input, &mut out, &mut Vec::new());
        chirp.apply_adjoint(&out_bar, &mut input_bar, &mut Vec::new());
        let (a, b) = (inner(&out_bar, &out), inner(&input_bar, &input));
        let size = (inner(&out_bar, &out_bar) * inner(&out, &out))
            .norm()
            .sqrt();
        assert!((a - b).norm() < 1e-15 * size, "{:e}", (a - b).norm() / size);
    }

    /// Four combs such that the given axis is the cheaper one to do first.
    fn plan(x_first: bool) -> (Chirp2, [Comb; 4]) {
        let counts = if x_first {
            [45, 50, 51, 20]
        } else {
            [45, 50, 20, 51]
        };
        let [from_y, from_x, to_y, to_x] = [0, 1, 2, 3].map(|i| Comb {
            start: i as f64 - 0.5,
            step: [0.125, -0.0625, 0.25, 0.1875][i],
            count: counts[i],
        });
        let plan = Chirp2::new(from_y, from_x, to_y, to_x, 1.5);
        assert_eq!(plan.x_first, x_first);
        (plan, [from_y, from_x, to_y, to_x])
    }

    #[test]
    fn two_axes_equal_the_direct_sum() {
        for x_first in [true, false] {
            let (plan, [from_y, from_x, to_y, to_x]) = plan(x_first);
            let input = complex_noise([from_y.count, from_x.count], 7, [0, 4]);
            let expected = Array2::from_shape_fn([to_y.count, to_x.count], |(n, m)| {
                let line = |row: ndarray::ArrayView1<'_, _>| {
                    direct(from_x, &row.to_vec(), 1.5, to_x.at(m))
                };
                let lines: Vec<_> = input.rows().into_iter().map(line).collect();
                direct(from_y, &lines, 1.5, to_y.at(n))
            });
            let out = plan.apply(input.view());
            let error = error(out.as_slice().unwrap(), expected.as_slice().unwrap());
            assert!(error < 2e-15, "{error:e}");
        }
    }

    #[test]
    fn two_axes_dot_product() {
        for x_first in [true, false] {
            let (plan, [from_y, from_x, to_y, to_x]) = plan(x_first);
            let input = complex_noise([from_y.count, from_x.count], 7, [0, 5]);
            let out_bar = complex_noise([to_y.count, to_x.count], 7, [0, 6]);
            let (out, input_bar) = (plan.apply(input.view()), plan.apply_adjoint(out_bar.view()));
            let (a, b) = (inner(&out_bar, &out), inner(&input_bar, &input));
            let size = (inner(&out_bar, &out_bar) * inner(&out, &out))
                .norm()
                .sqrt();
            assert!((a - b).norm() < 1e-15 * size, "{:e}", (a - b).norm() / size);
        }
    }

    #[test]
    fn same_bits_for_any_number_of_threads() {
        let (plan, [from_y, from_x, ..]) = plan(true);
        let input = complex_noise([from_y.count, from_x.count], 7, [0, 8]);
        let run = |threads| {
            let pool = ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| plan.apply(input.view()))
        };
        let one = run(1);
        assert!([2, 3, 7].into_iter().all(|threads| run(threads) == one));
    }
}
