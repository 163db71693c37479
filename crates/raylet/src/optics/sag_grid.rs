//! A surface given by heights on a grid, with a smooth spline between them.

use ndarray::{Array2, Axis};

use crate::math::real::Real;
use crate::math::spline::{FEWEST, coefficients, weights};

/// Share of a pitch by which a point may lie outside the grid and count as on its edge.
const EDGE: f64 = 1e-9;

/// Heights on a centred grid, indexed [y, x] with rows growing with y, and the bicubic spline through
/// them. The surface ends at the outer points of the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct SagGrid {
    pitch: [f64; 2],
    /// Two more than heights along each axis.
    coefficients: Array2<f64>,
}

impl SagGrid {
    /// The spline through `heights` in mm at a pitch [x, y] in mm; nothing with fewer than four points
    /// along an axis.
    pub fn new(heights: &Array2<f64>, pitch: [f64; 2]) -> Option<Self> {
        let (ny, nx) = heights.dim();
        if ny < FEWEST || nx < FEWEST {
            return None;
        }
        // Along rows first, then along columns.
        let along = |array: &Array2<f64>| {
            let mut wider = Array2::zeros((array.nrows(), array.ncols() + 2));
            for (row, mut out) in array.rows().into_iter().zip(wider.rows_mut()) {
                out.assign(&ndarray::Array1::from(coefficients(&row.to_vec())));
            }
            wider
        };
        let turned = along(heights).reversed_axes();
        let coefficients = along(&turned).reversed_axes();
        Some(Self {
            pitch,
            coefficients,
        })
    }

    /// Distance of neighbouring points along x and y in mm.
    pub fn pitch(&self) -> [f64; 2] {
        self.pitch
    }

    /// Half the extent along x and y in mm.
    pub fn half(&self) -> [f64; 2] {
        let points = |axis: usize| self.coefficients.len_of(Axis(1 - axis)) - 2;
        std::array::from_fn(|axis| 0.5 * (points(axis) - 1) as f64 * self.pitch[axis])
    }

    /// The height at (x, y); nothing outside the grid.
    #[inline(always)]
    pub fn sag<T: Real>(&self, x: T, y: T) -> Option<T> {
        let half = self.half();
        Some(self.sum(self.cell(x, 0, half)?, self.cell(y, 1, half)?))
    }

    /// The height at (x, y). The spline goes on over one cell beyond the grid, and stays at what it has there.
    pub(crate) fn continued<T: Real>(&self, x: T, y: T) -> T {
        let half = self.half();
        let held = |at: T, axis: usize| {
            let most = half[axis] + self.pitch[axis];
            match at.value() {
                low if low < -most => T::constant(-most),
                high if high > most => T::constant(most),
                _ => at,
            }
        };
        let split = |at: T, axis: usize| self.split(self.place(held(at, axis), axis, half), axis);
        self.sum(split(x, 0), split(y, 1))
    }

    /// The sum of the splines about a place, by its column and row, and the shares of the way to the next.
    #[inline(always)]
    fn sum<T: Real>(&self, (column, s): (usize, T), (row, t): (usize, T)) -> T {
        let (across, up) = (weights(s), weights(t));
        let mut sum = T::constant(0.0);
        for (j, up) in up.into_iter().enumerate() {
            let mut line = T::constant(0.0);
            for (i, across) in across.into_iter().enumerate() {
                line = line + across * self.coefficients[[row + j, column + i]];
            }
            sum = sum + up * line;
        }
        sum
    }

    /// The cell of a coordinate along an axis, and the place inside it from 0 to 1.
    #[inline(always)]
    fn cell<T: Real>(&self, at: T, axis: usize, half: [f64; 2]) -> Option<(usize, T)> {
        let u = self.place(at, axis, half);
        let (here, last) = (u.value(), self.cells(axis) as f64);
        (here >= -EDGE && here <= last + EDGE).then(|| self.split(u, axis))
    }

    /// A coordinate in steps of the grid from its first point.
    #[inline(always)]
    fn place<T: Real>(&self, at: T, axis: usize, half: [f64; 2]) -> T {
        (at + half[axis]) * (1.0 / self.pitch[axis])
    }

    /// The cell of a place in steps of the grid, or that which is nearest, and the place inside it.
    #[inline(always)]
    fn split<T: Real>(&self, u: T, axis: usize) -> (usize, T) {
        let cell = (u.value().max(0.0) as usize).min(self.cells(axis) - 1);
        (cell, u - cell as f64)
    }

    /// Number of cells along an axis.
    #[inline(always)]
    fn cells(&self, axis: usize) -> usize {
        self.coefficients.len_of(Axis(1 - axis)) - 3
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use crate::optics::sag_grid::SagGrid;

    /// A sphere of radius 20 on a grid of 41 × 31 points.
    fn sphere(x: f64, y: f64) -> f64 {
        20.0 - (400.0 - x * x - y * y).sqrt()
    }

    fn grid() -> SagGrid {
        let heights = Array2::from_shape_fn((31, 41), |(j, i)| {
            sphere((i as f64 - 20.0) * 0.2, (j as f64 - 15.0) * 0.3)
        });
        SagGrid::new(&heights, [0.2, 0.3]).unwrap()
    }

    #[test]
    fn a_grid_of_a_sphere_is_the_sphere_within_its_spacing_to_the_fourth() {
        // Cubic splines err by at most 5/384 h⁴ z⁗ inside, and z⁗ = 3/R³ at the vertex, about 5e-4 at the
        // corner: some 1e-7 mm with the larger error at the ends.
        let grid = grid();
        assert_eq!(grid.half(), [4.0, 4.5]);
        let mut worst = 0.0f64;
        for j in 0..=200 {
            for i in 0..=200 {
                let (x, y) = (-4.0 + 0.04 * f64::from(i), -4.5 + 0.045 * f64::from(j));
                let error = grid.sag(x, y).unwrap() - sphere(x, y);
                worst = worst.max(error.abs());
            }
        }
        assert!(worst < 3e-7, "{worst}");
    }

    #[test]
    fn nothing_lies_outside_the_grid() {
        let grid = grid();
        assert!(grid.sag(4.0, -4.5).is_some());
        assert!(grid.sag(4.001, 0.0).is_none());
        assert!(grid.sag(0.0, -4.501).is_none());
        assert!(SagGrid::new(&Array2::zeros((3, 9)), [1.0, 1.0]).is_none());
    }

    #[test]
    fn the_spline_goes_on_for_one_cell() {
        let grid = grid();
        assert_eq!(grid.continued(1.23, -0.4), grid.sag(1.23, -0.4).unwrap());
        assert!((grid.continued(4.1, 2.0) - sphere(4.1, 2.0)).abs() < 1e-6);
        assert_eq!(grid.continued(9.0, 2.0), grid.continued(4.2, 2.0));
    }
}
