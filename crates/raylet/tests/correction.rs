//! The correction of the aberration inside beamlets brings wide beamlets to what narrow ones, which have
//! hardly any, find.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Correction, Method, Settings};
use raylet::math::random::uniform;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::{Doe, Layer, PixelForm, Pixels};
use raylet::optics::frame::Frame;
use raylet::optics::refraction::{Coating, Interface};
use raylet::optics::screen::{Act, Screen, Sensor};
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::source::Source;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet::wave::grid::metrics::field_error;

fn screen(z: f64, act: Act) -> Screen {
    Screen {
        name: format!("at {z}"),
        frame: Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, z)),
        shape: Shape::Plane,
        act,
        index: 1.0,
        arrives: 1.0,
    }
}

fn face(z: f64, curvature: f64, index: [f64; 2]) -> Surface {
    Surface {
        shape: Shape::Conic(Conic {
            curvature,
            conic: 0.0,
        }),
        frame: Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, z)),
        aperture: Aperture::OPEN,
        interface: Interface::Refract,
        coating: Coating::Unit,
        index,
    }
}

/// Random phases on pixels of 4λ behind which a strong lens stands; lengths in wavelengths.
fn system() -> System {
    let phase = |(j, i): (usize, usize)| {
        Complex64::cis(std::f64::consts::TAU * uniform(5, [j as u32, i as u32, 0, 0]))
    };
    let doe = Doe {
        layers: vec![Layer::Pixels(Pixels {
            pitch: [4.0; 2],
            values: Array2::from_shape_fn((12, 12), phase),
            form: PixelForm::Box,
        })],
        aperture: Aperture::OPEN,
        reflect: false,
    };
    let sensor = Sensor {
        pixels: [30; 2],
        pitch: [1.0; 2],
    };
    System {
        wavelength: 1.0,
        source: Source::Plane {
            direction: Vec3::new(0.0, 0.0, 1.0),
            origin: Vec3::new(0.0, 0.0, 0.0),
        },
        screens: vec![
            screen(0.0, Act::Doe(doe)),
            screen(300.0, Act::Sensor(sensor)),
        ],
        trains: vec![vec![
            face(20.0, 1.0 / 200.0, [1.0, 1.5]),
            face(45.0, 0.0, [1.5, 1.0]),
        ]],
    }
}

#[test]
fn wide_beamlets_are_put_right() {
    let run = |sigma: f64, correction: Correction| {
        let settings = Settings {
            method: Method::Beamlet,
            sigma: Some(sigma),
            correction,
            ..Settings::default()
        };
        simulate(&system(), &settings, &|_| {})
            .unwrap()
            .field
            .values
    };
    let narrow = run(4.5, Correction::On);
    let error = |correction: Correction| {
        let wide = run(11.0, correction);
        field_error(wide.view(), narrow.view()).unwrap()
    };
    let (off, on) = (error(Correction::Off), error(Correction::On));
    assert!(off > 2.5e-3 && on < 0.4 * off, "{off:.2e}, {on:.2e}");
}
