//! A tilted spherical mirror: beamlets and plane wavelets before, between and behind its two astigmatic
//! images, with nothing fitted, so that a wrong sign of a root shows.
//!
//! The reference is Collins' integral, one for each meridian: at an angle of incidence θ the mirror's
//! focal lengths are f cos θ in the plane of incidence and f/cos θ across it (Coddington). The element is
//! a product of a function of x and one of y, so the field is a product of two one-dimensional sums.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::frame::Frame;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet::wave::grid::metrics::field_error;
use raylet_testkit::parts::{box_pixels, conic, lit, mirror, on_axis, screen, sensor};

const WAVELENGTH: f64 = 0.7e-3;
const K: f64 = std::f64::consts::TAU / WAVELENGTH;

/// Focal length of the mirror at normal incidence, and the angle of incidence on it.
const FOCUS: f64 = 20.0;
const ANGLE: f64 = 0.6;

/// Pixels of the element and points of the sensor along each axis, and their pitches.
const PIXELS: usize = 80;
const PITCH: f64 = 6.3e-3;
const POINTS: usize = 32;
const SPACING: f64 = 12e-3;

/// The element along one axis: a soft beam with ripples of phase.
fn profile(x: f64, period: f64) -> Complex64 {
    let ripple = 1.2 * (std::f64::consts::TAU * x / period + 0.4).cos();
    Complex64::from_polar((-x * x / (2.0 * 0.06 * 0.06)).exp(), ripple)
}

const PERIODS: [f64; 2] = [0.37, 0.29];

fn centred(i: usize, count: usize, pitch: f64) -> f64 {
    (i as f64 - 0.5 * (count as f64 - 1.0)) * pitch
}

fn element() -> ScreenKind {
    let values = Array2::from_shape_fn((PIXELS, PIXELS), |(j, i)| {
        let [x, y] = [i, j].map(|i| centred(i, PIXELS, PITCH));
        profile(x, PERIODS[0]) * profile(y, PERIODS[1])
    });
    box_pixels(values, PITCH)
}

/// The element, the mirror `before` behind it and the sensor `behind` along the reflected chief ray.
fn system(before: f64, behind: f64) -> System {
    let vertex = on_axis(before);
    let mirror = Surface {
        aperture: Aperture::disc(3.0),
        ..mirror(vertex.tilted([0.0, ANGLE, 0.0]), conic(-0.5 / FOCUS, 0.0))
    };
    // The reflected chief ray runs against the z axis of a frame turned by twice the angle.
    let turned = vertex.tilted([0.0, 2.0 * ANGLE, 0.0]);
    let end = turned.moved(Vec3::new(0.0, 0.0, -behind));
    let seen = Screen {
        arrives: -1.0,
        ..screen(end, sensor(POINTS, SPACING))
    };
    System {
        wavelength: WAVELENGTH,
        ..lit(
            vec![screen(Frame::GLOBAL, element()), seen],
            vec![vec![mirror]],
        )
    }
}

/// One meridian of Collins' integral: (k/2πi|B|)^{1/2} ∫ t(x) exp(ik(Ax² − 2xs + Ds²)/2B) dx, and a quarter
/// of a turn for the image that has been passed where B < 0. Returns the points of the sensor.
fn meridian([before, behind, focus]: [f64; 3], period: f64) -> Vec<Complex64> {
    let (a, d) = (1.0 - behind / focus, 1.0 - before / focus);
    let b = before + behind - before * behind / focus;
    let turns = if b < 0.0 { -0.75 } else { -0.25 };
    let factor = Complex64::from_polar(
        (K / (std::f64::consts::TAU * b.abs())).sqrt(),
        turns * std::f64::consts::PI,
    );

    // Eight midpoints to a pixel, whose value is constant.
    let parts = 8;
    (0..POINTS)
        .map(|i| {
            let s = centred(i, POINTS, SPACING);
            let mut sum = Complex64::ZERO;
            for pixel in 0..PIXELS {
                let middle = centred(pixel, PIXELS, PITCH);
                let value = profile(middle, period);
                for part in 0..parts {
                    let x = middle + centred(part, parts, PITCH / parts as f64);
                    let phase = 0.5 * K * (a * x * x - 2.0 * x * s + d * s * s) / b;
                    sum += value * Complex64::cis(phase);
                }
            }
            sum * factor * (PITCH / parts as f64)
        })
        .collect()
}

/// B along the plane of incidence and across it: positive before the image, negative behind.
fn images(before: f64, behind: f64) -> [f64; 2] {
    [FOCUS * ANGLE.cos(), FOCUS / ANGLE.cos()]
        .map(|focus| before + behind - before * behind / focus)
}

fn collins(before: f64, behind: f64) -> Array2<Complex64> {
    let tangential = meridian([before, behind, FOCUS * ANGLE.cos()], PERIODS[0]);
    let sagittal = meridian([before, behind, FOCUS / ANGLE.cos()], PERIODS[1]);
    let path = Complex64::cis(K * (before + behind));
    Array2::from_shape_fn((POINTS, POINTS), |(j, i)| {
        tangential[i] * sagittal[j] * path
    })
}

fn carried(system: &System, method: Method) -> Array2<Complex64> {
    let settings = Settings {
        method,
        ..Settings::default()
    };
    simulate(system, &settings, &|_| {}).unwrap().field.values
}

/// An element far before the mirror has two real images; one between the two foci a real one in the
/// plane of incidence and a virtual one across it. Collins' integral leaves out the mirror's aberrations,
/// which grow with the beam: the first limit is what they were found to do. The second one holds between
/// the two methods: it is wider in the last case, where the sensor sees a small part of a beam whose
/// beamlets are wider than the sensor, so that their cut tails weigh more.
#[test]
fn fields_around_astigmatic_images_have_the_right_sign_slow() {
    for (before, behind, signs, [limit, close]) in [
        (48.0, 12.0, [1.0, 1.0], [4e-3, 1.5e-3]),
        (48.0, 34.0, [-1.0, 1.0], [4e-3, 1.5e-3]),
        (48.0, 68.0, [-1.0, -1.0], [3e-3, 1.5e-3]),
        (22.0, 45.0, [1.0, 1.0], [2e-3, 1.5e-3]),
        (22.0, 80.0, [-1.0, 1.0], [1.2e-2, 4e-3]),
    ] {
        assert_eq!(images(before, behind).map(f64::signum), signs);
        let system = system(before, behind);
        let exact = collins(before, behind);
        let beamlets = carried(&system, Method::Beamlet);
        let planes = carried(&system, Method::Plane);
        let pairs = [(&beamlets, &exact), (&planes, &exact), (&planes, &beamlets)];
        let [beamlet, plane, apart] = pairs.map(|(a, b)| field_error(a.view(), b.view()).unwrap());
        let place = format!("{before} mm, {behind} mm");
        assert!(beamlet < limit, "{place}: {beamlet:.2e}");
        assert!(plane < limit, "{place}: {plane:.2e}");
        assert!(apart < close, "{place}: {apart:.2e}");
    }
}

/// Narrow windows need a long period: their copies overlap the more, the larger D is.
#[test]
fn narrow_windows_are_as_good() {
    let system = system(48.0, 12.0);
    let settings = Settings {
        method: Method::Plane,
        sigma: Some(0.03),
        ..Settings::default()
    };
    let planes = simulate(&system, &settings, &|_| {}).unwrap().field.values;
    let exact = collins(48.0, 12.0);
    let error = field_error(planes.view(), exact.view()).unwrap();
    assert!(error < 4e-3, "{error:.2e}");
}
