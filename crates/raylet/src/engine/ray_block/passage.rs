//! From the axes of one part to those of the next.
//!
//! `gradients_are_dot_products_with_derivatives` holds the adjoint.

use fearless_simd::Simd;

use crate::engine::ray_block::lane_vec3::LaneVec3;
use crate::math::vec3::Vec3;
use crate::optics::frame::Frame;

/// The way from one set of axes to another: p′ = R·p + t.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Passage {
    /// Parallel axes: a shift by t alone.
    Shift([f64; 3]),
    /// Turned axes.
    Turn {
        /// The rows of R.
        rows: [[f64; 3]; 3],
        /// The shift t in mm.
        shift: [f64; 3],
    },
}

impl Passage {
    /// From local coordinates of one frame to those of another.
    pub(crate) fn new(from: &Frame, to: &Frame) -> Self {
        let origin = to.to_local(from.origin);
        let shift = [origin.x, origin.y, origin.z];
        if [from.x, from.y, from.z] == [to.x, to.y, to.z] {
            return Passage::Shift(shift);
        }
        let row = |axis: Vec3| [from.x, from.y, from.z].map(|own| own.dot(axis));
        Passage::Turn {
            rows: [to.x, to.y, to.z].map(row),
            shift,
        }
    }

    /// Points on the other axes.
    #[inline(always)]
    pub(crate) fn points<S: Simd>(&self, p: LaneVec3<S>) -> LaneVec3<S> {
        let ([x, y, z], turned) = match self {
            Passage::Shift(shift) => (shift, p),
            Passage::Turn { rows, shift } => (shift, turned(rows, p)),
        };
        LaneVec3::new(turned.x + *x, turned.y + *y, turned.z + *z)
    }

    /// Directions on the other axes.
    #[inline(always)]
    pub(crate) fn directions<S: Simd>(&self, d: LaneVec3<S>) -> LaneVec3<S> {
        match self {
            Passage::Shift(_) => d,
            Passage::Turn { rows, .. } => turned(rows, d),
        }
    }

    /// Derivatives by directions, or by points, from those on the other axes.
    #[inline(always)]
    pub(crate) fn directions_adjoint<S: Simd>(&self, d: LaneVec3<S>) -> LaneVec3<S> {
        match self {
            Passage::Shift(_) => d,
            Passage::Turn {
                rows: [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]],
                ..
            } => turned(&[[*xx, *yx, *zx], [*xy, *yy, *zy], [*xz, *yz, *zz]], d),
        }
    }
}

#[inline(always)]
fn turned<S: Simd>(rows: &[[f64; 3]; 3], v: LaneVec3<S>) -> LaneVec3<S> {
    LaneVec3::new(
        v.component(rows[0]),
        v.component(rows[1]),
        v.component(rows[2]),
    )
}
