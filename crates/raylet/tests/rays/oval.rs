//! Cartesian ovals: the surfaces n₁ℓ₁ + n₂ℓ₂ = constant that image a point into a point.
//!
//! The library has no shape of that name. An oval is a conic plus even powers as far as its series goes,
//! so the tests expand it in u = r² and use it where what is left out lies below 1e-13 mm.

use raylet::optics::shape::{Conic, Shape};

use crate::rays::stage::{OwnedHop, screen};
use raylet_testkit::parts::{face as lens_face, on_axis};

/// Terms of a power series in u.
const TERMS: usize = 14;

type Series = [f64; TERMS];

/// Two conjugate points, `before` and `behind` the vertex (negative when virtual, and so is the path to
/// them), and the indices on the two sides.
#[derive(Clone, Copy)]
struct Oval {
    before: f64,
    behind: f64,
    index: [f64; 2],
}

fn product(a: &Series, b: &Series) -> Series {
    std::array::from_fn(|i| (0..=i).map(|j| a[j] * b[i - j]).sum())
}

/// The root of a series whose constant term is positive, term by term.
fn root(a: &Series) -> Series {
    let mut s = [0.0; TERMS];
    s[0] = a[0].sqrt();
    for i in 1..TERMS {
        let known: f64 = (1..i).map(|j| s[j] * s[i - j]).sum();
        s[i] = (a[i] - known) / (2.0 * s[0]);
    }
    s
}

impl Oval {
    /// The optical path over the vertex.
    fn path(&self) -> f64 {
        self.index[0] * self.before + self.index[1] * self.behind
    }

    /// ±n₁√(u + (a + z)²) ± n₂√(u + (b − z)²) with the signs of a and b, for a series z(u).
    fn paths(&self, z: &Series) -> Series {
        let leg = |distance: f64, sign: f64| {
            let mut along = z.map(|c| sign * c);
            along[0] += distance;
            let mut square = product(&along, &along);
            square[1] += 1.0;
            root(&square).map(|c| c * distance.signum())
        };
        let (first, second) = (leg(self.before, 1.0), leg(self.behind, -1.0));
        std::array::from_fn(|i| self.index[0] * first[i] + self.index[1] * second[i])
    }

    /// z(u) such that the paths are constant. Raising the coefficient of u^i by δ adds (n₁ − n₂)δ to that
    /// of the paths and leaves the lower ones alone, so they are solved one after another.
    fn series(&self) -> Series {
        let mut z = [0.0; TERMS];
        for i in 1..TERMS {
            z[i] -= self.paths(&z)[i] / (self.index[0] - self.index[1]);
        }
        z
    }

    /// The oval itself at a radius, by Newton's method on the path.
    fn height(&self, r: f64) -> f64 {
        let [n1, n2] = self.index;
        let mut z = 0.0;
        for _ in 0..50 {
            let leg = |along: f64| r.hypot(along) * along.signum();
            let (l1, l2) = (leg(self.before + z), leg(self.behind - z));
            let path = n1 * l1 + n2 * l2 - self.path();
            let slope = n1 * (self.before + z) / l1 - n2 * (self.behind - z) / l2;
            z -= path / slope;
        }
        z
    }

    /// The series as a paraboloid, which is c·u/2 exactly, and even powers.
    fn shape(&self) -> Shape {
        let z = self.series();
        Shape::Asphere {
            base: Conic {
                curvature: 2.0 * z[1],
                conic: -1.0,
            },
            coefficients: z[2..].to_vec(),
        }
    }
}

const OVALS: [(Oval, f64); 3] = [
    (
        Oval {
            before: 40.0,
            behind: 70.0,
            index: [1.0, 1.5],
        },
        3.0,
    ),
    (
        Oval {
            before: 90.0,
            behind: 35.0,
            index: [1.6, 1.0],
        },
        2.0,
    ),
    // A virtual image: the glass side's focus lies before the surface.
    (
        Oval {
            before: 30.0,
            behind: -80.0,
            index: [1.0, 1.7],
        },
        4.0,
    ),
];

#[test]
fn oval_images_a_point_into_a_point() {
    for (oval, radius) in OVALS {
        let shape = oval.shape();
        let left_out = (shape.height(radius, 0.0).unwrap().z - oval.height(radius)).abs();
        assert!(left_out < 1e-13, "{left_out:e}");
        let owned = OwnedHop {
            from: screen(on_axis(-oval.before), oval.index[0], 1.0),
            train: vec![lens_face(on_axis(0.0), shape, oval.index)],
            to: screen(on_axis(oval.behind), oval.index[1], 1.0),
        };
        for share in [0.0, 0.3, 0.6, 0.99] {
            // Aimed at the vertex plane; the oval is met near it.
            let sine = share * radius / radius.hypot(oval.before) * oval.index[0];
            let p = [0.6 * sine, -0.8 * sine];
            let landing = owned.hop().trace([0.0, 0.0], p, &mut ()).unwrap();
            assert!(landing.at[0].hypot(landing.at[1]) < 1e-12, "{landing:?}");
            assert!((landing.path - oval.path()).abs() < 1e-12, "{landing:?}");
        }
    }
}

/// The one oval whose constant is zero is a sphere with its aplanatic points.
#[test]
fn oval_of_equal_paths_is_a_sphere() {
    let (n, radius) = (1.5, 20.0);
    let oval = Oval {
        before: -radius * (1.0 + n),
        behind: radius * (1.0 + 1.0 / n),
        index: [1.0, n],
    };
    assert!(oval.path().abs() < 1e-14);
    for r in [1.0, 4.0, 9.0f64] {
        let sphere = radius - (radius * radius - r * r).sqrt();
        assert!((oval.height(r) - sphere).abs() < 1e-13);
    }
    // R − √(R² − u) = u/2R + u²/8R³ + u³/16R⁵ + …
    let z = oval.series();
    for (found, power, part) in [(z[1], 1, 2.0), (z[2], 3, 8.0), (z[3], 5, 16.0)] {
        let expected = 1.0 / (part * radius.powi(power));
        assert!((found / expected - 1.0).abs() < 1e-12);
    }
}
