//! What rims before and behind pixels do to their light, by plane waves and an ideal lens.

use ndarray::{Array1, Array2};
use num_complex::Complex64;
use raylet::engine::plan::settings::Settings;
use raylet::engine::rims::pixel_light::PixelValues;
use raylet::engine::rims::rim_screens::{RimTreatment, with_rims};
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet::wave::grid::metrics::field_error;
use raylet_accuracy::numerics::dense::{fourier_kernel, separable};
use raylet_accuracy::numerics::pixels::Pixels;
use raylet_accuracy::problems::problem::{axis, doe, sensor};
use raylet_accuracy::references::spectrum::{Lattice, Slab, Spectrum};
use raylet_testkit::noise::phases;
use raylet_testkit::parts::{conic, face, on_axis, plane_wave, screen};

/// Wavelength, focal length, and the ways from the pixels to the lens, and from a rim to the pixels, in mm.
const WAVELENGTH: f64 = 0.55e-3;
const FOCAL_LENGTH: f64 = 5.0;
const WAY: f64 = 0.5;
const BEFORE: f64 = 0.8;

/// Pixels of the sensor in the focus, and their pitch in mm.
const COUNT: usize = 32;
const PITCH: f64 = 1e-3;

/// Random phases of 8 µm in a disc of so many pixels.
fn pixels(count: usize) -> Pixels {
    let radius = 4e-3 * count as f64;
    let mut transmission = phases([count, count], 2);
    let centres = axis(count, 8e-3);
    for ((j, i), value) in transmission.indexed_iter_mut() {
        if centres[i].hypot(centres[j]) > radius {
            *value = Complex64::ZERO;
        }
    }
    Pixels {
        pitch: 8e-3,
        transmission,
    }
}

/// So many pixels, a lens with a rim of this radius, and a sensor in its focus.
fn system(count: usize, rim: f64) -> System {
    let (index, thickness) = (1.5, 0.1);
    let curvature = 1.0 / (FOCAL_LENGTH * (index - 1.0));
    let mut front = face(on_axis(WAY), conic(curvature, 0.0), [1.0, index]);
    front.aperture = Aperture::disc(rim);
    let back = face(on_axis(WAY + thickness), conic(0.0, 0.0), [index, 1.0]);
    let focus = WAY + thickness + FOCAL_LENGTH - thickness / index;
    let mut first = doe(0.0, &pixels(count));
    if let ScreenKind::Doe(doe) = &mut first.kind {
        doe.aperture = Aperture::disc(4e-3 * count as f64);
    }
    System {
        wavelength: WAVELENGTH,
        source: plane_wave([0.0; 2]),
        screens: vec![first, sensor(focus, COUNT, PITCH)],
        trains: vec![vec![front, back]],
    }
}

/// A wide stop, a rim of this radius that no light bends at, the pixels, a lens close to them, and a sensor in its focus.
fn system_behind_rim(rim: f64) -> System {
    let behind = system(32, f64::INFINITY);
    let moved = |screen: &Screen, z: f64| Screen {
        frame: screen.frame.moved(Vec3::new(0.0, 0.0, z)),
        ..screen.clone()
    };
    let stop = ScreenKind::Stop(Aperture::disc(0.8));
    let stop = screen(on_axis(-BEFORE - 0.1), stop);
    let mut plane = face(on_axis(-BEFORE), conic(0.0, 0.0), [1.0; 2]);
    plane.aperture = Aperture::disc(rim);
    let close = |surface: &Surface| Surface {
        frame: surface.frame.moved(Vec3::new(0.0, 0.0, 0.01 - WAY)),
        aperture: Aperture::OPEN,
        ..surface.clone()
    };
    let lens = behind.trains[0].iter().map(close).collect();
    let [first, last] = &behind.screens[..] else {
        panic!("two screens")
    };
    System {
        screens: vec![stop, first.clone(), moved(last, 0.01 - WAY)],
        trains: vec![vec![plane], lens],
        ..behind
    }
}

