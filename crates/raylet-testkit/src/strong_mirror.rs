//! A small mirror that bends light strongly, on which beamlets miss their target error.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::optics::aperture::Aperture;
use raylet::optics::refraction::{Coating, Interface};
use raylet::optics::screen::Screen;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;

use super::parts::{box_pixels, conic, face, lit, on_axis, screen, sensor};

/// Pixels of two wavelengths with scattered phases before a concave mirror of this radius, tilted by `tilt`
/// (rad), and a sensor at 0.4 of its radius; lengths in wavelengths.
pub fn strong_mirror(radius: f64, tilt: f64) -> System {
    let phase = |(j, i): (usize, usize)| Complex64::cis((3 * i * i + 5 * j * j + 7 * i * j) as f64);
    let pixels = box_pixels(Array2::from_shape_fn((20, 20), phase), 2.0);
    let (before, behind) = (10.0, 0.4 * radius);
    let mirror = Surface {
        interface: Interface::Reflect,
        aperture: Aperture::disc(0.6 * radius),
        coating: Coating::Unit,
        ..face(on_axis(before), conic(-1.0 / radius, 0.0), [1.0, 1.0])
    };
    let frame = mirror.frame.tilted([tilt, 0.0, 0.0]);
    let seen = Screen {
        arrives: -1.0,
        ..screen(on_axis(before - behind), sensor(16, 0.5))
    };
    lit(
        vec![screen(on_axis(0.0), pixels), seen],
        vec![vec![Surface { frame, ..mirror }]],
    )
}
