//! First Rayleigh–Sommerfeld integral from a plane of box pixels to any points in front of it,
//! by direct sum: the reference for free hops, planar or tilted.

use fearless_simd::{Level, Simd, dispatch};
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::numerics::phase::cis_turns;
use crate::numerics::pixels::Pixels;

/// Sources handled side by side by the inner loop.
const LANES: usize = 8;

/// Quadrature nodes on the screen, in columns padded to a multiple of [`LANES`] with nodes of no
/// amplitude.
struct Sources {
    x: Vec<f64>,
    y: Vec<f64>,
    real: Vec<f64>,
    imaginary: Vec<f64>,
}

/// The field at `points` (x, y, z > 0) behind `pixels` in the plane z = 0 of vacuum,
///   U = Σ ∫ T E_in (z/r) (1/2π) (1/r − ik) e^{ikr}/r dA,
/// for the incident wave E_in = exp(ik `tilt`·x) with optical direction cosines `tilt`, each
/// pixel integrated by `nodes`² Gauss–Legendre nodes.
///
/// For a medium of index n pass λ/n and the cosines divided by n. The error beside the
/// quadrature's is about 1e-16·r/λ.
pub fn rayleigh_sommerfeld(
    pixels: &Pixels,
    tilt: [f64; 2],
    wavelength: f64,
    nodes: usize,
    points: &[[f64; 3]],
) -> Vec<Complex64> {
    let (sources, level) = (sources(pixels, tilt, wavelength, nodes), Level::new());
    points
        .par_iter()
        .map(|point| dispatch!(level, simd => sum(simd, &sources, *point, wavelength)))
        .collect()
}

/// The cotangent of a field at points.
#[derive(Clone, Copy)]
pub struct FieldBar<'a> {
    /// The points (x, y, z > 0).
    pub points: &'a [[f64; 3]],
    /// The cotangent of its value at each point.
    pub values: &'a [Complex64],
}

/// The conjugate transpose of [`rayleigh_sommerfeld`] with respect to the pixels, [y, x]: from the cotangent of
/// the field at the points to that of each pixel's transmission.
pub fn rayleigh_sommerfeld_adjoint(
    pixels: &Pixels,
    tilt: [f64; 2],
    wavelength: f64,
    nodes: usize,
    back: FieldBar,
) -> Array2<Complex64> {
    let FieldBar { points, values } = back;
    let (rows, columns) = pixels.transmission.dim();
    let (ys, xs) = (pixels.nodes(rows, nodes), pixels.nodes(columns, nodes));
    let k = std::f64::consts::TAU / wavelength;
    // What one node gets back: Σ conj(kernel)·bar over the points.
    let node = |row: usize, column: usize| {
        let (x, y) = (xs.positions[column], ys.positions[row]);
        let (c, s) = cis_turns((tilt[0] * x + tilt[1] * y) / wavelength);
        let area = ys.weights[row] * xs.weights[column] / std::f64::consts::TAU;
        let lit = Complex64::new(c, s) * area;
        let mut sum = Complex64::ZERO;
        for ([px, py, pz], bar) in points.iter().zip(values) {
            let r = ((px - x).powi(2) + (py - y).powi(2) + pz * pz).sqrt();
            let (c, s) = cis_turns(r / wavelength);
            let kernel = Complex64::new(1.0 / r, -k) * Complex64::new(c, s) * (pz / (r * r));
            sum += (kernel * lit).conj() * bar;
        }
        sum
    };
    let pixel = |index: usize| -> Complex64 {
        let (row, column) = (index / columns, index % columns);
        let within =
            (0..nodes * nodes).map(|n| [row * nodes + n / nodes, column * nodes + n % nodes]);
        within.map(|[row, column]| node(row, column)).sum()
    };
    let all: Vec<Complex64> = (0..rows * columns).into_par_iter().map(pixel).collect();
    Array2::from_shape_fn((rows, columns), |(row, column)| all[row * columns + column])
}

/// The nodes of every pixel that lets light through, with amplitude T·E_in·dA.
fn sources(pixels: &Pixels, tilt: [f64; 2], wavelength: f64, nodes: usize) -> Sources {
    let (rows, columns) = pixels.transmission.dim();
    let (y_nodes, x_nodes) = (pixels.nodes(rows, nodes), pixels.nodes(columns, nodes));
    let mut sources = Sources {
        x: vec![],
        y: vec![],
        real: vec![],
        imaginary: vec![],
    };
    for (row, y) in y_nodes.positions.iter().enumerate() {
        for (column, x) in x_nodes.positions.iter().enumerate() {
            let transmission = pixels.transmission[[row / nodes, column / nodes]];
            if transmission.norm_sqr() == 0.0 {
                continue;
            }
            let (c, s) = cis_turns((tilt[0] * x + tilt[1] * y) / wavelength);
            let area = y_nodes.weights[row] * x_nodes.weights[column];
            sources.push(*x, *y, transmission * Complex64::new(c, s) * area);
        }
    }
    while !sources.x.len().is_multiple_of(LANES) {
        sources.push(0.0, 0.0, Complex64::new(0.0, 0.0));
    }
    sources
}

impl Sources {
    fn push(&mut self, x: f64, y: f64, amplitude: Complex64) {
        self.x.push(x);
        self.y.push(y);
        self.real.push(amplitude.re);
        self.imaginary.push(amplitude.im);
    }
}

