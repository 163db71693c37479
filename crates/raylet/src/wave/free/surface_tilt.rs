//! The tilt of a curved screen in the plane waves that it sends, from neighbouring plane waves.
//!
//! A curved screen sends the plane wave of direction p with Σ U·(1 − s·p/q)·e^{−ik(p·x + qz)} for its slopes s. On a conic
//! s = x·c/(1 − (1 + κ)cz): the place times a number that the height gives. The transform of U times the place is the derivative by
//! p of the transform of U, a sum over neighbouring directions. So one transform is enough for each level of height.
//! `emission_spectrum_dot_product`, beside the transforms, checks the adjoint.

use std::f64::consts::PI;

use ndarray::{Array1, Array2, ArrayView1, ArrayViewMut1, Axis, Slice};
use num_complex::Complex64;

use crate::optics::conic::Conic;
use crate::wave::free::free_plan::FreePlan;
use crate::wave::grid::field::{Axis as GridAxis, Grid};
use crate::wave::grid::heights::{Heights, Stack};
use crate::wave::patches::patch::Band;

/// Neighbours on each side of a direction.
pub(super) const NEIGHBOURS: usize = 8;

/// The largest phase between neighbouring directions, in rad, up to which the derivative is right to 1e-6.
const LARGEST_PHASE: f64 = 1.58;

/// The error of the numbers that heights give, when they are taken at the levels.
const LEVEL_ERROR: f64 = 1e-6;

/// Neighbours on both sides, and the direction itself.
const TAPS: usize = 2 * NEIGHBOURS + 1;

/// The tilt of a conic, for the directions of a plan.
pub(super) struct SurfaceTilt {
    conic: Conic,
    /// What multiplies a field by its place along x and y, in terms of its transform: the weights of neighbouring directions.
    places: [[Complex64; TAPS]; 2],
}

impl SurfaceTilt {
    /// Of a screen with these heights, known on a grid; nothing where the screen is no conic, bends too much for its levels, or
    /// is too wide for the directions.
    pub(super) fn of(
        heights: &Heights,
        stack: &Stack,
        grid: &Grid,
        plan: &FreePlan,
        k: f64,
    ) -> Option<Self> {
        let conic = heights.conic?;
        if error_at_levels(&conic, stack) > LEVEL_ERROR {
            return None;
        }
        let [x, y] = &plan.bands;
        Some(Self {
            conic,
            places: [place_weights(&grid.x, x, k)?, place_weights(&grid.y, y, k)?],
        })
    }

    /// Σ U·s·p of what a level holds, in directions [y, x], from its transform in these and [`NEIGHBOURS`] more to each side.
    pub(super) fn apply(
        &self,
        wide: &Array2<Complex64>,
        [band_x, band_y]: &[Band; 2],
        level: f64,
    ) -> Array2<Complex64> {
        let slope = slope_of_place(&self.conic, level);
        let [places_x, places_y] = &self.places;
        let mut tilt = Array2::zeros((band_y.count, band_x.count));
        ndarray::Zip::indexed(tilt.rows_mut()).par_for_each(|j, mut row| {
            // Neighbours along x and y, as rows of as many directions as the plan has.
            let all = |to: usize, from: usize| {
                let directions = Slice::from(from..from + band_x.count);
                wide.index_axis(Axis(0), to)
                    .slice_axis_move(Axis(0), directions)
            };
            multiply_by_place(places_x, |m| all(j + NEIGHBOURS, m), row.view_mut());
            for (i, value) in row.iter_mut().enumerate() {
                *value *= slope * band_x.at(i);
            }
            let mut along_y = Array1::zeros(band_x.count);
            multiply_by_place(places_y, |m| all(j + m, NEIGHBOURS), along_y.view_mut());
            row.scaled_add((slope * band_y.at(j)).into(), &along_y);
        });
        tilt
    }

    /// The conjugate transpose of [`SurfaceTilt::apply`]; adds to the cotangent of the transform.
    pub(super) fn apply_adjoint(
        &self,
        tilt_bar: &Array2<Complex64>,
        [band_x, band_y]: &[Band; 2],
        level: f64,
        wide_bar: &mut Array2<Complex64>,
    ) {
        let slope = slope_of_place(&self.conic, level);
        let [places_x, places_y] = &self.places;
        let inner = |row: usize| Some(row).filter(|j| *j < band_y.count);
        ndarray::Zip::indexed(wide_bar.rows_mut()).par_for_each(|to, mut row| {
            // tilt[j, i] = slope·(p_x·Σ wide[j + N, i + m]·place_x[m] + p_y·Σ wide[j + m, i + N]·place_y[m])
            if let Some(j) = to.checked_sub(NEIGHBOURS).and_then(inner) {
                for (i, bar) in tilt_bar.row(j).iter().enumerate() {
                    let bar = bar * (slope * band_x.at(i));
                    let beside = row.iter_mut().skip(i).zip(places_x);
                    beside.for_each(|(wave, weight)| *wave += bar * weight.conj());
                }
            }
            for (m, weight) in places_y.iter().enumerate() {
                let Some(j) = to.checked_sub(m).and_then(inner) else {
                    continue;
                };
                let weight = weight.conj() * (slope * band_y.at(j));
                let waves = row.iter_mut().skip(NEIGHBOURS);
                for (wave, bar) in waves.zip(tilt_bar.row(j)) {
                    *wave += bar * weight;
                }
            }
        });
    }
}

