//! Collins integral from a plane of box pixels through a paraxial train, by direct sum.

use ndarray::{Array1, Array2};
use num_complex::Complex64;

use crate::numerics::dense::separable;
use crate::numerics::phase::cis_turns;
use crate::numerics::pixels::Pixels;

/// A rotationally symmetric paraxial train between the pixel plane and the sensor: the ray matrix
/// [[a, b], [c, d]] on position and optical direction cosine (so that ad − bc = 1 between any two
/// media) and the optical path length along the axis.
#[derive(Clone, Copy, Debug)]
pub struct Abcd {
    /// Magnification term.
    pub a: f64,
    /// Reduced distance; zero means that the sensor images the pixels.
    pub b: f64,
    /// Minus the power.
    pub c: f64,
    /// Angular magnification term.
    pub d: f64,
    /// Optical path length along the axis.
    pub path: f64,
}

/// The sensor images the pixels (b = 0): the integral has no kernel there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImagingPlane;

impl Abcd {
    /// No train at all.
    pub fn identity() -> Self {
        Self {
            a: 1.0,
            b: 0.0,
            c: 0.0,
            d: 1.0,
            path: 0.0,
        }
    }

    /// This train, then flight over `distance` in a medium of index `index`.
    pub fn drift(self, distance: f64, index: f64) -> Self {
        let reduced = distance / index;
        Self {
            a: self.a + reduced * self.c,
            b: self.b + reduced * self.d,
            path: self.path + distance * index,
            ..self
        }
    }

    /// This train, then a thin refraction of power `power` (1/f of a thin lens in air;
    /// (n′ − n)/R of a surface).
    pub fn refract(self, power: f64) -> Self {
        Self {
            c: self.c - power * self.a,
            d: self.d - power * self.b,
            ..self
        }
    }
}

/// Collins' integral from a plane of box pixels through a train.
#[derive(Clone, Copy, Debug)]
pub struct CollinsIntegral<'a> {
    /// The pixels.
    pub pixels: &'a Pixels,
    /// Vacuum wavelength λ.
    pub wavelength: f64,
    /// What lies between the pixels and the sensor.
    pub train: Abcd,
    /// Gauss–Legendre nodes along each axis of a pixel.
    pub nodes: usize,
}

