//! The Bessel functions J₀ and J₁ along a list of arguments, in loops that vectorise.

use crate::numerics::phase::cis_turns;

/// From this argument on Hankel's expansion with [`TERMS`] terms each is exact to 1e-14.
const FAR: f64 = 32.0;

/// Terms of each of the two series of Hankel's expansion.
const TERMS: usize = 6;

/// The series P and Q of order 0 and of order 1, in powers of 1/x², Q without its first factor 1/x.
const SERIES: [[[f64; TERMS]; 2]; 2] = [hankel(0.0), hankel(1.0)];

/// Coefficients of Hankel's expansion of J_ν: aₖ = aₖ₋₁ (4ν² − (2k−1)²)/(8k), those of even k for P and of odd k for Q, with
/// alternating signs.
const fn hankel(order: f64) -> [[f64; TERMS]; 2] {
    let mut series = [[1.0; TERMS]; 2];
    let mut term = 1.0;
    let mut k = 0;
    while k < 2 * TERMS {
        if k > 0 {
            let odd = (2 * k - 1) as f64;
            term *= (4.0 * order * order - odd * odd) / (8.0 * k as f64);
        }
        let sign = if (k / 2) % 2 == 0 { 1.0 } else { -1.0 };
        series[k % 2][k / 2] = sign * term;
        k += 1;
    }
    series
}

/// Writes J₀(x) and J₁(x) for x = 2π·`rate`·`at`, for `at` ≥ 0 that grow along the list.
#[inline(always)]
pub fn bessel_pair(rate: f64, at: &[f64], zero: &mut [f64], one: &mut [f64]) {
    let tau = std::f64::consts::TAU;
    let near = at.partition_point(|at| tau * rate * at < FAR);
    for i in 0..near {
        let x = tau * rate * at[i];
        zero[i] = libm::j0(x);
        one[i] = libm::j1(x);
    }
    let far = zero[near..].iter_mut().zip(one[near..].iter_mut());
    for (at, (zero, one)) in at[near..].iter().zip(far) {
        [*zero, *one] = far_pair(rate * at);
    }
}

/// J₀ and J₁ by Hankel's expansion, at 2π times this many turns.
#[inline(always)]
fn far_pair(turns: f64) -> [f64; 2] {
    let inverse = 1.0 / (std::f64::consts::TAU * turns);
    let square = inverse * inverse;
    let sum = |series: &[f64; TERMS]| {
        let mut sum = series[TERMS - 1];
        for term in (0..TERMS - 1).rev() {
            sum = series[term] + square * sum;
        }
        sum
    };

    // The angle of J₁ is a quarter turn behind that of J₀.
    let (cosine, sine) = cis_turns(turns - 0.125);
    let amplitude = 1.0 / (std::f64::consts::PI * turns.sqrt());
    let [[p, q], [p_one, q_one]] = &SERIES;
    let zero = sum(p) * cosine - inverse * sum(q) * sine;
    let one = sum(p_one) * sine + inverse * sum(q_one) * cosine;
    [amplitude * zero, amplitude * one]
}

#[cfg(test)]
mod tests {
    use crate::numerics::bessel::bessel_pair;

    /// On both sides of the argument at which the expansion takes over, and far away.
    #[test]
    fn equals_the_library() {
        let at: Vec<f64> = (0..4000).map(|i| f64::from(i) * 0.37).collect();
        for rate in [0.001, 0.07, 1.3] {
            let (mut zero, mut one) = (vec![0.0; at.len()], vec![0.0; at.len()]);
            bessel_pair(rate, &at, &mut zero, &mut one);
            for (i, at) in at.iter().enumerate() {
                let x = std::f64::consts::TAU * rate * at;
                assert!((zero[i] - libm::j0(x)).abs() < 3e-14, "J0 at {x}");
                assert!((one[i] - libm::j1(x)).abs() < 3e-14, "J1 at {x}");
            }
        }
    }
}
