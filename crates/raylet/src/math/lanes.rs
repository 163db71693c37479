//! Eight numbers at once: exponentials and phases for the hot loops.
//!
//! The functions are plain loops over `[f64; 8]`; called inside `fearless_simd::dispatch!` they become
//! vector instructions. No fused multiply-add is used, so every instruction set gives the same bits.

/// Number of lanes.
pub const LANES: usize = 8;

/// Eight numbers.
pub type Lanes = [f64; LANES];

/// 1.5·2⁵²: adding and subtracting it rounds to the nearest integer.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// π/2 in three parts of 33, 33 and 53 bits (Cody and Waite).
const HALF_PI: [f64; 3] = [
    f64::from_bits(0x3FF9_21FB_5440_0000),
    f64::from_bits(0x3DD0_B461_1A60_0000),
    f64::from_bits(0x3BA3_198A_2E03_7073),
];

/// Cosine and sine, to 2e-16 for |x| up to 1e6.
#[inline(always)]
pub fn cis(x: Lanes) -> (Lanes, Lanes) {
    let (mut cos, mut sin) = ([0.0; LANES], [0.0; LANES]);
    for i in 0..LANES {
        // Reduce to |r| ≤ π/4 and the quadrant, kept as the low bits of a shifted double.
        let shifted = x[i] * std::f64::consts::FRAC_2_PI + ROUND;
        let turns = shifted - ROUND;
        let r = ((x[i] - turns * HALF_PI[0]) - turns * HALF_PI[1]) - turns * HALF_PI[2];
        (cos[i], sin[i]) = turned(r, shifted.to_bits());
    }
    (cos, sin)
}

/// Cosine and sine of 2πt, to 3e-16 beside the rounding of t itself, for |t| up to 1e14.
#[inline(always)]
pub fn cis_turns(t: Lanes) -> (Lanes, Lanes) {
    let (mut cos, mut sin) = ([0.0; LANES], [0.0; LANES]);
    for i in 0..LANES {
        // The distance to the nearest quarter turn is exact.
        let shifted = 4.0 * t[i] + ROUND;
        let rest = 4.0 * t[i] - (shifted - ROUND);
        let r = rest * std::f64::consts::FRAC_PI_2;
        (cos[i], sin[i]) = turned(r, shifted.to_bits());
    }
    (cos, sin)
}

/// Cosine and sine of r + quadrant·π/2 for |r| ≤ π/4; only the quadrant's two low bits count.
#[inline(always)]
fn turned(r: f64, quadrant: u64) -> (f64, f64) {
    let (c, s) = quarter(r);
    // Odd quadrants swap sine and cosine; the signs follow from the two low bits.
    let odd = quadrant & 1 == 1;
    let (c, s) = if odd { (s, c) } else { (c, s) };
    let cos_sign = ((quadrant ^ (quadrant >> 1)) & 1) << 63;
    let sin_sign = ((quadrant >> 1) & 1) << 63;
    (
        f64::from_bits(c.to_bits() ^ cos_sign),
        f64::from_bits(s.to_bits() ^ sin_sign),
    )
}

/// Cosine and sine for |r| ≤ π/4: Taylor polynomials of degree 16 and 17.
#[inline(always)]
fn quarter(r: f64) -> (f64, f64) {
    let z = r * r;
    let mut c = 4.779_477_332_387_385e-14;
    c = c * z - 1.147_074_559_772_972_5e-11;
    c = c * z + 2.087_675_698_786_81e-9;
    c = c * z - 2.755_731_922_398_589e-7;
    c = c * z + 2.480_158_730_158_73e-5;
    c = c * z - 1.388_888_888_888_889e-3;
    c = c * z + 4.166_666_666_666_666_4e-2;
    let cos = 1.0 - (0.5 * z - z * z * c);
    let mut s = 2.811_457_254_345_520_6e-15;
    s = s * z - 7.647_163_731_819_816e-13;
    s = s * z + 1.605_904_383_682_161_3e-10;
    s = s * z - 2.505_210_838_544_172e-8;
    s = s * z + 2.755_731_922_398_589e-6;
    s = s * z - 1.984_126_984_126_984e-4;
    s = s * z + 8.333_333_333_333_333e-3;
    s = s * z - 1.666_666_666_666_666_6e-1;
    (cos, r + r * z * s)
}

/// e^x, to 4e-16 relative for −700 ≤ x ≤ 700; zero below.
#[inline(always)]
pub fn exp(x: Lanes) -> Lanes {
    let mut out = [0.0; LANES];
    for i in 0..LANES {
        // x = n ln 2 + r with |r| ≤ ln 2 / 2; ln 2 in two parts.
        let clamped = x[i].clamp(-700.0, 700.0);
        let shifted = clamped * std::f64::consts::LOG2_E + ROUND;
        let n = shifted - ROUND;
        let r = (clamped - n * 6.931_471_803_691_238e-1) - n * 1.908_214_929_270_587_7e-10;
        let mut p = 1.605_904_383_682_161_3e-10;
        p = p * r + 2.087_675_698_786_81e-9;
        p = p * r + 2.505_210_838_544_172e-8;
        p = p * r + 2.755_731_922_398_589e-7;
        p = p * r + 2.755_731_922_398_589e-6;
        p = p * r + 2.480_158_730_158_73e-5;
        p = p * r + 1.984_126_984_126_984e-4;
        p = p * r + 1.388_888_888_888_889e-3;
        p = p * r + 8.333_333_333_333_333e-3;
        p = p * r + 4.166_666_666_666_666_4e-2;
        p = p * r + 1.666_666_666_666_666_6e-1;
        p = p * r + 0.5;
        let value = 1.0 + (r + r * r * p);
        // 2ⁿ through the exponent bits.
        let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
        out[i] = if x[i] < -700.0 { 0.0 } else { value * power };
    }
    out
}

#[cfg(test)]
mod tests {
    use crate::math::lanes::{LANES, cis, cis_turns, exp};

    #[test]
    fn cis_matches_the_standard_library() {
        let mut x = -1.0e5;
        while x < 1.0e5 {
            let lanes = std::array::from_fn(|i| x + i as f64 * 0.37);
            let (cos, sin) = cis(lanes);
            for i in 0..LANES {
                assert!((cos[i] - lanes[i].cos()).abs() < 3e-16, "cos {}", lanes[i]);
                assert!((sin[i] - lanes[i].sin()).abs() < 3e-16, "sin {}", lanes[i]);
            }
            x += 17.317;
        }
    }

    #[test]
    fn turns_match_the_standard_library() {
        for step in -3000..3000 {
            let lanes = std::array::from_fn(|i| f64::from(step) / 97.0 + i as f64 * 0.0137);
            let (cos, sin) = cis_turns(lanes);
            let (far_cos, far_sin) = cis_turns(lanes.map(|t| t + 1048576.0));
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
    fn exp_matches_the_standard_library() {
        for step in -6900..6900 {
            let lanes = std::array::from_fn(|i| f64::from(step) * 0.1 + i as f64 * 0.0123);
            for (ours, x) in exp(lanes).iter().zip(lanes) {
                assert!((ours / x.exp() - 1.0).abs() < 5e-16, "{x}");
            }
        }
        assert_eq!(exp([-800.0; LANES])[0], 0.0);
    }
}
