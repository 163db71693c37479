//! Random values by address: the same address gives the same value everywhere.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::math::random::uniform;

/// Phase factors exp(2πiu), `shape` = [ny, nx], u even from 0 to 1 by seed and place.
pub fn phases([ny, nx]: [usize; 2], seed: u64) -> Array2<Complex64> {
    Array2::from_shape_fn((ny, nx), |(j, i)| {
        Complex64::cis(std::f64::consts::TAU * uniform(seed, [j as u32, i as u32, 0, 0]))
    })
}

/// Complex values with parts from −½ to ½, in a column.
pub fn column(count: usize, seed: u64) -> Vec<Complex64> {
    let draw = |i: usize, part| uniform(seed, [i as u32, part, 0, 0]) - 0.5;
    let value = |i: usize| Complex64::new(draw(i, 0), draw(i, 1));
    (0..count).map(value).collect()
}
