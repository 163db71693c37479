//! Where rays meet surfaces without a formula: Newton's method.

use crate::math::real::Real;
use crate::math::vec3::Vec3;
use crate::optics::conic::Conic;
use crate::optics::ray::Loss;
use crate::optics::shape::Shape;

/// Newton steps allowed when a ray seeks a surface.
const NEWTON_STEPS: usize = 60;

/// Times a step is halved before the surface counts as out of reach.
const HALVINGS: usize = 40;

/// A ray passes by when the place of the least |F| is closer than this part of its length and 1 mm together.
const PASSED: f64 = 1e-7;

impl Shape {
    /// Seeks the surface from where the ray meets a conic near it, or else the vertex plane, or else from the ray's point
    /// nearest the vertex, or else from where the ray is; in plain numbers, then by one more Newton step in `T`: at a root
    /// that step carries exactly the derivatives of the implicit function and adds nothing else.
    pub(crate) fn meet_near<T: Real>(
        &self,
        near: &Conic,
        position: Vec3<T>,
        direction: Vec3<T>,
    ) -> Result<T, Loss> {
        let (p, d) = (position.value(), direction.value());
        let length = (near.meet(p, d).and_then(|start| self.seek(p, d, start)))
            .or_else(|_| self.seek(p, d, Shape::Plane.meet(p, d)?))
            .or_else(|_| self.seek(p, d, -p.dot(d)))
            .or_else(|_| self.seek(p, d, 0.0))?;
        let length = T::constant(length);
        let at = position + direction * length;
        let h = self.height(at.x, at.y).ok_or(Loss::Missed)?;
        let slope = direction.z - h.slope[0] * direction.x - h.slope[1] * direction.y;
        Ok(length - (at.z - h.z) / slope)
    }

    /// Newton's method on F = z − height(x, y) along a ray. Where a step does not bring the ray nearer to the surface, or
    /// leads to where there is none, the ray goes to where |F| is least, if that is not zero to second order, and passes
    /// by when it is there; or else the step is halved, and the ray passes by where no part of it helps.
    fn seek(&self, p: Vec3, d: Vec3, start: f64) -> Result<f64, Loss> {
        let gap = |length: f64| self.gap(p + d * length, d);
        // The same F without its derivatives, for steps that are only tried.
        let apart = |length: f64| {
            let at = p + d * length;
            Some(at.z - self.sag(at.x, at.y)?)
        };
        let mut length = start;
        let mut here = gap(length).ok_or(Loss::Missed)?;
        for _ in 0..NEWTON_STEPS {
            let step = here.apart / here.slope;
            let rounding = 4.0 * f64::EPSILON * (p.norm() + length.abs());
            if here.apart.abs() <= rounding || step.abs() <= 1e-14 * (1.0 + length.abs()) {
                return Ok(length);
            }

            // The whole step, the way to the least |F|, or the largest part of the step that helps.
            let whole = gap(length - step).filter(|next| next.is_nearer_than(&here));
            if whole.is_none() && here.passes_by(length) {
                return Err(Loss::Missed);
            }
            let least = || {
                let length = length - here.to_least()?;
                let next = gap(length).filter(|next| next.is_nearer_than(&here))?;
                Some((length, next))
            };
            let part = || {
                let part = std::iter::successors(Some(0.5 * step), |part| Some(0.5 * part))
                    .take(HALVINGS - 1)
                    .map(|part| length - part)
                    .find(|&at| apart(at).is_some_and(|next| next.abs() < here.apart.abs()))?;
                Some((part, gap(part)?))
            };
            let next = whole.map(|next| (length - step, next));
            let next = next.or_else(least).or_else(part).ok_or(Loss::Missed)?;
            (length, here) = next;
        }
        Err(Loss::NotConverged)
    }

    /// F at a point of a ray.
    #[inline(always)]
    fn gap<T: Real>(&self, at: Vec3<T>, d: Vec3<T>) -> Option<Gap<T>> {
        let h = self.height(at.x, at.y)?;
        let [xx, xy, yy] = h.hessian;
        Some(Gap {
            apart: at.z - h.z,
            slope: d.z - h.slope[0] * d.x - h.slope[1] * d.y,
            second: -(xx * d.x * d.x + xy * d.x * d.y * 2.0 + yy * d.y * d.y),
        })
    }
}

/// F = z − height(x, y) at a point of a ray, with its first two derivatives along the ray.
struct Gap<T = f64> {
    apart: T,
    slope: T,
    second: T,
}

impl Gap {
    fn is_nearer_than(&self, other: &Gap) -> bool {
        self.apart.abs() < other.apart.abs()
    }

    /// How far back |F| is least, where to second order F has no root.
    fn to_least(&self) -> Option<f64> {
        let discriminant = 2.0 * self.apart * self.second;
        (self.slope * self.slope < discriminant).then(|| self.slope / self.second)
    }

    /// Whether |F| is least here, at this length of the ray, and not zero.
    fn passes_by(&self, length: f64) -> bool {
        let close = PASSED * (1.0 + length.abs());
        self.to_least().is_some_and(|back| back.abs() <= close)
    }
}
