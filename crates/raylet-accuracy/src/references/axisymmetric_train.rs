//! Light through a train that is a figure of revolution, at any size, without rays: Hankel transforms from each surface to
//! the plane waves behind it, and from these to the next surface.
//!
//! A field u(r) e^{imφ} on the surface z = s(r) has the plane waves B(p) of sine p, in a medium of index n with
//! q = √(n² − p²),
//!   B(p) = (2π/λ²) ∫ u(r) e^{−ikq s} [J_m(kpr) − i s′ (p/q) J_m′(kpr)] r dr,
//! and at another surface, d further along the axis, they add to
//!   u(r) = 2π ∫ B(p) e^{ikq(d + s)} J_m(kpr) p dp.
//! These are the integrals of `interface.rs` with the azimuth done in closed form, with the same correction for the curvature of
//! a surface. The field is continuous across an interface (unit transmission), and zero outside each aperture. Evanescent
//! waves and those near to them are left out.
//!
//! The cost is the product of the nodes on a surface and those in the spectrum, both as many as the width has wavelengths: a
//! lens of centimetres takes minutes. No other symmetry than that of the light and the train is used.

use std::f64::consts::TAU;

use fearless_simd::{Level, Simd, dispatch};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::numerics::bessel::bessel_pair;
use crate::numerics::phase::cis_turns;
use crate::numerics::quadrature::gauss_legendre;

/// Nodes of each Gauss–Legendre panel.
const PANEL: usize = 32;

/// Up to this share of the largest angle to the axis, plane waves are kept whole.
const FULL: f64 = 0.75;

/// Terms of a sum that are added side by side.
const LANES: usize = 8;

/// The numerical settings.
#[derive(Clone, Copy, Debug)]
pub struct AxisymmetricTrain {
    /// Vacuum wavelength λ.
    pub wavelength: f64,
    /// Largest optical direction cosine p that is carried; from three quarters of its angle on, plane waves fade out. Light
    /// that an edge sends further aside is left out.
    pub reach: f64,
    /// Nodes in each cycle of the fastest phase under an integral: 2.5 leaves 1e-12.
    pub density: f64,
}

/// A surface, or a screen, around the axis.
#[derive(Clone, Copy)]
pub struct Face<'a> {
    /// Its vertex on the axis; light runs towards +z.
    pub z: f64,
    /// Radius of its aperture.
    pub radius: f64,
    /// Its height over the vertex and its slope, at a radius.
    pub sag: &'a (dyn Fn(f64) -> [f64; 2] + Sync),
    /// The factor of the field at a radius, without that of a vortex.
    pub transmission: &'a (dyn Fn(f64) -> Complex64 + Sync),
    /// Whether it adds a vortex of charge 1: m = 0 before it, m = 1 behind. A train has one at most.
    pub vortex: bool,
    /// Refractive index behind it.
    pub index: f64,
}

/// The samples of a face.
struct Rings {
    radius: Vec<f64>,
    /// Weights of an integral over r dr.
    weight: Vec<f64>,
    height: Vec<f64>,
    slope: Vec<f64>,
    /// Mean curvature.
    curvature: Vec<f64>,
}

/// Plane waves of one sine each.
struct Cones {
    sine: Vec<f64>,
    /// q = √(n² − p²).
    cosine: Vec<f64>,
    /// Weights of an integral over p dp.
    weight: Vec<f64>,
}

/// Light that leaves a face.
struct Light {
    rings: Rings,
    field: Vec<Complex64>,
    z: f64,
    index: f64,
    vortex: bool,
}

/// Plane waves, times their weights, on their way to points `depth` behind the vertex from which they come.
struct Arriving<'a> {
    cones: &'a Cones,
    waves: &'a Parts,
    depth: f64,
    vortex: bool,
}

/// Bessel functions of one sum, or the parts of its kernel; the scratch of a thread.
struct Scratch {
    zero: Vec<f64>,
    one: Vec<f64>,
}

/// Σ (`even` + i `odd`) exp(2πi `rate`·`phase`) `value` over a list.
struct Sum<'a> {
    even: &'a [f64],
    odd: &'a [f64],
    rate: f64,
    phase: &'a [f64],
    value: &'a Parts,
}

/// The parts of complex numbers, each in a list of its own.
struct Parts {
    real: Vec<f64>,
    imaginary: Vec<f64>,
}

