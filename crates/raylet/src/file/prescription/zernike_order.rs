//! Zernike polynomials in the orders of other programs, as coefficients in Noll's order and normalisation.
//!
//! Standard ones of OpticStudio are Noll's: its lists of coefficients print their formulas, 4^(1/2) ρ cos A and so on. Fringe ones
//! have no factor before the radial polynomial, and stand by n + |m|; the last one, of number 37, is that of ρ¹² alone.

use crate::optics::zernike::{noll_factor, noll_index};

/// Fringe polynomials that have a number.
pub(crate) const MOST_FRINGE: usize = 37;

/// Radial order n and signed azimuthal order m, negative for sines, of a fringe polynomial by its number from 1.
fn fringe_orders(number: usize) -> (u32, i32) {
    if number == MOST_FRINGE {
        return (12, 0);
    }
    // Polynomials of n + |m| = 2 group follow those of lower groups, from the highest |m| down, cosines before sines.
    let group = (number - 1).isqrt();
    let rank = number - 1 - group * group;
    let order = group - rank / 2;
    let m = order as i32;
    let signed = if rank % 2 == 1 { -m } else { m };
    ((2 * group - order) as u32, signed)
}

/// Coefficients of fringe polynomials 1, 2, … as those of Noll's; polynomials beyond 37 have none.
pub(crate) fn noll_of_fringe(coefficients: &[f64]) -> Vec<f64> {
    let mut noll = Vec::new();
    for (number, a) in (1..=MOST_FRINGE).zip(coefficients) {
        let (n, m) = fringe_orders(number);
        let Some(index) = noll_index(n, m).filter(|_| *a != 0.0) else {
            continue;
        };
        if noll.len() < index {
            noll.resize(index, 0.0);
        }
        if let Some(place) = noll.get_mut(index - 1) {
            *place += a / noll_factor(n, m);
        }
    }
    noll
}

/// Adds a · r² to a sum over a radius, in Noll's coefficients: r² = ρ² (1 + Z₄/√3)/2.
pub(crate) fn add_square(noll: &mut Vec<f64>, a: f64, radius: f64) {
    if noll.len() < 4 {
        noll.resize(4, 0.0);
    }
    let half = 0.5 * a * radius * radius;
    if let [piston, _, _, defocus, ..] = noll.as_mut_slice() {
        *piston += half;
        *defocus += half / 3f64.sqrt();
    }
}

#[cfg(test)]
mod tests {
    use crate::file::prescription::zernike_order::{add_square, noll_of_fringe};
    use crate::optics::zernike::ZernikeSum;

    /// The formulas as the University of Arizona and OpticStudio list them.
    fn listed(number: usize, p: f64, a: f64) -> f64 {
        let (c, s) = (|m: f64| (m * a).cos(), |m: f64| (m * a).sin());
        let e = |k: i32| p.powi(k);
        match number {
            1 => 1.0,
            2 => p * c(1.0),
            3 => p * s(1.0),
            4 => 2.0 * e(2) - 1.0,
            5 => e(2) * c(2.0),
            6 => e(2) * s(2.0),
            7 => (3.0 * e(2) - 2.0) * p * c(1.0),
            8 => (3.0 * e(2) - 2.0) * p * s(1.0),
            9 => 6.0 * e(4) - 6.0 * e(2) + 1.0,
            10 => e(3) * c(3.0),
            11 => e(3) * s(3.0),
            12 => (4.0 * e(2) - 3.0) * e(2) * c(2.0),
            13 => (4.0 * e(2) - 3.0) * e(2) * s(2.0),
            14 => (10.0 * e(4) - 12.0 * e(2) + 3.0) * p * c(1.0),
            15 => (10.0 * e(4) - 12.0 * e(2) + 3.0) * p * s(1.0),
            16 => 20.0 * e(6) - 30.0 * e(4) + 12.0 * e(2) - 1.0,
            17 => e(4) * c(4.0),
            18 => e(4) * s(4.0),
            19 => (5.0 * e(2) - 4.0) * e(3) * c(3.0),
            20 => (5.0 * e(2) - 4.0) * e(3) * s(3.0),
            21 => (15.0 * e(4) - 20.0 * e(2) + 6.0) * e(2) * c(2.0),
            22 => (15.0 * e(4) - 20.0 * e(2) + 6.0) * e(2) * s(2.0),
            23 => (35.0 * e(6) - 60.0 * e(4) + 30.0 * e(2) - 4.0) * p * c(1.0),
            24 => (35.0 * e(6) - 60.0 * e(4) + 30.0 * e(2) - 4.0) * p * s(1.0),
            25 => 70.0 * e(8) - 140.0 * e(6) + 90.0 * e(4) - 20.0 * e(2) + 1.0,
            26 => e(5) * c(5.0),
            27 => e(5) * s(5.0),
            28 => (6.0 * e(2) - 5.0) * e(4) * c(4.0),
            29 => (6.0 * e(2) - 5.0) * e(4) * s(4.0),
            30 => (21.0 * e(4) - 30.0 * e(2) + 10.0) * e(3) * c(3.0),
            31 => (21.0 * e(4) - 30.0 * e(2) + 10.0) * e(3) * s(3.0),
            32 => (56.0 * e(6) - 105.0 * e(4) + 60.0 * e(2) - 10.0) * e(2) * c(2.0),
            33 => (56.0 * e(6) - 105.0 * e(4) + 60.0 * e(2) - 10.0) * e(2) * s(2.0),
            34 => (126.0 * e(8) - 280.0 * e(6) + 210.0 * e(4) - 60.0 * e(2) + 5.0) * p * c(1.0),
            35 => (126.0 * e(8) - 280.0 * e(6) + 210.0 * e(4) - 60.0 * e(2) + 5.0) * p * s(1.0),
            36 => 252.0 * e(10) - 630.0 * e(8) + 560.0 * e(6) - 210.0 * e(4) + 30.0 * e(2) - 1.0,
            _ => {
                924.0 * e(12) - 2772.0 * e(10) + 3150.0 * e(8) - 1680.0 * e(6) + 420.0 * e(4)
                    - 42.0 * e(2)
                    + 1.0
            }
        }
    }

    #[test]
    fn every_fringe_polynomial_is_its_listed_formula() {
        for number in 1..=37 {
            let mut coefficients = vec![0.0; number];
            coefficients[number - 1] = 0.7;
            let sum = ZernikeSum::new(2.0, noll_of_fringe(&coefficients));
            for (p, a) in [(0.3, 0.4), (0.9, -1.1), (1.0, 2.5), (1.2, 0.2)] {
                let found = sum.at(2.0 * p * f64::cos(a), 2.0 * p * f64::sin(a));
                let expected = 0.7 * listed(number, p, a);
                assert!(
                    (found - expected).abs() < 2e-12 * expected.abs().max(1.0),
                    "{number} at {p}, {a}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn squares_of_the_radius_are_added_exactly() {
        let mut noll = Vec::new();
        add_square(&mut noll, 0.3, 2.0);
        let sum = ZernikeSum::new(2.0, noll);
        for [x, y] in [[0.0, 0.0], [1.0, -0.5], [3.0, 1.0]] {
            let expected: f64 = 0.3 * (x * x + y * y);
            assert!((sum.at(x, y) - expected).abs() < 1e-14, "{x} {y}");
        }
        assert!((sum.curvature_y() - 0.6).abs() < 1e-15);
    }
}
