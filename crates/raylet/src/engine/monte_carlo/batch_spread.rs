//! The spread of equal, independent batches of a random sum.

use ndarray::Array2;
use num_complex::Complex64;

/// Sums over equal, independent batches.
#[derive(Default)]
pub(crate) struct BatchSpread {
    count: usize,
    /// Σ|f|² of the batches f, and |F|² of their sum, at each sample.
    sums: Option<[Array2<f64>; 2]>,
}

impl BatchSpread {
    /// Takes note of one batch, given what was summed before and after it.
    pub(crate) fn add(&mut self, before: &Array2<Complex64>, after: &Array2<Complex64>) {
        self.count += 1;
        let zeros = || [0; 2].map(|_| Array2::zeros(after.raw_dim()));
        let [squares, total] = self.sums.get_or_insert_with(zeros);
        ndarray::Zip::from(squares)
            .and(total)
            .and(before)
            .and(after)
            .for_each(|square, total, b, a| {
                *square += (a - b).norm_sqr();
                *total = a.norm_sqr();
            });
    }

    /// Variance of the field at each sample, and Σ|U|², of the sum over `batches` of them: Σ|f − F/B|² over
    /// B batches f of sum F has the mean (B − 1)·var(f).
    pub(crate) fn finish(self, batches: f64) -> Option<(Array2<f64>, f64)> {
        let count = self.count as f64;
        let [squares, total] = self.sums.filter(|_| count > 1.0)?;
        let size = batches / count;
        let square = total.sum() * size * size;
        let each = (squares - total / count) / (count - 1.0);
        Some((each * batches, square))
    }
}
