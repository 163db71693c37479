//! Rays in blocks are single rays, for every shape.

use std::sync::Arc;

use fearless_simd::Level;
use ndarray::Array2;

use crate::engine::ray_block::hop_rays::{HopRays, LandingColumns, RayStart};
use crate::engine::trace::ray_trace::Carried;
use crate::fixtures::parts::{conic, face, on_axis, open_screen};
use crate::math::complex::{Complex, Symmetric};
use crate::math::random::pair;
use crate::math::vec3::Vec3;
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::frame::Frame;
use crate::optics::freeform::Term;
use crate::optics::ray::Loss;
use crate::optics::refraction::{Coating, Interface};
use crate::optics::sag_grid::SagGrid;
use crate::optics::screen::Screen;
use crate::optics::shape::{Conic, Shape};
use crate::optics::surface::Surface;
use crate::optics::system::Hop;
use crate::optics::toric::{Biconic, Toroid};

fn base(curvature: f64, conic: f64) -> Conic {
    Conic { curvature, conic }
}

fn shapes() -> Vec<Shape> {
    let waves = Array2::from_shape_fn((41, 41), |(j, i)| {
        0.02 * (0.3 * i as f64).sin() * (0.2 * j as f64).cos()
    });
    vec![
        Shape::Plane,
        conic(0.05, 0.0),
        conic(-0.04, -1.3),
        Shape::Asphere {
            base: base(0.05, -0.7),
            coefficients: vec![1e-4, -2e-6, 3e-8],
        },
        Shape::Freeform {
            base: base(-0.03, 0.2),
            terms: vec![Term::Powers(vec![0.02, 1e-3, -2e-3, 1e-4, 3e-5, -2e-6])],
        },
        Shape::Freeform {
            base: base(0.03, 0.0),
            terms: vec![Term::Powers(vec![0.0, 0.0, 2e-3, -1e-4])],
        },
        Shape::Biconic(Biconic {
            x: base(-0.04, 0.3),
            y: base(0.02, -1.2),
        }),
        Shape::Toroid(Toroid {
            rotation: 0.03,
            curve: base(-0.05, 0.0),
            coefficients: vec![3e-5],
        }),
        Shape::Freeform {
            base: base(0.04, -0.5),
            terms: vec![Term::Grid(Arc::new(
                SagGrid::new(&waves, [0.5, 0.55]).unwrap(),
            ))],
        },
    ]
}

/// A turned surface of this shape, then a plane one behind glass, or a mirror that sends the light back.
fn train(shape: &Shape, aperture: Aperture, mirror: bool) -> Vec<Surface> {
    let turned = |z: f64, tilt: [f64; 3]| on_axis(0.0).moved(Vec3::new(0.1, -0.2, z)).tilted(tilt);
    let first = Surface {
        aperture,
        coating: Coating::Fresnel,
        ..face(turned(5.0, [0.1, -0.05, 0.3]), shape.clone(), [1.0, 1.5])
    };
    let last = match mirror {
        true => Surface {
            interface: Interface::Reflect,
            ..face(
                turned(12.0, [0.05, 0.1, 0.0]),
                conic(-0.02, -0.4),
                [1.5, 1.5],
            )
        },
        false => face(turned(12.0, [0.0; 3]), Shape::Plane, [1.5, 1.2]),
    };
    vec![first, last]
}

/// Rays of all directions up to `reach`, beginning with gentle ones.
fn starts(reach: f64) -> Vec<RayStart> {
    (0..1000)
        .map(|i| {
            let reach = if i < 500 { 0.3 } else { reach };
            let [x, y] = pair(5, [i, 0, 0, 0]).map(|u| 6.0 * (u - 0.5));
            let [p, q] = pair(6, [i, 0, 0, 0]).map(|u| reach * (u - 0.5));
            [x, y, p, q]
        })
        .collect()
}

fn screens(mirror: bool, curved: bool) -> [Screen; 2] {
    let mut from = open_screen(Frame::GLOBAL.tilted([0.02, -0.01, 0.2]));
    let mut to = open_screen(on_axis(if mirror { -3.0 } else { 25.0 }).tilted([0.0, 0.05, 0.1]));
    (to.index, to.arrives) = if mirror { (1.5, -1.0) } else { (1.2, 1.0) };
    if curved {
        (from.shape, to.shape) = (Shape::sphere(-50.0), conic(-0.02, 0.4));
    }
    [from, to]
}

/// Calls a test with rays through every shape, edge, mirror or curved screen.
fn with_hops(test: impl Fn(&Hop, &str)) {
    let square = Aperture {
        outline: Outline::Rectangle {
            half_x: 3.0,
            half_y: 2.0,
        },
        centre: [0.2, 0.1],
    };
    for shape in shapes() {
        for aperture in [Aperture::OPEN, Aperture::disc(3.5), square.clone()] {
            for (mirror, curved) in [(false, false), (true, false), (false, true)] {
                let train = train(&shape, aperture.clone(), mirror);
                let [from, to] = &screens(mirror, curved);
                let hop = Hop {
                    wavelength: 0.5e-3,
                    from,
                    train: &train,
                    to,
                };
                test(&hop, &format!("{shape:?} {aperture:?} {mirror} {curved}"));
            }
        }
    }
}

