//! Diffractive mirrors on a curved surface, against the first Rayleigh–Sommerfeld integral over the true
//! surface: U(P) = (1/2π) ∫ U (N·(P−X)/r) (1/r − ik) e^{ikr}/r dx dy, N = (−∇s, 1).

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::{Aperture, Outline};
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::freeform::Term;
use raylet::optics::phase::placement::Placement;
use raylet::optics::phase::profile::Profile;
use raylet::optics::pixels::active_area::ActiveArea;
use raylet::optics::pixels::pixel_grid::{PixelForm, Pixels};
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::source::Source;
use raylet::optics::system::System;
use raylet_testkit::parts::{on_axis, screen};
use rayon::prelude::*;

use crate::numerics::phase::cis_turns;
use crate::numerics::quadrature::gauss_legendre;
use crate::problems::problem::{Problem, axis, sensor};

/// A Gaussian bump of this height and width: its smallest radius of curvature is 506 λ.
const HEIGHT: f64 = 12.65;
const SIGMA: f64 = 80.0;

/// What the mirror adds to the light, for wavelength one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coat {
    /// Nothing.
    Bare,
    /// The phase that focuses at this distance, made for a plane mirror.
    Focus(f64),
    /// The same for two foci: two linear phases of this sine, either way, added.
    TwoFoci(f64, f64),
    /// Random phases on pixels of this pitch.
    Random(f64),
}

/// Light going −z on to a square diffractive mirror, and back to a sensor above it.
pub struct MirrorProblem {
    /// What the mirror adds to the light.
    pub coat: Coat,
    /// Width of the square mirror.
    pub width: f64,
    /// Height of the sensor over the mirror's vertex plane.
    pub distance: f64,
    /// Points along each axis of the sensor.
    pub points: usize,
    /// Their distance.
    pub pitch: f64,
}

fn sag(x: f64, y: f64) -> [f64; 3] {
    let z = HEIGHT * (-(x * x + y * y) / (2.0 * SIGMA * SIGMA)).exp();
    [z, -x / (SIGMA * SIGMA) * z, -y / (SIGMA * SIGMA) * z]
}

/// The transmission at (x, y).
fn transmission(coat: Coat, width: f64, x: f64, y: f64) -> Complex64 {
    let focus = |f: f64| {
        let (c, s) = cis_turns(f - (x * x + y * y + f * f).sqrt());
        Complex64::new(c, s)
    };
    match coat {
        Coat::Bare => Complex64::ONE,
        Coat::Focus(f) => focus(f),
        Coat::TwoFoci(sine, f) => focus(f) * (2.0 * cis_turns(sine * x).0),
        Coat::Random(pitch) => {
            let cell = |v: f64| ((v + 0.5 * width) / pitch).floor() as u32;
            let u = raylet::math::random::uniform(3, [cell(y), cell(x), 0, 0]);
            let (c, s) = cis_turns(u);
            Complex64::new(c, s)
        }
    }
}

impl MirrorProblem {
    /// Cells of the quadrature: pixels, or wavelengths.
    fn cell(&self) -> f64 {
        match self.coat {
            Coat::Random(pitch) => pitch,
            _ => 1.0,
        }
    }

    /// The field on the sensor by the direct sum, with `nodes`² Gauss nodes in each cell.
    pub fn exact(&self, nodes: usize) -> Array2<Complex64> {
        let rule = gauss_legendre(nodes);
        let cells = (self.width / self.cell()).round() as usize;
        let place = |i: usize| {
            let (cell, g) = (i / nodes, i % nodes);
            -0.5 * self.width + self.cell() * (cell as f64 + 0.5 + 0.5 * rule[g].0)
        };
        let weight = |i: usize| 0.5 * self.cell() * rule[i % nodes].1;
        let count = cells * nodes;
        let points = axis(self.points, self.pitch);
        let rows: Vec<Vec<Complex64>> = (0..count)
            .into_par_iter()
            .map(|j| {
                let mut sum = vec![Complex64::ZERO; points.len() * points.len()];
                for i in 0..count {
                    let (x, y) = (place(i), place(j));
                    let [z, zx, zy] = sag(x, y);
                    let (c, s) = cis_turns(-z);
                    let lit = Complex64::new(c, s)
                        * transmission(self.coat, self.width, x, y)
                        * (weight(i) * weight(j) / std::f64::consts::TAU);
                    for (b, py) in points.iter().enumerate() {
                        for (a, px) in points.iter().enumerate() {
                            let d = [px - x, py - y, self.distance - z];
                            let r = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                            let lift = (d[2] - zx * d[0] - zy * d[1]) / (r * r);
                            let (c, s) = cis_turns(r);
                            let kernel = Complex64::new(1.0 / r, -std::f64::consts::TAU)
                                * Complex64::new(c, s)
                                * lift;
                            sum[b * points.len() + a] += lit * kernel;
                        }
                    }
                }
                sum
            })
            .collect();
        let mut total = Array2::zeros((points.len(), points.len()));
        for row in rows {
            for (sum, value) in total.iter_mut().zip(row) {
                *sum += value;
            }
        }
        total
    }

