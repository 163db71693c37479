//! The hot loops, each with a small input whose results do not depend on the machine.

use std::process::exit;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::ray_block::hop_rays::{HopRays, LandingColumns};
use raylet::math::chirp::{Chirp2, Comb};
use raylet::math::complex::{Complex, Symmetric};
use raylet::math::nufft::Nufft;
use raylet::math::random;
use raylet::math::simd_level::choose_level;
use raylet::optics::aperture::Aperture;
use raylet::optics::shape::Shape;
use raylet::optics::surface::Surface;
use raylet::optics::system::Hop;
use raylet::wave::beamlet::beamlet_sum::Canvas;
use raylet::wave::beamlet::wavelet::Arrival;
use raylet::wave::grid::raster::Raster;
use raylet_testkit::parts::{self, conic, face, on_axis, sensor};

use crate::stepping::{WITHOUT, between_marks};

/// The names of all loops.
pub(crate) const LOOPS: [&str; 8] = [
    "rays in blocks",
    "rays in blocks with Jacobians",
    "beamlets in blocks",
    "single rays",
    "sum of beamlets",
    "Fourier sum from points",
    "Fourier sum to points",
    "chirp",
];

/// Rays, beamlets that are summed, and points of a Fourier sum in a loop of the least size.
const RAYS: u32 = 16;
const BEAMLETS: u32 = 2;
const POINTS: u32 = 40;

/// The items that the rate of a loop counts, of one of the least size: rays at each surface, of blocks at the sensor too, points, or
/// values of beamlets, which are its results.
pub(crate) fn items(name: &str) -> Option<u32> {
    match name {
        "sum of beamlets" => None,
        "single rays" => Some(2 * RAYS),
        _ if name.starts_with("Fourier") => Some(POINTS),
        _ => Some(3 * RAYS),
    }
}