/// Adds the sum of neighbours with these weights, each neighbour a row of directions.
fn multiply_by_place<'a>(
    weights: &[Complex64; TAPS],
    neighbour: impl Fn(usize) -> ArrayView1<'a, Complex64>,
    mut to: ArrayViewMut1<Complex64>,
) {
    to.scaled_add(weights[NEIGHBOURS], &neighbour(NEIGHBOURS));
    for m in 1..=NEIGHBOURS {
        let Complex64 { re, im } = weights[NEIGHBOURS + m];
        let pair = ndarray::Zip::from(&mut to)
            .and(neighbour(NEIGHBOURS + m))
            .and(neighbour(NEIGHBOURS - m));

        // w·a + w*·b = Re w·(a + b) + i·Im w·(a − b); about the origin weights are imaginary.
        match re == 0.0 {
            true => pair.for_each(|to, a, b| {
                *to += Complex64::new(im * (b.im - a.im), im * (a.re - b.re));
            }),
            false => pair.for_each(|to, a, b| {
                let (sum, off) = ((a + b) * re, (a - b) * im);
                *to += Complex64::new(sum.re - off.im, sum.im + off.re);
            }),
        }
    }
}

/// The slope over the place where a conic has this height, c/(1 − (1 + κ)cz).
fn slope_of_place(conic: &Conic, height: f64) -> f64 {
    let c = conic.curvature;
    c / (1.0 - (1.0 + conic.conic) * c * height)
}

/// By how much the slopes over the place between the levels of a stack depart from their polynomial, in parts. With r the least of
/// 1 − (1 + κ)cz over the greatest, the error of n Chebyshev points falls as ((1 − √r)/(1 + √r))ⁿ.
fn error_at_levels(conic: &Conic, stack: &Stack) -> f64 {
    let slopes = (stack.levels.at.iter()).map(|level| slope_of_place(conic, *level).abs());
    let ends = slopes.fold([f64::INFINITY, 0.0], |[low, high], s| {
        [f64::min(low, s), f64::max(high, s)]
    });
    let root = (ends[0] / ends[1]).sqrt();
    2.0 * ((1.0 - root) / (1.0 + root)).powi(stack.len() as i32)
}

/// The weights of neighbouring directions that multiply a field along an axis by its place; nothing where it is too wide for the
/// spacing of the directions.
fn place_weights(axis: &GridAxis, band: &Band, k: f64) -> Option<[Complex64; TAPS]> {
    let last = axis.len().checked_sub(1)?;
    let [low, high] = [axis.node(0), axis.node(last)];
    let turn = k * band.spacing;
    if 0.5 * turn * (high - low) > LARGEST_PHASE {
        return None;
    }

    // About the middle of the axis, x − middle = θ/turn with θ = Σ 2bₘ·sin(mθ), and sines are differences of neighbours.
    let middle = 0.5 * (low + high);
    let mut weights = [Complex64::new(middle, 0.0); TAPS];
    for (m, sine) in (1..=NEIGHBOURS).zip(phase_by_sines()) {
        let aside =
            Complex64::new(0.0, 0.5 * sine / turn) * Complex64::cis(m as f64 * turn * middle);
        weights[NEIGHBOURS + m] = aside;
        weights[NEIGHBOURS - m] = aside.conj();
    }
    Some(weights)
}

/// Coefficients of sin(mθ), m from 1, whose sum is θ up to [`LARGEST_PHASE`]. θ/sin θ is smooth in t = cos θ, so it is a polynomial
/// through Chebyshev points there; its parts U₍ₘ₋₁₎(t) = sin(mθ)/sin θ follow from a Gauss sum, which is exact.
fn phase_by_sines() -> [f64; NEIGHBOURS] {
    let low = LARGEST_PHASE.cos();
    let points: [f64; NEIGHBOURS] = std::array::from_fn(|i| {
        let turn = PI * (i as f64 + 0.5) / NEIGHBOURS as f64;
        0.5 * (1.0 + low) + 0.5 * (1.0 - low) * turn.cos()
    });
    let through = |t: f64| -> f64 {
        let term = |i: usize| {
            let others = (0..NEIGHBOURS).filter(|j| *j != i);
            let share: f64 = others
                .map(|j| (t - points[j]) / (points[i] - points[j]))
                .product();
            share * points[i].acos() / (1.0 - points[i] * points[i]).sqrt()
        };
        (0..NEIGHBOURS).map(term).sum()
    };
    std::array::from_fn(|m| {
        let places = (1..=TAPS).map(|j| PI * j as f64 / (TAPS + 1) as f64);
        let sum: f64 = places
            .map(|turn| turn.sin() * through(turn.cos()) * ((m + 1) as f64 * turn).sin())
            .sum();
        2.0 * sum / (TAPS + 1) as f64
    })
}

#[cfg(test)]
mod tests {
    use crate::wave::free::surface_tilt::{LARGEST_PHASE, phase_by_sines};

    #[test]
    fn sines_add_up_to_the_phase() {
        let sines = phase_by_sines();
        for i in 0..=100 {
            let phase = LARGEST_PHASE * f64::from(i) / 100.0;
            let terms = (1..).zip(sines);
            let sum: f64 = terms
                .map(|(m, sine)| sine * (f64::from(m) * phase).sin())
                .sum();
            assert!((sum - phase).abs() < 1e-6, "{phase}: {:e}", sum - phase);
        }
    }
}
