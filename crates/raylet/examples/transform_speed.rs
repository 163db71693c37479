//! Times the Fourier transforms: `cargo run --release --example transform_speed`.

use std::time::Instant;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::math::chirp::{Chirp2, Comb};

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
}
