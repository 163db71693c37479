//! Times the Fourier transforms: `cargo run --release --example transform_speed`.
//!
//! Set RAYON_NUM_THREADS to choose the number of threads.

use std::time::Instant;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::math::chirp::{Chirp2, Comb};
use raylet::math::nufft::Nufft;
use raylet::math::random;

/// The shortest of a few runs, in seconds.
fn shortest(mut run: impl FnMut()) -> f64 {
    let once = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..5).map(once).fold(f64::INFINITY, f64::min)
}

fn main() {
    let comb = |count| Comb {
        start: -0.5,
        step: 0.001,
        count,
    };
    let plan = Chirp2::new(comb(480), comb(480), comb(1080), comb(1080), 300.0);
    let input = Array2::from_elem([480, 480], Complex64::ONE);
    let seconds = shortest(|| drop(plan.apply(input.view())));
    println!("Chirp2 480x480 -> 1080x1080: {:.1} ms", seconds * 1e3);

    // Random points: the slowest order to sort.
    let count = 3_000_000;
    let points: Vec<_> = (0..count)
        .map(|i| random::pair(1, [i, 0, 0, 0]).map(|u| std::f64::consts::TAU * u))
        .collect();
    let strengths = vec![Complex64::new(1.0, 0.5); points.len()];
    for size in [256, 1024] {
        for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
            let Ok(plan) = Nufft::new([size, size], tolerance) else {
                continue;
            };
            let mut modes = Array2::zeros([size, size]);
            let none = shortest(|| plan.type1(&[], &[], &mut modes));
            let one = shortest(|| plan.type1(&points, &strengths, &mut modes));
            let two = shortest(|| drop(plan.type2(modes.view(), &points)));
            let rate = |seconds: f64| f64::from(count) / seconds * 1e-6;
            println!(
                "Nufft {size}x{size} at {tolerance:e}: type 1 {:.1}, type 2 {:.1} million points/s; \
                 without points {:.1} ms",
                rate(one),
                rate(two),
                none * 1e3
            );
        }
    }
}
