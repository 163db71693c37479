//! Surfaces with two curvatures: biconics, cylinders and toroids.

use crate::math::jet::Jet;
use crate::math::real::Real;
use crate::optics::conic::Conic;
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

/// Square of a number.
#[inline(always)]
fn square<T: Real>(a: T) -> T {
    a * a
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
        self.sag(Jet::variable(x, 0), Jet::variable(y, 1))
            .map(Height::from)
    }

    #[inline(always)]
    fn sag<T: Real>(&self, x: T, y: T) -> Option<T> {
        let rate = |c: &Conic| (1.0 + c.conic) * c.curvature * c.curvature;
        let (xx, yy) = (square(x), square(y));
        let under = -(xx * rate(&self.x) + yy * rate(&self.y)) + 1.0;
        if under.any(|under| under <= 0.0) {
            return None;
        }
        Some((xx * self.x.curvature + yy * self.y.curvature) / (under.sqrt() + 1.0))
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
        self.sag(Jet::variable(x, 0), Jet::variable(y, 1))
            .map(Height::from)
    }

    #[inline(always)]
    fn sag<T: Real>(&self, x: T, y: T) -> Option<T> {
        // The curve along y.
        let c = self.curve.curvature;
        let yy = square(y);
        let under = yy * (-(1.0 + self.curve.conic) * c * c) + 1.0;
        if under.any(|under| under <= 0.0) {
            return None;
        }
        let zero = T::constant(0.0);
        let horner = |sum: T, a: &f64| sum * yy + *a;
        let powers = self.coefficients.iter().rev().fold(zero, horner) * yy * yy;
        let g = yy * c / (under.sqrt() + 1.0) + powers;

        // Turned about the axis at R: (R − z)² = (R − g)² − x², free of cancellation for any R.
        let arm = g * -self.rotation + 1.0;
        let under = square(arm) - square(x * self.rotation);
        if arm.any(|arm| arm <= 0.0) || under.any(|under| under <= 0.0) {
            return None;
        }
        Some((g * (arm + 1.0) + square(x) * self.rotation) / (under.sqrt() + 1.0))
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
