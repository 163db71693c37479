//! Where the own axes of a phase or of pixels stand on an element.

use crate::math::real::Real;

/// The own axes of a phase or of pixels: their origin, and by how much they are turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Where their origin stands, in mm.
    pub centre: [f64; 2],
    /// Angle of their x axis, in rad from the element's x towards its y.
    pub rotation: f64,
}

impl Placement {
    /// The own axes of the element.
    pub const NONE: Placement = Placement {
        centre: [0.0; 2],
        rotation: 0.0,
    };

    /// Whether the own axes are those of the element.
    pub fn is_none(&self) -> bool {
        self.centre == [0.0; 2] && self.rotation == 0.0
    }

    /// A point of the element on the own axes.
    pub fn inwards<T: Real>(&self, x: T, y: T) -> [T; 2] {
        let (sin, cos) = self.rotation.sin_cos();
        let (u, v) = (x - self.centre[0], y - self.centre[1]);
        [u * cos + v * sin, v * cos - u * sin]
    }

    /// A point on the own axes, on those of the element.
    pub fn outwards<T: Real>(&self, u: T, v: T) -> [T; 2] {
        let (sin, cos) = self.rotation.sin_cos();
        [
            u * cos - v * sin + self.centre[0],
            u * sin + v * cos + self.centre[1],
        ]
    }

    /// Where the axes of the element stand on these.
    pub(crate) fn inverse(&self) -> Self {
        Self {
            centre: self.inwards(0.0, 0.0),
            rotation: -self.rotation,
        }
    }

    /// A vector along the own axes, along those of the element.
    pub fn vector_outwards(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.rotation.sin_cos();
        [u * cos - v * sin, u * sin + v * cos]
    }

    /// A symmetric matrix (uu, uv, vv) over the own axes, over those of the element: (xx, xy, yy).
    pub fn matrix_outwards(&self, [uu, uv, vv]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = self.rotation.sin_cos();
        let (ss, sc, cc) = (sin * sin, sin * cos, cos * cos);
        [
            cc * uu - 2.0 * sc * uv + ss * vv,
            sc * (uu - vv) + (cc - ss) * uv,
            ss * uu + 2.0 * sc * uv + cc * vv,
        ]
    }
}
