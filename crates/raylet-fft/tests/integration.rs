//! The transforms against the sums that define them.

use std::f64::consts::TAU;

use num_complex::Complex64;
use raylet_fft::Planner;

/// Both plans against the sums that define them, for lengths with small and large prime factors.
#[test]
fn plans_are_the_sums_that_they_promise() {
    for length in [1, 2, 12, 31, 97] {
        let given: Vec<Complex64> = (0..length)
            .map(|j| Complex64::new(1.0 / (j as f64 + 1.0), j as f64))
            .collect();
        for (sign, plan) in [
            (-1.0, Planner::new().forward(length)),
            (1.0, Planner::new().inverse(length)),
        ] {
            let mut found = given.clone();
            plan.process(&mut found);
            for (m, found) in found.iter().enumerate() {
                let turn = |j: usize| {
                    Complex64::cis(sign * TAU * ((j * m) % length) as f64 / length as f64)
                };
                let sum: Complex64 = given.iter().enumerate().map(|(j, x)| x * turn(j)).sum();
                assert!(
                    (found - sum).norm() < 1e-11 * (length * length) as f64,
                    "{length}, {sign}: {m}"
                );
            }
        }
    }
}
