//! Diffractive mirrors on curved substrates, with phases that take their height into account: patches of a
//! sphere, and the mirror of figure 6 that shows two foci or a letter.

#![expect(
    clippy::indexing_slicing,
    reason = "pixels are indexed by loops over the sizes of the mirror they belong to"
)]

use std::f64::consts::TAU;

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use raylet::math::random::uniform;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::{Aperture, Outline};
use raylet::optics::conic::Conic;
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::frame::Frame;
use raylet::optics::freeform::Term;
use raylet::optics::phase::placement::Placement;
use raylet::optics::pixels::active_area::ActiveArea;
use raylet::optics::pixels::pixel_grid::{PixelForm, Pixels};
use raylet::optics::sag_grid::SagGrid;
use raylet::optics::screen::{Screen, ScreenKind, Sensor};
use raylet::optics::shape::Shape;
use raylet::optics::source::Source;
use raylet::optics::system::System;
use raylet::wave::free::rayleigh::{Emitter, Emitters};

/// Wavelength in mm; pixels are half of it.
const WAVELENGTH: f64 = 1e-3;
const PITCH: f64 = 0.5 * WAVELENGTH;

/// Pixels across the mirror, its radius and the distance of the sensor in mm.
const PIXELS: f64 = 501.0;
const RADIUS: f64 = 0.125;
const DISTANCE: f64 = 0.2505;

/// Half the distance of the two foci in mm.
const APART: f64 = 0.05;

/// Seed of the random phases.
const SEED: u64 = 17;

/// The substrate of the mirror.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Substrate {
    /// Two bumps of a tenth of a wavelength, tapered to zero at the edge of their square.
    Bumps,
    /// One Gaussian bump of 12.65 wavelengths, whose smallest radius is 506 wavelengths.
    Bump,
}

/// The picture that the mirror shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// Two foci on the x axis.
    Foci,
    /// A letter S, each of its points with a random phase.
    Letter,
}

/// The mirror, at a share of its full size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conformal {
    /// Its substrate.
    pub substrate: Substrate,
    /// The picture that it shows.
    pub show: Show,
    /// Share of the full size, in all lengths.
    pub scale: f64,
}

/// The lit part of its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LitArea {
    /// The disc that touches the edges.
    Disc,
    /// All of them.
    Square,
}

/// The part of the sensor's plane that is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Its middle on the x axis, in mm.
    pub x: f64,
    /// Samples along x and y.
    pub pixels: [usize; 2],
    /// Their distance in mm.
    pub pitch: f64,
}

impl Conformal {
    /// Pixels along each axis: an odd number.
    pub fn count(&self) -> usize {
        2 * (0.5 * PIXELS * self.scale).floor() as usize + 1
    }

    /// Where the pixels of a column or row are, in mm.
    pub fn place(&self, i: usize) -> f64 {
        (i as f64 - 0.5 * (self.count() as f64 - 1.0)) * PITCH
    }

    /// The foci on the x axis, in mm.
    pub fn foci(&self) -> [f64; 2] {
        [-APART * self.scale, APART * self.scale]
    }

    /// Width of the mirror in mm.
    pub fn width(&self) -> f64 {
        2.0 * RADIUS * self.scale
    }

    /// The substrate's shape.
    pub fn shape(&self) -> Shape {
        let base = Conic {
            curvature: 0.0,
            conic: 0.0,
        };
        let bump = || Term::Gaussian {
            height: 0.01265 * self.scale,
            centre: [0.0; 2],
            sigma: 0.08 * self.scale,
        };
        let term = match self.substrate {
            Substrate::Bump => bump(),
            // The grid always has the four points that a spline needs.
            Substrate::Bumps => self
                .tapered()
                .map_or_else(bump, |grid| Term::Grid(grid.into())),
        };
        let terms = vec![term];
        Shape::Freeform { base, terms }
    }

    /// The two bumps at the pixels' centres, and a flat ring around them.
    fn tapered(&self) -> Option<SagGrid> {
        let count = self.count() + 4;
        let share = |i: usize| 0.5 + self.place(i) / self.width() - 2.0 * PITCH / self.width();
        let bump = |at: [f64; 2], centre: f64, sigma: f64| {
            let square = (at[0] - centre).powi(2) + (at[1] - centre).powi(2);
            1e-4 * (-0.5 * square / (sigma * sigma)).exp()
        };
        let heights = Array2::from_shape_fn((count, count), |(j, i)| {
            let [x, y] = [share(i), share(j)];
            let inside = x.min(1.0 - x).min(y).min(1.0 - y) / 0.05;
            let taper = inside.clamp(0.0, 1.0).powi(2);
            taper * (bump([x, y], 0.6, 0.15) + bump([x, y], 0.3, 0.1))
        });
        SagGrid::new(&heights, [PITCH; 2])
    }

