//! Eight numbers at once: exponentials and phases for the hot loops.
//!
//! Written with portable vectors, so that inside `fearless_simd::dispatch!` they become the machine's
//! own instructions. No fused multiply-add is used: every instruction set gives the same bits.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, dispatch, f64x8, u64x8};
use num_complex::Complex64;

use crate::math::simd_level::level;

/// Number of lanes.
pub(crate) const LANES: usize = 8;

/// Eight numbers.
pub(crate) type Lanes = [f64; LANES];

/// 1.5·2⁵²: adding and subtracting it rounds to the nearest integer.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// π/2 in three parts of 33, 33 and 53 bits (Cody and Waite).
const HALF_PI: [f64; 3] = [
    f64::from_bits(0x3FF9_21FB_5440_0000),
    f64::from_bits(0x3DD0_B461_1A60_0000),
    f64::from_bits(0x3BA3_198A_2E03_7073),
];

/// Cosine and sine, to 3e-16 for |x| up to 1e6.
#[inline(always)]
pub(crate) fn cis<S: Simd>(x: f64x8<S>) -> (f64x8<S>, f64x8<S>) {
    // Reduce to |r| ≤ π/4 and the quadrant, kept as the low bits of a shifted double.
    let simd = x.simd;
    let splat = |v: f64| f64x8::splat(simd, v);
    let shifted = x * splat(std::f64::consts::FRAC_2_PI) + splat(ROUND);
    let turns = shifted - splat(ROUND);
    let [high, middle, low] = HALF_PI.map(splat);
    let r = ((x - turns * high) - turns * middle) - turns * low;
    turned(r, shifted.to_bits())
}

/// Cosine and sine of 2πt, to 3e-16 beside the rounding of t itself, for |t| up to 1e14.
#[inline(always)]
pub(crate) fn cis_turns<S: Simd>(t: f64x8<S>) -> (f64x8<S>, f64x8<S>) {
    let splat = |v: f64| f64x8::splat(t.simd, v);
    // The distance to the nearest quarter turn is exact.
    let quarters = t * splat(4.0);
    let shifted = quarters + splat(ROUND);
    let rest = quarters - (shifted - splat(ROUND));
    turned(rest * splat(std::f64::consts::FRAC_PI_2), shifted.to_bits())
}

/// exp(2πi·t) for each t, as [`cis_turns`] has it, written to `out`.
pub(crate) fn phasors(turns: &[f64], out: &mut [Complex64]) {
    dispatch!(level(), simd => phasors_in(simd, turns, out));
}

#[inline(always)]
fn phasors_in<S: Simd>(simd: S, turns: &[f64], out: &mut [Complex64]) {
    for (turns, out) in turns.chunks(LANES).zip(out.chunks_mut(LANES)) {
        let mut eight = [0.0; LANES];
        eight[..turns.len()].copy_from_slice(turns);
        let (cos, sin) = cis_turns(f64x8::from_slice(simd, &eight));
        for (out, (re, im)) in out
            .iter_mut()
            .zip(cos.as_slice().iter().zip(sin.as_slice()))
        {
            *out = Complex64::new(*re, *im);
        }
    }
}

/// Cosine and sine of r + quadrant·π/2 for |r| ≤ π/4; only the quadrant's two low bits count.
#[inline(always)]
fn turned<S: Simd>(r: f64x8<S>, quadrant: u64x8<S>) -> (f64x8<S>, f64x8<S>) {
    let (c, s) = quarter(r);
    // Odd quadrants swap sine and cosine; the signs follow from the two low bits.
    let one = u64x8::splat(r.simd, 1);
    let odd = (quadrant & one).simd_eq(one);
    let (cos, sin) = (odd.select(s, c), odd.select(c, s));
    let half: u64x8<S> = quadrant >> 1;
    let cos_sign = ((quadrant ^ half) & one) << 63;
    let sin_sign = (half & one) << 63;
    (
        f64x8::from_bits(cos.to_bits() ^ cos_sign),
        f64x8::from_bits(sin.to_bits() ^ sin_sign),
    )
}

/// Σ coefficients[i]·z^{n−1−i} by Horner's rule.
#[inline(always)]
fn horner<S: Simd, const N: usize>(z: f64x8<S>, coefficients: [f64; N]) -> f64x8<S> {
    let mut sum = f64x8::splat(z.simd, coefficients[0]);
    for coefficient in &coefficients[1..] {
        sum = sum * z + f64x8::splat(z.simd, *coefficient);
    }
    sum
}

/// Cosine and sine for |r| ≤ π/4: Taylor polynomials of degree 16 and 17.
#[inline(always)]
fn quarter<S: Simd>(r: f64x8<S>) -> (f64x8<S>, f64x8<S>) {
    let z = r * r;
    let c = horner(
        z,
        [
            4.779_477_332_387_385e-14,
            -1.147_074_559_772_972_5e-11,
            2.087_675_698_786_81e-9,
            -2.755_731_922_398_589e-7,
            2.480_158_730_158_73e-5,
            -1.388_888_888_888_889e-3,
            4.166_666_666_666_666_4e-2,
        ],
    );
    let s = horner(
        z,
        [
            2.811_457_254_345_520_6e-15,
            -7.647_163_731_819_816e-13,
            1.605_904_383_682_161_3e-10,
            -2.505_210_838_544_172e-8,
            2.755_731_922_398_589e-6,
            -1.984_126_984_126_984e-4,
            8.333_333_333_333_333e-3,
            -1.666_666_666_666_666_6e-1,
        ],
    );
    let one = f64x8::splat(r.simd, 1.0);
    let half = f64x8::splat(r.simd, 0.5);
    (one - (half * z - z * z * c), r + r * z * s)
}

