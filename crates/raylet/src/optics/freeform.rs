//! Sag terms that are added to a conic, each written once as a formula for z(x, y).

use std::sync::Arc;

use crate::math::jet::Jet;
use crate::math::real::Real;
use crate::optics::height::Height;
use crate::optics::sag_grid::SagGrid;
use crate::optics::zernike::ZernikeSum;

/// A term that is added to the height of a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    /// A Gaussian bump, z = h exp(−((x−x₀)² + (y−y₀)²)/2σ²).
    Gaussian {
        /// Height h at its centre, in mm.
        height: f64,
        /// Its centre, in mm.
        centre: [f64; 2],
        /// σ, in mm.
        sigma: f64,
    },
    /// All powers of the radius: coefficients of r, r², r³, … in 1, mm⁻¹, mm⁻², … At the tip that an r
    /// term makes the slope counts as zero.
    Powers(Vec<f64>),
    /// z = Σ a (x/ρ)ⁱ (y/ρ)ʲ.
    Polynomial {
        /// Normalising radius ρ in mm.
        radius: f64,
        /// Exponents i and j with the coefficient a in mm.
        terms: Vec<([u32; 2], f64)>,
    },
    /// z = Σ aⱼ Zⱼ(x/ρ, y/ρ), coefficients in mm.
    Zernike(ZernikeSum),
    /// Heights on a grid with a spline between them; nothing outside it.
    Grid(Arc<SagGrid>),
}

impl Term {
    /// Adds the term to a height; nothing where the term does not exist.
    #[inline(always)]
    pub(crate) fn add<T: Real>(&self, height: Height<T>, x: T, y: T) -> Option<Height<T>> {
        if let Term::Powers(coefficients) = self {
            return Some(add_radial(height, coefficients, x, y));
        }
        let jet = self.sag(Jet::variable(x, 0), Jet::variable(y, 1))?;
        Some(height.plus(jet))
    }

    /// z(x, y).
    #[inline(always)]
    pub fn sag<T: Real>(&self, x: T, y: T) -> Option<T> {
        match self {
            Term::Gaussian {
                height,
                centre,
                sigma,
            } => {
                let (u, v) = (x - centre[0], y - centre[1]);
                Some(((u * u + v * v) * (-0.5 / (sigma * sigma))).exp() * *height)
            }
            Term::Powers(coefficients) => Some(powers(coefficients, x, y)),
            Term::Polynomial { radius, terms } => {
                let (x, y) = (x * (1.0 / radius), y * (1.0 / radius));
                let add =
                    |sum: T, ([i, j], a): &([u32; 2], f64)| sum + power(x, *i) * power(y, *j) * *a;
                Some(terms.iter().fold(T::constant(0.0), add))
            }
            Term::Zernike(sum) => Some(sum.at(x, y)),
            Term::Grid(grid) => grid.sag(x, y),
        }
    }
}

/// Σ aᵢ rⁱ with i from 1: even powers as a polynomial in r², odd ones as r times another.
fn powers<T: Real>(coefficients: &[f64], x: T, y: T) -> T {
    let u = x * x + y * y;
    let r = if u.value() > 0.0 {
        u.sqrt()
    } else {
        T::constant(0.0)
    };
    let (mut odd, mut even) = (T::constant(0.0), T::constant(0.0));
    for pair in coefficients.chunks(2).rev() {
        odd = odd * u + pair[0];
        even = even * u + pair.get(1).copied().unwrap_or(0.0);
    }
    r * odd + u * even
}

