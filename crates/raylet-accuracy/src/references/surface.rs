//! A curved surface's sag, and the samples on its aperture that diffraction sums run over.

use crate::numerics::disc::disc_weights;

/// A function (x, y) ↦ [z, ∂z/∂x, ∂z/∂y].
pub type SagFunction<'a> = &'a (dyn Fn(f64, f64) -> [f64; 3] + Sync);

/// Height of a surface over the plane through its vertex.
#[derive(Clone, Copy)]
pub enum Sag<'a> {
    /// The plane itself.
    Flat,
    /// A sphere of signed radius R (centre at z = R), for x² + y² < R².
    Sphere(f64),
    /// Any single-valued surface.
    General(SagFunction<'a>),
}

impl Sag<'_> {
    /// The height and its two slopes at (x, y).
    pub fn at(&self, x: f64, y: f64) -> [f64; 3] {
        match self {
            Self::Flat => [0.0; 3],
            Self::Sphere(radius) => {
                // z = R − sign(R)·√(R² − r²), written without cancellation.
                let square = x * x + y * y;
                let root = radius.signum() * (radius * radius - square).sqrt();
                [square / (radius + root), x / root, y / root]
            }
            Self::General(function) => function(x, y),
        }
    }

    /// Mean curvature at (x, y), the slopes differenced over ±`step`.
    pub fn mean_curvature(&self, x: f64, y: f64, step: f64) -> f64 {
        let [_, slope_x, slope_y] = self.at(x, y);
        let (right, left) = (self.at(x + step, y), self.at(x - step, y));
        let (up, down) = (self.at(x, y + step), self.at(x, y - step));
        let [xx, xy] = [1, 2].map(|part| (right[part] - left[part]) / (2.0 * step));
        let yy = (up[2] - down[2]) / (2.0 * step);

        let stretch = 1.0 + slope_x * slope_x + slope_y * slope_y;
        let bend = (1.0 + slope_y * slope_y) * xx + (1.0 + slope_x * slope_x) * yy;
        (bend - 2.0 * slope_x * slope_y * xy) / (2.0 * stretch.powf(1.5))
    }
}

/// Samples of a surface above the points of a square grid that carry its disc aperture.
pub struct SurfaceSamples {
    /// Side P of the grid's period.
    pub period: f64,
    /// Points per period N; the pitch is P/N.
    pub samples: usize,
    /// The grid square that holds the aperture has indices −half ..= half about the axis.
    pub half: usize,
    /// Index [y, x] of each sample in that square.
    pub cells: Vec<[usize; 2]>,
    /// Position (x, y, z) of each sample, z from the vertex.
    pub points: Vec<[f64; 3]>,
    /// Slopes (∂z/∂x, ∂z/∂y) at each sample.
    pub slopes: Vec<[f64; 2]>,
    /// Mean curvature ½(κ₁ + κ₂) at each sample, positive where the centre lies at larger z.
    pub curvatures: Vec<f64>,
    /// Quadrature weight of each sample, in units of a cell's area.
    pub weights: Vec<f64>,
}

impl SurfaceSamples {
    /// Samples of `sag` within `semi_aperture` of the axis on the grid of pitch `period`/`samples`,
    /// weighted by the disc's quadrature of `stencil` points per axis ([`disc_weights`]): 1 for
    /// the covered area of each cell, 6 for an accurate edge. The sag must exist for `stencil`/2
    /// pitches beyond the rim.
    pub fn new(period: f64, samples: usize, semi_aperture: f64, stencil: usize, sag: Sag) -> Self {
        let pitch = period / samples as f64;
        let radius = semi_aperture / pitch;
        let half = radius.ceil() as usize + stencil;
        let mut surface = Self {
            period,
            samples,
            half,
            cells: vec![],
            points: vec![],
            slopes: vec![],
            curvatures: vec![],
            weights: vec![],
        };
        for ((row, column), weight) in disc_weights(radius, half, stencil).indexed_iter() {
            if *weight != 0.0 {
                let at = |index: usize| (index as f64 - half as f64) * pitch;
                let [z, slope_x, slope_y] = sag.at(at(column), at(row));
                surface.cells.push([row, column]);
                surface.points.push([at(column), at(row), z]);
                surface.slopes.push([slope_x, slope_y]);
                surface
                    .curvatures
                    .push(sag.mean_curvature(at(column), at(row), 0.5 * pitch));
                surface.weights.push(*weight);
            }
        }
        surface
    }

    /// Lowest and highest sample.
    pub fn heights(&self) -> (f64, f64) {
        let heights = self.points.iter().map(|point| point[2]);
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| {
            (low.min(z), high.max(z))
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::references::surface::{Sag, SurfaceSamples};

    #[test]
    fn slopes_are_the_derivatives_of_the_height() {
        for radius in [200.0, -37.0] {
            let sag = Sag::Sphere(radius);
            let ([z, slope_x, slope_y], step) = (sag.at(8.0, -5.0), 1e-4);
            assert!((z * z - 2.0 * z * radius + 89.0).abs() < 1e-10);
            let along_x =
                (sag.at(8.0 + step, -5.0)[0] - sag.at(8.0 - step, -5.0)[0]) / (2.0 * step);
            let along_y =
                (sag.at(8.0, -5.0 + step)[0] - sag.at(8.0, -5.0 - step)[0]) / (2.0 * step);
            assert!((sag.mean_curvature(8.0, -5.0, 0.1) * radius - 1.0).abs() < 1e-4);
            assert!((slope_x - along_x).abs() < 1e-9 && (slope_y - along_y).abs() < 1e-9);
        }
    }

    #[test]
    fn samples_cover_the_aperture() {
        let surface = SurfaceSamples::new(90.0, 180, 20.2, 6, Sag::Sphere(100.0));
        let area: f64 = surface.weights.iter().sum::<f64>() * 0.25;
        assert!(
            (area / (std::f64::consts::PI * 20.2 * 20.2) - 1.0).abs() < 1e-7,
            "{area}"
        );
        let (low, high) = surface.heights();
        assert!(
            low.abs() < 1e-12 && (high - 2.1).abs() < 0.5,
            "{low} {high}"
        );
    }
}
