//! Large arrays of a tile, whose memory the next tile of the same thread uses again.
//!
//! The allocator gives arrays of tens of MB back to the system each time. To get them page by page again takes as long as the
//! sums over them.

use std::cell::RefCell;

use ndarray::Array2;
use num_complex::Complex64;

/// So many arrays a thread keeps: a tile has one under windows that an edge cuts and one under the others.
const KEPT: usize = 2;

/// Larger arrays, in numbers, are given back: they would take much memory beside what else a run needs.
const LARGEST_KEPT: usize = 3_200_000;

thread_local! {
    static SPARE: RefCell<Vec<Vec<Complex64>>> = const { RefCell::new(Vec::new()) };
}

/// An array of zeros.
pub(crate) fn zeros(shape: (usize, usize)) -> Array2<Complex64> {
    let count = shape.0 * shape.1;
    let Some(mut values) = kept(count) else {
        return Array2::zeros(shape);
    };
    values.reserve_exact(count);
    values.resize(count, Complex64::ZERO);
    Array2::from_shape_vec(shape, values).unwrap_or_else(|_| Array2::zeros(shape))
}

/// Memory that this thread has kept: the smallest that is large enough, or else the largest, which is to grow.
fn kept(count: usize) -> Option<Vec<Complex64>> {
    let best = |spare: &mut Vec<Vec<Complex64>>| {
        let fits = spare
            .iter()
            .enumerate()
            .filter(|(_, one)| one.capacity() >= count);
        let place = fits
            .min_by_key(|(_, one)| one.capacity())
            .map(|(place, _)| place);
        // The largest stands first.
        let place = place.or((!spare.is_empty()).then_some(0))?;
        Some(spare.remove(place))
    };
    let mut values = SPARE.with_borrow_mut(best)?;
    values.clear();
    Some(values)
}

/// Keeps the memory of an array for this thread, if it is one of the largest up to [`LARGEST_KEPT`].
pub(crate) fn keep(array: Array2<Complex64>) {
    let (values, _) = array.into_raw_vec_and_offset();
    if values.capacity() > LARGEST_KEPT {
        return;
    }
    SPARE.with_borrow_mut(|spare| {
        spare.push(values);
        spare.sort_by_key(|one| std::cmp::Reverse(one.capacity()));
        spare.truncate(KEPT);
    });
}

/// Gives back what all threads have kept.
pub(crate) fn release() {
    drop(SPARE.take());
    rayon::broadcast(|_| drop(SPARE.take()));
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::wave::local_bands::reused_array::{SPARE, keep, release, zeros};

    #[test]
    fn memory_is_used_again_and_given_back() {
        let mut first = zeros((30, 40));
        first.fill(Complex64::ONE);
        let place = first.as_ptr();
        keep(first);
        let second = zeros((20, 50));
        assert_eq!(second.as_ptr(), place);
        assert!(second.iter().all(|value| *value == Complex64::ZERO));

        // The smallest that is large enough, and of three arrays the two largest.
        let (small, smaller) = (zeros((20, 10)), zeros((2, 3)));
        let beside = small.as_ptr();
        [second, small, smaller].into_iter().for_each(keep);
        let found = zeros((5, 5));
        assert_eq!(found.as_ptr(), beside);
        assert_eq!(zeros((20, 20)).as_ptr(), place);
        keep(found);

        // One that is too small grows, and is not kept beside the larger one.
        let grown = zeros((50, 50));
        assert!(grown.iter().all(|value| *value == Complex64::ZERO));
        keep(grown);
        assert_eq!(SPARE.with_borrow(Vec::len), 1);
        release();
        assert!(SPARE.with_borrow(Vec::is_empty));
    }
}
