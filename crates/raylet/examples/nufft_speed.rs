//! Seconds and errors of Fourier sums over scattered points, at several tolerances, on one thread and on two:
//! `cargo run --release --example nufft_speed -- POINTS`. A line has the type of the sum, modes along each axis, tolerance,
//! threads, points, seconds, the relative error against direct sums at a few modes or points, and the memory in MB beside that of the
//! points and what belongs to them, on Linux.

use std::error::Error;
use std::f64::consts::TAU;
use std::fs;
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
                let report = |kind: u8, run: Run| {
                    let Run {
                        seconds,
                        error,
                        megabytes,
                    } = run;
                    println!(
                        "{kind} {modes} {tolerance:e} {threads} {count} {seconds:.4} {error:.2e} {megabytes:.0}"
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

    /// The sums over points.
    fn type1(&self, plan: &Nufft) -> Run {
        let sums = || {
            let mut out = Array2::zeros(self.modes.dim());
            plan.type1(self.points, &self.strengths, &mut out);
            out
        };
        best(sums, |found| {
            let pairs = self.over_points.iter();
            error(pairs.map(|(mode, exact)| (found[*mode], *exact)))
        })
    }

    /// The sums over modes.
    fn type2(&self, plan: &Nufft) -> Run {
        let sums = || plan.type2(self.modes.view(), self.points);
        best(sums, |found| {
            let pairs = self.over_modes.iter();
            error(pairs.map(|(point, exact)| (found[*point], *exact)))
        })
    }
}

/// What sums take, and how wrong they are.
struct Run {
    seconds: f64,
    error: f64,
    megabytes: f64,
}

/// The least seconds of several runs, the error of the last one, and their memory.
fn best<T>(sums: impl Fn() -> T, error: impl Fn(&T) -> f64) -> Run {
    let before = memory("VmRSS");
    // The most that was held is counted anew, where that can be.
    let _ = fs::write("/proc/self/clear_refs", "5");
    let runs = (0..RUNS).map(|_| {
        let clock = Instant::now();
        let found = sums();
        (clock.elapsed().as_secs_f64(), error(&found))
    });
    let (seconds, error) = runs.fold((f64::INFINITY, 0.0), |(least, _), (seconds, error)| {
        (least.min(seconds), error)
    });
    Run {
        seconds,
        error,
        megabytes: memory("VmHWM") - before,
    }
}

/// A figure of this process in MB; zero where the system does not tell it.
fn memory(name: &str) -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with(name));
    let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok());
    kilobytes.unwrap_or(0.0) / 1e3
}

/// The relative error of pairs of found and exact sums.
fn error(pairs: impl Iterator<Item = (Complex64, Complex64)>) -> f64 {
    let add = |(off, norm): (f64, f64), (found, exact): (Complex64, Complex64)| {
        (off + (found - exact).norm_sqr(), norm + exact.norm_sqr())
    };
    let (off, norm) = pairs.fold((0.0, 0.0), add);
    (off / norm).sqrt()
}
