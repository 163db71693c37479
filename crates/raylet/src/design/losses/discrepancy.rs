//! How far the gradient of a loss is from differences of its values, for the tests of losses.

use ndarray::{Array2, ArrayView2, Zip};

use crate::design::losses::loss::Loss;
use crate::math::random;

/// Step of the differences in [`discrepancy`], relative to each intensity.
const STEP: f64 = 1e-3;

/// How far the gradient of a loss is from the differences of its values: along a random direction, by a
/// five-point rule, relative to the root of the sum of squares of the gradient's share in each pixel.
/// For a right gradient it is of the order of 1e-10, unless the loss has kinks.
pub(crate) fn discrepancy(loss: &dyn Loss, intensity: ArrayView2<'_, f64>, seed: u64) -> f64 {
    let direction = Array2::from_shape_fn(intensity.dim(), |(j, i)| {
        let noise = random::uniform(seed, [j as u32, i as u32, 0, 0]);
        intensity[[j, i]] * (2.0 * noise - 1.0)
    });
    let at = |step: f64| {
        let mut there = intensity.to_owned();
        there.scaled_add(step, &direction);
        loss.evaluate(there.view()).value
    };
    let near = (at(STEP) - at(-STEP)) / (2.0 * STEP);
    let far = (at(2.0 * STEP) - at(-2.0 * STEP)) / (4.0 * STEP);
    let difference = (4.0 * near - far) / 3.0;

    let bar = loss.evaluate(intensity).bar;
    let (slope, square) = Zip::from(&bar)
        .and(&direction)
        .fold((0.0, 0.0), |(slope, square), bar, step| {
            (slope + bar * step, square + (bar * step).powi(2))
        });
    (difference - slope).abs() / f64::sqrt(square)
}
