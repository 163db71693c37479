//! Screens and surfaces from which the tests build their systems.

use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::frame::Frame;
use raylet::optics::refraction::{Coating, Interface};
use raylet::optics::screen::{Act, Screen};
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::surface::Surface;
use raylet::optics::system::Hop;

/// A hop that owns its parts.
pub(crate) struct Bench {
    /// Where rays start.
    pub(crate) from: Screen,
    /// The surfaces between.
    pub(crate) train: Vec<Surface>,
    /// Where they end.
    pub(crate) to: Screen,
}

impl Bench {
    pub(crate) fn hop(&self) -> Hop<'_> {
        Hop {
            wavelength: 0.7e-3,
            from: &self.from,
            train: &self.train,
            to: &self.to,
        }
    }
}

/// A frame with the global axes at a point of the global z axis.
pub(crate) fn on_axis(z: f64) -> Frame {
    Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, z))
}

/// A screen without edge; light arrives and leaves along `arrives` times its z axis.
pub(crate) fn screen(frame: Frame, index: f64, arrives: f64) -> Screen {
    Screen {
        name: String::from("screen"),
        frame,
        act: Act::Stop(Aperture::OPEN),
        index,
        shape: Shape::Plane,
        arrives,
    }
}

/// A conic by its vertex radius and conic constant.
pub(crate) fn conic(radius: f64, conic: f64) -> Shape {
    Shape::Conic(Conic {
        curvature: 1.0 / radius,
        conic,
    })
}

/// A refracting surface without edge.
pub(crate) fn lens_face(frame: Frame, shape: Shape, index: [f64; 2]) -> Surface {
    Surface {
        shape,
        frame,
        aperture: Aperture::OPEN,
        interface: Interface::Refract,
        coating: Coating::Ideal,
        index,
    }
}

/// A mirror without edge.
pub(crate) fn mirror(frame: Frame, shape: Shape) -> Surface {
    Surface {
        interface: Interface::Reflect,
        ..lens_face(frame, shape, [1.0, 1.0])
    }
}
