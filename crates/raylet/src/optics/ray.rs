//! A ray: a point, a direction, and the optical path behind it.

use crate::math::real::Real;
use crate::math::vec3::Vec3;

/// A ray on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ray<T = f64> {
    /// Where it is, in mm, global coordinates.
    pub position: Vec3<T>,
    /// Where it goes: a unit vector.
    pub direction: Vec3<T>,
    /// Optical path length since its start, in mm.
    pub path: T,
}

impl<T: Real> Ray<T> {
    /// A ray that starts here.
    pub(crate) fn new(position: Vec3<T>, direction: Vec3<T>) -> Self {
        Self {
            position,
            direction,
            path: T::constant(0.0),
        }
    }

    /// The ray after flying `length` mm in a medium of the given index; negative lengths fly back.
    #[inline(always)]
    pub(crate) fn flown(self, length: T, index: T) -> Self {
        Self {
            position: self.position + self.direction * length,
            path: self.path + length * index,
            ..self
        }
    }
}

/// Why a ray did not arrive. A lost ray is counted, never an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Loss {
    /// It met a surface outside its clear aperture.
    Clipped,
    /// It did not meet a surface at all.
    Missed,
    /// It was totally reflected where it should have been refracted.
    TotalReflection,
    /// Its direction is evanescent in the medium it starts in.
    Evanescent,
    /// The iteration that seeks its intersection did not converge.
    NotConverged,
}