/// e^x, to 5e-16 relative for −700 ≤ x ≤ 700; held at e^{±700} beyond.
#[inline(always)]
pub(crate) fn exp<S: Simd>(x: f64x8<S>) -> f64x8<S> {
    // x = n ln 2 + r with |r| ≤ ln 2 / 2; ln 2 in two parts.
    let simd = x.simd;
    let splat = |v: f64| f64x8::splat(simd, v);
    let x = x.max(splat(-700.0)).min(splat(700.0));
    let shifted = x * splat(std::f64::consts::LOG2_E) + splat(ROUND);
    let n = shifted - splat(ROUND);
    let r = (x - n * splat(6.931_471_803_691_238e-1)) - n * splat(1.908_214_929_270_587_7e-10);
    let p = horner(
        r,
        [
            1.605_904_383_682_161_3e-10,
            2.087_675_698_786_81e-9,
            2.505_210_838_544_172e-8,
            2.755_731_922_398_589e-7,
            2.755_731_922_398_589e-6,
            2.480_158_730_158_73e-5,
            1.984_126_984_126_984e-4,
            1.388_888_888_888_889e-3,
            8.333_333_333_333_333e-3,
            4.166_666_666_666_666_4e-2,
            1.666_666_666_666_666_6e-1,
            0.5,
        ],
    );
    let value = splat(1.0) + (r + r * r * p);
    // 2ⁿ through the exponent bits.
    let power: u64x8<S> = (shifted.to_bits() + u64x8::splat(simd, 1023)) << 52;
    value * f64x8::from_bits(power)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Simd, SimdBase, dispatch, f64x8};
    use num_complex::Complex64;

    use crate::math::lanes::{LANES, Lanes, cis, cis_turns, exp, phasors};
    use crate::math::simd_level::level;

    #[inline(always)]
    fn run<S: Simd>(simd: S, x: &Lanes) -> [Lanes; 3] {
        let x = f64x8::from_slice(simd, x);
        let (cos, sin) = cis(x);
        [*cos.as_array(), *sin.as_array(), *exp(x).as_array()]
    }

    #[test]
    fn cis_matches_the_standard_library() {
        let mut x = -1.0e5;
        while x < 1.0e5 {
            let lanes: Lanes = std::array::from_fn(|i| x + i as f64 * 0.37);
            let [cos, sin, _] = dispatch!(level(), simd => run(simd, &lanes));
            for i in 0..LANES {
                assert!((cos[i] - lanes[i].cos()).abs() < 3e-16, "cos {}", lanes[i]);
                assert!((sin[i] - lanes[i].sin()).abs() < 3e-16, "sin {}", lanes[i]);
            }
            x += 17.317;
        }
    }

    #[inline(always)]
    fn turn<S: Simd>(simd: S, t: &Lanes) -> [Lanes; 2] {
        let (cos, sin) = cis_turns(f64x8::from_slice(simd, t));
        [*cos.as_array(), *sin.as_array()]
    }

    #[test]
    fn turns_match_the_standard_library() {
        for step in -3000..3000 {
            let lanes: Lanes = std::array::from_fn(|i| f64::from(step) / 97.0 + i as f64 * 0.0137);
            let far = lanes.map(|t| t + 1_048_576.0);
            let [cos, sin] = dispatch!(level(), simd => turn(simd, &lanes));
            let [far_cos, far_sin] = dispatch!(level(), simd => turn(simd, &far));
            for i in 0..LANES {
                let x = std::f64::consts::TAU * lanes[i].fract();
                assert!((cos[i] - x.cos()).abs() < 1e-15, "cos {}", lanes[i]);
                assert!((sin[i] - x.sin()).abs() < 1e-15, "sin {}", lanes[i]);
                // A million turns on, only the rounding of the argument shows.
                assert!((far_cos[i] - cos[i]).abs() < 1e-9);
                assert!((far_sin[i] - sin[i]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn lists_of_any_length_have_their_phasors() {
        for count in [0, 1, 7, 8, 21] {
            let turns: Vec<f64> = (0..count).map(|i| 0.0137 * f64::from(i) - 0.4).collect();
            let mut found = vec![Complex64::ZERO; turns.len()];
            phasors(&turns, &mut found);
            for (found, turn) in found.iter().zip(turns) {
                assert!((found - Complex64::cis(std::f64::consts::TAU * turn)).norm() < 1e-15);
            }
        }
    }

    #[test]
    fn exp_matches_the_standard_library() {
        for step in -6900..6900 {
            let lanes: Lanes = std::array::from_fn(|i| f64::from(step) * 0.1 + i as f64 * 0.0123);
            let [_, _, exp] = dispatch!(level(), simd => run(simd, &lanes));
            for (ours, x) in exp.iter().zip(lanes) {
                assert!((ours / x.exp() - 1.0).abs() < 5e-16, "{x}");
            }
        }
    }
}
