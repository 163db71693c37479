//! Rows of a raster in blocks of eight, one row in each lane.

use num_complex::Complex64;

use crate::math::lanes::LANES;
use crate::wave::grid::raster::Raster;

/// Rows of a raster being summed. Eight rows are a block; a block has for each column the real parts of its eight
/// values, then their imaginary parts.
pub(crate) struct Rows {
    values: Vec<f64>,
    /// The places of their values, in mm.
    pub raster: Raster,
}

/// Numbers of one column of a block.
pub(crate) const COLUMN: usize = 2 * LANES;

impl Rows {
    /// Dark rows of a raster.
    pub(crate) fn zeros(raster: Raster) -> Self {
        let [nx, ny] = raster.size;
        Self {
            values: vec![0.0; ny.div_ceil(LANES) * nx * COLUMN],
            raster,
        }
    }

    /// The value at a row and a column.
    pub(crate) fn value(&self, [j, i]: [usize; 2]) -> Complex64 {
        let at = self.place([j, i]);
        Complex64::new(self.values[at], self.values[at + LANES])
    }

    /// Sets the value at a row and a column.
    pub(crate) fn set(&mut self, [j, i]: [usize; 2], value: Complex64) {
        let at = self.place([j, i]);
        (self.values[at], self.values[at + LANES]) = (value.re, value.im);
    }

    fn place(&self, [j, i]: [usize; 2]) -> usize {
        (j / LANES * self.raster.size[0] + i) * COLUMN + j % LANES
    }

    /// The numbers of some columns of a block.
    #[inline(always)]
    pub(crate) fn columns(&self, block: usize, [first, last]: [usize; 2]) -> &[f64] {
        let start = block * self.raster.size[0];
        &self.values[(start + first) * COLUMN..(start + last) * COLUMN]
    }

    /// Mutable access to the numbers of some columns of a block.
    #[inline(always)]
    pub(crate) fn columns_mut(&mut self, block: usize, [first, last]: [usize; 2]) -> &mut [f64] {
        let start = block * self.raster.size[0];
        &mut self.values[(start + first) * COLUMN..(start + last) * COLUMN]
    }
}
