//! The phase factor exp(iφ), written so that a loop over it vectorises.

/// 2^52 + 2^51: adding and subtracting it rounds to the nearest whole number.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Taylor coefficients of sin θ/θ in θ².
const SINE: [f64; 11] = inverse_factorials(1);

/// Taylor coefficients of cos θ in θ².
const COSINE: [f64; 11] = inverse_factorials(0);

/// (−1)^i/(2i + `first`)! for i = 0 ..= 10.
const fn inverse_factorials(first: usize) -> [f64; 11] {
    let mut series = [1.0; 11];
    let mut index = 1;
    while index < 11 {
        let last = 2 * index + first;
        series[index] = -series[index - 1] / ((last * (last - 1)) as f64);
        index += 1;
    }
    series
}

/// Cosine and sine of 2π·`turns`; absolute error below 1e-15 beside that of `turns`,
/// for |`turns`| < 2^50.
#[inline(always)]
pub fn cis_turns(turns: f64) -> (f64, f64) {
    // Half the angle, θ = π(turns − nearest whole turn), lies in [−π/2, π/2].
    let nearest = (turns + ROUND) - ROUND;
    let theta = (turns - nearest) * std::f64::consts::PI;
    let square = theta * theta;

    // Taylor series of sin θ and cos θ: the first terms left out are below 1e-17.
    let mut sine = SINE[10];
    let mut cosine = COSINE[10];
    for term in (0..10).rev() {
        sine = SINE[term] + square * sine;
        cosine = COSINE[term] + square * cosine;
    }
    sine *= theta;

    // Double the angle.
    (1.0 - 2.0 * sine * sine, 2.0 * sine * cosine)
}

#[cfg(test)]
mod tests {
    use crate::numerics::phase::cis_turns;

    #[test]
    fn agrees_with_the_standard_library() {
        for step in -4000..4000 {
            let turns = 0.000_731 * f64::from(step);
            let (sine, cosine) = (turns * std::f64::consts::TAU).sin_cos();
            let (c, s) = cis_turns(turns);
            assert!(
                (c - cosine).abs() < 4e-15 && (s - sine).abs() < 4e-15,
                "{turns}"
            );
        }
        // Far from zero only the fraction of a turn counts.
        let (c, s) = cis_turns(1e9 + 0.125);
        assert!((c - s).abs() < 1e-15 && (c - 0.5_f64.sqrt()).abs() < 1e-15);
    }
}
