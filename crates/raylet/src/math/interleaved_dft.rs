//! Exact Fourier sums from interleaved combs: grids whose cells hold the same few nodes each.

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;

use crate::math::chirp::{Chirp, Comb};
use crate::math::lines::transform_rows;
use crate::math::part::{comb, part};

/// The plan of out\[n, m\] = Σⱼᵢ in\[j, i\]·exp(i·scale·(xᵢ·x′ₘ + yⱼ·y′ₙ)), where the points xᵢ of one axis
/// are several combs dealt out in turn: point i belongs to comb i mod (number of combs).
#[derive(Clone, Debug)]
pub(crate) struct InterleavedDft2 {
    x: Vec<Chirp>,
    y: Vec<Chirp>,
    to: [usize; 2],
}

impl InterleavedDft2 {
    /// Plans sums from the combs of each axis, all of one length, to the grid `to_y` × `to_x`.
    pub(crate) fn new(
        from_y: &[Comb],
        from_x: &[Comb],
        to_y: Comb,
        to_x: Comb,
        scale: f64,
    ) -> Self {
        let plan = |combs: &[Comb], to: Comb| {
            let one = |comb: &Comb| Chirp::new(*comb, to, scale);
            combs.iter().map(one).collect()
        };
        Self {
            x: plan(from_x, to_x),
            y: plan(from_y, to_y),
            to: [to_y.count, to_x.count],
        }
    }

    /// The sums over `input`, shape \[points of y, points of x\]. The same bits for any number of threads.
    ///
    /// # Panics
    /// If `input` has another shape.
    pub(crate) fn apply(&self, input: ArrayView2<'_, Complex64>) -> Array2<Complex64> {
        // Along x every row is summed by its combs, along y every column of what that gives.
        let mut middle: Array2<Complex64> = Array2::zeros([input.nrows(), self.to[1]]);
        for (g, chirp) in self.x.iter().enumerate() {
            let strand = part(input, .., comb(g, self.x.len()));
            transform_rows(strand, middle.view_mut(), |a, b, s| chirp.apply(a, b, s));
        }
        let mut out = Array2::zeros(self.to);
        for (g, chirp) in self.y.iter().enumerate() {
            let strand = part(middle.view(), comb(g, self.y.len()), ..).reversed_axes();
            let columns = out.view_mut().reversed_axes();
            transform_rows(strand, columns, |a, b, s| chirp.apply(a, b, s));
        }
        out
    }

    /// The conjugate transpose: from the grid back to the `points` \[y, x\] of the interleaved combs.
    ///
    /// # Panics
    /// If `out_bar` has another shape than the grid.
    pub(crate) fn apply_adjoint(
        &self,
        out_bar: ArrayView2<'_, Complex64>,
        points: [usize; 2],
    ) -> Array2<Complex64> {
        // out += y-sums of middle
        let mut middle_bar: Array2<Complex64> = Array2::zeros([points[0], self.to[1]]);
        for (g, chirp) in self.y.iter().enumerate() {
            let strand = part(middle_bar.view_mut(), comb(g, self.y.len()), ..);
            transform_rows(
                out_bar.reversed_axes(),
                strand.reversed_axes(),
                |a, b, s| {
                    chirp.apply_adjoint(a, b, s);
                },
            );
        }
        // middle += x-sums of input
        let mut input_bar = Array2::zeros(points);
        for (g, chirp) in self.x.iter().enumerate() {
            let strand = part(input_bar.view_mut(), .., comb(g, self.x.len()));
            transform_rows(middle_bar.view(), strand, |a, b, s| {
                chirp.apply_adjoint(a, b, s);
            });
        }
        input_bar
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::fixtures::noise::complex_noise;
    use crate::math::chirp::Comb;
    use crate::math::interleaved_dft::InterleavedDft2;

    fn comb(start: f64, step: f64, count: usize) -> Comb {
        Comb { start, step, count }
    }

    fn dft() -> (InterleavedDft2, [Vec<Comb>; 2], [Comb; 2]) {
        let y = vec![comb(-1.0, 0.5, 4), comb(-0.75, 0.5, 4)];
        let x = vec![comb(-2.0, 1.0, 5), comb(-1.7, 1.0, 5), comb(-1.4, 1.0, 5)];
        let to = [comb(-0.3, 0.1, 7), comb(-0.5, 0.07, 6)];
        (InterleavedDft2::new(&y, &x, to[0], to[1], 9.0), [y, x], to)
    }

    #[test]
    fn sums_are_those_written() {
        let (dft, [y, x], to) = dft();
        let input = complex_noise([8, 15], 7, [0, 1]);
        let found = dft.apply(input.view());
        for ((n, m), value) in found.indexed_iter() {
            let mut sum = Complex64::ZERO;
            for ((j, i), u) in input.indexed_iter() {
                let (a, b) = (y[j % 2].at(j / 2), x[i % 3].at(i / 3));
                sum += u * Complex64::cis(9.0 * (a * to[0].at(n) + b * to[1].at(m)));
            }
            assert!((value - sum).norm() < 1e-12);
        }
    }

    #[test]
    fn apply_dot_product() {
        let (dft, ..) = dft();
        let (a, b) = (
            complex_noise([8, 15], 7, [0, 2]),
            complex_noise([7, 6], 7, [0, 3]),
        );
        let inner = |a: &Array2<Complex64>, b: &Array2<Complex64>| -> Complex64 {
            a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
        };
        let there = inner(&b, &dft.apply(a.view()));
        let back = inner(&dft.apply_adjoint(b.view(), [8, 15]), &a);
        assert!((there - back).norm() < 1e-13 * there.norm());
    }
}
