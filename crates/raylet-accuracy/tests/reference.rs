//! References against each other and against the sums that share no code with the library.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::reference::{Reference, ReferenceError, ReferenceOptions, reference};
use raylet::engine::free::free_method::Approach;
use raylet::engine::plan::settings::Settings;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::{Aperture, Outline};
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::frame::Frame;
use raylet::optics::phase::profile::Profile;
use raylet::optics::refraction::{Coating, Interface};
use raylet::optics::screen::{Screen, ScreenKind, Sensor};
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::source::Source;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet_accuracy::numerics::pixels::Pixels as Boxes;
use raylet_accuracy::references::rayleigh_sommerfeld::rayleigh_sommerfeld;
use raylet_testkit::noise::phases;
use raylet_testkit::parts::{box_pixels, on_axis, screen, sensor};

const WAVELENGTH: f64 = 1e-3;
const CELLS: usize = 60;
const PITCH: f64 = 0.5e-3;

fn transmission() -> Array2<Complex64> {
    phases([CELLS, CELLS], 3)
}

/// Random half-wave pixels, lit at 10°, and a sensor.
fn free(place: Frame) -> System {
    let x = 10f64.to_radians().sin();
    System {
        wavelength: WAVELENGTH,
        source: Source::Plane {
            direction: Vec3::new(x, 0.0, (1.0 - x * x).sqrt()),
            origin: Vec3::new(0.0, 0.0, 0.0),
        },
        screens: vec![
            Screen {
                name: String::from("hologram"),
                ..screen(Frame::GLOBAL, box_pixels(transmission(), PITCH))
            },
            screen(place, sensor(30, 1.2e-3)),
        ],
        trains: vec![vec![]],
    }
}

fn run(system: &System, approach: Approach) -> Result<Reference, ReferenceError> {
    let choice = ReferenceOptions {
        approach,
        ..ReferenceOptions::default()
    };
    reference(system, &Settings::default(), choice, &|_| {})
}

/// Relative L2 error.
fn error(ours: &Array2<Complex64>, exact: &[Complex64]) -> f64 {
    let norm: f64 = exact.iter().map(|u| u.norm_sqr()).sum();
    let off: f64 = ours
        .iter()
        .zip(exact)
        .map(|(a, b)| (a - b).norm_sqr())
        .sum();
    (off / norm).sqrt()
}

/// The sum that shares no code, with six Gauss nodes a pixel.
fn exact(system: &System) -> Vec<Complex64> {
    let frame = &system.screens[1].frame;
    let place = |i: usize| (i as f64 - 14.5) * 1.2e-3;
    let points: Vec<[f64; 3]> = (0..900)
        .map(|n| {
            let p = frame.to_global(Vec3::new(place(n % 30), place(n / 30), 0.0));
            [p.x, p.y, p.z]
        })
        .collect();
    let pixels = Boxes {
        pitch: PITCH,
        transmission: transmission(),
    };
    let tilt = [10f64.to_radians().sin(), 0.0];
    rayleigh_sommerfeld(&pixels, tilt, WAVELENGTH, 6, &points)
}

#[test]
fn angular_spectrum_and_direct_sum_meet_the_exact_sum() {
    // Half-wave random pixels send light along the screen; the plane waves' period cuts what lands far
    // away, which matters most at half the width behind them.
    for (z, bound) in [(0.03, 6e-4), (0.12, 1.5e-4)] {
        let system = free(on_axis(z));
        let exact = exact(&system);
        let spectrum = run(&system, Approach::AngularSpectrum).unwrap();
        let spectrum = error(&spectrum.field.values, &exact);
        assert!(spectrum < bound, "{z}: {spectrum:e}");
        let sum = run(&system, Approach::RayleighSommerfeld).unwrap();
        let sum = error(&sum.field.values, &exact);
        assert!(sum < 1e-6, "{z}: {sum:e}");
    }
}

#[test]
fn tilted_sensor_is_summed_directly() {
    let system = free(on_axis(0.08).tilted([0.3, -0.5, 0.2]));
    let ours = run(&system, Approach::Auto).unwrap();
    assert_eq!(ours.steps[0].approach, Approach::RayleighSommerfeld);
    let error = error(&ours.field.values, &exact(&system));
    assert!(error < 1e-7, "{error:e}");

    let refused = run(&system, Approach::AngularSpectrum)
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("not parallel") && refused.contains("'sensor'"),
        "{refused}"
    );
}

