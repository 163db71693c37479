//! The derivative of complex values with respect to a parameter, from their values a little below and a little above.

use ndarray::Array2;
use num_complex::Complex64;

/// d(value)/dq from the values a little below and above: through the logarithm, whose steps a phase makes
/// evenly, unless one of them is dark.
fn rate(below: Complex64, here: Complex64, above: Complex64, distance: f64) -> Complex64 {
    if below == Complex64::ZERO || above == Complex64::ZERO {
        return (above - below) / distance;
    }
    here * (above / below).ln() / distance
}

/// Re Σ bar*·d(value)/dq.
pub(crate) fn pull_rate(
    [below, above]: [&Array2<Complex64>; 2],
    here: &Array2<Complex64>,
    bar: &Array2<Complex64>,
    distance: f64,
) -> f64 {
    let terms = below.iter().zip(above).zip(here.iter().zip(bar));
    terms
        .map(|((below, above), (here, bar))| {
            (bar.conj() * rate(*below, *here, *above, distance)).re
        })
        .sum()
}
