//! One-dimensional transforms along every row of an array, shared among the threads.

use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;

/// Rows taken together, so that reading or writing a transposed array uses whole cache lines.
const BLOCK: usize = 16;

/// Values in a cache line: a transposed block is read and written by so many columns at once.
const LINE: usize = 4;

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
    to: ArrayViewMut2<'_, Complex64>,
    buffers: &mut Buffers,
    transform: &F,
) where
    F: Fn(&[Complex64], &mut [Complex64], &mut Vec<Complex64>),
{
    let (inputs, outputs) = (from.ncols(), to.ncols());
    let Buffers {
        before,
        after,
        scratch,
    } = buffers;
    before.clear();
    before.resize(from.nrows() * inputs, Complex64::ZERO);
    read(from, before);
    after.clear();
    after.resize(to.nrows() * outputs, Complex64::ZERO);
    let rows = before.chunks_exact(inputs);
    for (before, after) in rows.zip(after.chunks_exact_mut(outputs)) {
        transform(before, after, scratch);
    }
    add(after, to);
}

/// Copies a block into rows; by columns where neighbours along the column are neighbours in memory.
fn read(from: ArrayView2<'_, Complex64>, rows: &mut [Complex64]) {
    let (count, width) = (from.ncols(), strip_width(from.strides()[1], from.ncols()));
    for (i, strip) in from.axis_chunks_iter(Axis(1), width).enumerate() {
        for (values, row) in strip.rows().into_iter().zip(rows.chunks_exact_mut(count)) {
            let row = row.iter_mut().skip(i * width);
            row.zip(values).for_each(|(r, &value)| *r = value);
        }
    }
}

/// Adds rows to a block, in the same way.
fn add(rows: &[Complex64], mut to: ArrayViewMut2<'_, Complex64>) {
    let (count, width) = (to.ncols(), strip_width(to.strides()[1], to.ncols()));
    for (i, mut strip) in to.axis_chunks_iter_mut(Axis(1), width).enumerate() {
        let values = strip.rows_mut().into_iter();
        for (values, row) in values.zip(rows.chunks_exact(count)) {
            let row = row.iter().skip(i * width);
            values.into_iter().zip(row).for_each(|(v, &r)| *v += r);
        }
    }
}

/// How many columns are copied at once: all that lie together in memory, or a cache line.
fn strip_width(stride: isize, columns: usize) -> usize {
    if stride == 1 { columns } else { LINE }
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
