//! Bessel functions of whole order, by sums over equal steps of their integrals, which are exact to rounding.

use std::f64::consts::PI;

/// J_l(x) = π⁻¹∫cos(lτ − x sin τ)dτ over half a turn: the integrand is periodic and its band ends a little beyond |x| + l.
pub(crate) fn bessel_j(order: u32, x: f64) -> f64 {
    let l = f64::from(order);
    let count = (x.abs() + l + 24.0).ceil();
    let part = |n: u32| {
        let turn = PI * (f64::from(n) + 0.5) / count;
        (l * turn - x * turn.sin()).cos()
    };
    (0..count as u32).map(part).sum::<f64>() / count
}

/// Steps of the integral of K_l, and the exponent from which the rest is below rounding.
const STEP: f64 = 0.1;
const NOTHING: f64 = 45.0;

/// e^x K_l(x) = ∫exp(x(1 − cosh t)) cosh(lt)dt from zero on, for x > 0: the integrand falls faster than any exponential.
pub(crate) fn scaled_bessel_k(order: u32, x: f64) -> f64 {
    let l = f64::from(order);
    let mut sum = 0.5;
    for n in 1u32.. {
        let t = STEP * f64::from(n);
        let sunk = x * (t.cosh() - 1.0);
        if sunk - l * t > NOTHING {
            break;
        }
        sum += (-sunk).exp() * (l * t).cosh();
    }
    STEP * sum
}

#[cfg(test)]
mod tests {
    use crate::math::bessel::{bessel_j, scaled_bessel_k};

    /// Values of Abramowitz and Stegun, tables 9.1, 9.2 and 9.8, and zeros of table 9.5.
    #[test]
    fn values_are_those_of_the_tables() {
        for (order, x, exact) in [
            (0, 1.0, 0.765_197_686_557_966_6),
            (1, 2.0, 0.576_724_807_756_873_4),
            (2, 10.0, 0.254_630_313_685_120_6),
            (0, 2.404_825_557_695_773, 0.0),
            (1, 3.831_705_970_207_512_3, 0.0),
            (2, 5.135_622_301_840_683, 0.0),
        ] {
            let found = bessel_j(order, x);
            assert!((found - exact).abs() < 1e-14, "J_{order}({x}) = {found}");
        }
        for (order, x, exact) in [
            (0, 1.0f64, 0.421_024_438_240_708_3),
            (1, 1.0, 0.601_907_230_197_234_6),
            (0, 0.1, 2.427_069_024_702_017),
            (1, 5.0, 0.004_044_613_445_452_164),
        ] {
            let found = (-x).exp() * scaled_bessel_k(order, x);
            assert!(
                (found / exact - 1.0).abs() < 1e-13,
                "K_{order}({x}) = {found}"
            );
        }
    }

    /// Wronski's relations between neighbours: K_{l+1}(x) = K_{l−1}(x) + (2l/x)K_l(x), and the same for J.
    #[test]
    fn neighbouring_orders_fit() {
        for x in [0.02, 0.7, 3.0, 40.0] {
            for l in 1..5 {
                let twice = 2.0 * f64::from(l) / x;
                let [below, here, above] = [l - 1, l, l + 1].map(|l| scaled_bessel_k(l, x));
                assert!(((below + twice * here) / above - 1.0).abs() < 1e-12);
                let [below, here, above] = [l - 1, l, l + 1].map(|l| bessel_j(l, x));
                assert!((twice * here - below - above).abs() < 1e-12 * twice.max(1.0));
            }
        }
    }
}
