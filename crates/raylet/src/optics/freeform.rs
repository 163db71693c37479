//! Sag terms without rotational symmetry, each written once as a formula for z(x, y).

use crate::math::jet::Jet;
use crate::math::real::Real;
use crate::optics::shape::Height;

/// A term that is added to the height of a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    /// A Gaussian bump, z = h exp(−((x−x₀)² + (y−y₀)²)/2σ²).
    Gaussian {
        /// Height h at its centre, in mm.
        height: f64,
        /// Its centre, in mm.
        centre: [f64; 2],
        /// σ, in mm.
        sigma: f64,
    },
}

impl Term {
    /// Adds the term to a height.
    #[inline(always)]
    pub fn add<T: Real>(&self, height: Height<T>, x: T, y: T) -> Height<T> {
        let jet = self.sag(Jet::variable(x, 0), Jet::variable(y, 1));
        let [sx, sy] = height.slope;
        let [xx, xy, yy] = height.bend;
        Height {
            z: height.z + jet.value,
            slope: [sx + jet.slope[0], sy + jet.slope[1]],
            bend: [xx + jet.bend[0], xy + jet.bend[1], yy + jet.bend[2]],
        }
    }

    /// z(x, y).
    #[inline(always)]
    fn sag<T: Real>(&self, x: T, y: T) -> T {
        match self {
            Term::Gaussian {
                height,
                centre,
                sigma,
            } => {
                let (u, v) = (x - centre[0], y - centre[1]);
                ((u * u + v * v) * (-0.5 / (sigma * sigma))).exp() * *height
            }
        }
    }
}