/// Runs a loop for the process that counts, with these vector instructions, of so many times the least size.
pub(crate) fn run_loop(name: &str, level: &str, times: u32) {
    if let Err(error) = choose_level(level) {
        eprintln!("{error}");
        exit(WITHOUT);
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread();
    pool.build_global().expect("one thread");
    let done = match name {
        "rays in blocks"
        | "rays in blocks with Jacobians"
        | "beamlets in blocks"
        | "single rays" => rays(name, RAYS * times),
        "sum of beamlets" => beamlets(BEAMLETS * times),
        "chirp" => chirp(),
        _ => points(name, POINTS * times),
    };
    done.expect("a loop that is counted");
}

/// A plano-convex lens of 50 mm focal length.
fn lens() -> Vec<Surface> {
    let surface = |z: f64, shape: Shape, index: [f64; 2]| Surface {
        aperture: Aperture::disc(12.7),
        ..face(on_axis(z), shape, index)
    };
    vec![
        surface(10.0, Shape::Plane, [1.0, 1.5195]),
        surface(15.3, conic(-1.0 / 25.8, 0.0), [1.5195, 1.0]),
    ]
}

/// Starts (x, y) within 5 mm, with direction cosines within ±0.02.
fn starts(count: u32) -> Vec<[f64; 4]> {
    let start = |i| {
        let ([x, y], [p, q]) = (random::pair(7, [i, 0, 0, 0]), random::pair(7, [i, 1, 0, 0]));
        [
            10.0 * x - 5.0,
            10.0 * y - 5.0,
            0.04 * p - 0.02,
            0.04 * q - 0.02,
        ]
    };
    (0..count).map(start).collect()
}

/// Rays and beamlets through a plane and a sphere.
fn rays(name: &str, count: u32) -> std::io::Result<()> {
    let screen = |z: f64| parts::screen(on_axis(z), sensor(256, 0.0025));
    let (from, train, to) = (screen(0.0), lens(), screen(64.0));
    let hop = Hop {
        wavelength: 532e-6,
        from: &from,
        train: &train,
        to: &to,
    };
    let (rays, starts) = (HopRays::new(&hop), starts(count));
    match name {
        "rays in blocks" => {
            // Columns that have their room.
            let mut landings = LandingColumns::default();
            rays.trace_into(&starts, &mut landings);
            between_marks(|| {
                rays.trace_into(&starts, &mut landings);
                landings.path
            })
        }
        "rays in blocks with Jacobians" => between_marks(|| {
            let found = rays.jacobians(&starts);
            found
                .iter()
                .flatten()
                .map(|(landing, _)| landing.path)
                .collect()
        }),
        "beamlets in blocks" => {
            let (q, zero) = (Complex::new(-0.01, 0.05), Complex::new(0.0, 0.0));
            let start = Symmetric {
                xx: q,
                xy: zero,
                yy: q,
            };
            between_marks(|| {
                let found = rays.carry_beamlets(start, &starts);
                found
                    .iter()
                    .flatten()
                    .map(|carried| carried.landing.path)
                    .collect()
            })
        }
        _ => between_marks(|| {
            let one = |[x, y, p, q]: &[f64; 4]| hop.trace([*x, *y], [*p, *q], &mut ());
            starts
                .iter()
                .filter_map(|start| Some(one(start).ok()?.path))
                .collect()
        }),
    }
}

/// Beamlets on a raster of 64 × 64, with footprints of 20 samples' radius; the result is the number of their values.
fn beamlets(count: u32) -> std::io::Result<()> {
    const PITCH: f64 = 0.0025;
    let (radius, k, threshold) = (20.0 * PITCH, std::f64::consts::TAU / 532e-6, 1e-3_f64);
    let decay = -2.0 * threshold.ln() / (k * radius * radius);
    let curvature = Complex64::new(0.3 * decay, decay);
    let pair = |i, kind| random::pair(3, [i, kind, 0, 0]).map(|u| u - 0.5);
    let arrivals: Vec<Arrival> = (0..count)
        .map(|i| Arrival {
            at: pair(i, 0).map(|u| 64.0 * PITCH * u),
            cosines: pair(i, 1).map(|u| 0.1 * u),
            amplitude: Complex64::new(1.0, 0.5),
            curvature: [curvature, Complex64::ZERO, curvature],
        })
        .collect();
    let mut canvas = Canvas::new(Raster {
        start: [-31.5 * PITCH; 2],
        pitch: [PITCH; 2],
        size: [64, 64],
    });
    between_marks(|| vec![canvas.add(&arrivals, k, threshold) as f64])
}

/// From 6 × 6 samples to 10 × 10.
fn chirp() -> std::io::Result<()> {
    let comb = |count| Comb {
        start: -0.5,
        step: 0.05,
        count,
    };
    let plan = Chirp2::new(comb(6), comb(6), comb(10), comb(10), 30.0);
    let input = Array2::from_shape_fn((6, 6), |(y, x)| Complex64::new(y as f64, x as f64));
    between_marks(|| {
        let found = plan.apply(input.view());
        found.iter().flat_map(|u| [u.re, u.im]).collect()
    })
}

/// Fourier sums between points and 8 × 8 modes at a tolerance of 1e-6.
fn points(name: &str, count: u32) -> std::io::Result<()> {
    let plan = Nufft::new([8, 8], 1e-6).expect("a tolerance that can be had");
    let point = |i| random::pair(1, [i, 0, 0, 0]).map(|u| std::f64::consts::TAU * u);
    let points: Vec<[f64; 2]> = (0..count).map(point).collect();
    let mut modes = Array2::from_elem([8, 8], Complex64::new(1.0, 0.5));
    match name {
        "Fourier sum from points" => {
            let strengths = vec![Complex64::new(1.0, 0.5); points.len()];
            between_marks(|| {
                plan.type1(&points, &strengths, &mut modes);
                modes.iter().flat_map(|u| [u.re, u.im]).collect()
            })
        }
        _ => between_marks(|| {
            let found = plan.type2(modes.view(), &points);
            found.iter().flat_map(|u| [u.re, u.im]).collect()
        }),
    }
}
