//! The width of beamlets about which others are tried.

use crate::engine::trace::direction_search::SearchRay;
use crate::optics::system::Hop;

/// σ₀ = (k‖∂p′/∂x‖)^{−1/2}, the width whose beamlets spread least behind the train's power, by the
/// median of the search; without power √(‖∂s/∂p‖/k), and never more than a quarter of the screen.
pub(crate) fn starting_width(hop: &Hop, from: [f64; 4], sample_rays: &[SearchRay]) -> f64 {
    let k = hop.wavenumber();
    let wavelength = hop.wavelength;
    let norm = |ray: &SearchRay, row: usize, column: usize| {
        let j = &ray.jacobian;
        let squares = (0..2).flat_map(|a| (0..2).map(move |b| j[row + a][column + b].powi(2)));
        (0.5 * squares.sum::<f64>()).sqrt()
    };
    let median = |row: usize, column: usize| {
        let mut values: Vec<f64> = sample_rays
            .iter()
            .map(|ray| norm(ray, row, column))
            .collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (power, throw) = (median(2, 0), median(0, 2));
    let by_power = (k * power).powf(-0.5);
    let by_throw = (throw / k).sqrt().max(3.0 * wavelength);
    let [x0, x1, y0, y1] = from;
    let largest = 0.25 * (x1 - x0).max(y1 - y0);
    let powered = power * throw > 1e-3;
    let start = if powered {
        by_power
    } else {
        by_power.min(by_throw)
    };
    start.min(largest).max(1.5 * wavelength)
}
