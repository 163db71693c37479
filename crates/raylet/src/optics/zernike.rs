//! Sums of Zernike polynomials in Noll's order and normalisation.
//!
//! Noll, "Zernike polynomials and atmospheric turbulence", J. Opt. Soc. Am. 66, 207 (1976).

use crate::math::real::Real;

/// Σ aⱼ Zⱼ(x/ρ, y/ρ), with j from 1.
///
/// A term with azimuthal order m is the real or imaginary part of (x + iy)^m times a polynomial in u = x² + y²
/// (x and y in units of ρ). All terms of one m share the power, and their polynomials are added up beforehand.
#[derive(Clone, Debug, PartialEq)]
pub struct ZernikeSum {
    radius: f64,
    /// Two polynomials for each m from 0, highest power first: of the cosine terms and of the sine terms.
    polynomials: Vec<[Vec<f64>; 2]>,
}

impl ZernikeSum {
    /// The sum with a normalising radius ρ in mm and the coefficients of Z₁, Z₂, …
    pub fn new(radius: f64, coefficients: Vec<f64>) -> Self {
        let mut polynomials: Vec<[Vec<f64>; 2]> = Vec::new();
        for (index, a) in coefficients.into_iter().enumerate() {
            if a == 0.0 {
                continue;
            }
            let (n, m) = noll(index + 1);
            let order = m.unsigned_abs();
            if polynomials.len() <= order as usize {
                polynomials.resize(order as usize + 1, Default::default());
            }
            let part = usize::from(m < 0);
            add_term(&mut polynomials[order as usize][part], n, order, a);
        }
        Self {
            radius,
            polynomials,
        }
    }

    /// Its second derivative by y at the middle, in the unit of the coefficients over mm².
    pub(crate) fn curvature_y(&self) -> f64 {
        // Of r² times a constant, and of r² cos 2θ = x² − y².
        let cosines = |m: usize| {
            self.polynomials
                .get(m)
                .map(|[cosines, _]| cosines.as_slice())
        };
        let square = match cosines(0) {
            Some([.., square, _]) => *square,
            _ => 0.0,
        };
        let astigmatic = cosines(2).and_then(|list| list.last().copied());
        2.0 * (square - astigmatic.unwrap_or(0.0)) / (self.radius * self.radius)
    }

    /// The sum with all coefficients times a factor.
    pub(crate) fn times(mut self, factor: f64) -> Self {
        let all = self.polynomials.iter_mut().flatten().flatten();
        all.for_each(|a| *a *= factor);
        self
    }

    /// Its value at (x, y) in mm, in the unit of the coefficients.
    #[inline(always)]
    pub fn at<T: Real>(&self, x: T, y: T) -> T {
        let (x, y) = (x * (1.0 / self.radius), y * (1.0 / self.radius));
        let u = x * x + y * y;
        // (x + iy)^m for m = 0, 1, 2, …
        let (mut re, mut im) = (T::constant(1.0), T::constant(0.0));
        let mut sum = T::constant(0.0);
        for (m, [cosines, sines]) in self.polynomials.iter().enumerate() {
            if m > 0 {
                (re, im) = (re * x - im * y, re * y + im * x);
            }
            for (part, polynomial) in [(re, cosines), (im, sines)] {
                if let [first, rest @ ..] = polynomial.as_slice() {
                    let first = T::constant(*first);
                    sum = sum + part * rest.iter().fold(first, |value, a| value * u + *a);
                }
            }
        }
        sum
    }
}

/// Adds a times the radial polynomial of order n over r^m to a polynomial in u, highest power first.
fn add_term(polynomial: &mut Vec<f64>, n: u32, m: u32, a: f64) {
    let half = ((n - m) / 2) as usize;
    if polynomial.len() <= half {
        polynomial.splice(0..0, vec![0.0; half + 1 - polynomial.len()]);
    }
    let norm = noll_factor(n, m.cast_signed());
    let skipped = polynomial.len() - half - 1;
    for (s, place) in polynomial[skipped..].iter_mut().enumerate() {
        *place += a * norm * radial_coefficient(n, m, s as u32);
    }
}

/// Noll's index, from 1, of a radial order n and a signed azimuthal order m, negative for sines; none where there is no such term.
pub(crate) fn noll_index(n: u32, m: i32) -> Option<usize> {
    let first = (n as usize) * (n as usize + 1) / 2 + 1;
    (first..=first + n as usize).find(|index| noll(*index) == (n, m))
}

/// The factor before the radial polynomial in Noll's normalisation: the square root of n + 1, or of twice that where m is not zero.
pub(crate) fn noll_factor(n: u32, m: i32) -> f64 {
    (f64::from(n + 1) * if m == 0 { 1.0 } else { 2.0 }).sqrt()
}

/// Radial order n and signed azimuthal order m of Noll's index (from 1); negative m for sines.
fn noll(index: usize) -> (u32, i32) {
    let mut n = 0;
    let mut first = 1;
    while first + n < index {
        first += n + 1;
        n += 1;
    }
    // Within an order |m| grows by two, starting from the parity of n; even indices are cosines.
    let place = index - first;
    let m = if n % 2 == 0 {
        2 * place.div_ceil(2)
    } else {
        2 * (place / 2) + 1
    };
    let sign = if index.is_multiple_of(2) { 1 } else { -1 };
    (n as u32, sign * m as i32)
}

