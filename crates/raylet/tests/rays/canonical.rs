//! What holds for every ray through any system: the symplectic form, Malus and Dupin, reversibility.

use raylet::engine::trace::ray_trace::Landing;
use raylet::math::real::Dual;
use raylet::math::vec3::Vec3;
use raylet::optics::frame::Frame;
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::surface::Surface;

use crate::rays::stage::{OwnedHop, conic, screen};
use raylet_testkit::parts::{face as lens_face, mirror, on_axis};

/// Rays, [x, y, p_x, p_y].
const RAYS: [[f64; 4]; 3] = [
    [0.3, -0.4, 0.12, 0.07],
    [-1.1, 0.6, -0.05, 0.10],
    [0.0, 0.9, 0.02, -0.14],
];

/// A frame on the axis, moved off it and tilted.
fn askew(z: f64, offset: [f64; 2], tilt: [f64; 3]) -> Frame {
    Frame::GLOBAL
        .moved(Vec3::new(offset[0], offset[1], z))
        .tilted(tilt)
}

fn asphere(curvature: f64, conic: f64, coefficients: &[f64]) -> Shape {
    Shape::Asphere {
        base: Conic { curvature, conic },
        coefficients: coefficients.to_vec(),
    }
}

/// A cemented doublet, each face tilted and decentred its own way, from air into water.
fn doublet() -> OwnedHop {
    let face = |z, offset, tilt, shape, index| lens_face(askew(z, offset, tilt), shape, index);
    OwnedHop {
        from: screen(askew(0.0, [0.0, 0.0], [0.1, -0.2, 0.3]), 1.0, 1.0),
        train: vec![
            face(
                8.0,
                [0.3, -0.2],
                [0.1, 0.05, 0.0],
                conic(25.0, 0.0),
                [1.0, 1.6],
            ),
            face(
                12.0,
                [-0.4, 0.1],
                [-0.2, 0.1, 0.4],
                conic(-18.0, -0.5),
                [1.6, 1.75],
            ),
            face(
                14.0,
                [0.2, 0.2],
                [0.05, -0.15, 0.0],
                asphere(-0.02, 0.3, &[3e-5, -2e-7]),
                [1.75, 1.33],
            ),
        ],
        to: screen(askew(45.0, [1.0, -2.0], [-0.3, 0.2, 0.1]), 1.33, 1.0),
    }
}

/// Two faces of a ball of high index: strong refraction, screens close by.
fn ball() -> OwnedHop {
    OwnedHop {
        from: screen(on_axis(-0.5).tilted([0.0, 0.3, 0.0]), 1.0, 1.0),
        train: vec![
            lens_face(
                askew(0.0, [0.3, 0.0], [0.2, 0.0, 0.0]),
                conic(3.0, 0.0),
                [1.0, 1.9],
            ),
            lens_face(
                askew(6.0, [0.3, 0.0], [0.2, 0.0, 0.0]),
                conic(-3.0, 0.0),
                [1.9, 1.0],
            ),
        ],
        to: screen(on_axis(7.5).tilted([0.1, -0.2, 0.0]), 1.0, 1.0),
    }
}

/// A zigzag of mirrors with these shapes and tilts, 30 mm apart along the chief ray; the screen at the
/// end is tilted as well.
fn zigzag(shapes: &[Shape]) -> OwnedHop {
    let (mut place, mut direction) = (Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.0, 0.0, 1.0));
    let mut train: Vec<Surface> = Vec::new();
    for (i, shape) in shapes.iter().enumerate() {
        place = place + direction * 30.0;
        let turn = 0.15 + 0.1 * i as f64;
        let frame = Frame::GLOBAL.moved(place).tilted([turn, 0.1 - turn, 0.2]);
        direction = direction + frame.z * (-2.0 * direction.dot(frame.z));
        train.push(mirror(frame, shape.clone()));
    }
    let frame = Frame::GLOBAL
        .moved(place + direction * 30.0)
        .tilted([0.2, -0.3, 0.5]);
    let arrives = direction.dot(frame.z).signum();
    OwnedHop {
        from: screen(Frame::GLOBAL.tilted([0.1, 0.0, 0.0]), 1.0, 1.0),
        train,
        to: screen(frame, 1.0, arrives),
    }
}

/// Through a lens to a tilted mirror and back through the lens the other way.
fn double_pass() -> OwnedHop {
    let faces = [
        lens_face(
            askew(6.0, [0.1, 0.0], [0.05, 0.0, 0.0]),
            conic(28.0, -0.7),
            [1.0, 1.5],
        ),
        lens_face(
            askew(10.0, [0.1, 0.0], [0.05, 0.0, 0.0]),
            conic(-40.0, 0.0),
            [1.5, 1.0],
        ),
    ];
    let mut train = faces.to_vec();
    train.push(mirror(
        askew(25.0, [0.0, 0.3], [0.04, -0.06, 0.0]),
        conic(-60.0, -1.0),
    ));
    train.extend(faces.into_iter().rev().map(turned));
    OwnedHop {
        from: screen(on_axis(0.0), 1.0, 1.0),
        train,
        to: screen(on_axis(-5.0).tilted([0.2, 0.1, 0.0]), 1.0, -1.0),
    }
}

