//! The three systems on which the source paper shows its method: a grating and a lens, a hologram close to
//! its sensor, and a hologram and a lens. Light of 0.7 µm, pixels of 6.3 µm.

use ndarray::{Array1, Array2};
use num_complex::Complex64;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::Layer;
use raylet::optics::frame::Frame;
use raylet::optics::phase::profile::Profile;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::shape::Shape;
use raylet::optics::source::Source;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet::wave::grid::field::Axis;

use super::parts::{self, conic, face, on_axis, plane_wave, screen};

/// Wavelength in mm.
pub const WAVELENGTH: f64 = 0.7e-3;

/// Distance of neighbouring pixels in mm.
pub const PITCH: f64 = 6.3e-3;

/// Phase gradient of the grating in rad/mm.
const GRADIENT: f64 = 30.0;

/// From the hologram to the sensor that is close to it, in mm: four times its radius.
pub const NEAR: f64 = 1.26;

/// Where the LA1131-A and the sensor behind it stand, in mm from the element.
const FACES: [f64; 2] = [3.0, 8.3];
const SENSOR: f64 = 53.0;

/// Half its clear aperture, and the radius of its curved face, in mm.
const LENS_RADIUS: f64 = 12.7;
const FACE_RADIUS: f64 = 25.8;

/// Index of its glass.
const INDEX: f64 = 1.5131;

/// A part of a sensor of square pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Its middle on the sensor in mm.
    pub middle: [f64; 2],
    /// Pixels along each side.
    pub count: usize,
    /// Their distance in mm.
    pub pitch: f64,
}

/// The sensor of the grating: 1001 pixels of half a wavelength.
pub const GRATING_SENSOR: Window = Window {
    middle: [0.0; 2],
    count: 1001,
    pitch: 0.35e-3,
};

/// A grating of phase 30 x rad (x in mm), open in a disc of this radius in mm (12.7 in the paper), and the
/// lens. `pixels` makes it of point samples 6.3 µm apart, as the paper has it.
pub fn grating(radius: f64, pixels: bool, sensor: Window) -> System {
    let layer = if pixels {
        let count = 2 * (radius / PITCH).ceil() as usize;
        let axis = Axis::uniform(count, PITCH, 0.0);
        let row = Array1::from_shape_fn(count, |i| Complex64::cis(GRADIENT * axis.node(i)));
        let values = Array2::ones([count, count]) * row;
        pixel_layer(values, PixelForm::Point)
    } else {
        Layer::Phase(Profile::Linear {
            gradient: [GRADIENT, 0.0],
        })
    };
    let sensor = sensor_screen(SENSOR, sensor);
    system(element("grating", layer, radius), lens(), sensor)
}

/// Another reading of the system with the grating, where text and public code of the paper disagree or leave
/// a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// The code: collimated light here, the curved face first, the sensor 50 mm behind its vertex.
    Code,
    /// The code's source: a point 100 m before the grating.
    FarPoint,
    /// The text: the sensor 50 mm behind the lens, which ends at its flat face.
    BehindLens,
    /// The flat face first.
    FlatFirst,
}

/// The readings.
pub const READINGS: [Reading; 4] = [
    Reading::Code,
    Reading::FarPoint,
    Reading::BehindLens,
    Reading::FlatFirst,
];

impl Reading {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Reading::Code => "curved face first, sensor 50 mm behind its vertex",
            Reading::FarPoint => "the same, light from a point 100 m away",
            Reading::BehindLens => "sensor 50 mm behind the flat face",
            Reading::FlatFirst => "flat face first, sensor at 53 mm",
        }
    }

    /// The system so read.
    pub fn apply(self, mut system: System) -> System {
        match self {
            Reading::Code => {}
            Reading::FarPoint => {
                system.source = Source::Point {
                    position: Vec3::new(0.0, 0.0, -1e5),
                    reference: Vec3::new(0.0, 0.0, 0.0),
                };
            }
            Reading::BehindLens => {
                for screen in system.screens.iter_mut().skip(1) {
                    screen.frame.origin.z = FACES[1] + SENSOR - FACES[0];
                }
            }
            Reading::FlatFirst => {
                for train in &mut system.trains {
                    train.reverse();
                    for (surface, z) in train.iter_mut().zip(FACES) {
                        surface.frame = on_axis(z);
                        surface.index.reverse();
                        if let Shape::Conic(conic) = &mut surface.shape {
                            conic.curvature = -conic.curvature;
                        }
                    }
                }
            }
        }
        system
    }
}

