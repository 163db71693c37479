//! Vectors of eight rays.
//!
//! Written out component by component: a closure in `array::map` is a function without the processor's vector
//! instructions, in which each of them is a call.

use fearless_simd::{Simd, SimdBase, f64x8};

use crate::math::lanes::{LANES, Lanes};
use crate::math::vec3::Vec3;

/// Eight points or directions.
#[derive(Clone, Copy)]
pub(crate) struct LaneVec3<S: Simd> {
    /// Their first components.
    pub x: f64x8<S>,
    /// Their second components.
    pub y: f64x8<S>,
    /// Their third components.
    pub z: f64x8<S>,
}

impl<S: Simd> LaneVec3<S> {
    /// Vectors from their components.
    #[inline(always)]
    pub(crate) fn new(x: f64x8<S>, y: f64x8<S>, z: f64x8<S>) -> Self {
        Self { x, y, z }
    }

    /// Eight times the same vector.
    #[inline(always)]
    pub(crate) fn all(simd: S, v: Vec3) -> Self {
        Self::new(
            f64x8::splat(simd, v.x),
            f64x8::splat(simd, v.y),
            f64x8::splat(simd, v.z),
        )
    }

    /// Scalar products.
    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> f64x8<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Vector products.
    #[inline(always)]
    pub(crate) fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    /// Each vector `times` a number of its own.
    #[inline(always)]
    pub(crate) fn times(self, times: f64x8<S>) -> Self {
        Self::new(self.x * times, self.y * times, self.z * times)
    }

    /// All vectors times one number.
    #[inline(always)]
    pub(crate) fn scaled(self, scale: f64) -> Self {
        Self::new(self.x * scale, self.y * scale, self.z * scale)
    }

    /// Sums.
    #[inline(always)]
    pub(crate) fn plus(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }

    /// The same vectors with another third component.
    #[inline(always)]
    pub(crate) fn with_z(self, z: f64x8<S>) -> Self {
        Self { z, ..self }
    }

    /// Products of the vectors with an axis.
    #[inline(always)]
    pub(crate) fn component(self, [x, y, z]: [f64; 3]) -> f64x8<S> {
        self.x * x + self.y * y + self.z * z
    }

    /// Their components in arrays.
    #[inline(always)]
    pub(crate) fn arrays(self) -> [Lanes; 3] {
        [*self.x.as_array(), *self.y.as_array(), *self.z.as_array()]
    }
}

/// One of eight vectors.
pub(crate) fn one_of(arrays: &[Lanes; 3], lane: usize) -> Vec3 {
    debug_assert!(lane < LANES, "a lane of eight");
    let [x, y, z] = arrays;
    Vec3::new(x[lane], y[lane], z[lane])
}
