//! First Rayleigh–Sommerfeld integral by direct sum: from a plane or curved screen to any points in front
//! of it.
//!
//!   U(P) = (1/2π) ∫ U(X) (N·(P−X)/r) (1/r − ik) e^{ikr}/r dx dy,  N = (−∇s, 1),
//!
//! with X = (x, y, s) and r = |P−X|; over a plane N·(P−X) is the height of P. Over a curved screen the
//! integral is Kirchhoff's approximation, good to about 1/kR (Goodman, Introduction to Fourier Optics,
//! section 3.5). The only approximation is the quadrature by the field's own nodes. Tilted planes and
//! scattered points cost nothing extra. Every node adds to every point.

use fearless_simd::{Simd, SimdBase, SimdFloat, dispatch, f64x8};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::math::lanes::{LANES, cis_turns};
use crate::math::simd_level::level;
use crate::wave::grid::field::Field;
use crate::wave::grid::heights::Heights;

/// Node–point pairs per second that one core sums; shapes predictions only.
pub(crate) const PAIRS_PER_SECOND: f64 = 1.5e8;

/// The lit nodes of a field, in columns padded to a multiple of eight with nodes of no amplitude.
///
/// The columns hold x, y, z in mm, the slopes ∂z/∂x, ∂z/∂y and the amplitude times the node's area over
/// the local plane in mm².
pub struct Emitters {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    slope_x: Vec<f64>,
    slope_y: Vec<f64>,
    re: Vec<f64>,
    im: Vec<f64>,
    lit: usize,
}

/// One node of a lit screen.
#[derive(Clone, Copy, Debug, Default)]
pub struct Emitter {
    /// x, y and height over the local plane, in mm.
    pub at: [f64; 3],
    /// Slopes of the screen there.
    pub slope: [f64; 2],
    /// Field times the node's area over the local plane, in mm².
    pub strength: Complex64,
}

impl Emitters {
    /// The nodes of a field that are not dark, on a screen with these heights.
    pub fn new(field: &Field, heights: &Heights) -> Self {
        let grid = &field.grid;
        let [sx, sy] = &heights.slope;
        let lit = field
            .values
            .indexed_iter()
            .filter(|(_, u)| **u != Complex64::ZERO);
        Self::of_nodes(lit.map(|((j, i), value)| Emitter {
            at: [grid.x.node(i), grid.y.node(j), heights.z[[j, i]]],
            slope: [sx[[j, i]], sy[[j, i]]],
            strength: value * (grid.x.weight(i) * grid.y.weight(j)),
        }))
    }

    /// These emitters.
    pub fn of_nodes(nodes: impl Iterator<Item = Emitter>) -> Self {
        let mut emitters = Self {
            x: Vec::new(),
            y: Vec::new(),
            z: Vec::new(),
            slope_x: Vec::new(),
            slope_y: Vec::new(),
            re: Vec::new(),
            im: Vec::new(),
            lit: 0,
        };
        for node in nodes {
            emitters.push(node);
        }
        emitters.lit = emitters.x.len();
        while !emitters.x.len().is_multiple_of(LANES) {
            emitters.push(Emitter::default());
        }
        emitters
    }

    fn push(&mut self, node: Emitter) {
        let [x, y, z] = node.at;
        self.x.push(x);
        self.y.push(y);
        self.z.push(z);
        self.slope_x.push(node.slope[0]);
        self.slope_y.push(node.slope[1]);
        self.re.push(node.strength.re);
        self.im.push(node.strength.im);
    }

    /// Number of lit nodes; a sum costs this many pairs per point.
    pub fn len(&self) -> usize {
        self.lit
    }

    /// Whether all is dark.
    pub fn is_empty(&self) -> bool {
        self.lit == 0
    }

