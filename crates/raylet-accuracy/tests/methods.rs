//! Convergence of each method with the number of rays, against Collins' integral and Rayleigh and Sommerfeld's.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Paper, Settings};
use raylet::optics::refraction::Coating;
use raylet::optics::system::System;
use raylet::wave::grid::metrics::field_error;
use raylet_accuracy::numerics::pixels::Pixels;
use raylet_accuracy::problems::problem::{axis, doe, face, sensor};
use raylet_accuracy::references::collins::{Abcd, CollinsIntegral};
use raylet_accuracy::references::rayleigh_sommerfeld::rayleigh_sommerfeld;
use raylet_testkit::parts::plane_wave;

const WAVELENGTH: f64 = 0.7e-3;
const PITCH: f64 = 6.3e-3;

/// Points of the sensor along each axis.
const POINTS: usize = 48;

/// An element that a few plane waves describe: a soft beam with ripples of phase.
fn element() -> Pixels {
    let count = 64;
    let along = |i: usize, period: f64| {
        let x = (i as f64 - 0.5 * (count as f64 - 1.0)) * PITCH;
        let ripple = 1.2 * (std::f64::consts::TAU * x / period + 0.4).cos();
        Complex64::from_polar((-x * x / (2.0 * 0.06 * 0.06)).exp(), ripple)
    };
    Pixels {
        pitch: PITCH,
        transmission: Array2::from_shape_fn((count, count), |(j, i)| {
            along(i, 0.37) * along(j, 0.29)
        }),
    }
}

/// The element, a plano-convex lens of 50 mm, the sensor.
fn behind_lens(pixels: &Pixels) -> (System, Array2<Complex64>) {
    let (radius, index) = (25.8, 1.513_063_997_196);
    let surface = |z, radius, index| face(z, radius, 6.0, Coating::Ideal, index);
    let system = System {
        wavelength: WAVELENGTH,
        source: plane_wave([0.0; 2]),
        screens: vec![doe(0.0, pixels), sensor(53.0, POINTS, PITCH)],
        trains: vec![vec![
            surface(3.0, radius, [1.0, index]),
            surface(8.3, f64::INFINITY, [index, 1.0]),
        ]],
    };
    let train = Abcd::identity()
        .drift(3.0, 1.0)
        .refract((index - 1.0) / radius)
        .drift(5.3, index)
        .drift(44.7, 1.0);
    let points = axis(POINTS, PITCH);
    let integral = CollinsIntegral {
        pixels,
        wavelength: WAVELENGTH,
        train,
        nodes: 4,
    };
    let exact = integral.field([0.0; 2], [&points, &points]).unwrap();
    (system, exact)
}

/// The field `distance` mm behind the element, by direct sum.
fn rayleigh(pixels: &Pixels, distance: f64) -> Array2<Complex64> {
    let points = axis(POINTS, PITCH);
    let places: Vec<[f64; 3]> = (0..POINTS * POINTS)
        .map(|i| [points[i % POINTS], points[i / POINTS], distance])
        .collect();
    let values = rayleigh_sommerfeld(pixels, [0.0; 2], WAVELENGTH, 4, &places);
    Array2::from_shape_fn((POINTS, POINTS), |(j, i)| values[j * POINTS + i])
}

fn with(method: Method) -> Settings {
    Settings {
        method,
        ..Settings::default()
    }
}

fn paper(positions: usize, secondary: usize, seed: u64) -> Settings {
    Settings {
        paper: Paper {
            rays: positions,
            secondary,
            patch: Some(32.0 * PITCH),
            padding: 4.0,
            ..Settings::default().paper
        },
        seed,
        ..with(Method::Paper)
    }
}

fn error(system: &System, settings: &Settings, exact: &Array2<Complex64>) -> f64 {
    let outcome = simulate(system, settings, &|_| {}).unwrap();
    field_error(outcome.field.values.view(), exact.view()).unwrap()
}

/// Sixteen times the rays do not help: without its prefactor the sum has another phase and size.
#[test]
fn plain_plane_waves_are_biased_behind_a_lens() {
    let (system, exact) = behind_lens(&element());
    let of = |settings: &Settings| error(&system, settings, &exact);
    let (beamlet, plane) = (of(&with(Method::Beamlet)), of(&with(Method::Plane)));
    let [few, many] = [64, 1024].map(|positions| of(&paper(positions, 1000, 1)));
    assert!(
        beamlet < 3e-3 && plane < 1e-2,
        "beamlets {beamlet:.2e}, planes {plane:.2e}"
    );
    assert!(few > 0.5 && many > 0.5, "paper {few:.2e} then {many:.2e}");
}

/// In free space nothing is missing, and the error falls as one over the root of the rays: root mean
/// squares of eight seeds, to what chance leaves of them.
#[test]
fn plain_plane_waves_converge_in_free_space() {
    let (pixels, distance) = (element(), 4.0);
    let system = System {
        wavelength: WAVELENGTH,
        source: plane_wave([0.0; 2]),
        screens: vec![doe(0.0, &pixels), sensor(distance, POINTS, PITCH)],
        trains: vec![vec![]],
    };
    let exact = rayleigh(&pixels, distance);
    let direct = error(&system, &with(Method::Auto), &exact);
    let [few, many] = [64, 1024].map(|positions| {
        let squares =
            (1..=8).map(|seed| error(&system, &paper(positions, 1000, seed), &exact).powi(2));
        (squares.sum::<f64>() / 8.0).sqrt()
    });
    assert!(direct < 1e-6, "without rays {direct:.2e}");
    assert!(
        (few / many - 4.0).abs() < 1.0,
        "paper {few:.2e} then {many:.2e}"
    );
}
