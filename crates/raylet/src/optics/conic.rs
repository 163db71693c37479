//! Spheres and conics of revolution, with even powers of the radius on top.

use crate::math::real::Real;
use crate::math::vec3::Vec3;
use crate::optics::height::Height;
use crate::optics::ray::Loss;

/// A sphere or conic of revolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conic {
    /// Curvature 1/R in 1/mm; positive when the centre lies at larger z.
    pub curvature: f64,
    /// Conic constant κ: 0 sphere, −1 paraboloid, below −1 hyperboloid.
    pub conic: f64,
}

impl Conic {
    /// Height and derivatives at (x, y); nothing where the surface does not exist.
    #[inline(always)]
    pub(crate) fn height<T: Real>(&self, x: T, y: T) -> Option<Height<T>> {
        let c = self.curvature;
        let k = (1.0 + self.conic) * c * c;
        let square = x * x + y * y;
        let under = square * -k + 1.0;
        if under.value() <= 0.0 {
            return None;
        }
        // With φ = √(1 − (1+κ)c²r²): slope c·x/φ, second derivatives c/φ·δ + (1+κ)c³·xx/φ³.
        let root = under.sqrt();
        let one_over = T::constant(1.0) / root;
        let first = one_over * c;
        let second = one_over * one_over * one_over * (k * c);
        Some(Height {
            z: square * c / (root + 1.0),
            slope: [x * first, y * first],
            hessian: [
                first + x * x * second,
                x * y * second,
                first + y * y * second,
            ],
        })
    }

    /// The distance along a ray to the sheet through the vertex.
    ///
    /// # Errors
    /// [`Loss::Missed`] when they do not meet.
    #[inline(always)]
    pub(crate) fn meet<T: Real>(&self, position: Vec3<T>, direction: Vec3<T>) -> Result<T, Loss> {
        // Closed form: the root of a L² + 2 b L + e = 0 that belongs to that sheet. Starting from the
        // point nearest the vertex keeps the equation free of cancellation.
        let near = -position.dot(direction);
        let r = position + direction * near;
        let c = self.curvature;
        let kappa = self.conic;
        let a = (direction.z * direction.z * kappa + 1.0) * c;
        let b = (r.dot(direction) + r.z * direction.z * kappa) * c - direction.z;
        let e = (r.dot(r) + r.z * r.z * kappa) * c - r.z * 2.0;
        let under = b * b - a * e;
        if under.value() < 0.0 {
            return Err(Loss::Missed);
        }
        let root = under.sqrt().along(direction.z);
        let length = e / (root - b);
        let z = r.z + direction.z * length;
        let on_sheet = 1.0 - (1.0 + kappa) * c * z.value() > 0.0;
        if !length.value().is_finite() || !on_sheet {
            return Err(Loss::Missed);
        }
        Ok(near + length)
    }
}

/// Adds Σ aᵢ r^{2i+4} to a height.
#[inline(always)]
pub(crate) fn add_powers<T: Real>(base: Height<T>, coefficients: &[f64], x: T, y: T) -> Height<T> {
    // With u = r² the sum is f(u) = u²·(a₀ + a₁u + …); Horner's rule for f and its two derivatives.
    let u = x * x + y * y;
    let zero = T::constant(0.0);
    let (mut f, mut df, mut ddf) = (zero, zero, zero);
    let powers = coefficients.iter().rev().copied().chain([0.0, 0.0]);
    for a in powers {
        ddf = ddf * u + df * 2.0;
        df = df * u + f;
        f = f * u + a;
    }
    Height {
        z: base.z + f,
        slope: [base.slope[0] + x * df * 2.0, base.slope[1] + y * df * 2.0],
        hessian: [
            base.hessian[0] + df * 2.0 + x * x * ddf * 4.0,
            base.hessian[1] + x * y * ddf * 4.0,
            base.hessian[2] + df * 2.0 + y * y * ddf * 4.0,
        ],
    }
}
