//! The grating equation, with the optical path that goes with it.

use raylet::engine::geometrical::ray_tube::trace_tube;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::frame::Frame;
use raylet::optics::phase::profile::Profile;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::source::Source;
use raylet::optics::system::System;

use crate::rays::stage::screen;
use raylet_testkit::parts::{self, element, on_axis};

const WAVELENGTH: f64 = 0.7e-3;
const K: f64 = std::f64::consts::TAU / WAVELENGTH;

/// A grating of `lines` per mm (negative for the order on the other side), grooves along its y axis.
fn grating(frame: Frame, lines: f64, reflect: bool) -> Screen {
    let gradient = [std::f64::consts::TAU * lines, 0.0];
    let layer = Layer::Phase(Profile::Linear { gradient });
    let mut doe = element(layer, Aperture::disc(10.0));
    doe.reflect = reflect;
    parts::screen(frame, ScreenKind::Doe(doe))
}

fn system(direction: Vec3, element: Screen, to: Screen) -> System {
    System {
        wavelength: WAVELENGTH,
        source: Source::Plane {
            direction,
            origin: Vec3::new(0.0, 0.0, 0.0),
        },
        screens: vec![element, to],
        trains: vec![vec![]],
    }
}

/// Light returns on itself from a grating at sin θ = λ/2d.
#[test]
fn littrow_grating_sends_light_back() {
    let lines = 1200.0;
    let sine = 0.5 * WAVELENGTH * lines;
    let direction = Vec3::new(-sine, 0.0, (1.0 - sine * sine).sqrt());
    let element = grating(Frame::GLOBAL, lines, true);
    let system = system(direction, element, screen(on_axis(-50.0), 1.0, -1.0));
    for start in [[0.0, 0.0], [3.0, -2.0], [-7.0, 4.0]] {
        let tube = trace_tube(&system, start).unwrap();
        assert!((tube.cosines[0] - sine).abs() < 1e-15 && tube.cosines[1] == 0.0);
        // It lands where a line back to the source meets the screen.
        let back = 50.0 * sine / direction.z;
        assert!((tube.at[0] - start[0] - back).abs() < 1e-13);
        assert!((tube.at[1] - start[1]).abs() < 1e-13);
    }
}

/// A plane wave at conical incidence on a tilted grating leaves as a plane wave: the phase of the source,
/// of the grating and of the flight together have no curvature and no tilt against the new direction.
#[test]
fn conical_diffraction_keeps_plane_waves_plane() {
    let lines = -700.0;
    let frame = Frame::GLOBAL.tilted([0.2, -0.3, 0.4]);
    let direction = Vec3::new(0.25, -0.1, 1.0).unit();
    let to = screen(on_axis(30.0).tilted([-0.1, 0.15, 0.0]), 1.0, 1.0);
    let system = system(direction, grating(frame, lines, false), to.clone());

    // Grating equation: the sine across the grooves changes by λ/d, the one along them does not.
    let (across, along) = (direction.dot(frame.x), direction.dot(frame.y));
    let turned = across + WAVELENGTH * lines;
    let rest = (1.0 - turned * turned - along * along).sqrt();
    let leaving = frame.x * turned + frame.y * along + frame.z * rest;

    // The phase of a plane wave of that direction, zero at the origin, in mm.
    for start in [[0.0, 0.0], [4.0, -3.0], [-6.0, 5.0], [1.0, 8.0]] {
        let tube = trace_tube(&system, start).unwrap();
        let [sx, sy] = tube.at;
        let landed = to.frame.to_global(Vec3::new(sx, sy, 0.0));
        let origin = frame.to_global(Vec3::new(start[0], start[1], 0.0));
        assert!((tube.cosines[0] - leaving.dot(to.frame.x)).abs() < 1e-14);
        assert!((tube.cosines[1] - leaving.dot(to.frame.y)).abs() < 1e-14);
        let phase = direction.dot(origin) + tube.path;
        assert!((phase - leaving.dot(landed)).abs() < 1e-12);
    }
}

/// An ideal diffractive lens images a point as far as it collimates: with the phase of two lenses made
/// for the two conjugates, source and image are joined by equal paths.
#[test]
fn two_diffractive_lenses_join_a_point_to_a_point() {
    let (before, behind) = (40.0, 25.0);
    let lens = |focal_length| {
        Layer::Phase(Profile::Lens {
            focal_length,
            wavenumber: K,
        })
    };
    let element = Doe {
        layers: vec![lens(before), lens(behind)],
        aperture: Aperture::disc(15.0),
        reflect: false,
    };
    let first = Screen {
        kind: ScreenKind::Doe(element),
        ..screen(Frame::GLOBAL, 1.0, 1.0)
    };
    let point = Vec3::new(0.0, 0.0, -before);
    let mut system = system(point, first, screen(on_axis(behind), 1.0, 1.0));
    system.source = Source::Point {
        position: point,
        reference: Vec3::new(0.0, 0.0, 0.0),
    };
    for [x, y] in [[0.0, 0.0], [3.0, 1.0], [-8.0, 6.0], [0.0, 14.0f64]] {
        let tube = trace_tube(&system, [x, y]).unwrap();
        let flight = x.hypot(y).hypot(before);
        assert!(tube.at[0].hypot(tube.at[1]) < 1e-12);
        assert!((flight + tube.path - before - behind).abs() < 1e-12);
    }
}
