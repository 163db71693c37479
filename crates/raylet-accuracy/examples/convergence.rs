//! How the chained references converge: the relative L2 change of the complex field on the sensor
//! when each numerical setting is varied, and the time each takes.
//!
//! `cargo run --release -p raylet-accuracy --example convergence [case]`

use std::time::Instant;

use ndarray::{Array1, Array2};
use num_complex::Complex64;
use raylet_accuracy::numerics::pixels::Pixels;
use raylet_accuracy::references::lens_train::{LensTrain, PlanoConvex, Source, Step};

/// A source, the steps to the sensor, the sensor's half width.
struct Case<'a> {
    name: &'a str,
    source: Source<'a>,
    steps: Vec<Step<'a>>,
}

const SENSOR: f64 = 20.0;

/// Pixels with a reproducible random phase, `count`² of side `pitch`.
fn random(count: usize, pitch: f64) -> Pixels {
    let mut state = 12345_u64;
    let transmission = Array2::from_shape_simple_fn((count, count), || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        Complex64::cis(std::f64::consts::TAU * (state >> 11) as f64 / (1_u64 << 53) as f64)
    });
    Pixels {
        pitch,
        transmission,
    }
}

/// Pixels of half a wavelength with the linear phase of a grating of sine 0.25.
fn grating() -> Pixels {
    let phase = |i: usize| std::f64::consts::TAU * 0.25 * 0.5 * i as f64;
    Pixels {
        pitch: 0.5,
        transmission: Array2::from_shape_fn((160, 160), |(_, j)| Complex64::cis(phase(j))),
    }
}

/// The field on the sensor and the seconds it took.
fn field(train: &LensTrain, case: &Case) -> (Array2<Complex64>, f64) {
    let start = Instant::now();
    let axis = Array1::linspace(-SENSOR, SENSOR, 81);
    let spectrum = train
        .run(case.source, &case.steps, SENSOR)
        .expect("the period is long enough");
    (
        spectrum.on_grid(&axis, &axis),
        start.elapsed().as_secs_f64(),
    )
}

fn table(case: &Case) {
    let base = LensTrain::converged(1.0, 432.0);
    let (reference, seconds) = field(&base, case);
    println!(
        "{}: period 432, pitch 1/5, stencil 8, extra 6, 10 nodes: {seconds:.1} s",
        case.name
    );
    let norm: f64 = reference.iter().map(|u| u.norm_sqr()).sum();
    let period = |period: f64| LensTrain::converged(1.0, period);
    for (name, train) in [
        (
            "pitch 1/2",
            LensTrain {
                samples: 864,
                ..base
            },
        ),
        (
            "pitch 1/3",
            LensTrain {
                samples: 1296,
                ..base
            },
        ),
        (
            "pitch 1/4",
            LensTrain {
                samples: 1728,
                ..base
            },
        ),
        (
            "pitch 1/6",
            LensTrain {
                samples: 2592,
                ..base
            },
        ),
        ("stencil 1", LensTrain { stencil: 1, ..base }),
        ("stencil 6", LensTrain { stencil: 6, ..base }),
        ("extra 4", LensTrain { extra: 4.0, ..base }),
        ("extra 5", LensTrain { extra: 5.0, ..base }),
        ("extra 8", LensTrain { extra: 8.0, ..base }),
        ("period 324", period(324.0)),
        ("period 648", period(648.0)),
        ("period 864", period(864.0)),
        (
            "6 nodes",
            LensTrain {
                pixel_nodes: 6,
                ..base
            },
        ),
        (
            "14 nodes",
            LensTrain {
                pixel_nodes: 14,
                ..base
            },
        ),
    ] {
        let (varied, seconds) = field(&train, case);
        let off: f64 = varied
            .iter()
            .zip(&reference)
            .map(|(a, b)| (a - b).norm_sqr())
            .sum();
        println!("  {name:<12} {:.1e}  {seconds:.1} s", (off / norm).sqrt());
    }
}

fn main() {
    let lens = PlanoConvex {
        radius: 200.0,
        thickness: 25.0,
        index: 1.5,
        semi_aperture: 50.0,
        gap_before: 20.0,
    };
    let (fine, coarse, grating) = (random(160, 0.5), random(40, 2.0), grating());
    let chain = |parts: &[&[Step<'static>]]| parts.concat();
    let to_focus = [Step::Drift(380.0)];
    let before = |name, pixels| Case {
        name,
        source: Source::Pixels(pixels, [0.0, 0.0]),
        steps: chain(&[&lens.convex_first(), &to_focus]),
    };
    let mut after = lens.convex_first();
    after.extend([Step::Drift(20.0), Step::Pixels(&coarse), Step::Drift(300.0)]);
    let mut between = lens.convex_first();
    between.extend([Step::Drift(20.0), Step::Pixels(&coarse)]);
    between.extend(lens.plane_first());
    between.push(Step::Drift(180.0));
    let cases = [
        before("random 0.5 before a lens", &fine),
        before("random 2.0 before a lens", &coarse),
        before("grating before a lens", &grating),
        Case {
            name: "random 2.0 after a lens",
            source: Source::Disc(45.0, [0.0, 0.0]),
            steps: after,
        },
        Case {
            name: "random 2.0 between lenses",
            source: Source::Disc(45.0, [0.0, 0.0]),
            steps: between,
        },
    ];
    let only: Option<usize> = std::env::args().nth(1).and_then(|text| text.parse().ok());
    for (index, case) in cases.iter().enumerate() {
        if only.is_none_or(|only| only == index) {
            table(case);
        }
    }
}
