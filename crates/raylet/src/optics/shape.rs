//! Surface shapes: height over the local plane, its derivatives, and where a ray meets it.

use crate::math::real::Real;
use crate::math::vec3::Vec3;
use crate::optics::freeform::Term;
use crate::optics::ray::Loss;

/// The shape of a surface in its own frame; the vertex is the origin and the normal there is z.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// z = 0.
    Plane,
    /// A sphere or conic, z = c r² / (1 + √(1 − (1 + κ) c² r²)).
    Conic(Conic),
    /// A conic plus even powers of r.
    Asphere {
        /// The conic below the powers.
        base: Conic,
        /// Coefficients of r⁴, r⁶, r⁸, … in mm⁻³, mm⁻⁵, mm⁻⁷, …
        coefficients: Vec<f64>,
    },
    /// A conic plus terms of any kind.
    Freeform {
        /// The conic below the terms.
        base: Conic,
        /// What is added to it.
        terms: Vec<Term>,
    },
}

/// A sphere or conic of revolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conic {
    /// Curvature 1/R in 1/mm; positive when the centre lies at larger z.
    pub curvature: f64,
    /// Conic constant κ: 0 sphere, −1 paraboloid, below −1 hyperboloid.
    pub conic: f64,
}

/// Height of a surface at one point with its first and second derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Height<T = f64> {
    /// z in mm.
    pub z: T,
    /// ∂z/∂x, ∂z/∂y.
    pub slope: [T; 2],
    /// ∂²z/∂x², ∂²z/∂x∂y, ∂²z/∂y² in 1/mm.
    pub bend: [T; 3],
}

/// Newton steps allowed when a ray seeks an asphere.
const NEWTON_STEPS: usize = 24;

impl Shape {
    /// Height and derivatives at (x, y); nothing where the surface does not exist.
    #[inline(always)]
    pub fn height<T: Real>(&self, x: T, y: T) -> Option<Height<T>> {
        match self {
            Shape::Plane => {
                let zero = T::constant(0.0);
                Some(Height {
                    z: zero,
                    slope: [zero; 2],
                    bend: [zero; 3],
                })
            }
            Shape::Conic(conic) => conic.height(x, y),
            Shape::Asphere { base, coefficients } => {
                base.height(x, y).map(|h| add_powers(h, coefficients, x, y))
            }
            Shape::Freeform { base, terms } => {
                let below = base.height(x, y)?;
                Some(terms.iter().fold(below, |h, term| term.add(h, x, y)))
            }
        }
    }

    /// The distance along a ray (local position and unit direction) to the surface, which may be
    /// negative.
    #[inline(always)]
    pub fn meet<T: Real>(&self, position: Vec3<T>, direction: Vec3<T>) -> Result<T, Loss> {
        match self {
            Shape::Plane => {
                if direction.z.value() == 0.0 {
                    return Err(Loss::Missed);
                }
                Ok(-position.z / direction.z)
            }
            Shape::Conic(conic) => conic.meet(position, direction),
            Shape::Asphere { base, .. } | Shape::Freeform { base, .. } => {
                self.meet_by_newton(base, position, direction)
            }
        }
    }

    /// Newton's method on F = z − height(x, y), in plain numbers, then one more step in `T`: at a root
    /// that step carries exactly the derivatives of the implicit function and adds nothing else.
    fn meet_by_newton<T: Real>(
        &self,
        base: &Conic,
        position: Vec3<T>,
        direction: Vec3<T>,
    ) -> Result<T, Loss> {
        let (p, d) = (position.value(), direction.value());
        let mut length = base.meet(p, d).or_else(|_| Shape::Plane.meet(p, d))?;
        let mut converged = false;
        for _ in 0..NEWTON_STEPS {
            let at = p + d * length;
            let h = self.height(at.x, at.y).ok_or(Loss::Missed)?;
            let slope = d.z - h.slope[0] * d.x - h.slope[1] * d.y;
            let step = (at.z - h.z) / slope;
            if !step.is_finite() {
                return Err(Loss::Missed);
            }
            length -= step;
            if step.abs() <= 1e-14 * (1.0 + length.abs()) {
                converged = true;
                break;
            }
        }
        if !converged {
            return Err(Loss::NotConverged);
        }
        let length = T::constant(length);
        let at = position + direction * length;
        let h = self.height(at.x, at.y).ok_or(Loss::Missed)?;
        let slope = direction.z - h.slope[0] * direction.x - h.slope[1] * direction.y;
        Ok(length - (at.z - h.z) / slope)
    }
}