fn systems() -> Vec<(&'static str, OwnedHop)> {
    let paraboloid = conic(-150.0, -1.0);
    let bent = asphere(0.01, 0.4, &[2e-6]);
    vec![
        ("doublet", doublet()),
        ("ball", ball()),
        ("one mirror", zigzag(std::slice::from_ref(&bent))),
        ("two mirrors", zigzag(&[paraboloid.clone(), bent.clone()])),
        ("three mirrors", zigzag(&[paraboloid, bent, Shape::Plane])),
        ("double pass", double_pass()),
    ]
}

/// A surface met from its other side.
fn turned(surface: Surface) -> Surface {
    let [before, after] = surface.index;
    Surface {
        index: [after, before],
        ..surface
    }
}

/// The same system for light that comes back.
fn reversed(owned: &OwnedHop) -> OwnedHop {
    OwnedHop {
        from: screen(owned.to.frame, owned.to.index, -owned.to.arrives),
        train: owned.train.iter().rev().cloned().map(turned).collect(),
        to: screen(owned.from.frame, owned.from.index, -owned.from.arrives),
    }
}

#[test]
fn jacobians_are_symplectic() {
    for (name, owned) in systems() {
        for [x, y, px, py] in RAYS {
            let (_, j) = owned.hop().jacobian([x, y], [px, py]).unwrap();
            for a in 0..4 {
                for b in 0..4 {
                    // JᵀΩJ = Ω, entry by entry.
                    let pair = |i: usize| j[i][a] * j[i + 2][b] - j[i + 2][a] * j[i][b];
                    let expected = f64::from(i8::from(b == a + 2) - i8::from(a == b + 2));
                    let off = pair(0) + pair(1) - expected;
                    assert!(off.abs() < 1e-10, "{name} {a} {b}: {off:e}");
                }
            }
        }
    }
}

/// d(OPL) = p′·ds − p·dx, from the tangents of the same trace.
#[test]
fn path_changes_by_the_work_of_the_ray() {
    for (name, owned) in systems() {
        for [x, y, px, py] in RAYS {
            let at = [Dual::<4>::variable(x, 0), Dual::variable(y, 1)];
            let p = [Dual::variable(px, 2), Dual::variable(py, 3)];
            let landing = owned.hop().trace(at, p, &mut ()).unwrap();
            for i in 0..4 {
                let arriving: f64 = (0..2)
                    .map(|a| landing.cosines[a].value * landing.at[a].tangent[i])
                    .sum();
                let leaving = [px, py, 0.0, 0.0][i];
                let off = landing.path.tangent[i] - (arriving - leaving);
                assert!(off.abs() < 1e-11, "{name} {i}: {off:e}");
            }
        }
    }
}

/// The derivative by differences of fourth order.
fn slope(value: impl Fn(f64) -> f64) -> f64 {
    let h = 4e-4;
    (8.0 * (value(h) - value(-h)) - (value(2.0 * h) - value(-2.0 * h))) / (12.0 * h)
}

/// The same for rays from one point, and the Jacobian itself, by differences of plain traces.
#[test]
fn rays_from_a_point_obey_malus_and_dupin() {
    for (name, owned) in systems() {
        for ray in RAYS {
            let (landing, jacobian) = owned
                .hop()
                .jacobian([ray[0], ray[1]], [ray[2], ray[3]])
                .unwrap();
            for i in 0..4 {
                let moved = |h: f64| -> Landing {
                    let mut r = ray;
                    r[i] += h;
                    owned
                        .hop()
                        .trace([r[0], r[1]], [r[2], r[3]], &mut ())
                        .unwrap()
                };
                let [sx, sy] = [0, 1].map(|a| slope(|h| moved(h).at[a]));
                let [tx, ty] = [0, 1].map(|a| slope(|h| moved(h).cosines[a]));
                for (row, difference) in [sx, sy, tx, ty].into_iter().enumerate() {
                    let off = jacobian[row][i] - difference;
                    assert!(off.abs() < 2e-9, "{name} {row} {i}: {off:e}");
                }
                if i >= 2 {
                    let path = slope(|h| moved(h).path);
                    let off = path - (landing.cosines[0] * sx + landing.cosines[1] * sy);
                    assert!(off.abs() < 1e-9, "{name} {i}: {off:e}");
                }
            }
        }
    }
}

#[test]
fn rays_go_back_the_way_they_came() {
    for (name, owned) in systems() {
        let back = reversed(&owned);
        for [x, y, px, py] in RAYS {
            let there = owned.hop().trace([x, y], [px, py], &mut ()).unwrap();
            let again = back
                .hop()
                .trace(there.at, there.cosines.map(|p| -p), &mut ())
                .unwrap();
            for (found, expected) in [
                (again.at[0], x),
                (again.at[1], y),
                (-again.cosines[0], px),
                (-again.cosines[1], py),
                (again.path, there.path),
            ] {
                assert!(
                    (found - expected).abs() < 1e-12,
                    "{name}: {found} {expected}"
                );
            }
        }
    }
}
