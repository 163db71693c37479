//! A smooth phase by samples on a grid, with a bicubic spline between them.

use std::sync::Arc;

use ndarray::Array2;

use crate::math::real::Real;
use crate::optics::sag_grid::SagGrid;

/// φ(x, y) by samples on a centred grid; copies share the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseGrid {
    /// The spline through the samples in rad.
    spline: Arc<SagGrid>,
    /// What multiplies it.
    factor: f64,
}

impl PhaseGrid {
    /// The spline through phases [y, x] in rad at a pitch [x, y] in mm; nothing with fewer than four along an axis.
    pub fn new(phases: &Array2<f64>, pitch: [f64; 2]) -> Option<Self> {
        let spline = Arc::new(SagGrid::new(phases, pitch)?);
        Some(Self {
            spline,
            factor: 1.0,
        })
    }

    /// The phase times a number.
    pub(crate) fn times(&self, factor: f64) -> Self {
        Self {
            spline: Arc::clone(&self.spline),
            factor: factor * self.factor,
        }
    }

    /// The phase in rad at a point; beyond the grid the spline goes on over one cell, and stays at what it has there.
    pub(crate) fn phase<T: Real>(&self, x: T, y: T) -> T {
        self.spline.continued(x, y) * self.factor
    }
}
