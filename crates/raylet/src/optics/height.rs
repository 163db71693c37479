//! The height of a surface over its local plane, with derivatives.

use crate::math::jet::Jet;
use crate::math::real::Real;

/// Height of a surface at one point with its first and second derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Height<T = f64> {
    /// z in mm.
    pub z: T,
    /// ∂z/∂x, ∂z/∂y.
    pub slope: [T; 2],
    /// ∂²z/∂x², ∂²z/∂x∂y, ∂²z/∂y² in 1/mm.
    pub hessian: [T; 3],
}

impl<T: Real> Height<T> {
    /// The local plane's own.
    #[inline(always)]
    pub(crate) fn flat() -> Self {
        let zero = T::constant(0.0);
        Self {
            z: zero,
            slope: [zero; 2],
            hessian: [zero; 3],
        }
    }

    /// This height with that of a formula on top of it.
    #[inline(always)]
    pub(crate) fn plus(self, jet: Jet<T>) -> Self {
        Self {
            z: self.z + jet.value,
            slope: std::array::from_fn(|i| self.slope[i] + jet.slope[i]),
            hessian: std::array::from_fn(|i| self.hessian[i] + jet.hessian[i]),
        }
    }
}

impl Height {
    /// The larger of the two principal curvatures, without its sign, in 1/mm.
    pub(crate) fn sharpest(&self) -> f64 {
        // Half the trace and the determinant of g⁻¹H/√det g, with the metric g = 1 + ∇s∇sᵀ and the second
        // derivatives H.
        let ([sx, sy], [xx, xy, yy]) = (self.slope, self.hessian);
        let det = 1.0 + sx * sx + sy * sy;
        let trace = xx * (1.0 + sy * sy) - 2.0 * xy * sx * sy + yy * (1.0 + sx * sx);
        let mean = 0.5 * trace / (det * det.sqrt());
        let product = (xx * yy - xy * xy) / (det * det);
        mean.abs() + (mean * mean - product).max(0.0).sqrt()
    }
}