/// Adds Σ aᵢ rⁱ to a height, as a function of u = r² with two derivatives: with f(u) for that sum the slope is 2x·f′, the
/// second derivatives are 2δ·f′ + 4xx·f″. Rays through eight such surfaces are planned in half the time that [`powers`] with
/// derivatives along x and y takes.
fn add_radial<T: Real>(base: Height<T>, coefficients: &[f64], x: T, y: T) -> Height<T> {
    let u = x * x + y * y;
    let zero = T::constant(0.0);
    let (mut odd, mut even) = ([zero; 3], [zero; 3]);
    for pair in coefficients.chunks(2).rev() {
        let next = |[f, df, ddf]: [T; 3], a: f64| [f * u + a, df * u + f, ddf * u + df * 2.0];
        odd = next(odd, pair[0]);
        even = next(even, pair.get(1).copied().unwrap_or(0.0));
    }
    let mut z = u * even[0];
    let mut first = even[0] + u * even[1];
    let mut second = even[1] * 2.0 + u * even[2];
    // f = r·g(u) with r = √u and dr/du = 1/2r; zero at the tip.
    if u.value() > 0.0 {
        let r = u.sqrt();
        let half = T::constant(0.5) / r;
        z = r * odd[0] + z;
        first = first + half * odd[0] + r * odd[1];
        second = second + half * (odd[1] * 2.0 - odd[0] * half * half * 2.0) + r * odd[2];
    }
    let (twice, four) = (first * 2.0, second * 4.0);
    Height {
        z: base.z + z,
        slope: [base.slope[0] + x * twice, base.slope[1] + y * twice],
        hessian: [
            base.hessian[0] + twice + x * x * four,
            base.hessian[1] + x * y * four,
            base.hessian[2] + twice + y * y * four,
        ],
    }
}

/// A whole power of a number.
fn power<T: Real>(base: T, exponent: u32) -> T {
    (0..exponent).fold(T::constant(1.0), |product, _| product * base)
}

#[cfg(test)]
mod tests {
    use crate::optics::conic::Conic;
    use crate::optics::freeform::Term;
    use crate::optics::height::Height;
    use crate::optics::zernike::ZernikeSum;

    const PLACES: [(f64, f64); 4] = [(0.0, 0.0), (1.5, -0.5), (-2.0, 2.5), (0.0, 3.0)];

    fn at(term: &Term, x: f64, y: f64) -> Height {
        term.add(Height::flat(), x, y).unwrap()
    }

    #[test]
    fn polynomials_make_the_parabola_and_the_powers_they_should() {
        let curvature = 0.08;
        let parabola = Conic {
            curvature,
            conic: -1.0,
        };
        // z = c r²/2, with a normalising radius of 2 that makes the coefficients four times as large.
        let a = 4.0 * 0.5 * curvature;
        let polynomial = Term::Polynomial {
            radius: 2.0,
            terms: vec![([2, 0], a), ([0, 2], a)],
        };
        let powers = Term::Powers(vec![0.0, 0.5 * curvature]);
        for (x, y) in PLACES {
            let exact = parabola.height(x, y).unwrap();
            for term in [&polynomial, &powers] {
                let height = at(term, x, y);
                assert!((height.z - exact.z).abs() < 1e-15);
                assert!((height.hessian[0] - exact.hessian[0]).abs() < 1e-15);
            }
        }
        let mixed = Term::Polynomial {
            radius: 1.0,
            terms: vec![([3, 1], 0.5)],
        };
        assert!((at(&mixed, 2.0, -3.0).z + 12.0).abs() < 1e-14);
    }

    #[test]
    fn odd_powers_are_cones_and_cubes_and_finite_on_the_axis() {
        let term = Term::Powers(vec![0.1, 0.0, 0.02, 0.0, -0.003]);
        let (x, y) = (1.2f64, -1.6f64);
        let expected = 0.1 * 2.0 + 0.02 * 8.0 - 0.003 * 32.0;
        assert!((at(&term, x, y).z - expected).abs() < 1e-15);
        let tip = at(&term, 0.0, 0.0);
        assert_eq!((tip.z, tip.slope, tip.hessian), (0.0, [0.0; 2], [0.0; 3]));
        // A cube's second derivatives vanish at its centre: 3r + 3x²/r along x.
        let cube = at(&Term::Powers(vec![0.0, 0.0, 1.0]), 1e-9, 0.0);
        assert!((cube.hessian[0] - 6e-9).abs() < 1e-20 && (cube.hessian[2] - 3e-9).abs() < 1e-20);
    }

    #[test]
    fn defocus_is_noll_four() {
        // Z₄ = √3 (2ρ² − 1).
        let term = Term::Zernike(ZernikeSum::new(2.0, vec![0.0, 0.0, 0.0, 0.01]));
        for (x, y) in PLACES {
            let square = (x * x + y * y) / 4.0;
            let expected = 0.01 * 3.0f64.sqrt() * (2.0 * square - 1.0);
            assert!((at(&term, x, y).z - expected).abs() < 1e-15);
        }
    }
}
