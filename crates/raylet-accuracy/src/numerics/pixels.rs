//! A plane screen of box pixels: complex transmission constant over each square pixel.

use ndarray::{Array1, Array2};
use num_complex::Complex64;

use crate::numerics::quadrature::gauss_legendre;

/// Square pixels of side `pitch` with complex `transmission` [y, x], centred on the axis;
/// opaque outside.
#[derive(Clone, Debug)]
pub struct Pixels {
    /// Side of a pixel.
    pub pitch: f64,
    /// Complex transmission [y, x].
    pub transmission: Array2<Complex64>,
}

/// Gauss–Legendre nodes along one axis of a pixel plane.
pub struct PixelNodes {
    /// Positions.
    pub positions: Array1<f64>,
    /// Quadrature weights (lengths).
    pub weights: Array1<f64>,
    /// Nodes per pixel: node i lies in pixel i / `per_pixel`.
    pub per_pixel: usize,
}

impl Pixels {
    /// Largest half side of the plane.
    pub fn half_width(&self) -> f64 {
        let (rows, columns) = self.transmission.dim();
        0.5 * self.pitch * rows.max(columns) as f64
    }

    /// Positions of the pixel centres along an axis with `count` pixels.
    pub fn centres(&self, count: usize) -> Array1<f64> {
        Array1::from_shape_fn(count, |i| {
            (i as f64 - 0.5 * (count as f64 - 1.0)) * self.pitch
        })
    }

    /// `per_pixel` Gauss–Legendre nodes in each pixel along an axis with `count` pixels.
    pub fn nodes(&self, count: usize, per_pixel: usize) -> PixelNodes {
        let rule = gauss_legendre(per_pixel);
        let centres = self.centres(count);
        let half = 0.5 * self.pitch;
        PixelNodes {
            positions: Array1::from_shape_fn(count * per_pixel, |i| {
                centres[i / per_pixel] + half * rule[i % per_pixel].0
            }),
            weights: Array1::from_shape_fn(count * per_pixel, |i| half * rule[i % per_pixel].1),
            per_pixel,
        }
    }
}