    /// The conjugate transpose of [`MirrorProblem::exact`] for random pixels, with respect to them: from the cotangent of
    /// the field on the sensor to that of each pixel's reflection, [y, x].
    pub fn exact_adjoint(&self, nodes: usize, field_bar: &Array2<Complex64>) -> Array2<Complex64> {
        let rule = gauss_legendre(nodes);
        let half = 0.5 * self.cell();
        let cells = (self.width / self.cell()).round() as usize;
        let place = |cell: usize, g: usize| {
            -0.5 * self.width + self.cell() * (cell as f64 + 0.5) + half * rule[g].0
        };
        let points = axis(self.points, self.pitch);
        // What one node gets back: Σ conj(kernel)·bar over the sensor.
        let node = |x: f64, y: f64| {
            let [z, zx, zy] = sag(x, y);
            let mut sum = Complex64::ZERO;
            for ((b, a), bar) in field_bar.indexed_iter() {
                let d = [points[a] - x, points[b] - y, self.distance - z];
                let r = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                let lift = (d[2] - zx * d[0] - zy * d[1]) / (r * r);
                let (c, s) = cis_turns(r - z);
                let kernel = Complex64::new(1.0 / r, -std::f64::consts::TAU) * Complex64::new(c, s);
                sum += (kernel * lift).conj() * bar;
            }
            sum / std::f64::consts::TAU
        };
        let pixel = |index: usize| -> Complex64 {
            let (row, column) = (index / cells, index % cells);
            let within = (0..nodes * nodes).map(|n| [n / nodes, n % nodes]);
            let part = |[j, i]: [usize; 2]| {
                let weight = half * half * rule[i].1 * rule[j].1;
                node(place(column, i), place(row, j)) * weight
            };
            within.map(part).sum()
        };
        let all: Vec<Complex64> = (0..cells * cells).into_par_iter().map(pixel).collect();
        Array2::from_shape_fn((cells, cells), |(row, column)| all[row * cells + column])
    }

    /// The element's layers.
    fn layers(&self) -> Vec<Layer> {
        let lens = |f: f64| {
            Layer::Phase(Profile::Lens {
                focal_length: f,
                wavenumber: std::f64::consts::TAU,
            })
        };
        match self.coat {
            Coat::Bare => vec![Layer::Phase(Profile::Linear { gradient: [0.0; 2] })],
            Coat::Focus(f) => vec![lens(f)],
            Coat::TwoFoci(sine, f) => {
                let order = |sign: f64| {
                    let gradient = [sign * std::f64::consts::TAU * sine, 0.0];
                    let tilted = Layer::Phase(Profile::Linear { gradient });
                    (Complex64::ONE, vec![lens(f), tilted])
                };
                vec![Layer::Sum(vec![order(1.0), order(-1.0)])]
            }
            Coat::Random(pitch) => {
                let count = (self.width / pitch).round() as usize;
                let place = |i: usize| -0.5 * self.width + pitch * (i as f64 + 0.5);
                vec![Layer::Pixels(Pixels {
                    pitch: [pitch; 2],
                    values: Array2::from_shape_fn((count, count), |(j, i)| {
                        transmission(self.coat, self.width, place(i), place(j))
                    }),
                    form: PixelForm::Box,
                    active: ActiveArea::WHOLE,
                    placement: Placement::NONE,
                })]
            }
        }
    }

    /// The problem for raylet.
    pub fn problem(self, name: &str, settings: Settings, nodes: usize) -> Problem {
        let half = 0.5 * self.width;
        let element = Doe {
            layers: self.layers(),
            aperture: Aperture {
                outline: Outline::Rectangle {
                    half_x: half,
                    half_y: half,
                },
                centre: [0.0; 2],
            },
            reflect: true,
        };
        let base = Conic {
            curvature: 0.0,
            conic: 0.0,
        };
        let bump = Term::Gaussian {
            height: HEIGHT,
            centre: [0.0; 2],
            sigma: SIGMA,
        };
        let mirror = Screen {
            shape: Shape::Freeform {
                base,
                terms: vec![bump],
            },
            arrives: -1.0,
            ..screen(on_axis(0.0), ScreenKind::Doe(element))
        };
        let system = System {
            wavelength: 1.0,
            source: Source::Plane {
                direction: Vec3::new(0.0, 0.0, -1.0),
                origin: Vec3::new(0.0, 0.0, 0.0),
            },
            screens: vec![mirror, sensor(self.distance, self.points, self.pitch)],
            trains: vec![vec![]],
        };
        let by = match settings.method {
            Method::Beamlet => "by beamlets",
            _ => "without rays",
        };
        Problem {
            name: format!("{name} on a Gaussian bump (radius 506λ), {by}"),
            reference: "Rayleigh–Sommerfeld on the true surface",
            system,
            settings,
            exact: Box::new(move || self.exact(nodes)),
        }
    }
}
