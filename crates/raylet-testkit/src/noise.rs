//! Random values by address: the same address gives the same value everywhere.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::math::random::{pair, uniform};

/// Complex values with parts from −½ to ½, [y, x]; others for each purpose.
pub fn noise(shape: impl Into<(usize, usize)>, purpose: u32) -> Array2<Complex64> {
    complex_noise(shape, 19, [purpose, 0])
}

/// Complex values with parts from −½ to ½, [y, x]; others for each seed and for other last words of the address.
pub fn complex_noise(
    shape: impl Into<(usize, usize)>,
    seed: u64,
    [a, b]: [u32; 2],
) -> Array2<Complex64> {
    Array2::from_shape_fn(shape.into(), |(j, i)| {
        let [re, im] = pair(seed, [j as u32, i as u32, a, b]);
        Complex64::new(re - 0.5, im - 0.5)
    })
}

/// Real values from 0 to 1, [y, x]; others for each seed and for other last words of the address.
pub fn real_noise(shape: impl Into<(usize, usize)>, seed: u64, [a, b]: [u32; 2]) -> Array2<f64> {
    Array2::from_shape_fn(shape.into(), |(j, i)| {
        uniform(seed, [j as u32, i as u32, a, b])
    })
}

/// Phase factors exp(2πiu), `shape` = [ny, nx], u even from 0 to 1 by seed and place.
pub fn phases(shape: [usize; 2], seed: u64) -> Array2<Complex64> {
    real_noise(shape, seed, [0, 0]).mapv(|turn| Complex64::cis(std::f64::consts::TAU * turn))
}

/// Complex values with parts from −½ to ½, in a column.
pub fn column(count: usize, seed: u64) -> Vec<Complex64> {
    let draw = |i: usize, part| uniform(seed, [i as u32, part, 0, 0]) - 0.5;
    let value = |i: usize| Complex64::new(draw(i, 0), draw(i, 1));
    (0..count).map(value).collect()
}
