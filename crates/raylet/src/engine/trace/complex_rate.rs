//! The derivative of complex values with respect to a parameter, from their values a little below and a little above.

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
pub(crate) fn pull_rate<'a, V: IntoIterator<Item = &'a Complex64>>(
    [below, above]: [V; 2],
    here: V,
    bar: V,
    distance: f64,
) -> f64 {
    let terms = below.into_iter().zip(above).zip(here.into_iter().zip(bar));
    terms
        .map(|((below, above), (here, bar))| {
            (bar.conj() * rate(*below, *here, *above, distance)).re
        })
        .sum()
}