/// The integral at one point, with the machine's widest vectors.
#[inline(always)]
fn sum<S: Simd>(_: S, sources: &Sources, [px, py, pz]: [f64; 3], wavelength: f64) -> Complex64 {
    let per_wavelength = 1.0 / wavelength;
    let k = std::f64::consts::TAU * per_wavelength;
    let (mut real, mut imaginary) = ([0.0; LANES], [0.0; LANES]);
    for first in (0..sources.x.len()).step_by(LANES) {
        let xs = &sources.x[first..first + LANES];
        let ys = &sources.y[first..first + LANES];
        let res = &sources.real[first..first + LANES];
        let ims = &sources.imaginary[first..first + LANES];
        for lane in 0..LANES {
            // e^{ikr} (1/r − ik)/r², times the node's amplitude.
            let (dx, dy) = (px - xs[lane], py - ys[lane]);
            let distance = (dx * dx + dy * dy + pz * pz).sqrt();
            let inverse = 1.0 / distance;
            let (c, s) = cis_turns(distance * per_wavelength);
            let falloff = inverse * inverse;
            let kernel_re = falloff * (c * inverse + s * k);
            let kernel_im = falloff * (s * inverse - c * k);
            real[lane] += kernel_re * res[lane] - kernel_im * ims[lane];
            imaginary[lane] += kernel_re * ims[lane] + kernel_im * res[lane];
        }
    }
    let total = Complex64::new(real.iter().sum(), imaginary.iter().sum());
    total * (pz / std::f64::consts::TAU)
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::numerics::disc::disc_weights;
    use crate::numerics::pixels::Pixels;
    use crate::references::rayleigh_sommerfeld::{
        FieldBar, rayleigh_sommerfeld, rayleigh_sommerfeld_adjoint,
    };

    /// On the axis behind a hard disc the integral is
    /// e^{ikz} − (z/√(z²+a²)) e^{ik√(z²+a²)} exactly.
    #[test]
    fn axis_behind_a_disc_has_its_closed_form() {
        let (radius, pitch) = (10.3, 0.125);
        let half = (radius / pitch) as usize + 5;
        let weights = disc_weights(radius / pitch, half, 6);
        let pixels = Pixels {
            pitch,
            transmission: weights.mapv(Complex64::from),
        };
        for (z, bound) in [(8.0, 7e-5), (20.0, 4e-6), (61.5, 2e-8)] {
            let slant = (z * z + radius * radius).sqrt();
            let tau = std::f64::consts::TAU;
            let exact = Complex64::cis(tau * z) - Complex64::cis(tau * slant) * (z / slant);
            // One node per pixel turns the weights into plain quadrature.
            let field = rayleigh_sommerfeld(&pixels, [0.0, 0.0], 1.0, 1, &[[0.0, 0.0, z]])[0];
            assert!(
                (field - exact).norm() < bound,
                "{z}: {:e}",
                (field - exact).norm()
            );
        }
    }

    #[test]
    fn gauss_nodes_converge_geometrically() {
        let pixels = Pixels {
            pitch: 1.0,
            transmission: Array2::from_shape_fn((16, 16), |(i, j)| {
                Complex64::cis((7 * i * i + 3 * j) as f64)
            }),
        };
        let points: Vec<_> = (0..40)
            .map(|i| [0.7 * f64::from(i) - 14.0, 3.0, 9.0 + 0.3 * f64::from(i)])
            .collect();
        let field = |nodes| rayleigh_sommerfeld(&pixels, [0.2, -0.1], 1.0, nodes, &points);
        let exact = field(12);
        let norm: f64 = exact.iter().map(|u| u.norm_sqr()).sum();
        for (nodes, bound) in [(3, 2.1e-3), (4, 7e-5), (6, 4.1e-8)] {
            let off: f64 = field(nodes)
                .iter()
                .zip(&exact)
                .map(|(a, b)| (a - b).norm_sqr())
                .sum();
            assert!(
                (off / norm).sqrt() < bound,
                "{nodes}: {:e}",
                (off / norm).sqrt()
            );
        }
    }

    #[test]
    fn rayleigh_sommerfeld_dot_product() {
        let noise = |i: usize| Complex64::cis((7 * i * i + 3 * i) as f64);
        let pixels = Pixels {
            pitch: 1.5,
            transmission: Array2::from_shape_fn((5, 7), |(j, i)| noise(7 * j + i)),
        };
        let points: Vec<_> = (0..30)
            .map(|i| [0.9 * f64::from(i) - 14.0, 3.0 - 0.2 * f64::from(i), 9.0])
            .collect();
        let bar: Vec<Complex64> = (0..30).map(|i| noise(50 + i)).collect();
        let field = rayleigh_sommerfeld(&pixels, [0.2, -0.1], 1.0, 4, &points);
        let field_bar = FieldBar {
            points: &points,
            values: &bar,
        };
        let back = rayleigh_sommerfeld_adjoint(&pixels, [0.2, -0.1], 1.0, 4, field_bar);
        let there: Complex64 = bar.iter().zip(&field).map(|(a, b)| a.conj() * b).sum();
        let back: Complex64 = (back.iter().zip(&pixels.transmission))
            .map(|(a, b)| a.conj() * b)
            .sum();
        assert!(
            (there - back).norm() < 1e-13 * there.norm(),
            "{there} {back}"
        );
    }
}
