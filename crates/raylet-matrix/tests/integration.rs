//! Products against the sums that define them.

use ndarray::{Array2, ArrayView2, Axis};
use num_complex::Complex64;
use raylet_matrix::{Entry, product, product_of_three};

/// Numbers without a pattern.
fn real(shape: (usize, usize), seed: f64) -> Array2<f64> {
    Array2::from_shape_fn(shape, |(j, i)| {
        (seed + 1.7 * j as f64 + 0.9 * i as f64).sin()
    })
}

fn complex(shape: (usize, usize), seed: f64) -> Array2<Complex64> {
    let (re, im) = (real(shape, seed), real(shape, seed + 0.5));
    Array2::from_shape_fn(shape, |at| Complex64::new(re[at], im[at]))
}

/// Sums by their definition.
fn summed<T: Entry + std::iter::Sum + std::ops::Mul<Output = T>>(
    left: ArrayView2<T>,
    right: ArrayView2<T>,
) -> Array2<T> {
    Array2::from_shape_fn((left.nrows(), right.ncols()), |(j, i)| {
        (0..left.ncols())
            .map(|n| left[[j, n]] * right[[n, i]])
            .sum()
    })
}

/// Sizes about those of vectors, and views of rows, columns, every second column, turned about and reversed.
#[test]
fn products_are_the_sums_that_define_them() {
    for (rows, inner, columns) in [(1, 1, 1), (3, 5, 7), (8, 16, 24), (31, 17, 40), (2, 90, 3)] {
        let (left, right) = (complex((rows, inner), 0.1), complex((inner, columns), 0.2));
        let close = |found: Array2<Complex64>, exact: Array2<Complex64>| {
            assert_eq!(found.dim(), exact.dim());
            for (found, exact) in found.iter().zip(&exact) {
                assert!(
                    (found - exact).norm() < 1e-13 * inner as f64,
                    "{found} {exact}"
                );
            }
        };
        close(
            product(left.view(), right.view()),
            summed(left.view(), right.view()),
        );
        let (across, down) = (
            complex((inner, rows), 0.3),
            complex((2 * columns, inner), 0.4),
        );
        let mut every_second = down.view();
        every_second.slice_axis_inplace(Axis(0), ndarray::Slice::new(0, None, 2));
        close(
            product(across.t(), every_second.t()),
            summed(across.t(), every_second.t()),
        );
        let mut reversed = left.view();
        reversed.invert_axis(Axis(1));
        close(
            product(reversed, right.view()),
            summed(reversed, right.view()),
        );
        let (left, right) = (real((rows, inner), 0.1), real((inner, columns), 0.2));
        let (found, exact) = (
            product(left.view(), right.view()),
            summed(left.view(), right.view()),
        );
        for (found, exact) in found.iter().zip(&exact) {
            assert!(
                (found - exact).abs() < 1e-13 * inner as f64,
                "{found} {exact}"
            );
        }
    }
}

#[test]
fn either_order_of_three_gives_the_same() {
    for (rows, height, width, columns) in [(3, 40, 50, 4), (40, 3, 4, 50), (5, 60, 2, 7)] {
        let (left, middle) = (complex((rows, height), 0.1), complex((height, width), 0.2));
        let right = complex((columns, width), 0.3);
        let found = product_of_three(left.view(), middle.view(), right.view());
        let exact = summed(left.view(), summed(middle.view(), right.t()).view());
        for (found, exact) in found.iter().zip(&exact) {
            assert!((found - exact).norm() < 1e-11);
        }
    }
}

#[test]
fn products_of_nothing_are_zero() {
    let (left, right) = (complex((3, 0), 0.1), complex((0, 2), 0.1));
    assert_eq!(
        product(left.view(), right.view()),
        Array2::from_elem((3, 2), Complex64::ZERO)
    );
    assert_eq!(
        product(complex((0, 4), 0.1).view(), complex((4, 2), 0.1).view()).dim(),
        (0, 2)
    );
}

#[test]
#[should_panic(expected = "columns of the left and rows of the right matrix")]
fn sizes_that_do_not_fit_are_refused() {
    product(real((2, 3), 0.0).view(), real((2, 3), 0.0).view());
}