    /// The complex reflection of each pixel: for light that comes along −z it undoes, at the pixel's centre
    /// on the true surface, the phase from there to what is shown.
    fn reflection(&self, shape: &Shape) -> Array2<Complex64> {
        let (count, k) = (self.count(), TAU / WAVELENGTH);
        let height = |n: usize| {
            let (x, y) = (self.place(n % count), self.place(n / count));
            let z = shape.height(x, y).map_or(0.0, |here| here.z);
            [x, y, z]
        };
        let points: Vec<[f64; 3]> = (0..count * count).map(height).collect();
        let distance = DISTANCE * self.scale;
        let values: Vec<Complex64> = match self.show {
            Show::Foci => points
                .par_iter()
                .map(|[x, y, z]| {
                    let to = |f: f64| ((f - x).powi(2) + y * y + (distance - z).powi(2)).sqrt();
                    let wave = |f: f64| Complex64::cis(k * (z - to(f)));
                    self.foci().map(wave).iter().sum()
                })
                .collect(),
            Show::Letter => {
                let before = |[x, y, z]: &[f64; 3]| [*x, *y, distance - z];
                let towards: Vec<[f64; 3]> = points.iter().map(before).collect();
                let back = self.letter_lights().field_at(&towards, WAVELENGTH);
                let phases = back.iter().zip(&points);
                phases
                    .map(|(back, [_, _, z])| Complex64::cis(k * z - back.arg()))
                    .collect()
            }
        };
        Array2::from_shape_fn((count, count), |(j, i)| values[j * count + i])
    }

    /// Points of the letter one wavelength apart, as if they shone.
    fn letter_lights(&self) -> Emitters {
        let half = (0.1 * self.scale / WAVELENGTH) as i32;
        let lit = (-half..=half).flat_map(move |j| (-half..=half).map(move |i| [i, j]));
        let lights = lit.filter_map(|[i, j]| {
            let [x, y] = [i, j].map(|n| f64::from(n) * WAVELENGTH);
            let turn = uniform(SEED, [(i + half) as u32, (j + half) as u32, 0, 0]);
            self.letter(x, y).then(|| Emitter {
                at: [x, y, 0.0],
                slope: [0.0; 2],
                strength: Complex64::cis(TAU * turn),
            })
        });
        Emitters::of_nodes(lights)
    }

    /// Whether the letter covers a place on the sensor: two arcs of a circle, three quarters each.
    pub fn letter(&self, x: f64, y: f64) -> bool {
        let (radius, half) = (0.032 * self.scale, 0.011 * self.scale);
        // Turned half about its middle the letter is the same.
        let on = |x: f64, y: f64| {
            let (u, v) = (x, y - radius);
            let angle = v.atan2(u).to_degrees();
            (u.hypot(v) - radius).abs() <= half && (angle <= -90.0 || angle > 20.0)
        };
        on(x, y) || on(-x, -y)
    }

    /// The mirror with its conjugate phases in light along −z, and a window of the sensor's plane above it.
    pub fn system(&self, window: Window) -> System {
        self.made(self.reflection(&self.shape()), LitArea::Disc, window)
    }

    /// The mirror with these reflections of its pixels, [y, x].
    pub fn made(&self, values: Array2<Complex64>, aperture: LitArea, window: Window) -> System {
        let outline = match aperture {
            LitArea::Disc => Outline::Disc {
                radius: RADIUS * self.scale,
            },
            LitArea::Square => Outline::Rectangle {
                half_x: 0.5 * PITCH * self.count() as f64,
                half_y: 0.5 * PITCH * self.count() as f64,
            },
        };
        let place = Vec3::new(window.x, 0.0, self.distance());
        let element = element(values, PITCH, outline);
        mirror(self.shape(), element, place, window.pixels, window.pitch)
    }

    /// Distance of the sensor's plane in mm.
    pub(crate) fn distance(&self) -> f64 {
        DISTANCE * self.scale
    }
}