impl AxisymmetricTrain {
    /// The field at these radii in the plane at `sensor`, behind faces that a plane wave of amplitude one lights along the
    /// axis, out of the vacuum; its phase is zero at z = 0. Behind a vortex it is u of u(r) e^{iφ}.
    pub fn field(&self, faces: &[Face], sensor: f64, radii: &[f64]) -> Vec<Complex64> {
        let mut before: Option<Light> = None;
        for face in faces {
            let ahead = before.as_ref().map_or(1.0, |light| light.index);
            let rings = self.rings(face, ahead);
            let mut field = match &before {
                None => self.plane_wave(face, &rings),
                Some(light) => self.carried(light, face.z, &rings.radius, &rings.height),
            };
            for (value, r) in field.iter_mut().zip(&rings.radius) {
                *value *= (face.transmission)(*r);
            }
            before = Some(Light {
                rings,
                field,
                z: face.z,
                index: face.index,
                vortex: face.vortex || before.is_some_and(|light| light.vortex),
            });
        }
        let flat = vec![0.0; radii.len()];
        before.map_or(Vec::new(), |light| {
            self.carried(&light, sensor, radii, &flat)
        })
    }

    /// The field at these radii and heights over the plane at `z`, of light that leaves a face.
    fn carried(&self, light: &Light, z: f64, radii: &[f64], heights: &[f64]) -> Vec<Complex64> {
        let depth = z - light.z;
        let widths = [
            extent(&light.rings.radius, &light.rings.height),
            extent(radii, heights),
        ];
        let cones = self.cones(light.index, widths, depth);
        let waves = self.leave(light, &cones);
        let arriving = Arriving {
            cones: &cones,
            waves: &waves,
            depth,
            vortex: light.vortex,
        };
        self.arrive(&arriving, radii, heights)
    }

    /// The light of the source on the first face.
    fn plane_wave(&self, face: &Face, rings: &Rings) -> Vec<Complex64> {
        let wave = |height: &f64| {
            let (cosine, sine) = cis_turns((face.z + height) / self.wavelength);
            Complex64::new(cosine, sine)
        };
        rings.height.iter().map(wave).collect()
    }

    /// The samples of a face, fine enough for the light before it and behind it against each plane wave that is carried.
    fn rings(&self, face: &Face, ahead: f64) -> Rings {
        let steepest = (face.sag)(face.radius)[1].abs();
        let bend = (face.index - ahead).abs() * steepest;
        let rate = (2.0 * self.reach * (1.0 + steepest) + bend) / self.wavelength;
        let nodes = panels(face.radius, rate * face.radius * self.density);
        let step = 1e-6 * face.radius;
        let mut rings = Rings {
            radius: Vec::new(),
            weight: Vec::new(),
            height: Vec::new(),
            slope: Vec::new(),
            curvature: Vec::new(),
        };
        for (r, weight) in nodes {
            let [height, slope] = (face.sag)(r);
            let second = ((face.sag)(r + step)[1] - (face.sag)(r - step)[1]) / (2.0 * step);
            let stretch = 1.0 + slope * slope;
            rings.radius.push(r);
            rings.weight.push(weight * r);
            rings.height.push(height);
            rings.slope.push(slope);
            let curvature = second / stretch.powf(1.5) + slope / (r * stretch.sqrt());
            rings.curvature.push(0.5 * curvature);
        }
        rings
    }

    /// The plane waves between two faces of these extents [radius, height], whose vertices are `depth` apart.
    fn cones(&self, index: f64, faces: [[f64; 2]; 2], depth: f64) -> Cones {
        // In the angle θ to the axis the phase changes at most at the rate k n times the distance of two points of the faces.
        let [from, to] = faces;
        let across = from[0] + to[0];
        let along = depth.abs() + from[1] + to[1];
        let widest = (self.reach / index).min(1.0).asin();
        let cycles = index * across.hypot(along) * widest / self.wavelength;
        let mut cones = Cones {
            sine: Vec::new(),
            cosine: Vec::new(),
            weight: Vec::new(),
        };
        for (angle, weight) in panels(widest, cycles * self.density) {
            let [sine, cosine] = [angle.sin(), angle.cos()].map(|part| index * part);
            cones.sine.push(sine);
            cones.cosine.push(cosine);
            cones
                .weight
                .push(weight * cosine * sine * kept(angle / widest));
        }
        cones
    }

    /// The plane waves behind a face, times their weights in the next integral.
    fn leave(&self, light: &Light, cones: &Cones) -> Parts {
        let rings = &light.rings;
        let reduced = self.wavelength / (TAU * light.index);
        let scale = TAU / (self.wavelength * self.wavelength);
        let value = |(i, field): (usize, &Complex64)| {
            let correction = Complex64::new(1.0, -rings.curvature[i] * reduced);
            *field * correction * (rings.weight[i] * scale)
        };
        let values: Parts = light.field.iter().enumerate().map(value).collect();
        let level = Level::new();
        let wave = |scratch: &mut Scratch, j: usize| {
            let (p, q) = (cones.sine[j], cones.cosine[j]);
            dispatch!(level, simd => self.leaving(simd, scratch, light, [p, q]));
            let sum = Sum {
                even: &scratch.zero,
                odd: &scratch.one,
                rate: -q / self.wavelength,
                phase: &rings.height,
                value: &values,
            };
            dispatch!(level, simd => sum.value(simd)) * (TAU * cones.weight[j])
        };
        let scratch = || Scratch::new(rings.radius.len());
        let all = (0..cones.sine.len()).into_par_iter();
        let waves: Vec<Complex64> = all.map_init(scratch, wave).collect();
        waves.into_iter().collect()
    }

