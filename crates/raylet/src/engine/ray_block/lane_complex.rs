//! Eight complex numbers.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, f64x8};

use crate::engine::ray_block::lane_vec3::LaneVec3;

/// Eight complex numbers.
#[derive(Clone, Copy)]
pub(crate) struct LaneComplex<S: Simd> {
    /// Their real parts.
    pub re: f64x8<S>,
    /// Their imaginary parts.
    pub im: f64x8<S>,
}

impl<S: Simd> LaneComplex<S> {
    /// Numbers from their parts.
    #[inline(always)]
    pub(crate) fn new(re: f64x8<S>, im: f64x8<S>) -> Self {
        Self { re, im }
    }

    /// Sums.
    #[inline(always)]
    pub(crate) fn plus(self, other: Self) -> Self {
        Self::new(self.re + other.re, self.im + other.im)
    }

    /// Products.
    #[inline(always)]
    pub(crate) fn times(self, other: Self) -> Self {
        Self::new(
            self.re * other.re - self.im * other.im,
            self.re * other.im + self.im * other.re,
        )
    }

    /// Each number times a real one.
    #[inline(always)]
    pub(crate) fn scaled(self, scale: f64x8<S>) -> Self {
        Self::new(self.re * scale, self.im * scale)
    }

    /// Inverses.
    #[inline(always)]
    pub(crate) fn inverse(self) -> Self {
        let scale = 1.0 / (self.re * self.re + self.im * self.im);
        Self::new(self.re * scale, -self.im * scale)
    }

    /// Principal square roots.
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        // The larger of the two parts is formed by a sum without cancellation, the other from it.
        let zero = f64x8::splat(self.re.simd, 0.0);
        let modulus = (self.re * self.re + self.im * self.im).sqrt();
        let larger = ((modulus + self.re.abs()) * 0.5).sqrt();
        let none = larger.simd_eq(zero);
        let smaller = none.select(zero, self.im.abs() * 0.5 / larger);
        let right = self.re.simd_ge(zero);
        let (re, im) = (right.select(larger, smaller), right.select(smaller, larger));
        Self::new(re, im.copysign(self.im))
    }
}

/// The products d·(a × b) of a real direction d and complex vectors a and b, each as its real and imaginary part.
#[inline(always)]
pub(crate) fn triple<S: Simd>(
    d: LaneVec3<S>,
    [a, a_im]: [LaneVec3<S>; 2],
    [b, b_im]: [LaneVec3<S>; 2],
) -> LaneComplex<S> {
    let (real, imaginary) = (d.cross(a), d.cross(a_im));
    LaneComplex::new(
        real.dot(b) - imaginary.dot(b_im),
        real.dot(b_im) + imaginary.dot(b),
    )
}