/// The light of the rim alone in the focus of an ideal lens at the pixels, over the light without a rim.
fn share_of_rim(rim: f64) -> f64 {
    let lattice = Lattice::new(WAVELENGTH, 1.3, 0.5);
    let slab = Slab {
        index: 1.0,
        thickness: BEFORE,
    };
    let disc = Spectrum::from_disc(lattice, 1.0, rim, [0.0; 2]);
    let disc = disc.through(&[slab], rim + 0.128).unwrap();
    let places: Array1<f64> = axis(512, 0.5e-3);
    let plane = Complex64::cis(std::f64::consts::TAU * (BEFORE / WAVELENGTH).fract());
    let pixels = pixels(32).transmission;
    let mut light = disc.on_grid(&places, &places);
    let mut whole = light.clone();
    for ((j, i), value) in light.indexed_iter_mut() {
        let through = pixels[(j / 16, i / 16)];
        whole[(j, i)] = plane * through;
        *value = (*value - plane) * through;
    }
    let scale = -1.0 / (WAVELENGTH * FOCAL_LENGTH);
    let kernel = fourier_kernel(&axis(COUNT, PITCH), &places, scale);
    let [rim, whole] = [light, whole].map(|field| separable(&kernel, &field, &kernel));
    let energy = |field: &Array2<Complex64>| field.iter().map(|u| u.norm_sqr()).sum::<f64>();
    (energy(&rim) / energy(&whole)).sqrt()
}

/// The field in the focus of an ideal lens, for each rim and without one.
fn fields(rims: &[f64]) -> (Vec<Array2<Complex64>>, Array2<Complex64>) {
    let lattice = Lattice::new(WAVELENGTH, 1.44, 0.3);
    let slab = Slab {
        index: 1.0,
        thickness: WAY,
    };
    let light = Spectrum::from_pixels(lattice, 1.0, &pixels(64), [0.0; 2]);
    let light = light.through(&[slab], 0.256 + 0.4).unwrap();
    let places: Array1<f64> = axis(900, 0.9e-3);
    let before = light.on_grid(&places, &places);
    let scale = -1.0 / (WAVELENGTH * FOCAL_LENGTH);
    let kernel = fourier_kernel(&axis(COUNT, PITCH), &places, scale);
    let focused = |rim: f64| {
        let open = |j: usize, i: usize| f64::from(places[i].hypot(places[j]) <= rim);
        let cut = Array2::from_shape_fn(before.dim(), |(j, i)| before[(j, i)] * open(j, i));
        separable(&kernel, &cut, &kernel)
    };
    let cut = rims.iter().map(|rim| focused(*rim)).collect();
    (cut, focused(f64::INFINITY))
}

/// The expected error of the first rim of a system, over the exact one: it must be within a range. The rim is cut ray by ray.
fn assert_told(system: &System, exact: f64, allowed: std::ops::Range<f64>) {
    let rimmed = with_rims(system, &Settings::default(), PixelValues::Fixed);
    let rim = rimmed.rims.first().unwrap();
    assert!(matches!(rim.treatment, RimTreatment::ByRay(_)), "{rim:?}");
    let told = rim.error();
    assert!(allowed.contains(&(told / exact)), "{told:e} for {exact:e}");
}

/// Pixels send light in all directions, and a rim beside the light of a small sensor turns some of it there. The expected error
/// of a rim that is cut ray by ray is that of what the rim does to the field. It was two to four times as large while an edge
/// counted as if it turned light to all sides, and not in the plane across it alone.
#[test]
fn rims_in_the_light_of_pixels_cost_what_is_told() {
    let rims = [0.3, 0.33, 0.36];
    let (cut, whole) = fields(&rims);
    for (rim, cut) in rims.into_iter().zip(cut) {
        let exact = field_error(cut.view(), whole.view()).unwrap();
        assert_told(&system(64, rim), exact, 0.5..2.5);
    }
}

/// The rim of a lens before pixels sends light to them at large angles. The pixels turn little of it to the sensor. The estimate
/// was thirty times as large while all of it counted.
#[test]
fn rims_before_pixels_cost_what_is_told() {
    for rim in [0.25, 0.32] {
        assert_told(&system_behind_rim(rim), share_of_rim(rim), 0.5..2.0);
    }
}
