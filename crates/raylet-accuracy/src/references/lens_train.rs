//! A train of pixel planes and small, strongly refracting lenses, carried from screen to
//! screen by plane waves and surface integrals.
//!
//! Accuracy: the discretisation converges as described at each setting of [`LensTrain`]; the physics is
//! exact for scalar waves in free space and through plane faces, and Kirchhoff's at a curved
//! interface (a field that is continuous, with unit transmission, zero outside the aperture), in
//! error there by about χ²/(k n R).

use num_complex::Complex64;

use crate::numerics::dense::{fourier_kernel, separable};
use crate::numerics::pixels::Pixels;
use crate::references::interface::{plane_to_surface, surface_to_plane};
use crate::references::spectrum::{Lattice, PeriodTooShort, Slab, Spectrum};
use crate::references::surface::{Sag, SurfaceSamples};

/// The numerical settings, each an argument so that its effect can be shown.
#[derive(Clone, Copy, Debug)]
pub struct LensTrain {
    /// Vacuum wavelength λ.
    pub wavelength: f64,
    /// Period P of the plane-wave lattice: six times the sum of the half widths of the widest hop
    /// leaves some 5e-5, four times 7e-4.
    pub period: f64,
    /// Samples N per period on lens surfaces, a product of small primes. Pitches P/N of λ/2, λ/3,
    /// λ/4, λ/5 leave 2e-3, 3e-4, 5e-5, 1e-5 at worst, mostly from the rim; never above λ/2.
    pub samples: usize,
    /// Largest |p| per axis carried: 1 for trains that begin and end in air.
    pub reach: f64,
    /// Chebyshev nodes beyond the least, in units of (1 + a)^⅓: 5 leaves 1e-6.
    pub extra: f64,
    /// Points per axis of the rim's quadrature: 1 covered area (2e-3 at λ/3), 6 or 8 an accurate
    /// edge.
    pub stencil: usize,
    /// Gauss–Legendre nodes per pixel and axis for pixels that are not the first screen.
    pub pixel_nodes: usize,
}

/// The first screen, at z = 0 in air, lit by a plane wave exp(ik tilt·x).
#[derive(Clone, Copy)]
pub enum Source<'a> {
    /// Box pixels.
    Pixels(&'a Pixels, [f64; 2]),
    /// A hard disc of this radius.
    Disc(f64, [f64; 2]),
    /// A hard disc of this radius with a thin, smooth phase over it.
    Phase(f64, PhaseFunction<'a>, [f64; 2]),
}

/// A function (x, y) ↦ phase in radians.
pub type PhaseFunction<'a> = &'a (dyn Fn(f64, f64) -> f64 + Sync);

/// What comes after, in order.
#[derive(Clone, Copy)]
pub enum Step<'a> {
    /// Flight over an axial distance in the medium at hand.
    Drift(f64),
    /// A plane face into a medium of this index.
    Face(f64),
    /// A curved face into a medium of index `index`, opaque beyond `semi_aperture`.
    Surface {
        /// Its shape, from the vertex.
        sag: Sag<'a>,
        /// Radius of its rim.
        semi_aperture: f64,
        /// Refractive index behind it.
        index: f64,
    },
    /// A plane of box pixels, opaque outside.
    Pixels(&'a Pixels),
}

/// A plano-convex lens in air.
#[derive(Clone, Copy, Debug)]
pub struct PlanoConvex {
    /// Radius of curvature, positive.
    pub radius: f64,
    /// Thickness on the axis.
    pub thickness: f64,
    /// Refractive index.
    pub index: f64,
    /// Radius of the convex side's rim.
    pub semi_aperture: f64,
    /// Axial distance from the screen before it.
    pub gap_before: f64,
}

impl PlanoConvex {
    /// The convex side towards the light.
    pub fn convex_first(&self) -> Vec<Step<'static>> {
        let sag = Sag::Sphere(self.radius);
        vec![
            Step::Drift(self.gap_before),
            Step::Surface {
                sag,
                semi_aperture: self.semi_aperture,
                index: self.index,
            },
            Step::Drift(self.thickness),
            Step::Face(1.0),
        ]
    }

    /// The plane side towards the light.
    pub fn plane_first(&self) -> Vec<Step<'static>> {
        let sag = Sag::Sphere(-self.radius);
        vec![
            Step::Drift(self.gap_before),
            Step::Face(self.index),
            Step::Drift(self.thickness),
            Step::Surface {
                sag,
                semi_aperture: self.semi_aperture,
                index: 1.0,
            },
        ]
    }
}

