//! Where a part stands: an origin and three orthonormal axes in global coordinates.

use crate::math::real::Real;
use crate::math::vec3::Vec3;

/// A right-handed orthonormal frame; `z` is the part's own axis (a surface's vertex normal).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The vertex, in mm.
    pub origin: Vec3,
    /// Local x axis.
    pub x: Vec3,
    /// Local y axis.
    pub y: Vec3,
    /// Local z axis.
    pub z: Vec3,
}

impl Frame {
    /// The global frame.
    pub const GLOBAL: Frame = Frame {
        origin: Vec3::new(0.0, 0.0, 0.0),
        x: Vec3::new(1.0, 0.0, 0.0),
        y: Vec3::new(0.0, 1.0, 0.0),
        z: Vec3::new(0.0, 0.0, 1.0),
    };

    /// This frame moved by `offset` mm, given along its own axes.
    pub fn moved(self, offset: Vec3) -> Self {
        Self {
            origin: self.to_global(offset),
            ..self
        }
    }

    /// This frame turned about its own x axis, then its new y axis, then its new z axis, by `tilt`
    /// radians, right-handed.
    pub fn tilted(self, tilt: [f64; 3]) -> Self {
        let turn = |a: Vec3, b: Vec3, angle: f64| {
            let (s, c) = angle.sin_cos();
            (a * c + b * s, b * c + a * -s)
        };
        let mut frame = self;
        (frame.y, frame.z) = turn(frame.y, frame.z, tilt[0]);
        (frame.z, frame.x) = turn(frame.z, frame.x, tilt[1]);
        (frame.x, frame.y) = turn(frame.x, frame.y, tilt[2]);
        frame
    }

    /// This frame moved along its own axes by `centre` mm, and turned by `rotation` rad from x towards y.
    pub(crate) fn placed(self, [x, y]: [f64; 2], rotation: f64) -> Self {
        self.moved(Vec3::new(x, y, 0.0))
            .tilted([0.0, 0.0, rotation])
    }

    /// A global direction in local components.
    #[inline(always)]
    pub fn direction_to_local<T: Real>(&self, v: Vec3<T>) -> Vec3<T> {
        let along = |axis: Vec3| v.x * axis.x + v.y * axis.y + v.z * axis.z;
        Vec3::new(along(self.x), along(self.y), along(self.z))
    }

    /// A local direction in global components.
    #[inline(always)]
    pub fn direction_to_global<T: Real>(&self, v: Vec3<T>) -> Vec3<T> {
        Vec3::new(
            v.x * self.x.x + v.y * self.y.x + v.z * self.z.x,
            v.x * self.x.y + v.y * self.y.y + v.z * self.z.y,
            v.x * self.x.z + v.y * self.y.z + v.z * self.z.z,
        )
    }

    /// A global point in local coordinates.
    #[inline(always)]
    pub fn to_local<T: Real>(&self, point: Vec3<T>) -> Vec3<T> {
        self.direction_to_local(Vec3::new(
            point.x - self.origin.x,
            point.y - self.origin.y,
            point.z - self.origin.z,
        ))
    }

    /// A local point in global coordinates.
    #[inline(always)]
    pub fn to_global<T: Real>(&self, point: Vec3<T>) -> Vec3<T> {
        let v = self.direction_to_global(point);
        Vec3::new(
            v.x + self.origin.x,
            v.y + self.origin.y,
            v.z + self.origin.z,
        )
    }

    /// Whether `other` has the same axes within rounding (the frames differ by a shift only).
    pub(crate) fn is_parallel(&self, other: &Frame) -> bool {
        let close = |a: Vec3, b: Vec3| (a - b).norm() < 1e-12;
        close(self.x, other.x) && close(self.y, other.y) && close(self.z, other.z)
    }
}

/// Local axes and an origin, as a ray of numbers `T` sees them: those of a [`Frame`], or of one that moves.
pub trait Axes<T: Real> {
    /// The local x and y axes, global.
    fn across(&self) -> [Vec3<T>; 2];
    /// A global direction in local components.
    fn direction_to_local(&self, v: Vec3<T>) -> Vec3<T>;
    /// A local direction in global components.
    fn direction_to_global(&self, v: Vec3<T>) -> Vec3<T>;
    /// A global point in local coordinates.
    fn to_local(&self, point: Vec3<T>) -> Vec3<T>;
    /// A local point in global coordinates.
    fn to_global(&self, point: Vec3<T>) -> Vec3<T>;
}

impl<T: Real> Axes<T> for Frame {
    #[inline(always)]
    fn across(&self) -> [Vec3<T>; 2] {
        [Vec3::constant(self.x), Vec3::constant(self.y)]
    }
    #[inline(always)]
    fn direction_to_local(&self, v: Vec3<T>) -> Vec3<T> {
        Frame::direction_to_local(self, v)
    }
    #[inline(always)]
    fn direction_to_global(&self, v: Vec3<T>) -> Vec3<T> {
        Frame::direction_to_global(self, v)
    }
    #[inline(always)]
    fn to_local(&self, point: Vec3<T>) -> Vec3<T> {
        Frame::to_local(self, point)
    }
    #[inline(always)]
    fn to_global(&self, point: Vec3<T>) -> Vec3<T> {
        Frame::to_global(self, point)
    }
}

#[cfg(test)]
mod tests {
    use crate::math::vec3::Vec3;
    use crate::optics::frame::Frame;

    #[test]
    fn tilt_signs_are_right_handed() {
        // A positive tilt about x turns z towards −y; about y, z towards +x; about z, x towards +y.
        let angle = 0.1;
        let z = Frame::GLOBAL.tilted([angle, 0.0, 0.0]).z;
        assert!((z - Vec3::new(0.0, -angle.sin(), angle.cos())).norm() < 1e-15);
        let z = Frame::GLOBAL.tilted([0.0, angle, 0.0]).z;
        assert!((z - Vec3::new(angle.sin(), 0.0, angle.cos())).norm() < 1e-15);
        let x = Frame::GLOBAL.tilted([0.0, 0.0, angle]).x;
        assert!((x - Vec3::new(angle.cos(), angle.sin(), 0.0)).norm() < 1e-15);
    }

    #[test]
    fn local_and_global_are_inverse() {
        let frame = Frame::GLOBAL
            .moved(Vec3::new(1.0, -2.0, 30.0))
            .tilted([0.3, -0.7, 1.1]);
        let point = Vec3::new(0.4, 5.0, -6.0);
        assert!((frame.to_global(frame.to_local(point)) - point).norm() < 1e-14);
        assert!((frame.x.cross(frame.y) - frame.z).norm() < 1e-15);
    }
}
