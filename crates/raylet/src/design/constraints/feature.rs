//! The smallest feature that a tool can make: blocks of pixels, or a blur before the levels.

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayView2, Axis};

/// Square blocks of pixels that have one value.
///
/// Every feature of what comes out is at least a block wide. Blocks start at the first row and column;
/// the last ones may be cut off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blocks {
    size: usize,
    shape: (usize, usize),
}

/// A conic blur: the mean of all pixels within a radius R with weights R − distance.
///
/// Before a projection onto two levels it is the density filter of topology optimisation (Bruns and
/// Tortorelli, Comput. Methods Appl. Mech. Eng. 190, 3443, 2001). It makes features below the radius rare
/// and does not forbid them; [`Blocks`] do.
#[derive(Clone, Debug, PartialEq)]
pub struct Blur {
    /// Offset in rows and columns, and weight.
    kernel: Vec<([isize; 2], f64)>,
    /// One over the weights inside the element, for each pixel.
    share: Array2<f64>,
}

/// Why features cannot be so.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FeatureError {
    /// Blocks of no pixels.
    #[error("blocks of 0 pixels; expected at least 1")]
    Blocks,
    /// A radius that is none.
    #[error("a radius of {0} pixels; expected a number of at least 1")]
    Radius(f64),
}

impl Blocks {
    /// Blocks of `size` × `size` pixels on an element of that many rows and columns.
    ///
    /// # Errors
    /// When the size is zero.
    pub fn new(size: usize, shape: (usize, usize)) -> Result<Self, FeatureError> {
        if size == 0 {
            return Err(FeatureError::Blocks);
        }
        Ok(Self { size, shape })
    }

    /// Rows and columns of blocks.
    pub fn coarse(&self) -> (usize, usize) {
        let (ny, nx) = self.shape;
        (ny.div_ceil(self.size), nx.div_ceil(self.size))
    }

    /// Each block's value in all of its pixels.
    pub fn spread(&self, blocks: ArrayView2<'_, f64>) -> Array2<f64> {
        Array2::from_shape_fn(self.shape, |(j, i)| blocks[[j / self.size, i / self.size]])
    }

    /// The sum over each block's pixels.
    pub fn spread_adjoint(&self, pixels_bar: ArrayView2<'_, f64>) -> Array2<f64> {
        // pixels = blocks[j / size, i / size]
        let mut blocks_bar = Array2::zeros(self.coarse());
        for ((j, i), bar) in pixels_bar.indexed_iter() {
            blocks_bar[[j / self.size, i / self.size]] += bar;
        }
        blocks_bar
    }
}

impl Blur {
    /// A blur of this radius in pixels, on an element of `shape` rows and columns.
    ///
    /// # Errors
    /// When the radius is no number of at least 1.
    pub fn new(radius: f64, shape: (usize, usize)) -> Result<Self, FeatureError> {
        if !(radius >= 1.0 && radius.is_finite()) {
            return Err(FeatureError::Radius(radius));
        }
        let reach = radius.ceil() as isize;
        let offsets = (-reach..=reach).flat_map(|j| (-reach..=reach).map(move |i| [j, i]));
        let weight = |[j, i]: [isize; 2]| radius - (j as f64).hypot(i as f64);
        let kernel = offsets.map(|offset| (offset, weight(offset)));
        let mut blur = Self {
            kernel: kernel.filter(|(_, weight)| *weight > 0.0).collect(),
            share: Array2::ones(shape),
        };
        blur.share = blur.gather(blur.share.view()).mapv(|weight| 1.0 / weight);
        Ok(blur)
    }

    /// Each pixel's weighted mean over its neighbours.
    pub fn soften(&self, pixels: ArrayView2<'_, f64>) -> Array2<f64> {
        self.gather(pixels) * &self.share
    }

    /// The transpose of [`Blur::soften`]. The kernel is even, so only the order of kernel and shares changes.
    pub fn soften_adjoint(&self, soft_bar: ArrayView2<'_, f64>) -> Array2<f64> {
        // soft = share · (kernel ∗ pixels)
        self.gather((&self.share * &soft_bar).view())
    }

    /// The convolution with the kernel, nothing beyond the rim.
    fn gather(&self, pixels: ArrayView2<'_, f64>) -> Array2<f64> {
        let (ny, nx) = pixels.dim();
        let mut sums = Array2::zeros((ny, nx));
        let rows = sums.axis_iter_mut(Axis(0)).into_par_iter().enumerate();
        rows.for_each(|(j, mut row)| {
            for ([dj, di], weight) in &self.kernel {
                // The stretch of columns that the shifted row covers.
                let from = j as isize + dj;
                let (start, end) = ((-di).max(0), (nx as isize - di).min(nx as isize));
                if from < 0 || from >= ny as isize || start >= end {
                    continue;
                }
                let shifted = pixels.index_axis(Axis(0), from as usize);
                let shifted = shifted.slice_axis(Axis(0), (start + di..end + di).into());
                let mut row = row.slice_axis_mut(Axis(0), (start..end).into());
                row.scaled_add(*weight, &shifted);
            }
        });
        sums
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use crate::design::constraints::feature::{Blocks, Blur, FeatureError};
    use crate::fixtures::noise::real_noise;

    /// Values from −½ to ½.
    fn values(shape: (usize, usize), purpose: u32) -> Array2<f64> {
        real_noise(shape, 6, [0, purpose]) - 0.5
    }

    #[test]
    fn spread_dot_product_and_blocks() {
        let blocks = Blocks::new(3, (8, 10)).unwrap();
        assert_eq!(blocks.coarse(), (3, 4));
        let (coarse, bar) = (values((3, 4), 0), values((8, 10), 1));
        let fine = blocks.spread(coarse.view());
        let back = blocks.spread_adjoint(bar.view());
        assert!(((&fine * &bar).sum() - (&coarse * &back).sum()).abs() < 1e-14);
        assert!((0..8).all(|j| (0..10).all(|i| fine[[j, i]] == coarse[[j / 3, i / 3]])));
        assert_eq!(Blocks::new(0, (8, 10)), Err(FeatureError::Blocks));
    }

    #[test]
    fn soften_dot_product_and_means() {
        for (radius, shape) in [(1.0, (4, 5)), (2.5, (9, 11)), (6.0, (3, 4))] {
            let blur = Blur::new(radius, shape).unwrap();
            let (pixels, bar) = (values(shape, 0), values(shape, 1));
            let soft = blur.soften(pixels.view());
            let back = blur.soften_adjoint(bar.view());
            assert!(((&soft * &bar).sum() - (&pixels * &back).sum()).abs() < 1e-14);

            // By its definition, and what is even stays even.
            let mean = |j: usize, i: usize| {
                let (mut sum, mut weights) = (0.0, 0.0);
                for ((y, x), value) in pixels.indexed_iter() {
                    let distance = (y as f64 - j as f64).hypot(x as f64 - i as f64);
                    let weight = (radius - distance).max(0.0);
                    sum += weight * value;
                    weights += weight;
                }
                sum / weights
            };
            for ((j, i), value) in soft.indexed_iter() {
                assert!((value - mean(j, i)).abs() < 1e-15);
            }
            let even = blur.soften(Array2::from_elem(shape, 0.3).view());
            assert!(even.iter().all(|value| (value - 0.3).abs() < 1e-15));
        }
        assert!(Blur::new(0.5, (2, 2)).is_err() && Blur::new(f64::NAN, (2, 2)).is_err());
    }
}
