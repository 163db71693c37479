//! Pairs per second of the direct Rayleigh–Sommerfeld sum on one core.

use num_complex::Complex64;
use raylet::wave::free::rayleigh::Emitters;
use raylet::wave::grid::field::{Axis, Field, Grid};
use raylet::wave::grid::heights::Heights;

fn main() {
    let axis = Axis::uniform(256, 1e-3, 0.0);
    let mut field = Field::zeros(Grid {
        x: axis.clone(),
        y: axis,
    });
    field.values.fill(Complex64::ONE);
    let emitters = Emitters::new(&field, &Heights::flat(&field.grid));
    let points: Vec<[f64; 3]> = (0..8192)
        .map(|i| [1e-4 * f64::from(i), 0.01, 40.0])
        .collect();
    for threads in [1, 2] {
        match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
            Ok(pool) => {
                let clock = std::time::Instant::now();
                let sum = pool.install(|| emitters.field_at(&points, 0.7e-3));
                let seconds = clock.elapsed().as_secs_f64();
                let pairs = (emitters.len() * sum.len()) as f64;
                println!("{threads} thread(s): {:.3e} pairs/s", pairs / seconds);
            }
            Err(error) => eprintln!("{error}"),
        }
    }
}
