//! Complex numbers over any [`Real`], and the symmetric 2×2 matrices that hold a beamlet's curvature.
//!
//! Fields and spectra use `num_complex::Complex64`; these types are for the few formulas along a ray
//! that must also carry tangents.

use std::ops::{Add, Mul, Sub};

use num_complex::Complex64;

use crate::math::real::Real;

/// A complex number `re + i·im`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Complex<T = f64> {
    /// Real part.
    pub re: T,
    /// Imaginary part.
    pub im: T,
}

impl<T: Real> Complex<T> {
    /// The number `re` + i·`im`.
    #[inline(always)]
    pub const fn new(re: T, im: T) -> Self {
        Self { re, im }
    }

    /// The real number one.
    #[inline(always)]
    pub(crate) fn one() -> Self {
        Self::new(T::constant(1.0), T::constant(0.0))
    }

    /// The number without tangents.
    #[inline(always)]
    pub(crate) fn value(self) -> Complex64 {
        Complex64::new(self.re.value(), self.im.value())
    }

    /// Multiplied by a real number.
    #[inline(always)]
    pub(crate) fn scale(self, factor: T) -> Self {
        Self::new(self.re * factor, self.im * factor)
    }

    /// 1/z.
    #[inline(always)]
    pub(crate) fn inverse(self) -> Self {
        let norm = self.re * self.re + self.im * self.im;
        Self::new(self.re / norm, -self.im / norm)
    }

    /// The principal square root (real part not negative).
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        let modulus = (self.re * self.re + self.im * self.im).sqrt();
        // The larger of the two parts is formed by a sum without cancellation, the other from it.
        if self.re.value() >= 0.0 {
            let re = ((modulus + self.re) * 0.5).sqrt();
            if re.value() == 0.0 {
                return Self::new(T::constant(0.0), T::constant(0.0));
            }
            Self::new(re, self.im / (re * 2.0))
        } else {
            let im = ((modulus - self.re) * 0.5).sqrt();
            let im = if self.im.value() < 0.0 { -im } else { im };
            Self::new(self.im / (im * 2.0), im)
        }
    }
}

impl<T: Real> Add for Complex<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.re + other.re, self.im + other.im)
    }
}

impl<T: Real> Sub for Complex<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.re - other.re, self.im - other.im)
    }
}

impl<T: Real> Mul for Complex<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::new(
            self.re * other.re - self.im * other.im,
            self.re * other.im + self.im * other.re,
        )
    }
}

/// A symmetric complex 2×2 matrix [[xx, xy], [xy, yy]].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symmetric<T = f64> {
    /// Upper left entry.
    pub xx: Complex<T>,
    /// Both off-diagonal entries.
    pub xy: Complex<T>,
    /// Lower right entry.
    pub yy: Complex<T>,
}

impl<T: Real> Symmetric<T> {
    /// xx·yy − xy².
    #[inline(always)]
    pub(crate) fn determinant(self) -> Complex<T> {
        self.xx * self.yy - self.xy * self.xy
    }

    /// Mᵀ·self·M for a real matrix M given by rows.
    #[inline(always)]
    pub(crate) fn congruent(self, m: [[T; 2]; 2]) -> Self {
        let [[a, b], [c, d]] = m;
        let two = T::constant(2.0);
        Self {
            xx: self.xx.scale(a * a) + self.xy.scale(two * a * c) + self.yy.scale(c * c),
            xy: self.xx.scale(a * b) + self.xy.scale(a * d + b * c) + self.yy.scale(c * d),
            yy: self.xx.scale(b * b) + self.xy.scale(two * b * d) + self.yy.scale(d * d),
        }
    }

    /// self·(1 + s·self)⁻¹ and det(1 + s·self)^{−1/2}, the root taken as the product of the principal
    /// roots over the eigenvalues 1 + sμ.
    ///
    /// With Im self positive definite every 1 + sμ stays in one half plane, so the product of principal
    /// roots is the continuous branch for any real s.
    #[inline(always)]
    pub(crate) fn fly(self, s: T) -> (Self, Complex<T>) {
        let determinant = self.determinant();
        let trace = self.xx + self.yy;
        let total = Complex::one() + trace.scale(s) + determinant.scale(s * s);
        let inverse = total.inverse();
        // G(1+sG)⁻¹ = (G + s·det G·1)/det(1+sG) for a 2×2 matrix.
        let shift = determinant.scale(s);
        let flown = Self {
            xx: (self.xx + shift) * inverse,
            xy: self.xy * inverse,
            yy: (self.yy + shift) * inverse,
        };
        (flown, self.root(s, total))
    }

    /// The product of principal inverse roots of the eigenvalues of 1 + s·self, given its determinant.
    #[inline(always)]
    fn root(self, s: T, total: Complex<T>) -> Complex<T> {
        let principal = total.sqrt().inverse();
        // The product of two principal roots equals ± the principal root of the product; the sign is
        // found from the eigenvalues themselves, which needs no tangents.
        let (xx, xy, yy) = (self.xx.value(), self.xy.value(), self.yy.value());
        let half = (xx - yy) * 0.5;
        let gap = (half * half + xy * xy).sqrt();
        let mean = (xx + yy) * 0.5;
        let one = Complex64::new(1.0, 0.0);
        let product =
            (one + (mean + gap) * s.value()).sqrt() * (one + (mean - gap) * s.value()).sqrt();
        if (product * principal.value()).re < 0.0 {
            principal.scale(T::constant(-1.0))
        } else {
            principal
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::math::complex::{Complex, Symmetric};

    fn sample() -> Symmetric {
        Symmetric {
            xx: Complex::new(-0.3, 0.8),
            xy: Complex::new(0.2, 0.1),
            yy: Complex::new(0.5, 1.1),
        }
    }

    #[test]
    fn flight_composes() {
        let (half, a) = sample().fly(-1.7);
        let (both, b) = half.fly(4.2);
        let (whole, c) = sample().fly(2.5);
        assert!((both.xx.value() - whole.xx.value()).norm() < 1e-14);
        assert!((both.xy.value() - whole.xy.value()).norm() < 1e-14);
        assert!((both.yy.value() - whole.yy.value()).norm() < 1e-14);
        assert!(((a * b).value() - c.value()).norm() < 1e-14);
    }

    #[test]
    fn root_is_continuous_through_both_foci() {
        // A converging astigmatic beam: the amplitude must not jump as it passes its two line foci.
        let beam = Symmetric {
            xx: Complex::new(-1.0, 0.01),
            xy: Complex::new(0.0, 0.0),
            yy: Complex::new(-0.5, 0.01),
        };
        let mut before = beam.fly(0.0).1.value();
        for i in 1..=4000 {
            let now = beam.fly(i as f64 * 1e-3).1.value();
            assert!((now - before).norm() < 0.3 * before.norm());
            before = now;
        }
        // Two foci passed: a total phase of −π, that is a factor near −1.
        assert!(before.re < 0.0);
    }
}
