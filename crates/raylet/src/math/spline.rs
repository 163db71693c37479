//! Cubic splines, twice continuously differentiable: through equally spaced values, exact for cubics, and through values at
//! any knots that begin with a slope of zero.

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

/// The pieces of the cubic spline that takes the `values` at growing `knots` and begins with a slope of zero, as an even
/// function of what is counted from the first knot does. Each is (a, b, c, d) of a + bt + ct² + dt³ with t from its knot.
/// The third derivative is continuous at the last knot but one; beyond the last knot the last piece keeps its curvature.
///
/// # Panics
/// With fewer than [`FEWEST`] values, or another number of knots.
pub(crate) fn even_pieces(knots: &[f64], values: &[f64]) -> Vec<[f64; 4]> {
    let n = values.len();
    assert!(n >= FEWEST && knots.len() == n, "{n} values");
    let steps: Vec<f64> = knots.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let rises: Vec<f64> = (0..n - 1)
        .map(|i| (values[i + 1] - values[i]) / steps[i])
        .collect();
    let second = second_derivatives(&steps, &rises);

    let piece = |i: usize| {
        let (h, rise) = (steps[i], rises[i]);
        let slope = rise - h * (2.0 * second[i] + second[i + 1]) / 6.0;
        let third = (second[i + 1] - second[i]) / (6.0 * h);
        [values[i], slope, 0.5 * second[i], third]
    };
    let mut pieces: Vec<[f64; 4]> = (0..n - 1).map(piece).collect();
    let ([_, b, c, d], h) = (pieces[n - 2], steps[n - 2]);
    let slope = b + h * (2.0 * c + 3.0 * d * h);
    pieces.push([values[n - 1], slope, 0.5 * second[n - 1], 0.0]);
    pieces
}

/// The second derivatives at the knots of [`even_pieces`], from the steps between knots and the mean slopes over them.
fn second_derivatives(steps: &[f64], rises: &[f64]) -> Vec<f64> {
    let n = steps.len() + 1;
    // Row i: before·m[i−1] + here·m[i] + after·m[i+1] = right. The first row holds the slope, and the last second derivative
    // is replaced by what the two before it make of it: m[n−1] = (1 + q) m[n−2] − q m[n−3].
    let q = steps[n - 2] / steps[n - 3];
    let mut second = vec![0.0; n];
    let mut above = vec![0.0; n];
    for i in 0..n - 1 {
        let (before, right) = match i {
            0 => (0.0, 6.0 * rises[0]),
            _ => (steps[i - 1], 6.0 * (rises[i] - rises[i - 1])),
        };
        let (mut before, mut here, mut after) = (before, 2.0 * (before + steps[i]), steps[i]);
        if i == n - 2 {
            here += after * (1.0 + q);
            before -= after * q;
            after = 0.0;
        }
        let (last, over) = match i {
            0 => (0.0, 0.0),
            _ => (second[i - 1], above[i - 1]),
        };
        let pivot = 1.0 / (here - before * over);
        above[i] = after * pivot;
        second[i] = (right - before * last) * pivot;
    }
    for i in (0..n - 2).rev() {
        second[i] -= above[i] * second[i + 1];
    }
    second[n - 1] = (1.0 + q) * second[n - 2] - q * second[n - 3];
    second
}

#[cfg(test)]
mod tests {
    use crate::math::spline::{coefficients, even_pieces, weights};

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

    /// A cubic without a linear part comes back from any knots; the pieces meet with their first two derivatives.
    #[test]
    fn even_pieces_are_exact_for_cubics_that_begin_level() {
        let cubic = |t: f64| 0.3 + 0.7 * t * t - 0.2 * t * t * t;
        let knots = [0.0, 0.1, 0.4, 0.5, 1.1, 1.9];
        for n in 4..=knots.len() {
            let knots = &knots[..n];
            let values: Vec<f64> = knots.iter().map(|t| cubic(*t)).collect();
            let pieces = even_pieces(knots, &values);
            assert_eq!(pieces.len(), n);
            for (i, [a, b, c, d]) in pieces.iter().enumerate().take(n - 1) {
                for share in [0.0, 0.3, 1.0] {
                    let t = share * (knots[i + 1] - knots[i]);
                    let found = a + t * (b + t * (c + t * d));
                    assert!((found - cubic(knots[i] + t)).abs() < 1e-13, "{n} {i}");
                }
            }
        }
    }

    #[test]
    fn even_pieces_join_smoothly_and_err_with_the_fourth_power() {
        let wave = |t: f64| (3.0 * t * t).cos();
        let worst = |n: usize| {
            let at = |i: usize| {
                let share = i as f64 / (n - 1) as f64;
                1.2 * share * (0.7 + 0.3 * share)
            };
            let knots: Vec<f64> = (0..n).map(at).collect();
            let values: Vec<f64> = knots.iter().map(|t| wave(*t)).collect();
            let pieces = even_pieces(&knots, &values);
            let mut worst = 0.0f64;
            for (i, [a, b, c, d]) in pieces.iter().enumerate().take(n - 1) {
                let h = knots[i + 1] - knots[i];
                let [_, slope, bend, _] = pieces[i + 1];
                assert!((b + h * (2.0 * c + 3.0 * d * h) - slope).abs() < 1e-9);
                assert!((c + 3.0 * d * h - bend).abs() < 1e-9);
                let t = 0.5 * h;
                worst = worst.max((a + t * (b + t * (c + t * d)) - wave(knots[i] + t)).abs());
            }
            worst
        };
        let (coarse, fine) = (worst(31), worst(61));
        assert!(coarse < 6e-4 && coarse / fine > 12.0, "{coarse} {fine}");
    }
}