/// A phase hologram in a disc as wide as its pixels, with a sensor like it at 1.26 mm.
pub fn near_hologram(phase: &Array2<f64>, form: PixelForm) -> System {
    hologram(phase, form, Vec::new(), NEAR)
}

/// A phase hologram in a disc as wide as its pixels, the lens, and a sensor like the hologram 53 mm from it.
pub fn lens_hologram(phase: &Array2<f64>, form: PixelForm) -> System {
    hologram(phase, form, lens(), SENSOR)
}

fn hologram(phase: &Array2<f64>, form: PixelForm, train: Vec<Surface>, z: f64) -> System {
    let count = phase.ncols();
    let layer = pixel_layer(phase.mapv(Complex64::cis), form);
    let like = Window {
        middle: [0.0; 2],
        count,
        pitch: PITCH,
    };
    let radius = 0.5 * count as f64 * PITCH;
    let element = element("hologram", layer, radius);
    system(element, train, sensor_screen(z, like))
}

/// The share of each of `count`² pixels that a disc as wide as all of them leaves open.
pub fn open(count: usize) -> Array2<f64> {
    let axis = Axis::uniform(count, PITCH, 0.0);
    let disc = Aperture::disc(0.5 * count as f64 * PITCH);
    let span = |i: usize| {
        let low = axis.start + (i as f64 - 0.5) * PITCH;
        [low, low + PITCH]
    };
    Array2::from_shape_fn((count, count), |(j, i)| {
        let ([x0, x1], [y0, y1]) = (span(i), span(j));
        disc.coverage(x0, x1, y0, y1)
    })
}

fn pixel_layer(values: Array2<Complex64>, form: PixelForm) -> Layer {
    parts::pixel_layer(values, PITCH, form)
}

fn element(name: &str, layer: Layer, radius: f64) -> Screen {
    let doe = parts::element(layer, Aperture::disc(radius));
    Screen {
        name: name.to_owned(),
        ..screen(on_axis(0.0), ScreenKind::Doe(doe))
    }
}

fn sensor_screen(z: f64, window: Window) -> Screen {
    let [x, y] = window.middle;
    let frame = Frame::GLOBAL.moved(Vec3::new(x, y, z));
    screen(frame, parts::sensor(window.count, window.pitch))
}

/// The LA1131-A, its curved side to the element.
fn lens() -> Vec<Surface> {
    let face = |z: f64, shape: Shape, index: [f64; 2]| Surface {
        aperture: Aperture::disc(LENS_RADIUS),
        ..face(on_axis(z), shape, index)
    };
    vec![
        face(FACES[0], conic(1.0 / FACE_RADIUS, 0.0), [1.0, INDEX]),
        face(FACES[1], Shape::Plane, [INDEX, 1.0]),
    ]
}

fn system(element: Screen, train: Vec<Surface>, sensor: Screen) -> System {
    System {
        wavelength: WAVELENGTH,
        source: plane_wave([0.0; 2]),
        screens: vec![element, sensor],
        trains: vec![train],
    }
}

#[cfg(test)]
mod tests {
    use raylet::optics::paraxial::Abcd;

    use super::{GRATING_SENSOR, READINGS, Reading, grating};

    /// Focal length and distance of the focus from the sensor of every reading.
    #[test]
    fn readings_differ_in_where_they_focus() {
        let matrix = |reading: Reading| {
            let system = reading.apply(grating(12.7, false, GRATING_SENSOR));
            let found = system.hops().next().map(|hop| Abcd::between(&hop));
            found.unwrap().unwrap()
        };
        for reading in READINGS {
            // f = 50.2826 mm whichever face is first; the focus lies f·a behind the sensor.
            let Abcd { a, c, .. } = matrix(reading);
            assert!((1.0 / c + 50.2826).abs() < 1e-3, "{reading:?}");
            let expected = match reading {
                Reading::Code | Reading::FarPoint => 2.0799,
                Reading::BehindLens => 46.7799 - 50.0,
                Reading::FlatFirst => 50.2826 - 44.7,
            };
            assert!((-a / c - expected).abs() < 1e-3, "{reading:?} {}", -a / c);
        }
    }
}