    /// The kernel J_m − i s′ (p/q) J_m′ of a plane wave that leaves, into the scratch.
    #[inline(always)]
    fn leaving<S: Simd>(&self, _: S, scratch: &mut Scratch, light: &Light, [p, q]: [f64; 2]) {
        let rings = &light.rings;
        let rate = p / self.wavelength;
        bessel_pair(rate, &rings.radius, &mut scratch.zero, &mut scratch.one);
        let pairs = scratch.zero.iter_mut().zip(scratch.one.iter_mut());
        for ((zero, one), (r, slope)) in pairs.zip(rings.radius.iter().zip(&rings.slope)) {
            let tilt = -slope * p / q;
            let (even, derivative) = match light.vortex {
                false => (*zero, -*one),
                true => (*one, *zero - *one / (TAU * rate * r)),
            };
            [*zero, *one] = [even, tilt * derivative];
        }
    }

    /// The field of plane waves at these radii and heights.
    fn arrive(&self, light: &Arriving, radii: &[f64], heights: &[f64]) -> Vec<Complex64> {
        let level = Level::new();
        let point = |scratch: &mut Scratch, (r, height): (&f64, &f64)| {
            let rate = r / self.wavelength;
            let Scratch { zero, one } = scratch;
            dispatch!(level, simd => bessels(simd, rate, &light.cones.sine, zero, one));
            if light.vortex {
                std::mem::swap(zero, one);
            }
            one.fill(0.0);
            let sum = Sum {
                even: zero,
                odd: one,
                rate: (light.depth + height) / self.wavelength,
                phase: &light.cones.cosine,
                value: light.waves,
            };
            dispatch!(level, simd => sum.value(simd))
        };
        let scratch = || Scratch::new(light.cones.sine.len());
        let all = radii.par_iter().zip(heights);
        all.map_init(scratch, point).collect()
    }
}

/// [`bessel_pair`] with the machine's widest vectors.
#[inline(always)]
fn bessels<S: Simd>(_: S, rate: f64, at: &[f64], zero: &mut [f64], one: &mut [f64]) {
    bessel_pair(rate, at, zero, one);
}

/// Gauss–Legendre panels over (0, `end`) with at least `count` nodes in all.
fn panels(end: f64, count: f64) -> Vec<(f64, f64)> {
    let rule = gauss_legendre(PANEL);
    let panels = (count / PANEL as f64).ceil().max(1.0) as usize;
    let half = 0.5 * end / panels as f64;
    let nodes = |panel: usize| {
        let middle = half * (2 * panel + 1) as f64;
        let node = move |(at, weight): &(f64, f64)| (middle + half * at, half * weight);
        rule.iter().map(node).collect::<Vec<_>>()
    };
    (0..panels).flat_map(nodes).collect()
}

/// What is kept of a plane wave, by its angle over the largest: all up to [`FULL`], then less and less. At a sharp end the
/// integral would have a wave of its own, as the whole integral has without evanescent waves.
fn kept(angle: f64) -> f64 {
    let x = ((angle - FULL) / (1.0 - FULL)).clamp(0.0, 1.0);
    1.0 - x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
}

/// The largest radius and the largest height of a list of points.
fn extent(radii: &[f64], heights: &[f64]) -> [f64; 2] {
    [radii, heights].map(|list| list.iter().fold(0.0, |most: f64, x| most.max(x.abs())))
}

impl Scratch {
    fn new(length: usize) -> Self {
        Self {
            zero: vec![0.0; length],
            one: vec![0.0; length],
        }
    }
}

impl Sum<'_> {
    /// Its value, with the machine's widest vectors; the lists are whole panels long.
    #[inline(always)]
    fn value<S: Simd>(&self, _: S) -> Complex64 {
        let kernel = blocks(self.even).iter().zip(blocks(self.odd));
        let values = blocks(&self.value.real)
            .iter()
            .zip(blocks(&self.value.imaginary));
        let (mut real, mut imaginary) = ([0.0; LANES], [0.0; LANES]);
        for (phase, ((even, odd), (re, im))) in blocks(self.phase).iter().zip(kernel.zip(values)) {
            for lane in 0..LANES {
                let (cosine, sine) = cis_turns(self.rate * phase[lane]);
                let x = even[lane] * cosine - odd[lane] * sine;
                let y = even[lane] * sine + odd[lane] * cosine;
                real[lane] += x * re[lane] - y * im[lane];
                imaginary[lane] += x * im[lane] + y * re[lane];
            }
        }
        Complex64::new(real.iter().sum(), imaginary.iter().sum())
    }
}

