//! The plane waves of a field of limited extent, on a square lattice of directions.
//!
//! U(x, y, z) = Σ A(p) e^{ik(p·x + q z)}, p on the lattice λ/P·(integers), |p| < n: a field of
//! period P, equal to the true one where the copies do not reach ([`Spectrum::through`]).

use fearless_simd::{Level, Simd, dispatch};
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::numerics::dense::{fourier_kernel, separable};
use crate::numerics::disc::disc_transform;
use crate::numerics::phase::cis_turns;
use crate::numerics::pixels::Pixels;

/// Modes handled side by side by the sum at points.
const LANES: usize = 8;

/// Directions p = λ/P·(−half ..= half) along both axes.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    /// Vacuum wavelength λ.
    pub wavelength: f64,
    /// Period P of the field.
    pub period: f64,
    /// Largest index along an axis.
    pub half: usize,
}

impl Lattice {
    /// The lattice of all |p| ≤ `reach` per axis.
    pub fn new(wavelength: f64, period: f64, reach: f64) -> Self {
        let half = (reach * period / wavelength) as usize;
        Self {
            wavelength,
            period,
            half,
        }
    }

    /// The directions along one axis.
    pub fn directions(&self) -> Array1<f64> {
        let step = self.wavelength / self.period;
        Array1::from_shape_fn(2 * self.half + 1, |i| (i as f64 - self.half as f64) * step)
    }
}

/// A plane-parallel layer: refractive index and thickness (negative: backwards).
#[derive(Clone, Copy, Debug)]
pub struct Slab {
    /// Refractive index.
    pub index: f64,
    /// Thickness.
    pub thickness: f64,
}

/// The period is too short for the widths of the screens at both ends of a hop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodTooShort {
    /// The requested period.
    pub period: f64,
    /// The period must exceed this; four times half of it is advised.
    pub least: f64,
}

/// Plane waves on a lattice, with their phases at one plane.
#[derive(Clone, Debug)]
pub struct Spectrum {
    /// The directions.
    pub lattice: Lattice,
    /// Refractive index of the medium at the plane.
    pub index: f64,
    /// Amplitudes A [p_y, p_x], zero for |p| ≥ index.
    pub modes: Array2<Complex64>,
}

impl Spectrum {
    /// The spectrum of `pixels` lit by exp(ik `tilt`·x), exact for box pixels:
    /// A(p) = (1/P²) Σ T e^{−ik(p−tilt)·x_c} times the pixel's sinc per axis.
    pub fn from_pixels(lattice: Lattice, index: f64, pixels: &Pixels, tilt: [f64; 2]) -> Self {
        let (rows, columns) = pixels.transmission.dim();
        let kernel = |count, tilt| {
            // The integral over each pixel, per mode.
            let p = lattice.directions() - tilt;
            let per_wavelength = 1.0 / lattice.wavelength;
            let mut kernel = fourier_kernel(&p, &pixels.centres(count), -per_wavelength);
            for (mut row, p) in kernel.outer_iter_mut().zip(&p) {
                let phase = std::f64::consts::PI * p * pixels.pitch * per_wavelength;
                let sinc = if phase == 0.0 {
                    1.0
                } else {
                    phase.sin() / phase
                };
                row *= Complex64::from(sinc * pixels.pitch / lattice.period);
            }
            kernel
        };
        let modes = separable(
            &kernel(rows, tilt[1]),
            &pixels.transmission,
            &kernel(columns, tilt[0]),
        );
        Self {
            lattice,
            index,
            modes,
        }
        .propagating()
    }

    /// The spectrum of a hard disc of radius `radius` lit by exp(ik `tilt`·x).
    pub fn from_disc(lattice: Lattice, index: f64, radius: f64, tilt: [f64; 2]) -> Self {
        let p = lattice.directions();
        let k = std::f64::consts::TAU / lattice.wavelength;
        let modes = Array2::from_shape_fn((p.len(), p.len()), |(row, column)| {
            let offset = (p[column] - tilt[0]).hypot(p[row] - tilt[1]);
            let value = disc_transform(radius, k * offset);
            Complex64::from(value / (lattice.period * lattice.period))
        });
        Self {
            lattice,
            index,
            modes,
        }
        .propagating()
    }

    /// The square of the normal direction cosine, q² = n² − |p|², per mode [p_y, p_x].
    fn normal_squared(&self, index: f64) -> Array2<f64> {
        let p = self.lattice.directions();
        Array2::from_shape_fn((p.len(), p.len()), |(row, column)| {
            index * index - p[row] * p[row] - p[column] * p[column]
        })
    }

    /// Normal direction cosine q per mode [p_y, p_x]; zero where evanescent.
    pub fn normal(&self) -> Array2<f64> {
        self.normal_squared(self.index)
            .mapv(|square| square.max(0.0).sqrt())
    }

    /// Drops what does not propagate.
    fn propagating(mut self) -> Self {
        let square = self.normal_squared(self.index);
        self.modes.zip_mut_with(&square, |mode, square| {
            if *square <= 0.0 {
                *mode = Complex64::new(0.0, 0.0);
            }
        });
        self
    }

