//! The inner products of dot-product tests.

use ndarray::Array2;
use num_complex::Complex64;

/// Holds that Σ ȳ*·Ax = Σ (Aᴴȳ)*·x, from pairs of ȳ with Ax and of Aᴴȳ with x.
#[track_caller]
pub fn assert_transposed(
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