/// A list in blocks of so many terms as are added side by side.
fn blocks(list: &[f64]) -> &[[f64; LANES]] {
    list.as_chunks().0
}

impl FromIterator<Complex64> for Parts {
    fn from_iter<I: IntoIterator<Item = Complex64>>(values: I) -> Self {
        let (real, imaginary) = values.into_iter().map(|value| (value.re, value.im)).unzip();
        Self { real, imaginary }
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::references::axisymmetric_train::{AxisymmetricTrain, Face};
    use crate::references::lens_train::{LensTrain, PlanoConvex, Source, Step};
    use crate::references::surface::Sag;

    const FLAT: fn(f64) -> [f64; 2] = |_| [0.0, 0.0];
    const CLEAR: fn(f64) -> Complex64 = |_| Complex64::ONE;

    /// All directions that propagate.
    const TRAIN: AxisymmetricTrain = AxisymmetricTrain {
        wavelength: 1.0,
        reach: 1.4,
        density: 2.5,
    };

    fn disc(radius: f64) -> Face<'static> {
        Face {
            z: 0.0,
            radius,
            sag: &FLAT,
            transmission: &CLEAR,
            vortex: false,
            index: 1.0,
        }
    }

    /// On the axis behind a disc of radius a: e^{ikz} − z/√(z² + a²) e^{ik√(z² + a²)} (first Rayleigh–Sommerfeld integral).
    #[test]
    fn a_disc_has_its_closed_form_on_the_axis() {
        for (radius, z, bound) in [
            (30.0, 40.0, 1e-5),
            (300.0, 900.0, 1e-9),
            (12.0, 400.0, 1e-9),
        ] {
            let far = f64::hypot(radius, z);
            let wave = |path: f64| Complex64::cis(std::f64::consts::TAU * path);
            let exact = wave(z) - wave(far) * (z / far);
            let found = TRAIN.field(&[disc(radius)], z, &[0.0])[0];
            assert!((found - exact).norm() < bound, "{radius}: {found} {exact}");
        }
    }

    /// Relative L2 distance of `a` from `b`.
    fn distance(a: &[Complex64], b: &[Complex64]) -> f64 {
        let off: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_sqr()).sum();
        (off / b.iter().map(|b| b.norm_sqr()).sum::<f64>()).sqrt()
    }

    /// A strong lens whose rim cuts the light, with and without a vortex before it, against the reference on square grids.
    #[test]
    fn a_lens_equals_the_sum_over_square_grids_slow() {
        let lens = PlanoConvex {
            radius: 60.0,
            thickness: 6.0,
            index: 1.5,
            semi_aperture: 18.0,
            gap_before: 10.0,
        };
        let mut steps = lens.plane_first();
        steps.push(Step::Drift(60.0));
        let front = move |r: f64| {
            let [z, slope, _] = Sag::Sphere(-60.0).at(r, 0.0);
            [z, slope]
        };
        let face = |z: f64, radius: f64, index: f64| Face {
            z,
            radius,
            index,
            ..disc(0.0)
        };
        let faces = |vortex: bool| {
            [
                Face {
                    vortex,
                    ..disc(20.0)
                },
                face(10.0, 45.0, 1.5),
                Face {
                    sag: &front,
                    ..face(16.0, 18.0, 1.0)
                },
            ]
        };
        let grid = LensTrain::converged(1.0, 240.0);
        let angle = |x: f64, y: f64| y.atan2(x);
        let radii: Vec<f64> = (0..12).map(|i| 0.4 + f64::from(i) * 0.6).collect();
        let points: Vec<[f64; 3]> = radii.iter().map(|r| [*r, 0.0, 0.0]).collect();
        for (vortex, source, bound) in [
            (false, Source::Disc(20.0, [0.0; 2]), 1e-4),
            (true, Source::Phase(20.0, &angle, [0.0; 2]), 6e-4),
        ] {
            let exact = grid
                .run(source, &steps, 8.0)
                .unwrap()
                .at_points(&points, 0.0);
            let found = TRAIN.field(&faces(vortex), 76.0, &radii);
            let error = distance(&found, &exact);
            assert!(error < bound, "{vortex}: {error:e}");
        }
    }
}
