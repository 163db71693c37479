//! Surfaces with two curvatures: biconics, cylinders and toroids.

use crate::math::real::Real;
use crate::optics::conic::{Conic, add_powers};
use crate::optics::height::Height;

/// z = (cx x² + cy y²) / (1 + √(1 − (1+κx) cx² x² − (1+κy) cy² y²)); a cylinder when one curvature is
/// zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Biconic {
    /// The section along x.
    pub x: Conic,
    /// The section along y.
    pub y: Conic,
}

/// A curve z(y) = conic + Σ aᵢ y^{2i+4}, turned about an axis parallel to y through its centre of
/// rotation on the z axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Toroid {
    /// One over the distance from the vertex to the axis of rotation in 1/mm, positive when the axis lies
    /// at larger z: the curvature along x at the vertex. Zero for a cylinder.
    pub rotation: f64,
    /// The conic in the curve along y.
    pub curve: Conic,
    /// Coefficients of y⁴, y⁶, y⁸, … in mm⁻³, mm⁻⁵, mm⁻⁷, …
    pub coefficients: Vec<f64>,
}

impl Biconic {
    /// The surface of revolution that is nearest to it at the vertex.
    pub(crate) fn mean(&self) -> Conic {
        Conic {
            curvature: 0.5 * (self.x.curvature + self.y.curvature),
            conic: 0.5 * (self.x.conic + self.y.conic),
        }
    }

    /// Height and derivatives at (x, y); nothing where the surface does not exist.
    #[inline(always)]
    pub(crate) fn height<T: Real>(&self, x: T, y: T) -> Option<Height<T>> {
        let rate = |c: &Conic| (1.0 + c.conic) * c.curvature * c.curvature;
        let (a, b) = (rate(&self.x), rate(&self.y));
        let under = -(x * x * a + y * y * b) + 1.0;
        if under.value() <= 0.0 {
            return None;
        }

        // The root q and its derivatives, from q² = 1 − a x² − b y².
        let q = under.sqrt();
        let one_over = T::constant(1.0) / q;
        let [qx, qy] = [x * one_over * -a, y * one_over * -b];
        let [qxx, qyy] = [a, b].map(|a| T::constant(-a));
        let qxx = (qxx - qx * qx) * one_over;
        let qxy = -(qx * qy * one_over);
        let qyy = (qyy - qy * qy) * one_over;

        // Those of z, from z (1 + q) = cx x² + cy y².
        let [cx, cy] = [self.x.curvature, self.y.curvature];
        let part = T::constant(1.0) / (q + 1.0);
        let z = (x * x * cx + y * y * cy) * part;
        let zx = (x * (2.0 * cx) - z * qx) * part;
        let zy = (y * (2.0 * cy) - z * qy) * part;
        Some(Height {
            z,
            slope: [zx, zy],
            hessian: [
                (-(zx * qx * 2.0 + z * qxx) + 2.0 * cx) * part,
                -(zx * qy + zy * qx + z * qxy) * part,
                (-(zy * qy * 2.0 + z * qyy) + 2.0 * cy) * part,
            ],
        })
    }
}

impl Toroid {
    /// The surface of revolution that is nearest to it at the vertex.
    pub(crate) fn mean(&self) -> Conic {
        Conic {
            curvature: 0.5 * (self.rotation + self.curve.curvature),
            conic: 0.0,
        }
    }