impl CollinsIntegral<'_> {
    /// The field [y, x] at sensor positions `y` × `x`,
    ///   U = e^{ik path}/(iλb) ∫ T E_in e^{(ik/2b)(a x₁² − 2 x₁·x₂ + d x₂²)} d²x₁,
    /// with E_in = exp(ik `tilt`·x₁).
    ///
    /// Fails at an image plane of the pixels (b = 0).
    pub fn field(
        &self,
        tilt: [f64; 2],
        [y, x]: [&Array1<f64>; 2],
    ) -> Result<Array2<Complex64>, ImagingPlane> {
        let Abcd { b, path, .. } = self.train;
        if b == 0.0 {
            return Err(ImagingPlane);
        }
        let (rows, columns) = self.pixels.transmission.dim();
        let field = separable(
            &self.kernel(y, rows, tilt[1]),
            &self.pixels.transmission,
            &self.kernel(x, columns, tilt[0]),
        );
        let (c, s) = cis_turns(path / self.wavelength);
        Ok(field * (Complex64::new(c, s) / Complex64::new(0.0, self.wavelength * b)))
    }

    /// The kernel [sensor position, pixel] along one axis, integrated over each pixel.
    fn kernel(&self, sensor: &Array1<f64>, count: usize, tilt: f64) -> Array2<Complex64> {
        let nodes = self.pixels.nodes(count, self.nodes);
        let Abcd { a, b, d, .. } = self.train;
        Array2::from_shape_fn((sensor.len(), count), |(row, pixel)| {
            let to = sensor[row];
            let range = pixel * self.nodes..(pixel + 1) * self.nodes;
            range
                .map(|node| {
                    let from = nodes.positions[node];
                    let path = (a * from * from - 2.0 * from * to + d * to * to) / (2.0 * b);
                    let (c, s) = cis_turns((path + tilt * from) / self.wavelength);
                    Complex64::new(c, s) * nodes.weights[node]
                })
                .sum()
        })
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array1, Array2};
    use num_complex::Complex64;

    use crate::numerics::pixels::Pixels;
    use crate::references::collins::{Abcd, CollinsIntegral, ImagingPlane};

    /// A Gaussian beam in its waist, 10 mm before a lens of 50 mm: by the q-parameter,
    /// U = e^{ik path} e^{ik x²/2q′}/(a + b/q), with the Gouy phase in the complex divisor.
    #[test]
    fn gaussian_beam_follows_its_q_parameter() {
        let (wavelength, waist, pitch) = (0.7e-3, 0.4, 0.01);
        let k = std::f64::consts::TAU / wavelength;
        let centres = |i: usize| (i as f64 - 199.5) * pitch;
        let pixels = Pixels {
            pitch,
            transmission: Array2::from_shape_fn((400, 400), |(i, j)| {
                Complex64::from(
                    (-(centres(i).powi(2) + centres(j).powi(2)) / (waist * waist)).exp(),
                )
            }),
        };
        for sensor in [30.0, 50.0, 80.0, 400.0] {
            let train = Abcd::identity()
                .drift(10.0, 1.0)
                .refract(1.0 / 50.0)
                .drift(4.0, 1.5)
                .drift(sensor, 1.0);
            let q = Complex64::new(0.0, -0.5 * k * waist * waist);
            let divisor = train.a + train.b / q;
            let curvature = (train.c + train.d / q) / divisor;
            let axis = Array1::linspace(-0.5, 0.5, 21);

            // One node per pixel is the trapezoidal rule: spectrally exact for a Gaussian.
            let integral = CollinsIntegral {
                pixels: &pixels,
                wavelength,
                train,
                nodes: 1,
            };
            let field = integral.field([0.0, 0.0], [&axis, &axis]).unwrap();
            let mut worst: f64 = 0.0;
            for ((row, column), value) in field.indexed_iter() {
                let square = axis[row].powi(2) + axis[column].powi(2);
                let exponent = Complex64::i() * k * (train.path + 0.5 * square * curvature);
                worst = worst.max((value - exponent.exp() / divisor).norm() * divisor.norm());
            }
            assert!(worst < 2e-9, "{sensor}: {worst:e}");
        }
    }

    #[test]
    fn nodes_converge_and_tilt_shifts() {
        let pixels = Pixels {
            pitch: 0.02,
            transmission: Array2::from_shape_fn((40, 40), |(i, j)| {
                Complex64::cis((7 * i * i + 3 * j) as f64)
            }),
        };
        let train = Abcd::identity().drift(50.0, 1.0);
        let axis = Array1::linspace(-4.0, 4.0, 33);
        let field = |nodes, shift: f64| {
            let moved = axis.mapv(|x| x + shift * 50.0);
            let integral = CollinsIntegral {
                pixels: &pixels,
                wavelength: 0.7e-3,
                train,
                nodes,
            };
            integral.field([shift, 0.0], [&axis, &moved]).unwrap()
        };
        let norm =
            |field: &Array2<Complex64>| field.iter().map(|u| u.norm_sqr()).sum::<f64>().sqrt();
        let exact = field(16, 0.0);
        for (nodes, bound) in [(6, 1e-2), (8, 7e-5), (12, 5e-10)] {
            let off = norm(&(field(nodes, 0.0) - &exact)) / norm(&exact);
            assert!(off < bound, "{nodes}: {off:e}");
        }
        // A tilted illumination only moves the pattern, up to phase.
        let tilted = field(16, 0.03);
        for (a, b) in tilted.iter().zip(&exact) {
            assert!((a.norm() - b.norm()).abs() < 1e-8);
        }
    }

    #[test]
    fn image_planes_are_refused() {
        let pixels = Pixels {
            pitch: 1.0,
            transmission: Array2::zeros((2, 2)),
        };
        let train = Abcd::identity()
            .drift(100.0, 1.0)
            .refract(1.0 / 50.0)
            .drift(100.0, 1.0);
        let axis = Array1::zeros(1);
        let integral = CollinsIntegral {
            pixels: &pixels,
            wavelength: 1.0,
            train,
            nodes: 1,
        };
        let result = integral.field([0.0, 0.0], [&axis, &axis]);
        assert_eq!(result.unwrap_err(), ImagingPlane);
    }
}
