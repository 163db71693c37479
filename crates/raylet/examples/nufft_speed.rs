//! Seconds and errors of Fourier sums over scattered points, at several tolerances, on one thread and on two:
//! `cargo run --release --example nufft_speed -- POINTS`. A line has the type of the sum, modes along each axis, tolerance,
//! threads, points, seconds and the relative error, against direct sums at a few modes or points.

use std::error::Error;
use std::f64::consts::TAU;
use std::time::Instant;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::math::nufft::Nufft;
use raylet::math::random::pair;

/// Modes or points at which sums are computed directly.
const LOOKED_AT: usize = 12;

/// Runs of which the best counts.
const RUNS: usize = 3;

fn main() -> Result<(), Box<dyn Error>> {
    let count: u32 = std::env::args()
        .nth(1)
        .map_or(Ok(10_000_000), |n| n.parse())?;
    let points: Vec<[f64; 2]> = (0..count)
        .map(|i| pair(1, [i, 0, 0, 0]).map(|u| TAU * u))
        .collect();
    for modes in [256, 1024] {
        let sums = Sums::new(&points, modes);
        for tolerance in [1e-3, 1e-6, 1e-9] {
            for threads in [1, 2] {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()?;
                let plan = Nufft::new([modes; 2], tolerance)?;
                let report = |kind: u8, (seconds, error): (f64, f64)| {
                    println!(
                        "{kind} {modes} {tolerance:e} {threads} {count} {seconds:.4} {error:.2e}"
                    );
                };
                report(1, pool.install(|| sums.type1(&plan)));
                report(2, pool.install(|| sums.type2(&plan)));
            }
        }
    }
    Ok(())
}

/// Points with their strengths and modes, and some sums over them.
struct Sums<'a> {
    points: &'a [[f64; 2]],
    strengths: Vec<Complex64>,
    modes: Array2<Complex64>,
    /// Modes [y, x], and their sums over all points.
    over_points: Vec<([usize; 2], Complex64)>,
    /// Points, and their sums over all modes.
    over_modes: Vec<(usize, Complex64)>,
}

impl<'a> Sums<'a> {
    fn new(points: &'a [[f64; 2]], side: usize) -> Self {
        let noise = |i: usize, purpose: u32| {
            let [re, im] = pair(2, [i as u32, purpose, 0, 0]);
            Complex64::new(re - 0.5, im - 0.5)
        };
        let strengths: Vec<Complex64> = (0..points.len()).map(|i| noise(i, 0)).collect();
        let modes = Array2::from_shape_fn((side, side), |(j, i)| noise(j * side + i, 1));
        let order = |index: usize| index as f64 - (side / 2) as f64;
        let phase = |[j, i]: [usize; 2], [u, v]: [f64; 2]| order(i) * u + order(j) * v;
        let over_points = (0..LOOKED_AT).map(|n| {
            let mode = pair(3, [n as u32, 0, 0, 0]).map(|share| (share * side as f64) as usize);
            let terms = points.iter().zip(&strengths);
            let sum = terms.map(|(point, strength)| strength * Complex64::cis(phase(mode, *point)));
            (mode, sum.sum())
        });
        let over_modes = (0..LOOKED_AT).map(|n| {
            let point = points[n];
            let terms = modes.indexed_iter();
            let sum = terms.map(|((j, i), value)| value * Complex64::cis(-phase([j, i], point)));
            (n, sum.sum())
        });
        let (over_points, over_modes) = (over_points.collect(), over_modes.collect());
        Self {
            points,
            strengths,
            modes,
            over_points,
            over_modes,
        }
    }

    /// Seconds and error of the sums over points.
    fn type1(&self, plan: &Nufft) -> (f64, f64) {
        let (seconds, found) = best(|| {
            let mut out = Array2::zeros(self.modes.dim());
            plan.type1(self.points, &self.strengths, &mut out);
            out
        });
        (
            seconds,
            error(
                self.over_points
                    .iter()
                    .map(|(mode, exact)| (found[*mode], *exact)),
            ),
        )
    }

    /// Seconds and error of the sums over modes.
    fn type2(&self, plan: &Nufft) -> (f64, f64) {
        let (seconds, found) = best(|| plan.type2(self.modes.view(), self.points));
        (
            seconds,
            error(
                self.over_modes
                    .iter()
                    .map(|(point, exact)| (found[*point], *exact)),
            ),
        )
    }
}

/// The least seconds of several runs, and what the last one gives.
fn best<T>(run: impl Fn() -> T) -> (f64, T) {
    let timed = || {
        let clock = Instant::now();
        let found = run();
        (clock.elapsed().as_secs_f64(), found)
    };
    let first = timed();
    (1..RUNS).fold(first, |(least, _), _| {
        let (seconds, found) = timed();
        (least.min(seconds), found)
    })
}

/// The relative error of pairs of found and exact sums.
fn error(pairs: impl Iterator<Item = (Complex64, Complex64)>) -> f64 {
    let add = |(off, norm): (f64, f64), (found, exact): (Complex64, Complex64)| {
        (off + (found - exact).norm_sqr(), norm + exact.norm_sqr())
    };
    let (off, norm) = pairs.fold((0.0, 0.0), add);
    (off / norm).sqrt()
}
