//! How steeply the light of a field crosses its plane: its power per area is |U|² times the mean cosine of its directions.

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;
use raylet_fft::Planner;

/// Samples along each side of the part about the brightest one whose directions are found.
const SIDE: usize = 1024;

/// The mean cosine of the plane waves of a field [y, x], weighted by their energy, from the part about its brightest sample.
/// `pitch` is that of the samples along x and y in mm, and `k` = 2πn/λ in rad/mm. One for a dark field. Of the waves that the
/// samples do not tell apart each counts as that nearest to the cosines `about`.
pub(crate) fn mean_cosine(
    values: &Array2<Complex64>,
    pitch: [f64; 2],
    k: f64,
    about: [f64; 2],
) -> f64 {
    let part = about_the_brightest(values);
    let (ny, nx) = part.dim();
    let mut spectrum = part.to_owned();
    transform_rows(&mut spectrum);
    let mut spectrum = spectrum.reversed_axes().as_standard_layout().into_owned();
    transform_rows(&mut spectrum);

    // The direction cosine of the wave with this number, of so many along an axis.
    let cosine = |m: usize, count: usize, axis: usize| {
        let period = std::f64::consts::TAU / (pitch[axis] * k);
        let first = period * m as f64 / count as f64;
        first + period * ((about[axis] - first) / period).round()
    };
    let (mut all, mut through) = (0.0, 0.0);
    for ((i, j), wave) in spectrum.indexed_iter() {
        let (p, q) = (cosine(i, nx, 0), cosine(j, ny, 1));
        all += wave.norm_sqr();
        through += wave.norm_sqr() * (1.0 - p * p - q * q).max(0.0).sqrt();
    }
    if all > 0.0 { through / all } else { 1.0 }
}

/// The part of at most [`SIDE`] samples along each side about the brightest sample.
fn about_the_brightest(values: &Array2<Complex64>) -> ArrayView2<'_, Complex64> {
    let brighter = |a: &((usize, usize), &Complex64), b: &((usize, usize), &Complex64)| {
        a.1.norm_sqr().total_cmp(&b.1.norm_sqr())
    };
    let (row, column) = values
        .indexed_iter()
        .max_by(brighter)
        .map_or((0, 0), |(at, _)| at);
    let span = |at: usize, count: usize| {
        let side = count.min(SIDE);
        let first = at.saturating_sub(side / 2).min(count - side);
        ndarray::Slice::from(first..first + side)
    };
    let (ny, nx) = values.dim();
    let mut part = values.view();
    part.slice_axis_inplace(ndarray::Axis(0), span(row, ny));
    part.slice_axis_inplace(ndarray::Axis(1), span(column, nx));
    part
}

/// The transform along each row.
fn transform_rows(values: &mut Array2<Complex64>) {
    let fft = Planner::new().forward(values.ncols());
    if let Some(all) = values.as_slice_mut() {
        fft.process(all);
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::wave::grid::mean_cosine::mean_cosine;

    /// Two plane waves of 3 : 4 in amplitude, whose cosines are 0.8 and √(1 − 0.2² − 0.5²), sampled over whole periods.
    #[test]
    fn two_plane_waves_have_the_mean_of_their_cosines() {
        let (k, pitch) = (std::f64::consts::TAU / 0.5e-3, 0.125e-3);
        let wave = |p: f64, q: f64, x: usize, y: usize| {
            Complex64::cis(k * pitch * (p * x as f64 + q * y as f64))
        };
        let values = Array2::from_shape_fn((40, 60), |(y, x)| {
            3.0 * wave(0.6, 0.0, x, y) + 4.0 * wave(-0.2, 0.5, x, y)
        });
        let found = mean_cosine(&values, [pitch; 2], k, [0.0; 2]);
        let exact = (9.0 * 0.8 + 16.0 * (1.0f64 - 0.04 - 0.25).sqrt()) / 25.0;
        assert!((found - exact).abs() < 1e-12, "{found} {exact}");
        assert_eq!(
            mean_cosine(&Array2::zeros((4, 4)), [pitch; 2], k, [0.0; 2]),
            1.0
        );

        // Every fourth sample tells the waves apart only if it is known about where they go.
        let coarse = Array2::from_shape_fn((10, 15), |(y, x)| values[[4 * y, 4 * x]]);
        let found = mean_cosine(&coarse, [4.0 * pitch; 2], k, [0.2, 0.2]);
        assert!((found - exact).abs() < 1e-12, "{found} {exact}");
    }
}