/// Rays in blocks land where single rays land, and are lost for the same reasons.
#[test]
fn blocks_agree_with_single_rays() {
    let mut reasons = std::collections::HashSet::new();
    let (seen, landed) = (
        std::cell::RefCell::new(&mut reasons),
        std::cell::Cell::new(0),
    );
    with_hops(|hop, name| {
        let starts = starts(2.2);
        for (block, start) in HopRays::new(hop).trace(&starts).iter().zip(&starts) {
            let [x, y, p, q] = *start;
            match (block, hop.trace([x, y], [p, q], &mut ())) {
                (Ok(ours), Ok(alone)) => {
                    let all = |l: &crate::engine::trace::ray_trace::Landing| {
                        [l.at[0], l.at[1], l.cosines[0], l.cosines[1], l.path]
                    };
                    for (ours, alone) in all(ours).iter().zip(all(&alone)) {
                        let close = 1e-11 * (1.0 + alone.abs());
                        assert!((ours - alone).abs() < close, "{name}: {start:?}");
                    }
                    landed.set(landed.get() + 1);
                }
                (Err(ours), Err(alone)) => {
                    assert_eq!(*ours, alone, "{name}: {start:?}");
                    seen.borrow_mut().insert(alone);
                }
                (ours, alone) => panic!("{name}: {start:?}: {ours:?} {alone:?}"),
            }
        }
    });
    assert!(landed.get() > 10_000, "{}", landed.get());
    for loss in [
        Loss::Clipped,
        Loss::Missed,
        Loss::TotalReflection,
        Loss::Evanescent,
    ] {
        assert!(reasons.contains(&loss), "{loss:?}");
    }
}

/// Their Jacobians are those of dual numbers.
#[test]
fn jacobians_agree_with_dual_numbers() {
    with_hops(|hop, name| {
        let starts = starts(0.5);
        let mut landed = 0;
        for (block, start) in HopRays::new(hop).jacobians(&starts).iter().zip(&starts) {
            let [x, y, p, q] = *start;
            let (Ok((_, ours)), Ok((_, alone))) = (block, hop.jacobian([x, y], [p, q])) else {
                continue;
            };
            let pairs = ours.as_flattened().iter().zip(alone.as_flattened());
            for (ours, alone) in pairs {
                let close = 1e-10 * (1.0 + alone.abs());
                assert!(
                    (ours - alone).abs() < close,
                    "{name}: {start:?} {ours} {alone}"
                );
            }
            landed += 1;
        }
        assert!(landed > 50, "{name}: {landed}");
    });
}

/// A ray has the same bits alone and among others, in columns, and without the processor's vectors.
#[test]
fn a_ray_does_not_depend_on_those_beside_it() {
    with_hops(|hop, name| {
        let starts = starts(1.2);
        let mut rays = HopRays::new(hop);
        let together = rays.trace(&starts);
        let mut columns = LandingColumns::default();
        rays.trace_into(&starts, &mut columns);
        rays.level = Level::baseline();
        for (i, start) in starts.iter().enumerate() {
            assert_eq!(rays.trace(&[*start]), [together[i]], "{name}: {start:?}");
            assert_eq!(together[i].err(), columns.lost[i]);
            if let Ok(landing) = together[i] {
                assert_eq!(landing.at, [0, 1].map(|a| columns.at[a][i]));
                assert_eq!(landing.cosines, [0, 1].map(|a| columns.cosines[a][i]));
                assert_eq!(landing.path, columns.path[i]);
            }
        }
    });
}

/// Beamlets in blocks are those that go one by one, whether their light narrows, widens, or passes one or both of its foci on
/// the way, hardly diffracted or much.
#[test]
fn beamlets_agree_with_single_beamlets() {
    let imaginary = |re: f64, im: f64| Complex::new(re, im);
    let compared = std::cell::Cell::new(0);
    with_hops(|hop, name| {
        if !hop.from.is_plane() {
            return;
        }
        for (focus, other, width) in [
            (0.0, 0.0, 1e-3),
            (-0.3, -0.5, 1e-4),
            (-1.5, -2.5, 2e-2),
            (0.2, 0.34, 0.5),
            (-0.4, 0.01, 1e-7),
            (0.02, -0.5, 1e-9),
            (-0.6, -0.3, 1e-9),
        ] {
            let q = Symmetric {
                xx: imaginary(focus, width),
                xy: imaginary(0.1 * focus, 0.2 * width),
                yy: imaginary(other, 1.3 * width),
            };
            let starts = starts(0.6);
            let carried = HopRays::new(hop).carry_beamlets(q, &starts);
            for (block, [x, y, px, py]) in carried.iter().zip(&starts) {
                let (block, alone) = match (block, hop.carry_beamlet([*x, *y], [*px, *py], q)) {
                    (Ok(block), Ok(alone)) => (block, alone),
                    (block, alone) => {
                        assert_eq!(block.as_ref().err(), alone.as_ref().err());
                        continue;
                    }
                };
                let parts = |carried: &Carried| {
                    let (a, g) = (carried.amplitude, carried.curvature);
                    [a, g.xx, g.xy, g.yy].map(|z| z.value())
                };
                for (ours, alone) in parts(block).iter().zip(parts(&alone)) {
                    let close = 1e-8 * (1e-2 + alone.norm());
                    assert!(
                        (ours - alone).norm() < close,
                        "{name} {focus}: {px} {py} {ours} {alone}"
                    );
                }
                compared.set(compared.get() + 1);
            }
        }
    });
    assert!(compared.get() > 10_000, "{}", compared.get());
}
