//! Two-dimensional discrete Fourier transforms of centred squares, of which only a centred square
//! of the output is needed.

use std::sync::Arc;

use ndarray::{Array2, Axis};
use num_complex::Complex64;
use raylet_fft::{Fft, Planner};
use rayon::prelude::*;

/// The transform of length N along both axes, from and to index squares −h ..= h about zero.
pub struct CentredTransform {
    length: usize,
    /// exp(+2πi jm/N): from plane waves to samples.
    synthesis: Arc<dyn Fft<f64>>,
    /// exp(−2πi jm/N): from samples to plane waves.
    analysis: Arc<dyn Fft<f64>>,
}

impl CentredTransform {
    /// Plans the transforms of `length` N along each axis.
    pub fn new(length: usize) -> Self {
        let mut planner = Planner::new();
        Self {
            length,
            synthesis: planner.inverse(length),
            analysis: planner.forward(length),
        }
    }

    /// g_j = Σ_m c_m exp(+2πi j·m/N) for |j| ≤ `half` along each axis, from `modes` [m_y, m_x]
    /// with m = index − (side − 1)/2, sides odd. All sides must be at most N.
    pub fn synthesise(&self, modes: &Array2<Complex64>, half: usize) -> Array2<Complex64> {
        self.both_axes(self.synthesis.as_ref(), modes, half)
    }

    /// c_m = Σ_j g_j exp(−2πi j·m/N) for |m| ≤ `half`: the transpose conjugate of
    /// [`Self::synthesise`], without a factor.
    pub fn analyse(&self, samples: &Array2<Complex64>, half: usize) -> Array2<Complex64> {
        self.both_axes(self.analysis.as_ref(), samples, half)
    }

    /// Transforms the rows, then the columns, with the result turned back to [y, x].
    fn both_axes(
        &self,
        plan: &dyn Fft<f64>,
        from: &Array2<Complex64>,
        half: usize,
    ) -> Array2<Complex64> {
        let turned = self.rows(plan, from, half).reversed_axes();
        let turned = turned.as_standard_layout().into_owned();
        self.rows(plan, &turned, half)
            .reversed_axes()
            .as_standard_layout()
            .into_owned()
    }

    /// Transforms each row, keeping the outputs −half ..= half.
    fn rows(
        &self,
        plan: &dyn Fft<f64>,
        from: &Array2<Complex64>,
        half: usize,
    ) -> Array2<Complex64> {
        let length = self.length;
        let mut to = Array2::zeros((from.nrows(), 2 * half + 1));
        let zero = Complex64::new(0.0, 0.0);
        let scratch = || {
            (
                vec![zero; length],
                vec![zero; plan.get_inplace_scratch_len()],
            )
        };
        let lines: Vec<_> = to
            .axis_iter_mut(Axis(0))
            .zip(from.axis_iter(Axis(0)))
            .collect();
        lines
            .into_par_iter()
            .for_each_init(scratch, |(line, scratch), (mut to, from)| {
                // Indices below zero wrap to the end of the line.
                line.fill(zero);
                let centre = (from.len() - 1) / 2;
                for (index, value) in from.iter().enumerate() {
                    line[(index + length - centre) % length] = *value;
                }
                plan.process_with_scratch(line, scratch);
                for (index, value) in to.iter_mut().enumerate() {
                    *value = line[(index + length - half) % length];
                }
            });
        to
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array1, Array2};
    use num_complex::Complex64;

    use crate::numerics::dense::{fourier_kernel, separable};
    use crate::numerics::fourier::CentredTransform;

    #[test]
    fn equals_the_direct_sum_both_ways() {
        let (length, modes_half, half) = (30_usize, 7_i32, 5_i32);
        let modes = Array2::from_shape_fn((15, 15), |(i, j)| {
            Complex64::new((i * j) as f64 % 3.0, (i as f64 - 2.0 * j as f64).sin())
        });
        let m = Array1::from_iter((-modes_half..=modes_half).map(f64::from));
        let j = Array1::from_iter((-half..=half).map(f64::from));
        let transform = CentredTransform::new(length);

        let kernel = fourier_kernel(&j, &m, 1.0 / length as f64);
        let direct = separable(&kernel, &modes, &kernel);
        let fast = transform.synthesise(&modes, half as usize);
        assert!((&direct - &fast).iter().all(|d| d.norm() < 1e-11));

        let kernel = fourier_kernel(&m, &j, -1.0 / length as f64);
        let back = separable(&kernel, &direct, &kernel);
        let fast = transform.analyse(&direct, modes_half as usize);
        assert!((&back - &fast).iter().all(|d| d.norm() < 1e-10));
    }
}
