//! One-dimensional transforms along every row of an array, shared among the threads.

use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;

/// Rows taken together, so that reading or writing a transposed array uses whole cache lines.
const BLOCK: usize = 16;

/// Buffers of one thread: a block of rows before and after, and what the transform itself needs.
#[derive(Default)]
struct Buffers {
    before: Vec<Complex64>,
    after: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

/// Adds to row j of `to` the `transform` of row j of `from`, for every j.
///
/// `transform(before, after, scratch)` receives one row as a slice, a row of zeros to add to, and a
/// vector it may resize at will. To work along columns, pass both arrays transposed: rows travel in
/// blocks through contiguous buffers, so any memory order is served. Each row is computed on its own,
/// so the result does not depend on the number of threads.
///
/// # Panics
/// If the arrays differ in their number of rows.
pub(crate) fn transform_rows<F>(
    from: ArrayView2<'_, Complex64>,
    mut to: ArrayViewMut2<'_, Complex64>,
    transform: F,
) where
    F: Fn(&[Complex64], &mut [Complex64], &mut Vec<Complex64>) + Sync,
{
    assert_eq!(from.nrows(), to.nrows(), "as many rows out as in");
    if from.ncols() == 0 || to.ncols() == 0 {
        return;
    }
    let blocks: Vec<_> = from
        .axis_chunks_iter(Axis(0), BLOCK)
        .zip(to.axis_chunks_iter_mut(Axis(0), BLOCK))
        .collect();
    blocks
        .into_par_iter()
        .for_each_init(Buffers::default, |buffers, (from, to)| {
            transform_block(from, to, buffers, &transform);
        });
}

/// The same for the few rows of one block, on the calling thread.
fn transform_block<F>(
    from: ArrayView2<'_, Complex64>,
    mut to: ArrayViewMut2<'_, Complex64>,
    buffers: &mut Buffers,
    transform: &F,
) where
    F: Fn(&[Complex64], &mut [Complex64], &mut Vec<Complex64>),
{
    let (inputs, outputs) = (from.ncols(), to.ncols());
    // Read column by column when neighbours along the column are neighbours in memory.
    buffers.before.clear();
    buffers
        .before
        .resize(from.nrows() * inputs, Complex64::ZERO);
    if from.strides()[1] == 1 {
        for (row, before) in from
            .rows()
            .into_iter()
            .zip(buffers.before.chunks_exact_mut(inputs))
        {
            before
                .iter_mut()
                .zip(row)
                .for_each(|(b, &value)| *b = value);
        }
    } else {
        for (i, column) in from.columns().into_iter().enumerate() {
            for (j, &value) in column.iter().enumerate() {
                buffers.before[j * inputs + i] = value;
            }
        }
    }

    // Transform each row.
    buffers.after.clear();
    buffers.after.resize(to.nrows() * outputs, Complex64::ZERO);
    let rows = buffers.before.chunks_exact(inputs);
    for (before, after) in rows.zip(buffers.after.chunks_exact_mut(outputs)) {
        transform(before, after, &mut buffers.scratch);
    }

    // Add the block to its place, again along whichever direction is contiguous.
    if to.strides()[1] == 1 {
        for (row, after) in to
            .rows_mut()
            .into_iter()
            .zip(buffers.after.chunks_exact(outputs))
        {
            row.into_iter()
                .zip(after)
                .for_each(|(r, &value)| *r += value);
        }
    } else {
        for (i, column) in to.columns_mut().into_iter().enumerate() {
            for (j, value) in column.into_iter().enumerate() {
                *value += buffers.after[j * outputs + i];
            }
        }
    }
}

/// The smallest product of powers of 2, 3 and 5 that is not below `least`: a length that Fourier
/// transforms quickly.
pub(crate) fn quick_length(least: usize) -> usize {
    let mut length = least.max(1);
    while [2, 3, 5].into_iter().fold(length, without) != 1 {
        length += 1;
    }
    length
}

/// `number` divided by `factor` as often as it goes.
fn without(mut number: usize, factor: usize) -> usize {
    while number.is_multiple_of(factor) {
        number /= factor;
    }
    number
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::math::lines::{quick_length, transform_rows};

    #[test]
    fn rows_and_columns_in_any_memory_order() {
        let from = Array2::from_shape_fn((37, 21), |(j, i)| Complex64::new(j as f64, i as f64));
        let twice = |before: &[Complex64], after: &mut [Complex64], _: &mut Vec<Complex64>| {
            after
                .iter_mut()
                .zip(before)
                .for_each(|(a, b)| *a += b * 2.0);
        };
        // Along rows, and along columns on top of it: each element four times.
        let mut to = Array2::zeros((37, 21));
        transform_rows(from.view(), to.view_mut(), twice);
        transform_rows(from.t(), to.view_mut().reversed_axes(), twice);
        assert_eq!(to, from.mapv(|value| value * 4.0));
    }

    #[test]
    fn quick_lengths() {
        assert_eq!(
            [0, 1, 7, 11, 1559, 4097].map(quick_length),
            [1, 1, 8, 12, 1600, 4320]
        );
    }
}