/// The sum Σ aⱼ Zⱼ(x/ρ, y/ρ) as products of powers of x and y in mm: their powers [i, j] and coefficients.
pub(crate) fn zernike_products(radius: f64, coefficients: &[f64]) -> Vec<([u32; 2], f64)> {
    let mut products = Vec::new();
    for (index, a) in coefficients.iter().enumerate().filter(|(_, a)| **a != 0.0) {
        let (n, m) = noll(index + 1);
        let order = m.unsigned_abs();
        let norm = (f64::from(n + 1) * if m == 0 { 1.0 } else { 2.0 }).sqrt();
        for s in 0..=(n - order) / 2 {
            let scale =
                a * norm * radial_coefficient(n, order, s) * radius.powi((2 * s) as i32 - n as i32);
            // (x² + y²)^half times the real or imaginary part of (x + iy)^order.
            let half = (n - order) / 2 - s;
            for k in 0..=half {
                for l in 0..=order {
                    let sine = l % 2 == 1;
                    if sine != (m < 0) {
                        continue;
                    }
                    let sign = if (l / 2) % 2 == 0 { 1.0 } else { -1.0 };
                    let factor = sign * binomial(half, k) * binomial(order, l);
                    let powers = [2 * (half - k) + order - l, 2 * k + l];
                    products.push((powers, scale * factor));
                }
            }
        }
    }
    products
}

/// n over k.
fn binomial(n: u32, k: u32) -> f64 {
    (0..k).fold(1.0, |product, i| {
        product * f64::from(n - i) / f64::from(i + 1)
    })
}

/// k! for all k for which it is a number.
const FACTORIALS: [f64; 171] = {
    let mut list = [1.0; 171];
    let mut k = 1;
    while k < list.len() {
        list[k] = list[k - 1] * k as f64;
        k += 1;
    }
    list
};

/// (−1)^s (n−s)! / (s! ((n+m)/2−s)! ((n−m)/2−s)!).
fn radial_coefficient(n: u32, m: u32, s: u32) -> f64 {
    let factorial = |k: u32| FACTORIALS.get(k as usize).map_or(f64::INFINITY, |&k| k);
    let sign = if s.is_multiple_of(2) { 1.0 } else { -1.0 };
    sign * factorial(n - s)
        / (factorial(s) * factorial((n + m) / 2 - s) * factorial((n - m) / 2 - s))
}

#[cfg(test)]
mod tests {
    use crate::optics::zernike::{ZernikeSum, noll, zernike_products};

    #[test]
    fn products_of_powers_have_the_values_of_the_sum() {
        let coefficients: Vec<f64> = (1..=36).map(|j| 1.0 / f64::from(j)).collect();
        let sum = ZernikeSum::new(2.5, coefficients.clone());
        let products = zernike_products(2.5, &coefficients);
        for (x, y) in [(0.0, 0.0), (1.2, -0.7), (-2.0, 1.1), (0.3, 2.2)] {
            let terms = products.iter();
            let value: f64 = terms
                .map(|([i, j], a)| a * f64::powi(x, *i as i32) * f64::powi(y, *j as i32))
                .sum();
            assert!((value - sum.at(x, y)).abs() < 1e-12);
        }
    }

    #[test]
    fn noll_order_is_the_published_one() {
        let published = [
            (0, 0),
            (1, 1),
            (1, -1),
            (2, 0),
            (2, -2),
            (2, 2),
            (3, -1),
            (3, 1),
            (3, -3),
            (3, 3),
            (4, 0),
            (4, 2),
            (4, -2),
            (4, 4),
            (4, -4),
        ];
        for (i, expected) in published.iter().enumerate() {
            assert_eq!(noll(i + 1), *expected, "Z{}", i + 1);
        }
    }

    #[test]
    fn zernikes_are_orthonormal_on_the_unit_disc() {
        // Midpoint rule in polar coordinates; Noll: mean of Zi·Zj over the disc is δij.
        let term = |j: usize| {
            let mut coefficients = vec![0.0; j];
            coefficients[j - 1] = 1.0;
            ZernikeSum::new(1.0, coefficients)
        };
        let mean = |i: usize, j: usize| {
            let (a, b) = (term(i), term(j));
            let (rings, spokes) = (400, 64);
            let mut sum = 0.0;
            for ring in 0..rings {
                let r = ((f64::from(ring) + 0.5) / f64::from(rings)).sqrt();
                for spoke in 0..spokes {
                    let t = f64::from(spoke) * std::f64::consts::TAU / f64::from(spokes);
                    let (x, y) = (r * t.cos(), r * t.sin());
                    sum += a.at(x, y) * b.at(x, y);
                }
            }
            sum / f64::from(rings * spokes)
        };
        for i in 1..=11 {
            for j in 1..=11 {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((mean(i, j) - expected).abs() < 1e-4, "Z{i} Z{j}");
            }
        }
    }

    #[test]
    fn terms_of_one_azimuthal_order_add_up() {
        // Z₄ = √3 (2r² − 1), Z₇ = √8 (3r³ − 2r) sin θ, Z₃ = 2r sin θ, Z₁₁ = √5 (6r⁴ − 6r² + 1).
        let mut coefficients = vec![0.0; 11];
        (coefficients[2], coefficients[3]) = (0.3, -0.7);
        (coefficients[6], coefficients[10]) = (1.1, 0.2);
        let (x, y) = (0.9, -1.3);
        let (v, u) = (y / 2.0, (x * x + y * y) / 4.0);
        let expected = 0.3 * 2.0 * v - 0.7 * 3.0f64.sqrt() * (2.0 * u - 1.0)
            + 1.1 * 8.0f64.sqrt() * (3.0 * u - 2.0) * v
            + 0.2 * 5.0f64.sqrt() * (6.0 * u * u - 6.0 * u + 1.0);
        assert!((ZernikeSum::new(2.0, coefficients).at(x, y) - expected).abs() < 1e-14);
    }
}
