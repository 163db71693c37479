//! Surface shapes: height over the local plane, its derivatives, and where a ray meets it.

use crate::math::real::Real;
use crate::math::vec3::Vec3;
use crate::optics::conic::add_powers;
use crate::optics::freeform::Term;
use crate::optics::ray::Loss;
use crate::optics::toric::{Biconic, Toroid};

pub use crate::optics::conic::Conic;
pub use crate::optics::height::Height;

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
    /// A conic along x and another along y; a cylinder when one of them is a line.
    Biconic(Biconic),
    /// A curve along y turned about an axis parallel to y.
    Toroid(Toroid),
    /// A conic plus terms of any kind.
    Freeform {
        /// The conic below the terms.
        base: Conic,
        /// What is added to it.
        terms: Vec<Term>,
    },
}

impl Shape {
    /// A sphere by its radius in mm, positive where the centre lies at larger z; a plane where it is infinite.
    pub fn sphere(radius: f64) -> Self {
        if radius.is_infinite() {
            return Shape::Plane;
        }
        Shape::Conic(Conic {
            curvature: 1.0 / radius,
            conic: 0.0,
        })
    }

    /// Height and derivatives at (x, y); nothing where the surface does not exist.
    #[inline(always)]
    pub fn height<T: Real>(&self, x: T, y: T) -> Option<Height<T>> {
        match self {
            Shape::Plane => Some(Height::flat()),
            Shape::Conic(conic) => conic.height(x, y),
            _ => self.height_called(x, y),
        }
    }

    /// The same as a function of its own: copies of it in every caller take long to compile.
    #[inline(never)]
    fn height_called<T: Real>(&self, x: T, y: T) -> Option<Height<T>> {
        match self {
            Shape::Plane => Some(Height::flat()),
            Shape::Conic(conic) => conic.height(x, y),
            Shape::Asphere { base, coefficients } => {
                base.height(x, y).map(|h| add_powers(h, coefficients, x, y))
            }
            Shape::Biconic(biconic) => biconic.height(x, y),
            Shape::Toroid(toroid) => toroid.height(x, y),
            Shape::Freeform { base, terms } => {
                let below = base.height(x, y)?;
                terms.iter().try_fold(below, |h, term| term.add(h, x, y))
            }
        }
    }

    /// Height alone at (x, y): the z of [`Shape::height`], without the cost of derivatives.
    #[inline(always)]
    pub(crate) fn sag(&self, x: f64, y: f64) -> Option<f64> {
        match self {
            Shape::Freeform { base, terms } => {
                let below = base.height(x, y)?.z;
                let add = |z: f64, term: &Term| Some(z + term.sag(x, y)?);
                terms.iter().try_fold(below, add)
            }
            _ => Some(self.height(x, y)?.z),
        }
    }

    /// Whether it looks the same from every direction about its axis.
    pub(crate) fn is_round(&self) -> bool {
        match self {
            Shape::Plane | Shape::Conic(_) | Shape::Asphere { .. } => true,
            Shape::Biconic(_) | Shape::Toroid(_) => false,
            Shape::Freeform { terms, .. } => {
                terms.iter().all(|term| matches!(term, Term::Powers(_)))
            }
        }
    }

    /// The distance along a ray (local position and unit direction) to the surface, which may be
    /// negative.
    ///
    /// # Errors
    /// [`Loss::Missed`] when they do not meet.
    #[inline(always)]
    pub(crate) fn meet<T: Real>(&self, position: Vec3<T>, direction: Vec3<T>) -> Result<T, Loss> {
        let mean = match self {
            Shape::Plane => {
                if direction.z.value() == 0.0 {
                    return Err(Loss::Missed);
                }
                return Ok(-position.z / direction.z);
            }
            Shape::Conic(conic) => return conic.meet(position, direction),
            Shape::Asphere { base, .. } | Shape::Freeform { base, .. } => *base,
            Shape::Biconic(biconic) => biconic.mean(),
            Shape::Toroid(toroid) => toroid.mean(),
        };
        // In one place: the compiler copies the search, with all heights in it, to where it is called.
        self.meet_near(&mean, position, direction)
    }
}