/// Plane waves on their way: where they began and what they have crossed since.
struct Flight {
    spectrum: Spectrum,
    /// Half width of the screen behind.
    half_width: f64,
    /// Slabs since; the last one's index is the medium at hand.
    slabs: Vec<Slab>,
}

impl Flight {
    fn new(spectrum: Spectrum, half_width: f64) -> Self {
        let slabs = vec![Slab {
            index: spectrum.index,
            thickness: 0.0,
        }];
        Self {
            spectrum,
            half_width,
            slabs,
        }
    }

    /// Refractive index of the medium at hand.
    fn index(&self) -> f64 {
        self.slabs
            .last()
            .map_or(self.spectrum.index, |slab| slab.index)
    }

    /// Arrives at a screen of half width `half_width` in the plane at hand.
    fn arrive(self, half_width: f64) -> Result<Spectrum, PeriodTooShort> {
        self.spectrum
            .through(&self.slabs, self.half_width + half_width)
    }
}

impl LensTrain {
    /// Settings that leave discretisation errors of about 1e-5 in the field for trains in air of
    /// index up to 1.5 (the `convergence` example), given a sufficient `period`.
    pub fn converged(wavelength: f64, period: f64) -> Self {
        let samples = (5.0 * period / wavelength).round() as usize;
        Self {
            wavelength,
            period,
            samples,
            reach: 1.0,
            extra: 6.0,
            stencil: 8,
            pixel_nodes: 10,
        }
    }

    /// The plane waves at the plane where `steps` end, right for a sensor within
    /// `sensor_half_width` of the axis there (per axis): see [`Spectrum::on_grid`] and
    /// [`Spectrum::at_points`]. The phase counts from z = 0. Fails if the period is shorter than
    /// twice the sum of two consecutive screens' half widths.
    pub fn run(
        &self,
        source: Source,
        steps: &[Step],
        sensor_half_width: f64,
    ) -> Result<Spectrum, PeriodTooShort> {
        let mut flight = self.start(source);
        for step in steps {
            flight = match *step {
                Step::Drift(distance) => {
                    let index = flight.index();
                    flight.slabs.push(Slab {
                        index,
                        thickness: distance,
                    });
                    flight
                }
                Step::Face(index) => {
                    flight.slabs.push(Slab {
                        index,
                        thickness: 0.0,
                    });
                    flight
                }
                Step::Surface {
                    sag,
                    semi_aperture,
                    index,
                } => {
                    let surface = SurfaceSamples::new(
                        self.period,
                        self.samples,
                        semi_aperture,
                        self.stencil,
                        sag,
                    );
                    let arrived = flight.arrive(semi_aperture)?;
                    let field = plane_to_surface(&arrived, &surface, self.extra);
                    let behind =
                        surface_to_plane(&field, &surface, arrived.lattice, index, self.extra);
                    Flight::new(behind, semi_aperture)
                }
                Step::Pixels(pixels) => {
                    let half_width = pixels.half_width();
                    let arrived = flight.arrive(half_width)?;
                    Flight::new(self.modulate(&arrived, pixels), half_width)
                }
            };
        }
        flight.arrive(sensor_half_width)
    }

