//! Cubic splines through equally spaced values: twice continuously differentiable, exact for cubics.

use crate::math::real::Real;

/// Fewest values that such a spline passes through.
pub(crate) const FEWEST: usize = 4;

/// The coefficients of the cubic B-spline that takes the `values` at 0, 1, 2, …, two more than values;
/// the first belongs to the knot before the first value. The third derivative is continuous at the
/// second knot from either end ("not a knot").
///
/// # Panics
/// With fewer than [`FEWEST`] values.
pub(crate) fn coefficients(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    assert!(n >= FEWEST, "{n} values");
    // c[i + 1] belongs to value i: (c[i] + 4 c[i+1] + c[i+2]) / 6 = values[i]. At the second value the
    // condition of the ends gives its coefficient at once.
    let mut c = vec![0.0; n + 2];
    let second = |a: f64, b: f64, d: f64| (8.0 * b - a - d) / 6.0;
    c[2] = second(values[0], values[1], values[2]);
    c[n - 1] = second(values[n - 1], values[n - 2], values[n - 3]);

    // Between them stands a tridiagonal system with ones beside fours: eliminate, then substitute.
    let mut above = vec![0.0; n + 2];
    for i in 3..n - 1 {
        let pivot = 1.0 / (4.0 - above[i - 1]);
        above[i] = pivot;
        c[i] = (6.0 * values[i - 1] - c[i - 1]) * pivot;
    }
    for i in (3..n - 1).rev() {
        c[i] -= above[i] * c[i + 1];
    }

    // What is left follows from the first and last two values.
    c[1] = 6.0 * values[1] - 4.0 * c[2] - c[3];
    c[0] = 6.0 * values[0] - 4.0 * c[1] - c[2];
    c[n] = 6.0 * values[n - 2] - 4.0 * c[n - 1] - c[n - 2];
    c[n + 1] = 6.0 * values[n - 1] - 4.0 * c[n] - c[n - 1];
    c
}

/// The weights of four neighbouring coefficients at the share `t` of the way from the second one's knot
/// to the third one's.
#[inline(always)]
pub(crate) fn weights<T: Real>(t: T) -> [T; 4] {
    let s = -t + 1.0;
    let inner = |t: T| ((t * 3.0 - 6.0) * t * t + 4.0) * (1.0 / 6.0);
    [
        s * s * s * (1.0 / 6.0),
        inner(t),
        inner(s),
        t * t * t * (1.0 / 6.0),
    ]
}

#[cfg(test)]
mod tests {
    use crate::math::spline::{coefficients, weights};

    fn value(c: &[f64], u: f64) -> f64 {
        let last = c.len() - 4;
        let i = (u as usize).min(last);
        let pairs = weights(u - i as f64).into_iter().zip(&c[i..]);
        pairs.map(|(w, c)| w * c).sum()
    }

    #[test]
    fn cubics_come_back_exactly() {
        let cubic = |u: f64| 0.3 - 1.1 * u + 0.7 * u * u - 0.05 * u * u * u;
        for n in 4..12 {
            let values: Vec<f64> = (0..n).map(|i| cubic(f64::from(i))).collect();
            let c = coefficients(&values);
            for step in 0..=50 {
                let u = f64::from(n - 1) * f64::from(step) / 50.0;
                assert!((value(&c, u) - cubic(u)).abs() < 1e-12, "{n} {u}");
            }
        }
    }

    #[test]
    fn values_are_met_and_the_error_falls_with_the_fourth_power() {
        let wave = |x: f64| (2.0 * x).sin();
        let worst = |n: usize| {
            let h = 3.0 / (n - 1) as f64;
            let values: Vec<f64> = (0..n).map(|i| wave(i as f64 * h)).collect();
            let c = coefficients(&values);
            for (i, expected) in values.iter().enumerate() {
                assert!((value(&c, i as f64) - expected).abs() < 1e-14);
            }
            let at = |i: i32| f64::from(i) / 1000.0 * (n - 1) as f64;
            (0..=1000)
                .map(|i| (value(&c, at(i)) - wave(at(i) * h)).abs())
                .fold(0.0, f64::max)
        };
        let (coarse, fine) = (worst(41), worst(81));
        assert!(coarse < 2e-5 && coarse / fine > 12.0, "{coarse} {fine}");
    }
}
