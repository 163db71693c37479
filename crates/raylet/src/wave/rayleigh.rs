//! First Rayleigh–Sommerfeld integral by direct sum: from a plane to any points in front of it.
//!
//!   U(P) = (1/2π) ∫ U(x) (z/r) (1/r − ik) e^{ikr}/r dA
//!
//! with r the distance and z the height of P over the plane (Goodman, Introduction to Fourier Optics,
//! section 3.5). No approximation but the quadrature of the field's own nodes, so tilted planes and
//! scattered points cost nothing extra; every node meets every point.

use fearless_simd::{Level, Simd, SimdBase, SimdFloat, dispatch, f64x8};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::math::lanes::{LANES, cis_turns};
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
    fn sum<S: Simd>(&self, simd: S, [px, py, pz]: [f64; 3], wavelength: f64) -> Complex64 {
        let splat = |v: f64| f64x8::splat(simd, v);
        let k = splat(std::f64::consts::TAU / wavelength);
        let [per_wavelength, one] = [1.0 / wavelength, 1.0].map(splat);
        let (px, py, height) = (splat(px), splat(py), splat(pz * pz));
        let (mut re, mut im) = (splat(0.0), splat(0.0));
        let columns = self.x.chunks_exact(LANES).zip(self.y.chunks_exact(LANES));
        let strengths = self.re.chunks_exact(LANES).zip(self.im.chunks_exact(LANES));
        for ((x, y), (strength_re, strength_im)) in columns.zip(strengths) {
            let dx = px - f64x8::from_slice(simd, x);
            let dy = py - f64x8::from_slice(simd, y);
            let distance = (dx * dx + dy * dy + height).sqrt();
            let inverse = one / distance;
            let (cos, sin) = cis_turns(distance * per_wavelength);

            // e^{ikr} (1/r − ik)/r², times the node's strength.
            let falloff = inverse * inverse;
            let kernel_re = falloff * (cos * inverse + sin * k);
            let kernel_im = falloff * (sin * inverse - cos * k);
            let strength_re = f64x8::from_slice(simd, strength_re);
            let strength_im = f64x8::from_slice(simd, strength_im);
            re += kernel_re * strength_re - kernel_im * strength_im;
            im += kernel_re * strength_im + kernel_im * strength_re;
        }
        let total = |sum: f64x8<S>| sum.as_array().iter().sum::<f64>();
        Complex64::new(total(re), total(im)) * (pz / std::f64::consts::TAU)
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::wave::field::Axis;
    use crate::wave::rayleigh::Emitters;

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