/// Pixels behind an aperture, that reflect.
fn element(values: Array2<Complex64>, pitch: f64, outline: Outline) -> Doe {
    Doe {
        layers: vec![Layer::Pixels(Pixels {
            pitch: [pitch; 2],
            values,
            form: PixelForm::Box,
            active: ActiveArea::WHOLE,
            placement: Placement::NONE,
        })],
        aperture: Aperture {
            outline,
            centre: [0.0; 2],
        },
        reflect: true,
    }
}

/// An element of this shape, lit along −z, and a sensor above it.
fn mirror(shape: Shape, element: Doe, place: Vec3, pixels: [usize; 2], pitch: f64) -> System {
    let sensor = Sensor {
        pixels,
        pitch: [pitch; 2],
    };
    let screen = |name: &str, origin: Vec3, shape: Shape, kind: ScreenKind, arrives: f64| Screen {
        name: name.to_owned(),
        frame: Frame::GLOBAL.moved(origin),
        shape,
        kind,
        index: 1.0,
        behind: None,
        arrives,
    };
    let middle = Vec3::new(0.0, 0.0, 0.0);
    System {
        wavelength: WAVELENGTH,
        source: Source::Plane {
            direction: Vec3::new(0.0, 0.0, -1.0),
            origin: middle,
        },
        screens: vec![
            screen("mirror", middle, shape, ScreenKind::Doe(element), -1.0),
            screen(
                "sensor",
                place,
                Shape::Plane,
                ScreenKind::Sensor(sensor),
                1.0,
            ),
        ],
        trains: vec![vec![]],
    }
}

/// A square of `width` wavelengths of a convex spherical mirror, `radius` wavelengths in radius, with random
/// phases on pixels of two wavelengths, and a sensor of `points`² points half as wide, `width` away.
pub fn spherical_patch(width: usize, radius: f64, points: usize) -> System {
    let (count, side) = (width / 2, width as f64 * WAVELENGTH);
    let values = Array2::from_shape_fn((count, count), |(j, i)| {
        Complex64::cis(TAU * uniform(SEED, [i as u32, j as u32, 1, 0]))
    });
    let shape = Shape::Conic(Conic {
        curvature: -1.0 / (radius * WAVELENGTH),
        conic: 0.0,
    });
    let outline = Outline::Rectangle {
        half_x: 0.5 * side,
        half_y: 0.5 * side,
    };
    let place = Vec3::new(0.0, 0.0, side);
    let pitch = 0.5 * side / points as f64;
    let element = element(values, 2.0 * WAVELENGTH, outline);
    mirror(shape, element, place, [points; 2], pitch)
}

#[cfg(test)]
mod tests {
    use crate::mirrors::conformal_mirror::{Conformal, Show, Substrate, Window, spherical_patch};

    #[test]
    fn substrates_have_their_radii() {
        let conformal = |substrate| Conformal {
            substrate,
            show: Show::Foci,
            scale: 1.0,
        };
        let window = Window {
            x: 0.0,
            pixels: [4; 2],
            pitch: 1e-3,
        };
        let radius = |substrate| {
            let system = conformal(substrate).system(window);
            system.screens[0].smallest_radius().unwrap()
        };
        let curved = radius(Substrate::Bump);
        assert!((curved - 0.5059).abs() < 1e-4, "{curved}");

        // The two bumps at their middles and half a taper inside the edge, in mm.
        let shape = conformal(Substrate::Bumps).shape();
        let z = |x: f64, y: f64| shape.height(x, y).unwrap().z;
        let bump = |square: f64, sigma: f64| 1e-4 * (-0.5 * square / (sigma * sigma)).exp();
        let there = |x: f64, y: f64| {
            bump((x - 0.025).powi(2) + (y - 0.025).powi(2), 0.0375)
                + bump((x + 0.05).powi(2) + (y + 0.05).powi(2), 0.025)
        };
        for [x, y] in [[0.025, 0.025], [-0.05, -0.05], [0.03, -0.02]] {
            assert!((z(x, y) - there(x, y)).abs() < 1e-9, "{x} {y}");
        }
        let edge = z(0.11875, 0.02);
        assert!((edge - 0.25 * there(0.11875, 0.02)).abs() < 1e-9);
        let patch = spherical_patch(10, 250.0, 4);
        let radius = patch.screens[0].smallest_radius().unwrap();
        assert!((radius - 0.25).abs() < 1e-6, "{radius}");
    }
}
