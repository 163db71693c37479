//! Random arrays and the inner products of dot-product tests.

use ndarray::Array2;
use num_complex::Complex64;

use crate::math::random::pair;

/// Random numbers of the square about zero, other ones for each purpose.
pub(crate) fn noise(shape: impl Into<(usize, usize)>, purpose: u32) -> Array2<Complex64> {
    Array2::from_shape_fn(shape.into(), |(j, i)| {
        let [re, im] = pair(19, [j as u32, i as u32, purpose, 0]);
        Complex64::new(re - 0.5, im - 0.5)
    })
}

/// Holds that Σ ȳ*·Ax = Σ (Aᴴȳ)*·x, from pairs of ȳ with Ax and of Aᴴȳ with x.
#[track_caller]
pub(crate) fn assert_transposed(
    there: &[(&Array2<Complex64>, &Array2<Complex64>)],
    back: &[(&Array2<Complex64>, &Array2<Complex64>)],
) {
    let inner = |pairs: &[(&Array2<Complex64>, &Array2<Complex64>)]| -> Complex64 {
        let one = |(a, b): &(&Array2<Complex64>, &Array2<Complex64>)| -> Complex64 {
            a.iter().zip(*b).map(|(a, b)| a.conj() * b).sum()
        };
        pairs.iter().map(one).sum()
    };
    let square = |list: &Array2<Complex64>| list.iter().map(|v| v.norm_sqr()).sum::<f64>();
    let sizes: [f64; 2] = [
        there.iter().map(|(a, _)| square(a)).sum(),
        there.iter().map(|(_, b)| square(b)).sum(),
    ];
    let (there, back) = (inner(there), inner(back));
    let size = (sizes[0] * sizes[1]).sqrt();
    let error = (there - back).norm() / size;
    assert!(
        size > 0.0 && error < 1e-13,
        "{there} there, {back} back: {error:e}"
    );
}