/// A stop between two free hops changes nothing when it is wide: two fields passed on against one.
#[test]
fn chained_hops_agree_with_one() {
    let mut system = free(on_axis(0.12));
    let exact = exact(&system);
    let stop = ScreenKind::Stop(Aperture::disc(0.25));
    system.screens.insert(1, screen(on_axis(0.05), stop));
    system.trains.push(vec![]);
    let ours = run(&system, Approach::Auto).unwrap();
    assert_eq!(ours.steps.len(), 2);
    let error = error(&ours.field.values, &exact);
    assert!(error < 6e-4, "{error:e}");
}

#[test]
fn lenses_go_by_collins_and_the_rest_is_refused_with_reasons() {
    let mut system = free(on_axis(30.0));
    let surface = |frame: Frame| Surface {
        shape: Shape::Conic(Conic {
            curvature: 1.0 / 25.0,
            conic: 0.0,
        }),
        frame,
        aperture: Aperture::disc(5.0),
        interface: Interface::Refract,
        coating: Coating::Ideal,
        index: [1.0, 1.0001],
    };
    system.trains[0] = vec![surface(on_axis(10.0))];
    system.screens[1].index = 1.0001;
    let ours = run(&system, Approach::Auto).unwrap();
    assert_eq!(ours.steps[0].approach, Approach::Collins);

    // Out of centre nothing is left for pixels.
    system.trains[0][0].frame.origin.x = 1.0;
    let refused = run(&system, Approach::Auto).unwrap_err().to_string();
    for part in [
        "'hologram'",
        "'sensor'",
        "plates",
        "stand between",
        "off the axis",
        "pixels",
    ] {
        assert!(refused.contains(part), "{refused}");
    }
    for approach in [
        Approach::AngularSpectrum,
        Approach::RayleighSommerfeld,
        Approach::Collins,
        Approach::Refraction,
    ] {
        let refused = run(&system, approach).unwrap_err().to_string();
        assert!(refused.contains("does not apply"), "{refused}");
    }
}

#[test]
fn endless_sums_are_not_begun() {
    let choice = ReferenceOptions {
        approach: Approach::RayleighSommerfeld,
        patience: 1e-6,
    };
    let refused =
        reference(&free(on_axis(0.1)), &Settings::default(), choice, &|_| {}).unwrap_err();
    assert!(
        matches!(refused, ReferenceError::TooLong { .. }),
        "{refused}"
    );
}

/// A hard-edged square of smooth phase: the plane waves, the direct sum and Collins agree.
#[test]
fn open_areas_agree_between_methods() {
    let half = 0.2;
    let lens = Doe {
        layers: vec![Layer::Phase(Profile::Lens {
            focal_length: 30.0,
            wavenumber: std::f64::consts::TAU / WAVELENGTH,
        })],
        aperture: Aperture {
            outline: Outline::Rectangle {
                half_x: half,
                half_y: half,
            },
            centre: [0.0; 2],
        },
        reflect: false,
    };
    let mut system = free(on_axis(5.0));
    system.source = Source::Plane {
        direction: Vec3::new(0.0, 0.0, 1.0),
        origin: Vec3::new(0.0, 0.0, 0.0),
    };
    system.screens[0].kind = ScreenKind::Doe(lens);
    system.screens[1].kind = ScreenKind::Sensor(Sensor {
        pixels: [40, 40],
        pitch: [8e-3; 2],
    });
    let spectrum = run(&system, Approach::AngularSpectrum).unwrap();
    let exact: Vec<Complex64> = spectrum.field.values.iter().copied().collect();
    // Collins' integral is paraxial: the steepest light here is at 5°.
    for (approach, bound) in [
        (Approach::RayleighSommerfeld, 6e-4),
        (Approach::Collins, 4e-3),
    ] {
        let ours = run(&system, approach).unwrap();
        let error = error(&ours.field.values, &exact);
        assert!(error < bound, "{approach:?} {error:e}");
    }
}
