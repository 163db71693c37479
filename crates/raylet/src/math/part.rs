//! Parts of arrays by rows and columns. They do what `ndarray::s!` does, whose expansion is not allowed where unsafe
//! code is forbidden.

use std::ops::Range;

use ndarray::{ArrayBase, Axis, Ix2, RawData, Slice};

/// The part of an array on these rows and columns.
///
/// # Panics
/// If the array has fewer of them.
pub fn part<S: RawData>(
    mut whole: ArrayBase<S, Ix2>,
    rows: impl Into<Slice>,
    columns: impl Into<Slice>,
) -> ArrayBase<S, Ix2> {
    whole.slice_axis_inplace(Axis(0), rows.into());
    whole.slice_axis_inplace(Axis(1), columns.into());
    whole
}

/// Rows that are worked on together: their values stay in the cache of a core.
const BLOCK: usize = 32;

/// So many rows in blocks, from the first on.
pub(crate) fn blocks(rows: usize) -> impl Iterator<Item = Range<usize>> {
    (0..rows)
        .step_by(BLOCK)
        .map(move |first| first..(first + BLOCK).min(rows))
}

/// Every `step`-th row or column from `first` on.
pub(crate) fn comb(first: usize, step: usize) -> Slice {
    Slice::new(first as isize, None, step as isize)
}

#[cfg(test)]
mod tests {
    use ndarray::arr2;

    use crate::math::part::{comb, part};

    #[test]
    fn parts_are_those_of_ndarray() {
        let mut all = arr2(&[[1, 2, 3, 4], [5, 6, 7, 8], [9, 10, 11, 12]]);
        assert_eq!(part(all.view(), 1..3, 0..2), arr2(&[[5, 6], [9, 10]]));
        assert_eq!(
            part(all.view(), .., comb(1, 2)),
            arr2(&[[2, 4], [6, 8], [10, 12]])
        );
        part(all.view_mut(), comb(0, 2), 3..4).fill(0);
        assert_eq!(all.column(3).to_vec(), [0, 8, 0]);
    }
}