impl Conic {
    #[inline(always)]
    fn height<T: Real>(&self, x: T, y: T) -> Option<Height<T>> {
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
            bend: [
                first + x * x * second,
                x * y * second,
                first + y * y * second,
            ],
        })
    }

    /// Closed form: the root of a L² + 2 b L + e = 0 that belongs to the sheet through the vertex.
    #[inline(always)]
    fn meet<T: Real>(&self, position: Vec3<T>, direction: Vec3<T>) -> Result<T, Loss> {
        // Starting from the point nearest the vertex keeps the equation free of cancellation.
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
        let root = under.sqrt();
        let root = if direction.z.value() < 0.0 {
            -root
        } else {
            root
        };
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
fn add_powers<T: Real>(base: Height<T>, coefficients: &[f64], x: T, y: T) -> Height<T> {
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
        bend: [
            base.bend[0] + df * 2.0 + x * x * ddf * 4.0,
            base.bend[1] + x * y * ddf * 4.0,
            base.bend[2] + df * 2.0 + y * y * ddf * 4.0,
        ],
    }
}

#[cfg(test)]
mod tests {
    use crate::math::vec3::Vec3;
    use crate::optics::freeform::Term;
    use crate::optics::shape::{Conic, Shape};

    fn shapes() -> Vec<Shape> {
        let base = Conic {
            curvature: 0.04,
            conic: -0.7,
        };
        vec![
            Shape::Plane,
            Shape::Conic(Conic {
                curvature: -0.05,
                conic: 0.0,
            }),
            Shape::Conic(base),
            Shape::Asphere {
                base,
                coefficients: vec![1e-5, -2e-8, 3e-11],
            },
            Shape::Freeform {
                base,
                terms: vec![Term::Gaussian {
                    height: -0.4,
                    centre: [1.0, 2.0],
                    sigma: 5.0,
                }],
            },
        ]
    }

    #[test]
    fn derivatives_match_differences() {
        let (x, y, h) = (3.1, -4.2, 1e-4);
        for shape in shapes() {
            let at = |x, y| shape.height(x, y).unwrap();
            let here = at(x, y);
            let dx = (at(x + h, y).z - at(x - h, y).z) / (2.0 * h);
            let dy = (at(x, y + h).z - at(x, y - h).z) / (2.0 * h);
            let dxx = (at(x + h, y).slope[0] - at(x - h, y).slope[0]) / (2.0 * h);
            let dxy = (at(x, y + h).slope[0] - at(x, y - h).slope[0]) / (2.0 * h);
            let dyy = (at(x, y + h).slope[1] - at(x, y - h).slope[1]) / (2.0 * h);
            for (exact, difference) in here
                .slope
                .iter()
                .chain(&here.bend)
                .zip([dx, dy, dxx, dxy, dyy])
            {
                assert!((exact - difference).abs() < 1e-9, "{shape:?}");
            }
        }
    }

    #[test]
    fn rays_end_on_the_surface() {
        for shape in shapes() {
            for direction in [
                Vec3::new(0.1, -0.2, 1.0).unit(),
                Vec3::new(0.1, 0.3, -1.0).unit(),
            ] {
                let position = Vec3::new(1.0, 2.0, -500.0 * direction.z);
                let position = position + direction * 0.0;
                let length = shape.meet(position, direction);
                let Ok(length) = length else { continue };
                let hit = position + direction * length;
                let height = shape.height(hit.x, hit.y).unwrap();
                assert!((height.z - hit.z).abs() < 2e-13, "{shape:?}");
            }
        }
    }

    #[test]
    fn rays_beside_a_ball_miss_it() {
        let ball = Shape::Conic(Conic {
            curvature: 0.1,
            conic: 0.0,
        });
        let forward = Vec3::new(0.0, 0.0, 1.0);
        assert!(ball.meet(Vec3::new(10.1, 0.0, -5.0), forward).is_err());
        assert!(ball.meet(Vec3::new(9.9, 0.0, -5.0), forward).is_ok());
    }
}