    /// The field at points (x, y, z) in front of the screen, in mm, in a medium where light has the given
    /// `wavelength` (vacuum wavelength over index, mm). The same bits for any number of threads.
    pub fn field_at(&self, points: &[[f64; 3]], wavelength: f64) -> Vec<Complex64> {
        let level = level();
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
        let (px, py, pz) = (splat(px), splat(py), splat(pz));
        let (mut re, mut im) = (splat(0.0), splat(0.0));
        for first in (0..self.x.len()).step_by(LANES) {
            let column = |values: &[f64]| f64x8::from_slice(simd, &values[first..first + LANES]);
            let dx = px - column(&self.x);
            let dy = py - column(&self.y);
            let dz = pz - column(&self.z);
            let distance = (dx * dx + dy * dy + dz * dz).sqrt();
            let inverse = one / distance;
            let (cos, sin) = cis_turns(distance * per_wavelength);

            // N·(P−X) e^{ikr} (1/r − ik)/r², times the node's strength.
            let lift = dz - column(&self.slope_x) * dx - column(&self.slope_y) * dy;
            let falloff = lift * inverse * inverse;
            let kernel_re = falloff * (cos * inverse + sin * k);
            let kernel_im = falloff * (sin * inverse - cos * k);
            let (strength_re, strength_im) = (column(&self.re), column(&self.im));
            re += kernel_re * strength_re - kernel_im * strength_im;
            im += kernel_re * strength_im + kernel_im * strength_re;
        }
        let total = |sum: f64x8<S>| sum.as_array().iter().sum::<f64>();
        Complex64::new(total(re), total(im)) / std::f64::consts::TAU
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::wave::free::rayleigh::{Emitter, Emitters};
    use crate::wave::grid::field::Axis;

    /// A uniformly lit disc: Gauss nodes along the radius, equal steps around.
    fn disc(radius: f64) -> Emitters {
        let rings = Axis::gauss(24, radius / 24.0, 0.5 * radius, 8);
        let spokes = 16;
        let nodes = (0..rings.len() * spokes).map(|n| {
            let (ring, spoke) = (n / spokes, n % spokes);
            let r = rings.node(ring);
            let (sin, cos) = (std::f64::consts::TAU * spoke as f64 / spokes as f64).sin_cos();
            let area = r * rings.weight(ring) * std::f64::consts::TAU / spokes as f64;
            Emitter {
                at: [r * cos, r * sin, 0.0],
                slope: [0.0; 2],
                strength: Complex64::new(area, 0.0),
            }
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
            let field = disc(radius).field_at(&[[0.0, 0.0, z]], wavelength)[0];
            let error = (field - exact).norm();
            assert!(error < 1e-12 + 2e-16 * k * z, "{z}: {error:e}");
        }
    }

    /// Light that converges from a spherical cap to its centre: on the axis every node is as far away, and
    /// N·(P−X)/r dA is the cap's own area R²dΩ, so U = (1/R − ik)e^{ikR}R·(1 − cos θ) for amplitude one.
    #[test]
    fn a_cap_shines_into_its_centre() {
        let (wavelength, radius, half) = (1.0, 300.0f64, 90.0f64);
        let k = std::f64::consts::TAU / wavelength;
        let rings = Axis::gauss(200, half / 200.0, 0.5 * half, 4);
        let nodes = (0..rings.len() * 24).map(|n| {
            let (ring, spoke) = (n / 24, n % 24);
            let r = rings.node(ring);
            let (sin, cos) = (std::f64::consts::TAU * spoke as f64 / 24.0).sin_cos();
            let depth = (radius * radius - r * r).sqrt();
            Emitter {
                at: [r * cos, r * sin, radius - depth],
                slope: [r * cos / depth, r * sin / depth],
                strength: Complex64::new(
                    r * rings.weight(ring) * std::f64::consts::TAU / 24.0,
                    0.0,
                ),
            }
        });
        let field = Emitters::of_nodes(nodes).field_at(&[[0.0, 0.0, radius]], wavelength)[0];
        let open = 1.0 - (1.0 - (half / radius).powi(2)).sqrt();
        let exact = Complex64::new(1.0 / radius, -k) * Complex64::cis(k * radius) * radius * open;
        assert!(
            (field - exact).norm() < 1e-9 * exact.norm(),
            "{field} {exact}"
        );
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
            pool.install(|| emitters.field_at(&points, 0.7e-3))
        };
        assert_eq!(run(1), run(3));
    }
}