    /// The first screen's plane waves.
    fn start(&self, source: Source) -> Flight {
        let lattice = Lattice::new(self.wavelength, self.period, self.reach);
        match source {
            Source::Pixels(pixels, tilt) => Flight::new(
                Spectrum::from_pixels(lattice, 1.0, pixels, tilt),
                pixels.half_width(),
            ),
            Source::Disc(radius, tilt) => {
                Flight::new(Spectrum::from_disc(lattice, 1.0, radius, tilt), radius)
            }
            Source::Phase(radius, phase, tilt) => {
                let (period, samples) = (self.period, self.samples);
                let disc = SurfaceSamples::new(period, samples, radius, self.stencil, Sag::Flat);
                let k = std::f64::consts::TAU / self.wavelength;
                let field = |[x, y, _]: &[f64; 3]| {
                    Complex64::cis(phase(*x, *y) + k * (tilt[0] * x + tilt[1] * y))
                };
                let field: Vec<Complex64> = disc.points.iter().map(field).collect();
                let spectrum = surface_to_plane(&field, &disc, lattice, 1.0, self.extra);
                Flight::new(spectrum, radius)
            }
        }
    }

    /// The plane waves behind `pixels`: the field at each pixel's Gauss nodes, times the
    /// transmission, integrated against each plane wave.
    fn modulate(&self, arrived: &Spectrum, pixels: &Pixels) -> Spectrum {
        let (rows, columns) = pixels.transmission.dim();
        let (y, x) = (
            pixels.nodes(rows, self.pixel_nodes),
            pixels.nodes(columns, self.pixel_nodes),
        );
        let mut field = arrived.on_grid(&y.positions, &x.positions);
        for ((row, column), value) in field.indexed_iter_mut() {
            let pixel = [row / y.per_pixel, column / x.per_pixel];
            *value *= pixels.transmission[pixel] * (y.weights[row] * x.weights[column]);
        }
        let p = arrived.lattice.directions();
        let kernel = |at| fourier_kernel(&p, at, -1.0 / self.wavelength);
        let modes = separable(&kernel(&y.positions), &field, &kernel(&x.positions));
        let cell = arrived.lattice.period * arrived.lattice.period;
        Spectrum {
            modes: modes / Complex64::from(cell),
            ..*arrived
        }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::numerics::pixels::Pixels;
    use crate::references::lens_train::{LensTrain, PlanoConvex, Source, Step};
    use crate::references::rayleigh_sommerfeld::rayleigh_sommerfeld;
    use crate::references::spectrum::PeriodTooShort;

    const TRAIN: LensTrain = LensTrain {
        wavelength: 1.0,
        period: 150.0,
        samples: 450,
        reach: 1.0,
        extra: 5.0,
        stencil: 6,
        pixel_nodes: 8,
    };

    /// A phase k·(a·x + b·y) over a disc is the disc under light from that direction.
    #[test]
    fn linear_phase_is_a_tilt() {
        let phase = |x: f64, y: f64| std::f64::consts::TAU * (0.12 * x - 0.07 * y);
        let sources = [
            Source::Phase(14.0, &phase, [0.03, 0.02]),
            Source::Disc(14.0, [0.15, -0.05]),
        ];
        let x = ndarray::Array1::linspace(-9.0, 9.0, 7);
        let [ours, exact] = sources.map(|source| {
            let spectrum = TRAIN.run(source, &[Step::Drift(30.0)], 10.0).unwrap();
            spectrum.on_grid(&x, &x)
        });
        let off = (&ours - &exact).iter().map(|u| u.norm_sqr()).sum::<f64>();
        let norm = exact.iter().map(|u| u.norm_sqr()).sum::<f64>();
        assert!((off / norm).sqrt() < 1e-3, "{:e}", (off / norm).sqrt());
    }

    /// Relative L2 distance of `a` from `b`.
    fn distance(a: &[Complex64], b: &[Complex64]) -> f64 {
        let off: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_sqr()).sum();
        (off / b.iter().map(|b| b.norm_sqr()).sum::<f64>()).sqrt()
    }

    fn scrambled(count: usize, pitch: f64) -> Pixels {
        let phase = |i: usize, j: usize| (5 * i * i + 3 * j * i + 2 * j) as f64;
        Pixels {
            pitch,
            transmission: Array2::from_shape_fn((count, count), |(i, j)| {
                Complex64::cis(phase(i, j))
            }),
        }
    }

