//! Uniform grids of sample points.

/// A uniform grid of sample points: x = start + i·pitch, likewise y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    /// First column and first row, in mm.
    pub start: [f64; 2],
    /// Distance of columns and of rows, in mm.
    pub pitch: [f64; 2],
    /// Number of columns and rows.
    pub size: [usize; 2],
}
