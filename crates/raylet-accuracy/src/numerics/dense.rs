//! Products of dense complex matrices on all cores.

use ndarray::{Array1, Array2, ArrayView2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::numerics::phase::cis_turns;

/// The matrix product `left`·`right`, the rows of `left` shared out between the threads.
pub fn multiply(left: ArrayView2<Complex64>, right: ArrayView2<Complex64>) -> Array2<Complex64> {
    let mut product = Array2::zeros((left.nrows(), right.ncols()));
    let rows = left
        .nrows()
        .div_ceil(2 * rayon::current_num_threads())
        .max(1);
    let parts: Vec<_> = product
        .axis_chunks_iter_mut(Axis(0), rows)
        .zip(left.axis_chunks_iter(Axis(0), rows))
        .collect();
    parts
        .into_par_iter()
        .for_each(|(mut part, left)| part.assign(&left.dot(&right)));
    product
}

/// The separable transform `y`·`field`·`x`ᵀ, for kernels [out, in] along each axis and a field
/// [in y, in x]; the result is [out y, out x].
pub fn separable(
    y: &Array2<Complex64>,
    field: &Array2<Complex64>,
    x: &Array2<Complex64>,
) -> Array2<Complex64> {
    multiply(y.view(), multiply(field.view(), x.t()).view())
}

/// The Fourier kernel exp(2πi·`sign`·a_i·b_j) as a matrix [i, j]; `sign` carries 1/λ as well.
pub fn fourier_kernel(a: &Array1<f64>, b: &Array1<f64>, sign: f64) -> Array2<Complex64> {
    Array2::from_shape_fn((a.len(), b.len()), |(i, j)| {
        let (c, s) = cis_turns(sign * a[i] * b[j]);
        Complex64::new(c, s)
    })
}
