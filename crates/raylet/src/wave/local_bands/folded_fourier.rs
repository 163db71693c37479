//! Fourier sums from the nodes under one window to its plane waves by fast transforms, where the period of the plane waves is
//! a whole number of cells.
//!
//! Nodes one period apart have the same factor in every plane wave, so they are added first. What is left is one period of
//! cells with the same few nodes each: one fast transform for each of these.

use std::ops::Range;
use std::sync::Arc;

use ndarray::Array2;
use num_complex::Complex64;
use raylet_fft::{Fft, Planner};

use crate::math::part::blocks;
use crate::wave::local_bands::fourier_axis::FourierAxis;
use crate::wave::local_bands::reused_array;

/// How far the cells of a period may be from a whole number, for each of them.
const TOLERANCE: f64 = 1e-11;

/// The largest prime factor of a length whose transform is fast.
const LARGEST_FACTOR: usize = 7;

/// The smallest whole number from `least` on whose prime factors are small.
pub(crate) fn fast_length(least: usize) -> usize {
    let is_smooth = |number: &usize| {
        let reduced = (2..=LARGEST_FACTOR).fold(*number, |mut number, factor| {
            while number.is_multiple_of(factor) {
                number /= factor;
            }
            number
        });
        reduced == 1
    };
    (least.max(1)..).find(is_smooth).unwrap_or(least)
}

/// Numbers along one axis of a window, added up into one period: node i of a cell stands in strand i, at the cell's place in
/// the period.
pub(crate) struct FoldedFourier {
    /// Cells of a period.
    length: usize,
    /// Nodes of a cell.
    strands: usize,
    /// For each node its place among `strands` × `length`.
    places: Vec<usize>,
    /// The factor of each node before it is added.
    before: Vec<Complex64>,
    /// The place of each plane wave in a transform.
    bins: Vec<usize>,
    /// For each strand the factors of plane waves behind the transform.
    after: Vec<Vec<Complex64>>,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

impl FoldedFourier {
    /// Plans the sums along one axis; nothing where the period is no whole number of cells, or a transform of that length is
    /// slow.
    pub(crate) fn new(along: &FourierAxis, planner: &mut Planner) -> Option<Self> {
        let (modes, k) = (along.modes, along.k);
        let cells = along.period() / along.axis.pitch;
        let length = cells.round() as usize;
        if length == 0
            || (cells - cells.round()).abs() > TOLERANCE * cells
            || fast_length(length) != length
        {
            return None;
        }
        let strands = along.axis.nodes_of_cell();
        let node = |i: usize| {
            let (cell, strand) = (i / strands, i % strands);
            let turned = Complex64::cis(-k * modes.shift * along.offset(i));
            (strand * length + cell % length, turned * along.weight(i))
        };
        let (places, before) = (along.range.0..along.range.1).map(node).unzip();
        let index = |m: usize| modes.first + m as i64;
        let after = |strand: usize| {
            // The strand's node of the first cell, beside the window's centre.
            let u = along.offset(strand);
            let turned = |m: usize| Complex64::cis(-k * modes.spacing * index(m) as f64 * u);
            let factors = along.cell_factors(strand).into_iter().enumerate();
            factors.map(|(m, factor)| turned(m) * factor).collect()
        };
        Some(Self {
            length,
            strands,
            places,
            before,
            bins: (0..modes.count)
                .map(|m| index(m).rem_euclid(length as i64) as usize)
                .collect(),
            after: (0..strands).map(after).collect(),
            forward: planner.forward(length),
            inverse: planner.inverse(length),
        })
    }

    /// Numbers of a folded line.
    pub(crate) fn folded(&self) -> usize {
        self.strands * self.length
    }

    /// Transforms each row of folded numbers into a column, which is added to those that are there: shape [rows, folded] to
    /// [plane waves, rows].
    fn rows(
        &self,
        mut folded: Array2<Complex64>,
        mut columns: Array2<Complex64>,
    ) -> Array2<Complex64> {
        let mut scratch = vec![Complex64::ZERO; self.forward.get_inplace_scratch_len()];
        for (mut row, mut out) in folded.rows_mut().into_iter().zip(columns.columns_mut()) {
            let Some(row) = row.as_slice_mut() else {
                continue;
            };
            self.forward.process_with_scratch(row, &mut scratch);
            for (strand, after) in row.chunks_exact(self.length).zip(&self.after) {
                for ((out, bin), after) in out.iter_mut().zip(&self.bins).zip(after) {
                    *out += strand[*bin] * after;
                }
            }
        }
        reused_array::keep(folded);
        columns
    }

    /// The conjugate transpose of [`FoldedFourier::rows`].
    fn rows_adjoint(&self, bar: &Array2<Complex64>) -> Array2<Complex64> {
        let mut scratch = vec![Complex64::ZERO; self.inverse.get_inplace_scratch_len()];
        let mut folded: Array2<Complex64> = Array2::zeros((bar.ncols(), self.folded()));
        for (mut row, bar) in folded.rows_mut().into_iter().zip(bar.columns()) {
            let Some(row) = row.as_slice_mut() else {
                continue;
            };
            for (strand, after) in row.chunks_exact_mut(self.length).zip(&self.after) {
                for ((bar, bin), after) in bar.iter().zip(&self.bins).zip(after) {
                    strand[*bin] += bar * after.conj();
                }
            }
            self.inverse.process_with_scratch(row, &mut scratch);
        }
        folded
    }
}

/// Fourier sums over both axes.
pub(crate) struct FoldedFourier2 {
    /// Along x.
    pub x: FoldedFourier,
    /// Along y.
    pub y: FoldedFourier,
}

impl FoldedFourier2 {
    /// Adds the light of rows of nodes, from the first one on, to that of the nodes one period apart.
    fn fold(&self, light: &Array2<Complex64>, first: usize, folded: &mut Array2<Complex64>) {
        let (x, y) = (&self.x, &self.y);
        let along_y = y.places.iter().zip(&y.before).skip(first);
        for (row, (place, before)) in light.rows().into_iter().zip(along_y) {
            let mut sum = folded.row_mut(*place);
            for ((value, place), along) in row.iter().zip(&x.places).zip(&x.before) {
                sum[*place] += value * along * before;
            }
        }
    }

