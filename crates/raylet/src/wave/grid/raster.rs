//! Uniform grids of sample points.

use ndarray::Array2;
use num_complex::Complex64;

use crate::math::chirp::Comb;
use crate::optics::screen::Sensor;

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

impl Raster {
    /// The points along x (0) or y (1).
    pub(crate) fn comb(&self, axis: usize) -> Comb {
        Comb {
            start: self.start[axis],
            step: self.pitch[axis],
            count: self.size[axis],
        }
    }

    /// The pixel centres of a sensor.
    pub(crate) fn of(sensor: &Sensor) -> Self {
        let first = |a: usize| -0.5 * (sensor.pixels[a] as f64 - 1.0) * sensor.pitch[a];
        Self {
            start: [first(0), first(1)],
            pitch: sensor.pitch,
            size: sensor.pixels,
        }
    }

    /// ∫|U|² over the raster, in mm² for unit amplitude.
    pub(crate) fn power(&self, values: &Array2<Complex64>) -> f64 {
        let area = self.pitch[0] * self.pitch[1];
        values.iter().map(|u| u.norm_sqr()).sum::<f64>() * area
    }
}
