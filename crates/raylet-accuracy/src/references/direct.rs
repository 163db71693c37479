//! Samples of a field on surfaces anywhere in space, and the first Rayleigh–Sommerfeld integral over them
//! by direct sum: the reference for whatever is tilted, decentred or folded.

use fearless_simd::{Level, Simd, dispatch};
use num_complex::Complex64;
use raylet::math::vec3::Vec3;
use raylet::optics::frame::Frame;
use rayon::prelude::*;

use crate::numerics::phase::cis_turns;
use crate::numerics::pixels::Pixels;

/// Sources handled side by side by the inner loop.
const LANES: usize = 8;

/// A field on samples of a surface.
#[derive(Default)]
pub struct SampledSurface {
    /// Where the samples are.
    pub points: Vec<Vec3>,
    /// Their vector areas: quadrature weight times the unit normal towards where the light goes.
    pub areas: Vec<Vec3>,
    /// The field there.
    pub field: Vec<Complex64>,
}

/// A block of sources, each part in lanes: position, vector area, field.
type Block = [[f64; LANES]; 8];

impl SampledSurface {
    /// The Gauss nodes of a plane of box pixels that stands in `frame`, dark ones left out; the field is
    /// the transmission.
    pub fn pixels(pixels: &Pixels, frame: &Frame, nodes: usize) -> Self {
        let (rows, columns) = pixels.transmission.dim();
        let (y, x) = (pixels.nodes(rows, nodes), pixels.nodes(columns, nodes));
        let mut sheet = Self::default();
        for (row, py) in y.positions.iter().enumerate() {
            for (column, px) in x.positions.iter().enumerate() {
                let value = pixels.transmission[[row / nodes, column / nodes]];
                if value.norm_sqr() > 0.0 {
                    sheet.points.push(frame.to_global(Vec3::new(*px, *py, 0.0)));
                    sheet
                        .areas
                        .push(frame.z * (y.weights[row] * x.weights[column]));
                    sheet.field.push(value);
                }
            }
        }
        sheet
    }

    /// Multiplies the field by collimated light of unit `direction` in air, its phase zero at the origin.
    pub fn lit(mut self, direction: Vec3, wavelength: f64) -> Self {
        for (value, point) in self.field.iter_mut().zip(&self.points) {
            let (c, s) = cis_turns(direction.dot(*point) / wavelength);
            *value *= Complex64::new(c, s);
        }
        self
    }

    /// Multiplies the field by what arrives at the samples.
    pub fn times(mut self, arriving: &[Complex64]) -> Self {
        for (value, arriving) in self.field.iter_mut().zip(arriving) {
            *value *= arriving;
        }
        self
    }

    /// The field at any points in front, in vacuum:
    /// U(P) = (1/2π) Σ U (A·(P−X)/r²) (1/r − ik) e^{ikr}.
    pub fn radiate(&self, wavelength: f64, points: &[Vec3]) -> Vec<Complex64> {
        let (blocks, level) = (self.blocks(), Level::new());
        points
            .par_iter()
            .map(|point| dispatch!(level, simd => sum(simd, &blocks, point, wavelength)))
            .collect()
    }

    /// The samples in blocks, the last filled up with dark ones.
    fn blocks(&self) -> Vec<Block> {
        let mut blocks = vec![[[0.0; LANES]; 8]; self.points.len().div_ceil(LANES)];
        for (sample, value) in self.field.iter().enumerate() {
            let (at, area) = (self.points[sample], self.areas[sample]);
            let parts = [at.x, at.y, at.z, area.x, area.y, area.z, value.re, value.im];
            for (part, number) in parts.into_iter().enumerate() {
                blocks[sample / LANES][part][sample % LANES] = number;
            }
        }
        blocks
    }
}

/// The integral at one point, with the machine's widest vectors.
#[inline(always)]
fn sum<S: Simd>(_: S, blocks: &[Block], point: &Vec3, wavelength: f64) -> Complex64 {
    let per_wavelength = 1.0 / wavelength;
    let k = std::f64::consts::TAU * per_wavelength;
    let (mut real, mut imaginary) = ([0.0; LANES], [0.0; LANES]);
    for [x, y, z, ax, ay, az, re, im] in blocks {
        for lane in 0..LANES {
            let (dx, dy, dz) = (point.x - x[lane], point.y - y[lane], point.z - z[lane]);
            let distance = (dx * dx + dy * dy + dz * dz).sqrt();
            let inverse = 1.0 / distance;
            let (c, s) = cis_turns(distance * per_wavelength);
            let lift = (ax[lane] * dx + ay[lane] * dy + az[lane] * dz) * inverse * inverse;
            let kernel_re = lift * (c * inverse + s * k);
            let kernel_im = lift * (s * inverse - c * k);
            real[lane] += kernel_re * re[lane] - kernel_im * im[lane];
            imaginary[lane] += kernel_re * im[lane] + kernel_im * re[lane];
        }
    }
    let total = Complex64::new(real.iter().sum(), imaginary.iter().sum());
    total / std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;
    use raylet::math::vec3::Vec3;
    use raylet::optics::frame::Frame;

    use crate::numerics::pixels::Pixels;
    use crate::references::direct::SampledSurface;
    use crate::references::rayleigh_sommerfeld::rayleigh_sommerfeld;

    /// Turned and moved as a whole, pixels and points keep their field.
    #[test]
    fn a_frame_changes_nothing() {
        let pixels = Pixels {
            pitch: 0.9,
            transmission: Array2::from_shape_fn((7, 9), |(i, j)| {
                Complex64::cis((5 * i * i + 3 * j * i) as f64)
            }),
        };
        let local: Vec<[f64; 3]> = (0..20)
            .map(|i| [0.7 * f64::from(i) - 7.0, 2.0, 9.0 + 0.3 * f64::from(i)])
            .collect();
        let exact = rayleigh_sommerfeld(&pixels, [0.2, -0.1], 0.8, 5, &local);
        let frame = Frame::GLOBAL
            .moved(Vec3::new(3.0, -8.0, 20.0))
            .tilted([0.4, -0.9, 0.3]);
        let direction = frame.direction_to_global(Vec3::new(0.2, -0.1, (1.0f64 - 0.05).sqrt()));
        let points: Vec<Vec3> = local
            .iter()
            .map(|[x, y, z]| frame.to_global(Vec3::new(*x, *y, *z)))
            .collect();
        let found = SampledSurface::pixels(&pixels, &frame, 5)
            .lit(direction, 0.8)
            .radiate(0.8, &points);
        // The light's phase is counted from another origin.
        let turn = Complex64::cis(-std::f64::consts::TAU * direction.dot(frame.origin) / 0.8);
        for (found, exact) in found.iter().zip(&exact) {
            assert!((found * turn - exact).norm() < 1e-11);
        }
    }
}