    /// The plane waves [m_y, m_x] of `light`, which gives that at the nodes [y, x] of some rows.
    pub(crate) fn apply(
        &self,
        light: impl Fn(Range<usize>) -> Array2<Complex64>,
    ) -> Array2<Complex64> {
        let mut folded = reused_array::zeros((self.y.folded(), self.x.folded()));
        for rows in blocks(self.y.places.len()) {
            self.fold(&light(rows.clone()), rows.start, &mut folded);
        }
        let (x, y) = (&self.x, &self.y);
        let between = reused_array::zeros((x.bins.len(), y.folded()));
        let waves = Array2::zeros((y.bins.len(), x.bins.len()));
        y.rows(x.rows(folded, between), waves)
    }

    /// The conjugate transpose.
    pub(crate) fn apply_adjoint(&self, waves_bar: &Array2<Complex64>) -> Array2<Complex64> {
        let (x, y) = (&self.x, &self.y);
        let folded_bar = x.rows_adjoint(&y.rows_adjoint(waves_bar));
        let mut light_bar = Array2::zeros((y.places.len(), x.places.len()));
        let rows = light_bar.rows_mut().into_iter().zip(&y.places);
        for ((mut row, place), before) in rows.zip(&y.before) {
            let bar = folded_bar.row(*place);
            for ((value, place), along) in row.iter_mut().zip(&x.places).zip(&x.before) {
                *value = bar[*place] * (along * before).conj();
            }
        }
        light_bar
    }

    /// Operations of one application, about.
    pub(crate) fn operations(&self) -> f64 {
        let [x, y] = [&self.x, &self.y].map(|axis| axis.folded() as f64);
        let one = |folded: f64, length: usize| 5.0 * folded * (length as f64).log2().max(1.0);
        let nodes = self.x.places.len() as f64 * self.y.places.len() as f64;
        let waves = self.x.bins.len() as f64;
        8.0 * nodes + y * one(x, self.x.length) + waves * one(y, self.y.length)
    }
}

#[cfg(test)]
mod tests {
    use raylet_fft::Planner;

    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use crate::math::part::part;
    use crate::wave::grid::field::Axis;
    use crate::wave::local_bands::folded_fourier::{FoldedFourier, FoldedFourier2, fast_length};
    use crate::wave::local_bands::fourier_axis::{CellFilter, FourierAxis, Modes};
    use crate::wave::local_bands::fourier_matrix::fourier_matrix;

    const K: f64 = 6.0;

    #[test]
    fn fast_lengths_have_small_factors() {
        assert_eq!([1, 11, 97, 879].map(fast_length), [1, 12, 98, 882]);
    }

    /// Folded sums are those of the matrix, and their adjoint is the conjugate transpose.
    #[test]
    fn folded_sums_are_exact_and_apply_dot_product() {
        let pitch = 0.17;
        let (wide, narrow) = (
            Axis::gauss(90, pitch, 0.3, 2),
            Axis::uniform(50, pitch, -0.1),
        );
        let spacing = std::f64::consts::TAU / (K * 24.0 * pitch);
        let modes = [
            Modes::between(-0.9, 1.3, spacing, 0.05),
            Modes::between(-3.0, 2.8, spacing, -0.3),
        ];
        let along = |a: usize| FourierAxis {
            axis: [&wide, &narrow][a],
            range: [(7, 160), (3, 49)][a],
            filter: [CellFilter::Pairs, CellFilter::Points][a],
            centre: [0.4, -0.2][a],
            k: K,
            modes: &modes[a],
        };
        let plan = |a: usize| FoldedFourier::new(&along(a), &mut Planner::new()).unwrap();
        let folded = FoldedFourier2 {
            x: plan(0),
            y: plan(1),
        };
        let light = noise((46, 153), 0);
        let there = folded.apply(|rows| part(light.view(), rows, ..).to_owned());
        let [x, y] = [0, 1].map(|a| fourier_matrix(&along(a)));
        let exact = y.dot(&light).dot(&x.t());
        for (found, exact) in there.iter().zip(&exact) {
            assert!((found - exact).norm() < 1e-12);
        }
        let bar = noise(there.dim(), 1);
        let back = folded.apply_adjoint(&bar);
        assert_transposed(&[(&bar, &there)], &[(&back, &light)]);
    }

    #[test]
    fn periods_of_no_whole_number_of_cells_are_left_to_the_matrix() {
        let axis = Axis::uniform(50, 0.17, 0.0);
        let spacing = std::f64::consts::TAU / (K * 24.3 * 0.17);
        let modes = Modes::between(-1.0, 1.0, spacing, 0.0);
        let along = FourierAxis {
            axis: &axis,
            range: (0, 50),
            filter: CellFilter::Points,
            centre: 0.0,
            k: K,
            modes: &modes,
        };
        assert!(FoldedFourier::new(&along, &mut Planner::new()).is_none());
    }
}