/// A shape as a ray of numbers `T` meets it: one that stays, or one that bends.
pub(crate) trait Bending<T: Real> {
    /// Whether it is a plane, and stays one.
    fn is_plane(&self) -> bool;
    /// Height and derivatives at (x, y); nothing where the surface does not exist.
    fn height(&self, x: T, y: T) -> Option<Height<T>>;
    /// The distance along a ray (local position and unit direction) to it.
    ///
    /// # Errors
    /// [`Loss::Missed`] when they do not meet.
    fn meet(&self, position: Vec3<T>, direction: Vec3<T>) -> Result<T, Loss>;
}

impl<T: Real> Bending<T> for Shape {
    #[inline(always)]
    fn is_plane(&self) -> bool {
        *self == Shape::Plane
    }
    #[inline(always)]
    fn height(&self, x: T, y: T) -> Option<Height<T>> {
        Shape::height(self, x, y)
    }
    #[inline(always)]
    fn meet(&self, position: Vec3<T>, direction: Vec3<T>) -> Result<T, Loss> {
        Shape::meet(self, position, direction)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use ndarray::Array2;

    use crate::math::real::{Dual, Real};
    use crate::math::vec3::Vec3;
    use crate::optics::freeform::Term;
    use crate::optics::ray::Loss;
    use crate::optics::sag_grid::SagGrid;
    use crate::optics::shape::{Conic, Shape};
    use crate::optics::toric::{Biconic, Toroid};
    use crate::optics::zernike::ZernikeSum;

    fn shapes() -> Vec<Shape> {
        let base = Conic {
            curvature: 0.04,
            conic: -0.7,
        };
        let sphere = Conic {
            curvature: -0.05,
            conic: 0.0,
        };
        let heights = Array2::from_shape_fn((41, 41), |(j, i)| {
            0.02 * (0.3 * i as f64).sin() * (0.2 * j as f64).cos()
        });
        let terms = vec![
            Term::Gaussian {
                height: -0.4,
                centre: [1.0, 2.0],
                sigma: 5.0,
            },
            Term::Powers(vec![0.03, 1e-3, -1e-4, 1e-5]),
            Term::Polynomial {
                radius: 5.0,
                terms: vec![([1, 0], 0.02), ([2, 1], -0.1), ([0, 3], 0.05)],
            },
            Term::Zernike(ZernikeSum::new(
                8.0,
                (0..15).map(|j| 0.02 / f64::from(1 + j)).collect(),
            )),
            Term::Grid(Arc::new(SagGrid::new(&heights, [0.5, 0.55]).unwrap())),
        ];
        let mut shapes = vec![
            Shape::Plane,
            Shape::Conic(sphere),
            Shape::Conic(base),
            Shape::Asphere {
                base,
                coefficients: vec![1e-5, -2e-8, 3e-11],
            },
            Shape::Biconic(Biconic { x: base, y: sphere }),
            Shape::Toroid(Toroid {
                rotation: 0.03,
                curve: sphere,
                coefficients: vec![1e-5, -2e-8],
            }),
        ];
        shapes.extend(terms.iter().map(|term| Shape::Freeform {
            base,
            terms: vec![term.clone()],
        }));
        shapes.push(Shape::Freeform { base, terms });
        shapes
    }

    #[test]
    fn derivatives_match_differences() {
        let (x, y, h) = (3.1, -4.2, 1e-4);
        for shape in shapes() {
            let at = |x, y| shape.height(x, y).unwrap();
            let here = at(x, y);
            assert_eq!(shape.sag(x, y), Some(here.z), "{shape:?}");
            let dx = (at(x + h, y).z - at(x - h, y).z) / (2.0 * h);
            let dy = (at(x, y + h).z - at(x, y - h).z) / (2.0 * h);
            let dxx = (at(x + h, y).slope[0] - at(x - h, y).slope[0]) / (2.0 * h);
            let dxy = (at(x, y + h).slope[0] - at(x, y - h).slope[0]) / (2.0 * h);
            let dyy = (at(x, y + h).slope[1] - at(x, y - h).slope[1]) / (2.0 * h);
            let exact = here.slope.iter().chain(&here.hessian);
            for (exact, difference) in exact.zip([dx, dy, dxx, dxy, dyy]) {
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
                // From far away to within half a millimetre of (1, 2) on the vertex plane.
                let position = Vec3::new(1.0, 2.0, 0.0) + direction * -500.0;
                let length = shape.meet(position, direction).unwrap();
                let hit = position + direction * length;
                let height = shape.height(hit.x, hit.y).unwrap();
                assert!((height.z - hit.z).abs() < 5e-13, "{shape:?}");
            }
        }
    }

    #[test]
    fn derivatives_of_the_meeting_match_differences() {
        let meet = |shape: &Shape, x: f64, p: f64| {
            let direction = Vec3::new(p, 0.1, 1.0).unit();
            shape.meet(Vec3::new(x, -2.0, -7.0), direction).unwrap()
        };
        let h = 1e-5;
        for shape in shapes() {
            let [x, p] = [Dual::<2>::variable(1.3, 0), Dual::variable(-0.2, 1)];
            let direction = Vec3::new(p, Dual::constant(0.1), Dual::constant(1.0)).unit();
            let position = Vec3::new(x, Dual::constant(-2.0), Dual::constant(-7.0));
            let ours = shape.meet(position, direction).unwrap().tangent;
            let dx = meet(&shape, 1.3 + h, -0.2) - meet(&shape, 1.3 - h, -0.2);
            let dp = meet(&shape, 1.3, -0.2 + h) - meet(&shape, 1.3, -0.2 - h);
            for (ours, difference) in ours.into_iter().zip([dx, dp]) {
                assert!((ours - difference / (2.0 * h)).abs() < 1e-7, "{shape:?}");
            }
        }
    }

    /// Rays from a disc of radius 14 in front of a surface of radius 10, steep ones among them: those
    /// that meet the conic must meet the equal biconic or toroid at the same place, the others miss both.
    #[test]
    fn steep_rays_meet_or_miss_as_they_meet_or_miss_the_conic() {
        let sphere = Conic {
            curvature: 0.1,
            conic: 0.0,
        };
        let twins = [
            Shape::Biconic(Biconic {
                x: sphere,
                y: sphere,
            }),
            Shape::Toroid(Toroid {
                rotation: 0.1,
                curve: sphere,
                coefficients: vec![],
            }),
            Shape::Freeform {
                base: sphere,
                terms: vec![],
            },
        ];
        let (mut met, mut missed) = (0, 0);
        let step = |i: i32| f64::from(i) / 7.0;
        for (a, b, c, d) in (0..9 * 9 * 9 * 9).map(|n: i32| {
            let digit = |place: i32| n / 9i32.pow(place as u32) % 9 - 4;
            (digit(0), digit(1), digit(2), digit(3))
        }) {
            let position = Vec3::new(14.0 * step(a), 14.0 * step(b), -4.0);
            let direction = Vec3::new(step(c), step(d), 1.0).unit();
            let exact = sphere.meet(position, direction);
            // Next to the equator the slope is infinite and no digit of the length is accurate.
            if exact.is_ok_and(|length| position.z + direction.z * length > 9.9) {
                continue;
            }
            for twin in &twins {
                match (twin.meet(position, direction), exact) {
                    (Ok(ours), Ok(exact)) => {
                        // A ray that only touches the ball meets it to half the digits.
                        assert!((ours - exact).abs() < 1e-6, "{ours} {exact}");
                        let hit = position + direction * ours;
                        let z = sphere.height(hit.x, hit.y).unwrap().z;
                        assert!((z - hit.z).abs() < 1e-13);
                        met += 1;
                    }
                    (Err(loss), Err(_)) => {
                        assert_eq!(loss, Loss::Missed);
                        missed += 1;
                    }
                    (ours, exact) => panic!("{ours:?} {exact:?} {position:?} {direction:?}"),
                }
            }
        }
        assert!(met > 1000 && missed > 1000, "{met} {missed}");
    }

    /// A ray of 84° that has left an asphere by 0.03 mm: it passes by the surface from where it meets the conic, from the
    /// vertex plane, and from its point nearest the vertex.
    #[test]
    fn grazing_rays_meet_the_surface_they_are_at() {
        let shape = Shape::Asphere {
            base: Conic {
                curvature: -0.055_578_612_577_007_56,
                conic: -0.891_337_366_179_280_5,
            },
            coefficients: vec![1.191_681_2e-4, -1.816_153e-7, 3.219_564e-8],
        };
        let direction = Vec3::new(0.747_962_46, 0.656_806_79, 0.095_692_188).unit();
        let [x, y] = [-1.289_937_2, -7.388_496_8];
        let foot = Vec3::new(x, y, shape.height(x, y).unwrap().z);
        let length = shape.meet(foot + direction * 0.029, direction).unwrap();
        assert!((length + 0.029).abs() < 1e-12, "{length}");
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
