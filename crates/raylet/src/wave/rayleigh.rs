//! First Rayleigh–Sommerfeld integral by direct sum: from a plane to any points in front of it.
//!
//!   U(P) = (1/2π) ∫ U(x) (z/r) (1/r − ik) e^{ikr}/r dA
//!
//! with r the distance and z the height of P over the plane (Goodman, Introduction to Fourier Optics,
//! section 3.5). No approximation but the quadrature of the field's own nodes, so tilted planes and
//! scattered points cost nothing extra; every node meets every point.

use fearless_simd::{Level, Simd, dispatch};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::math::lanes::{LANES, Lanes, cis_turns};
use crate::wave::field::Field;

/// Node–point pairs per second that one core sums; shapes predictions only.
pub const PAIRS_PER_SECOND: f64 = 1.5e8;

/// The lit nodes of a field, in columns padded to a multiple of eight with nodes of no amplitude.
///
/// The columns hold x, y in mm and the amplitude times the node's area in mm².
pub struct Emitters {
    x: Vec<f64>,
    y: Vec<f64>,
    re: Vec<f64>,
    im: Vec<f64>,
    lit: usize,
}

impl Emitters {
    /// The nodes of a field that are not dark.
    pub fn new(field: &Field) -> Self {
        let grid = &field.grid;
        let lit = field
            .values
            .indexed_iter()
            .filter(|(_, u)| **u != Complex64::ZERO);
        Self::of_nodes(lit.map(|((j, i), value)| {
            let area = grid.x.weight(i) * grid.y.weight(j);
            (grid.x.node(i), grid.y.node(j), value * area)
        }))
    }

    /// Emitters at (x, y) in mm, of strength field × area in mm².
    pub fn of_nodes(nodes: impl Iterator<Item = (f64, f64, Complex64)>) -> Self {
        let mut emitters = Self {
            x: Vec::new(),
            y: Vec::new(),
            re: Vec::new(),
            im: Vec::new(),
            lit: 0,
        };
        for (x, y, strength) in nodes {
            emitters.push(x, y, strength);
        }
        emitters.lit = emitters.x.len();
        while !emitters.x.len().is_multiple_of(LANES) {
            emitters.push(0.0, 0.0, Complex64::ZERO);
        }
        emitters
    }

    fn push(&mut self, x: f64, y: f64, strength: Complex64) {
        self.x.push(x);
        self.y.push(y);
        self.re.push(strength.re);
        self.im.push(strength.im);
    }

    /// Number of lit nodes; a sum costs this many pairs per point.
    pub fn len(&self) -> usize {
        self.lit
    }

    /// Whether all is dark.
    pub fn is_empty(&self) -> bool {
        self.lit == 0
    }

    /// The field at points (x, y, z > 0) over the plane, in mm, in a medium where light has the given
    /// `wavelength` (vacuum wavelength over index, mm). The same bits for any number of threads.
    pub fn shine(&self, points: &[[f64; 3]], wavelength: f64) -> Vec<Complex64> {
        let level = Level::new();
        points
            .par_iter()
            .map(|point| dispatch!(level, simd => self.sum(simd, *point, wavelength)))
            .collect()
    }

    /// The integral at one point.
    #[inline(always)]
    fn sum<S: Simd>(&self, _simd: S, [px, py, pz]: [f64; 3], wavelength: f64) -> Complex64 {
        let per_wavelength = 1.0 / wavelength;
        let k = std::f64::consts::TAU * per_wavelength;
        let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
        let columns = self.x.chunks_exact(LANES).zip(self.y.chunks_exact(LANES));
        let strengths = self.re.chunks_exact(LANES).zip(self.im.chunks_exact(LANES));
        for ((xs, ys), (res, ims)) in columns.zip(strengths) {
            // 1/r by Newton's method from single precision, r without a further root.
            let (mut square, mut turns): (Lanes, Lanes) = ([0.0; LANES], [0.0; LANES]);
            let mut inverse = [0.0; LANES];
            for l in 0..LANES {
                let (dx, dy) = (px - xs[l], py - ys[l]);
                square[l] = dx * dx + dy * dy + pz * pz;
                inverse[l] = inverse_root(square[l]);
                turns[l] = square[l] * inverse[l] * per_wavelength;
            }
            let (cos, sin) = cis_turns(turns);

            // e^{ikr} (1/r − ik)/r², times the node's strength.
            for l in 0..LANES {
                let falloff = inverse[l] * inverse[l];
                let kernel_re = falloff * (cos[l] * inverse[l] + sin[l] * k);
                let kernel_im = falloff * (sin[l] * inverse[l] - cos[l] * k);
                re[l] += kernel_re * res[l] - kernel_im * ims[l];
                im[l] += kernel_re * ims[l] + kernel_im * res[l];
            }
        }
        Complex64::new(re.iter().sum(), im.iter().sum()) * (pz / std::f64::consts::TAU)
    }
}

/// 1/√s to 2e-16 relative for 1e-37 < s < 1e37.
#[inline(always)]
fn inverse_root(s: f64) -> f64 {
    let y = f64::from(1.0 / (s as f32).sqrt());
    let y = y * (1.5 - 0.5 * s * y * y);
    // The last step as a correction, so that its rounding does not count.
    y + y * (0.5 * (1.0 - s * y * y))
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::wave::field::Axis;
    use crate::wave::rayleigh::{Emitters, inverse_root};

    #[test]
    fn inverse_root_is_exact_to_rounding() {
        let mut s = 1e-12;
        while s < 1e12 {
            assert!((inverse_root(s) * s.sqrt() - 1.0).abs() < 5e-16, "{s}");
            s *= 1.0137;
        }
    }

    /// A uniformly lit disc: Gauss nodes along the radius, equal steps around.
    fn disc(radius: f64) -> Emitters {
        let rings = Axis::gauss(24, radius / 24.0, 0.5 * radius, 8);
        let spokes = 16;
        let nodes = (0..rings.len() * spokes).map(|n| {
            let (ring, spoke) = (n / spokes, n % spokes);
            let r = rings.node(ring);
            let (sin, cos) = (std::f64::consts::TAU * spoke as f64 / spokes as f64).sin_cos();
            let area = r * rings.weight(ring) * std::f64::consts::TAU / spokes as f64;
            (r * cos, r * sin, Complex64::new(area, 0.0))
        });
        Emitters::of_nodes(nodes)
    }

    /// On the axis behind a disc the integral is e^{ikz} − (z/s) e^{iks}, s = √(z² + a²).
    #[test]
    fn axis_behind_a_disc_has_its_closed_form() {
        let (wavelength, radius) = (0.7e-3, 7.2e-3);
        let k = std::f64::consts::TAU / wavelength;
        for z in [3e-3, 20e-3, 60e-3, 400.0] {
            let slant = f64::hypot(z, radius);
            let exact = Complex64::cis(k * z) - Complex64::cis(k * slant) * (z / slant);
            let field = disc(radius).shine(&[[0.0, 0.0, z]], wavelength)[0];
            let error = (field - exact).norm();
            assert!(error < 1e-12 + 2e-16 * k * z, "{z}: {error:e}");
        }
    }

    #[test]
    fn bits_do_not_depend_on_threads() {
        let emitters = disc(7.2e-3);
        let points: Vec<[f64; 3]> = (0..50)
            .map(|i| [1e-4 * f64::from(i), -2e-4 * f64::from(i), 0.01])
            .collect();
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| emitters.shine(&points, 0.7e-3))
        };
        assert_eq!(run(1), run(3));
    }
}