    /// Height and derivatives at (x, y); nothing where the surface does not exist.
    #[inline(always)]
    pub(crate) fn height<T: Real>(&self, x: T, y: T) -> Option<Height<T>> {
        let [g, dg, ddg] = self.along_y(y)?;

        // Turned about the axis at R: (R − z)² = (R − g)² − x², free of cancellation for any R. In units of R, the
        // arm is 1 − g/R and the root is 1 − z/R.
        let turn = self.rotation;
        let arm = g * -turn + 1.0;
        let under = arm * arm - x * x * (turn * turn);
        if arm.value() <= 0.0 || under.value() <= 0.0 {
            return None;
        }
        let root = under.sqrt();
        let z = (g * (arm + 1.0) + x * x * turn) / (root + 1.0);

        // With u = x/R and the slope g' along the curve, z_x = u/root and z_y = arm g'/root.
        let one_over = T::constant(1.0) / root;
        let cube = one_over * one_over * one_over * turn;
        let (u, lift) = (x * turn, arm * dg);
        Some(Height {
            z,
            slope: [u * one_over, lift * one_over],
            hessian: [
                arm * arm * cube,
                u * lift * cube,
                (arm * ddg - dg * dg * turn) * one_over + lift * lift * cube,
            ],
        })
    }

    /// The curve at y, with its first and second derivatives.
    #[inline(always)]
    fn along_y<T: Real>(&self, y: T) -> Option<[T; 3]> {
        let flat = T::constant(0.0);
        let below = self.curve.height(flat, y)?;
        let h = add_powers(below, &self.coefficients, flat, y);
        Some([h.z, h.slope[1], h.hessian[2]])
    }
}

#[cfg(test)]
mod tests {
    use crate::optics::conic::Conic;
    use crate::optics::toric::{Biconic, Toroid};

    const PLACES: [(f64, f64); 5] = [(0.0, 0.0), (3.0, 0.0), (0.0, -4.0), (2.5, 3.5), (-5.0, 1.0)];

    fn conic(curvature: f64, conic: f64) -> Conic {
        Conic { curvature, conic }
    }

    #[test]
    fn equal_sections_make_a_surface_of_revolution() {
        let one = conic(-0.05, -0.6);
        let biconic = Biconic { x: one, y: one };
        let sphere = conic(0.05, 0.0);
        let toroid = Toroid {
            rotation: 0.05,
            curve: sphere,
            coefficients: vec![],
        };
        for (x, y) in PLACES {
            let (a, b) = (biconic.height(x, y).unwrap(), one.height(x, y).unwrap());
            assert!((a.z - b.z).abs() < 1e-15);
            let (a, b) = (toroid.height(x, y).unwrap(), sphere.height(x, y).unwrap());
            assert!((a.z - b.z).abs() < 1e-14);
            assert!((a.hessian[1] - b.hessian[1]).abs() < 1e-14);
        }
        assert!(toroid.height(20.1, 0.0).is_none() && biconic.height(-40.0, 40.0).is_none());
    }

    #[test]
    fn a_cylinder_is_a_circle_along_one_axis() {
        let cylinder = Biconic {
            x: conic(0.0, 0.0),
            y: conic(1.0 / 12.0, 0.0),
        };
        let toroid = Toroid {
            rotation: 0.0,
            curve: conic(1.0 / 12.0, 0.0),
            coefficients: vec![],
        };
        for (x, y) in PLACES {
            let circle = 12.0 - (144.0 - y * y).sqrt();
            assert!((cylinder.height(x, y).unwrap().z - circle).abs() < 1e-14);
            assert!((toroid.height(x, y).unwrap().z - circle).abs() < 1e-14);
        }
    }

    #[test]
    fn a_toroid_keeps_the_distance_of_its_curve_from_the_axis_of_rotation() {
        let toroid = Toroid {
            rotation: -1.0 / 15.0,
            curve: conic(0.03, -0.4),
            coefficients: vec![1e-4, -3e-7],
        };
        for (x, y) in PLACES {
            let y2: f64 = y * y;
            let curve = conic(0.03, -0.4).height(0.0, y).unwrap().z;
            let arm = -15.0 - (curve + 1e-4 * y2 * y2 - 3e-7 * y2 * y2 * y2);
            let z = toroid.height(x, y).unwrap().z;
            assert!((x.hypot(-15.0 - z) - arm.abs()).abs() < 1e-13, "{x} {y}");
        }
    }
}