    /// The field's energy over a period, Σ|A|²·P².
    pub fn energy(&self) -> f64 {
        let sum: f64 = self.modes.iter().map(|mode| mode.norm_sqr()).sum();
        sum * self.lattice.period * self.lattice.period
    }

    /// The plane waves behind plane-parallel `slabs`, A·e^{ik Σ q_i d_i}, p conserved and unit
    /// field transmission at their faces; the index becomes the last slab's. Modes that cannot
    /// reach the target, or would reach it as a periodic copy, fade out (see `Taper`); `width` is
    /// the sum of the half widths per axis of the screen where the field began and of the one it
    /// goes to. Fails if P ≤ 2·`width`.
    pub fn through(mut self, slabs: &[Slab], width: f64) -> Result<Self, PeriodTooShort> {
        let taper = Taper::new(self.lattice, slabs, width)?;
        let p = self.lattice.directions();
        let per_wavelength = 1.0 / self.lattice.wavelength;
        for ((row, column), mode) in self.modes.indexed_iter_mut() {
            let square = p[row] * p[row] + p[column] * p[column];
            let (mut path, mut landing) = (0.0, 0.0);
            for slab in slabs {
                // The root of a negative number, not a number, marks an evanescent wave.
                let q = (slab.index * slab.index - square).sqrt();
                path += q * slab.thickness;
                landing += slab.thickness / q;
            }
            let kept = taper.weight(landing * p[row]) * taper.weight(landing * p[column]);
            let (c, s) = cis_turns(path * per_wavelength);
            *mode = if kept > 0.0 {
                *mode * Complex64::new(c, s) * kept
            } else {
                Complex64::ZERO
            };
        }
        if let Some(last) = slabs.last() {
            self.index = last.index;
        }
        Ok(self.propagating())
    }

    /// The field [y, x] at positions `y` × `x` in the spectrum's own plane.
    pub fn on_grid(&self, y: &Array1<f64>, x: &Array1<f64>) -> Array2<Complex64> {
        let p = self.lattice.directions();
        let per_wavelength = 1.0 / self.lattice.wavelength;
        let kernel = |at: &Array1<f64>| fourier_kernel(at, &p, per_wavelength);
        separable(&kernel(y), &self.modes, &kernel(x))
    }

    /// The field at any `points` (x, y, z), z from the spectrum's plane and small beside the last
    /// hop (a tilted sensor), from the modes with |A| > `threshold`·max|A|.
    pub fn at_points(&self, points: &[[f64; 3]], threshold: f64) -> Vec<Complex64> {
        let (significant, level) = (self.significant(threshold), Level::new());
        let sum = |point: &[f64; 3]| {
            let turns = point.map(|length| length / self.lattice.wavelength);
            dispatch!(level, simd => sum(simd, &significant, turns))
        };
        points.par_iter().map(sum).collect()
    }

    /// Blocks of modes (p_x, p_y, q, Re A, Im A), the last filled up with modes of no amplitude.
    fn significant(&self, threshold: f64) -> Vec<[[f64; LANES]; 5]> {
        let largest = self
            .modes
            .iter()
            .map(|mode| mode.norm())
            .fold(0.0, f64::max);
        let p = self.lattice.directions();
        let q = self.normal();
        let kept: Vec<_> = self
            .modes
            .indexed_iter()
            .filter(|(_, mode)| mode.norm() > threshold * largest)
            .map(|((row, column), mode)| [p[column], p[row], q[[row, column]], mode.re, mode.im])
            .collect();
        kept.chunks(LANES)
            .map(|modes| {
                let mut block = [[0.0; LANES]; 5];
                for (lane, mode) in modes.iter().enumerate() {
                    for part in 0..5 {
                        block[part][lane] = mode[part];
                    }
                }
                block
            })
            .collect()
    }
}

/// The weight of a mode by how far it lands, L = Σ d_i p_axis/q_i per axis.
///
/// It is 1 where L ≤ W + margin, W the sum of the half widths of both screens, and 0 where
/// L ≥ P − W: there the first periodic copy reaches the target. Between, it falls as a septic
/// smoothstep *in the cosine of the landing angle*, D/√(D² + L²) with D = Σ d_i/n_i: the phase of
/// grazing modes runs evenly in that cosine, so that the fade is slow beside it everywhere. (A
/// fade in L itself crowds its grazing end and leaves 3e-4 where this leaves 2e-6.)
/// The margin is 1.5√(λD), at most a quarter of what is left, P − 2W.
struct Taper {
    depth: f64,
    /// Cosine down to which a mode keeps its weight.
    full: f64,
    /// Cosine from which it has none.
    none: f64,
}

impl Taper {
    fn new(lattice: Lattice, slabs: &[Slab], width: f64) -> Result<Self, PeriodTooShort> {
        let spare = lattice.period - 2.0 * width;
        if spare <= 0.0 {
            return Err(PeriodTooShort {
                period: lattice.period,
                least: 2.0 * width,
            });
        }
        let depth: f64 = slabs
            .iter()
            .map(|slab| slab.thickness / slab.index)
            .sum::<f64>()
            .abs();
        let margin = (1.5 * (lattice.wavelength * depth).sqrt()).min(0.25 * spare);
        let cosine = |landing: f64| depth / depth.hypot(landing);
        Ok(Self {
            depth,
            full: cosine(width + margin),
            none: cosine(width + spare),
        })
    }

