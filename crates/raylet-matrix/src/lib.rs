//! Products of dense matrices of real or complex numbers in double precision.
//!
//! The kernels are those of the library `gemm`, which uses the widest vectors of the processor that it finds. They take
//! pointers and strides, so this crate is the only place of raylet with unsafe code: [`product`] alone calls them, with what a
//! view of an array guarantees. Products are computed on the calling thread, so they have the same bits for any number of
//! threads.

#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

use gemm::Parallelism;
use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;

mod sealed {
    /// Numbers whose kernels `gemm` has.
    pub trait Sealed: Copy + 'static {
        /// Zero.
        const ZERO: Self;
        /// One.
        const ONE: Self;
    }
}

/// The entries of a matrix: real or complex numbers in double precision.
pub trait Entry: sealed::Sealed {}

impl sealed::Sealed for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
}

impl sealed::Sealed for Complex64 {
    const ZERO: Self = Complex64::ZERO;
    const ONE: Self = Complex64::ONE;
}

impl Entry for f64 {}
impl Entry for Complex64 {}

/// The matrix left · right, its rows one after another in memory.
///
/// # Panics
/// If `left` has not as many columns as `right` has rows.
pub fn product<T: Entry>(left: ArrayView2<T>, right: ArrayView2<T>) -> Array2<T> {
    let ((rows, inner), (height, columns)) = (left.dim(), right.dim());
    assert_eq!(
        inner, height,
        "columns of the left and rows of the right matrix"
    );
    let mut out = Array2::from_elem((rows, columns), T::ZERO);
    if rows == 0 || columns == 0 || inner == 0 {
        return out;
    }
    let [left_down, left_along] = strides(&left);
    let [right_down, right_along] = strides(&right);
    #[expect(unsafe_code, reason = "the kernels take pointers")]
    // SAFETY: each pointer, its strides and its size are those of an array or a view that lives until the call ends; what is
    // written to is new, so it overlaps nothing that is read; its rows follow one another.
    unsafe {
        gemm::gemm(
            rows,
            columns,
            inner,
            out.as_mut_ptr(),
            1,
            columns as isize,
            false,
            left.as_ptr(),
            left_along,
            left_down,
            right.as_ptr(),
            right_along,
            right_down,
            T::ZERO,
            T::ONE,
            false,
            false,
            false,
            Parallelism::None,
        );
    }
    out
}

/// The matrix left · middle · rightᵀ, by the order of products that takes fewer operations.
///
/// # Panics
/// If the sizes do not fit.
pub fn product_of_three<T: Entry>(
    left: ArrayView2<T>,
    middle: ArrayView2<T>,
    right: ArrayView2<T>,
) -> Array2<T> {
    let ((rows, height), (columns, width)) = (left.dim(), right.dim());
    let left_first = rows * width * (height + columns);
    let right_first = height * columns * (width + rows);
    if left_first < right_first {
        product(product(left, middle).view(), right.t())
    } else {
        product(left, product(middle, right.t()).view())
    }
}

/// Distances in memory from row to row and from column to column.
fn strides<T>(view: &ArrayView2<T>) -> [isize; 2] {
    let strides = view.strides();
    [0, 1].map(|axis| strides.get(axis).copied().unwrap_or(0))
}