    /// Points on a sensor at height z = 0, tilted about y.
    fn sensor() -> Vec<[f64; 3]> {
        (0..100)
            .map(|i| (f64::from(i % 10) - 4.5, f64::from(i / 10) - 4.5))
            .map(|(x, y)| [x, y, 0.2 * x])
            .collect()
    }

    /// A lens of index 1 leaves light from pixels as it is in free space, but for what passes
    /// its rim and for the curvature's second-order term.
    #[test]
    fn a_lens_of_air_is_free_space_slow() {
        // A soft-edged beam, little of which meets the rim.
        let mut pixels = scrambled(40, 0.5);
        for ((i, j), value) in pixels.transmission.indexed_iter_mut() {
            let (y, x) = ((i as f64 - 19.5) / 8.0, (j as f64 - 19.5) / 8.0);
            *value = Complex64::from_polar((-x * x - y * y).exp(), (2.0 * x).sin() + x * y);
        }
        let lens = PlanoConvex {
            radius: 120.0,
            thickness: 8.0,
            index: 1.0,
            semi_aperture: 28.0,
            gap_before: 12.0,
        };
        let at: Vec<_> = sensor()
            .iter()
            .map(|[x, y, z]| [*x, *y, z + 40.0])
            .collect();
        let exact = rayleigh_sommerfeld(&pixels, [0.1, 0.05], 1.0, 14, &at);
        for mut steps in [lens.convex_first(), lens.plane_first()] {
            steps.push(Step::Drift(20.0));
            let behind = TRAIN
                .run(Source::Pixels(&pixels, [0.1, 0.05]), &steps, 6.0)
                .unwrap();
            let error = distance(&behind.at_points(&sensor(), 1e-9), &exact);
            assert!(error < 2.8e-5, "{error:e}");
        }
    }

    /// Two pixel planes in a row equal two Rayleigh–Sommerfeld sums.
    #[test]
    fn pixels_behind_pixels_equal_direct_sums() {
        let (first, second) = (scrambled(16, 0.5), scrambled(8, 1.0));
        let steps = [Step::Drift(9.0), Step::Pixels(&second), Step::Drift(15.0)];
        let behind = TRAIN
            .run(Source::Pixels(&first, [0.0, 0.0]), &steps, 6.0)
            .unwrap();

        // The field at the nodes of the second plane, then each node as a source of its own.
        let nodes = second.nodes(8, 8);
        let mut at = vec![];
        for y in &nodes.positions {
            at.extend(nodes.positions.iter().map(|x| [*x, *y, 9.0]));
        }
        let field = rayleigh_sommerfeld(&first, [0.0, 0.0], 1.0, 6, &at);
        let k = std::f64::consts::TAU;
        let radiate = |to: &[f64; 3]| -> Complex64 {
            let parts = field.iter().enumerate().map(|(node, value)| {
                let (row, column) = (node / 64, node % 64);
                let area = nodes.weights[row] * nodes.weights[column];
                let depth = 15.0 + to[2];
                let r = (to[0] - at[node][0])
                    .hypot(to[1] - at[node][1])
                    .hypot(depth);
                let kernel =
                    Complex64::cis(k * r) * Complex64::new(1.0 / r, -k) * (depth / (r * r * k));
                value * second.transmission[[row / 8, column / 8]] * kernel * area
            });
            parts.sum()
        };
        let exact: Vec<_> = sensor().iter().map(radiate).collect();
        let error = distance(&behind.at_points(&sensor(), 1e-9), &exact);
        assert!(error < 1e-4, "{error:e}");
    }

    #[test]
    fn a_wide_screen_needs_a_long_period() {
        let result = TRAIN.run(Source::Disc(40.0, [0.0, 0.0]), &[Step::Drift(9.0)], 36.0);
        assert_eq!(
            result.unwrap_err(),
            PeriodTooShort {
                period: 150.0,
                least: 152.0
            }
        );
    }
}
