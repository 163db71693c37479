//! Values on a grid that shape a surface of a lens file or its phase.

use std::path::PathBuf;
use std::sync::Arc;

use ndarray::Array2;

use crate::optics::sag_grid::SagGrid;

/// Part of a pitch over which the curvature in the middle of a grid is taken.
const STEP: f64 = 1e-2;

/// What the values of a grid are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GridKind {
    /// Heights in µm.
    Sag,
    /// Phases in rad.
    Phase,
}

/// A grid of a surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FaceGrid {
    /// What its values are.
    pub kind: GridKind,
    /// The file that the scene names.
    pub file: PathBuf,
    /// The values [y, x] with rows growing with y.
    pub values: Arc<Array2<f64>>,
    /// Distance of neighbouring points along x and y in mm.
    pub pitch_mm: [f64; 2],
}

impl FaceGrid {
    /// The second derivative by y in the middle, in the unit of the values over mm²; zero where there is no spline.
    pub(crate) fn curvature_y(&self) -> f64 {
        let Some(spline) = SagGrid::new(&self.values, self.pitch_mm) else {
            return 0.0;
        };
        let step = STEP * self.pitch_mm[1];
        let at = |y: f64| spline.sag(0.0, y).unwrap_or(0.0);
        (at(step) - 2.0 * at(0.0) + at(-step)) / (step * step)
    }
}