    /// The weight along one axis; none for an evanescent mode, whose landing is not a number.
    fn weight(&self, landing: f64) -> f64 {
        if landing.is_nan() {
            return 0.0;
        }
        // Over no distance nothing lands elsewhere.
        if landing == 0.0 {
            return 1.0;
        }
        let cosine = self.depth / self.depth.hypot(landing);
        let t = ((cosine - self.none) / (self.full - self.none)).clamp(0.0, 1.0);
        t.powi(4) * (35.0 + t * (-84.0 + t * (70.0 - 20.0 * t)))
    }
}

/// The sum of plane waves at one point, in wavelengths, with the machine's widest vectors.
#[inline(always)]
fn sum<S: Simd>(_: S, blocks: &[[[f64; LANES]; 5]], turns: [f64; 3]) -> Complex64 {
    let (mut real, mut imaginary) = ([0.0; LANES], [0.0; LANES]);
    for modes in blocks {
        for lane in 0..LANES {
            let [px, py, q, re, im] = [0, 1, 2, 3, 4].map(|part| modes[part][lane]);
            let (c, s) = cis_turns(turns[0] * px + turns[1] * py + turns[2] * q);
            real[lane] += c * re - s * im;
            imaginary[lane] += c * im + s * re;
        }
    }
    Complex64::new(real.iter().sum(), imaginary.iter().sum())
}

#[cfg(test)]
mod tests {
    use ndarray::{Array1, Array2};
    use num_complex::Complex64;

    use crate::numerics::pixels::Pixels;
    use crate::references::rayleigh_sommerfeld::rayleigh_sommerfeld;
    use crate::references::spectrum::{Lattice, PeriodTooShort, Slab, Spectrum};

    /// Pixels of 0.7λ with scrambled phases.
    fn scrambled() -> Pixels {
        Pixels {
            pitch: 0.7,
            transmission: Array2::from_shape_fn((24, 24), |(i, j)| {
                Complex64::cis((5 * i * i + 3 * j * i) as f64)
            }),
        }
    }

    /// Relative L2 distance of `a` from `b`.
    fn distance(a: &[Complex64], b: &[Complex64]) -> f64 {
        let off: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_sqr()).sum();
        (off / b.iter().map(|b| b.norm_sqr()).sum::<f64>()).sqrt()
    }

    /// Behind pixels of 17λ, oblique light, a tilted sensor 40λ away: error per period.
    #[test]
    fn free_space_equals_rayleigh_sommerfeld_slow() {
        let points: Vec<_> = (0..400)
            .map(|i| {
                let (x, y) = (f64::from(i % 20) - 9.5, f64::from(i / 20) - 9.5);
                [x, y, 40.0 + 0.3 * x]
            })
            .collect();
        let pixels = scrambled();
        let exact = rayleigh_sommerfeld(&pixels, [0.2, 0.1], 1.0, 6, &points);
        for (period, bound) in [(80.0, 7e-4), (120.0, 5e-5), (240.0, 2.1e-6)] {
            let near: Vec<_> = points.iter().map(|[x, y, z]| [*x, *y, z - 40.0]).collect();
            let spectrum =
                Spectrum::from_pixels(Lattice::new(1.0, period, 1.0), 1.0, &pixels, [0.2, 0.1]);
            let behind = spectrum
                .through(
                    &[Slab {
                        index: 1.0,
                        thickness: 40.0,
                    }],
                    19.0,
                )
                .unwrap();
            let error = distance(&behind.at_points(&near, 0.0), &exact);
            assert!(error < bound, "{period}: {error:e}");
        }
    }

    #[test]
    fn grid_and_points_agree() {
        let spectrum =
            Spectrum::from_pixels(Lattice::new(0.5, 40.0, 1.0), 1.0, &scrambled(), [0.0, 0.0]);
        let (x, y) = (
            Array1::linspace(-3.0, 4.0, 5),
            Array1::linspace(-2.0, 2.0, 4),
        );
        let grid = spectrum.on_grid(&y, &x);
        for ((row, column), value) in grid.indexed_iter() {
            let at = spectrum.at_points(&[[x[column], y[row], 0.0]], 0.0)[0];
            assert!((at - value).norm() < 1e-11);
        }
    }

    #[test]
    fn short_periods_are_refused() {
        let spectrum = Spectrum::from_disc(Lattice::new(1.0, 30.0, 1.0), 1.0, 8.0, [0.0, 0.0]);
        let result = spectrum.through(
            &[Slab {
                index: 1.0,
                thickness: 5.0,
            }],
            16.0,
        );
        assert_eq!(
            result.unwrap_err(),
            PeriodTooShort {
                period: 30.0,
                least: 32.0
            }
        );
    }
}
