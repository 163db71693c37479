//! Values of a beamlet along the rows of a block, from column to column.
//!
//! Along a row the exponent is quadratic in x, so neighbouring values have a ratio that itself changes by a constant factor: two
//! complex multiplications per value. `add_dot_product` in `beamlet_kernel.rs` tests the adjoint.

use fearless_simd::{Simd, SimdBase, f64x8};
use num_complex::Complex64;

use crate::math::lanes::{LANES, cis, exp};

/// Columns after which values would have to be computed anew: their errors grow as the square of their number.
pub(crate) const LONGEST: usize = 256;

/// Values in one column of eight rows, and their ratios to those in the next column.
pub(crate) struct ColumnValues<S: Simd> {
    pub value: Pair<S>,
    pub ratio: Pair<S>,
    /// The factor by which the ratio changes from column to column.
    pub step: Pair<S>,
}

/// Real and imaginary parts of eight numbers.
pub(crate) type Pair<S> = (f64x8<S>, f64x8<S>);

impl<S: Simd> ColumnValues<S> {
    /// The same for a beamlet of this amplitude.
    #[inline(always)]
    pub(crate) fn scaled(mut self, simd: S, amplitude: Complex64) -> Self {
        let splat = |v: f64| f64x8::splat(simd, v);
        self.value = times(self.value, (splat(amplitude.re), splat(amplitude.im)));
        self
    }

    /// The same with rows dark where `lit` is zero; it is one elsewhere.
    #[inline(always)]
    pub(crate) fn only(mut self, lit: f64x8<S>) -> Self {
        self.value = (self.value.0 * lit, self.value.1 * lit);
        self.ratio = (self.ratio.0 * lit, self.ratio.1 * lit);
        self
    }

    /// Adds the values to columns.
    #[inline(always)]
    pub(crate) fn add<'c>(self, simd: S, columns: impl Iterator<Item = &'c mut [f64]>) {
        let Self {
            mut value,
            mut ratio,
            step,
        } = self;
        for column in columns {
            let (re, im) = column.split_at_mut(LANES);
            (f64x8::from_slice(simd, re) + value.0).store_slice(re);
            (f64x8::from_slice(simd, im) + value.1).store_slice(im);
            value = times(value, ratio);
            ratio = times(ratio, step);
        }
    }

    /// Σ of columns times the conjugates of the values that [`ColumnValues::add`] would add to them, row by row, times
    /// 1, u, u² where u starts here and grows by `pitch`.
    #[inline(always)]
    pub(crate) fn add_adjoint<'c>(
        self,
        simd: S,
        columns: impl Iterator<Item = &'c [f64]>,
        mut u: f64,
        pitch: f64,
    ) -> [Pair<S>; 3] {
        let Self {
            mut value,
            mut ratio,
            step,
        } = self;
        let zero = f64x8::splat(simd, 0.0);
        let mut sums = [(zero, zero); 3];
        for column in columns {
            let (re, im) = column.split_at(LANES);
            let (re, im) = (f64x8::from_slice(simd, re), f64x8::from_slice(simd, im));
            // re + i·im += value
            let mut part = (value.0 * re + value.1 * im, value.0 * im - value.1 * re);
            let far = f64x8::splat(simd, u);
            for sum in &mut sums {
                *sum = (sum.0 + part.0, sum.1 + part.1);
                part = (part.0 * far, part.1 * far);
            }
            u += pitch;
            value = times(value, ratio);
            ratio = times(ratio, step);
        }
        sums
    }
}

/// The products of eight pairs of complex numbers.
#[inline(always)]
pub(crate) fn times<S: Simd>(a: Pair<S>, b: Pair<S>) -> Pair<S> {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

/// exp(a + ib) of eight pairs.
#[inline(always)]
pub(crate) fn polar<S: Simd>(a: f64x8<S>, b: f64x8<S>) -> Pair<S> {
    let size = exp(a);
    let (cos, sin) = cis(b);
    (size * cos, size * sin)
}
