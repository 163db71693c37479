//! Screens, surfaces and sources of small systems, in air and without edge unless a call says more.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::frame::Frame;
use raylet::optics::phase::placement::Placement;
use raylet::optics::pixels::active_area::ActiveArea;
use raylet::optics::pixels::pixel_grid::{PixelForm, Pixels};
use raylet::optics::refraction::{Coating, Interface};
use raylet::optics::screen::{Screen, ScreenKind, Sensor};
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::source::Source;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;

/// A frame with the global axes at a point of the global z axis, in mm.
pub fn on_axis(z: f64) -> Frame {
    Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, z))
}

/// A plane screen, at which light arrives towards its +z; it has the name of its kind.
pub fn screen(frame: Frame, kind: ScreenKind) -> Screen {
    let name = match &kind {
        ScreenKind::Stop(_) => "stop",
        ScreenKind::Doe(_) => "element",
        ScreenKind::Sensor(_) => "sensor",
    };
    Screen {
        name: name.to_owned(),
        frame,
        shape: Shape::Plane,
        kind,
        index: 1.0,
        behind: None,
        arrives: 1.0,
    }
}

/// A plane screen without edge.
pub fn open_screen(frame: Frame) -> Screen {
    screen(frame, ScreenKind::Stop(Aperture::OPEN))
}

/// An element of one layer.
pub fn element(layer: Layer, aperture: Aperture) -> Doe {
    Doe {
        layers: vec![layer],
        aperture,
        reflect: false,
    }
}

/// Square pixels of this pitch in mm, [y, x].
pub fn pixel_layer(values: Array2<Complex64>, pitch: f64, form: PixelForm) -> Layer {
    Layer::Pixels(Pixels {
        pitch: [pitch; 2],
        values,
        form,
        active: ActiveArea::WHOLE,
        placement: Placement::NONE,
    })
}

/// An element of square box pixels of this pitch in mm, [y, x], which end where the pixels do.
pub fn box_pixels(values: Array2<Complex64>, pitch: f64) -> ScreenKind {
    let layer = pixel_layer(values, pitch, PixelForm::Box);
    ScreenKind::Doe(element(layer, Aperture::OPEN))
}

/// A sensor of `count`² pixels of this pitch in mm.
pub fn sensor(count: usize, pitch: f64) -> ScreenKind {
    ScreenKind::Sensor(Sensor {
        pixels: [count; 2],
        pitch: [pitch; 2],
    })
}

/// A conic by its curvature in 1/mm and its conic constant.
pub fn conic(curvature: f64, conic: f64) -> Shape {
    Shape::Conic(Conic { curvature, conic })
}

/// A refracting surface, ideally coated, with the indices before and behind it.
pub fn face(frame: Frame, shape: Shape, index: [f64; 2]) -> Surface {
    Surface {
        shape,
        frame,
        aperture: Aperture::OPEN,
        interface: Interface::Refract,
        coating: Coating::Ideal,
        index,
    }
}

/// A mirror.
pub fn mirror(frame: Frame, shape: Shape) -> Surface {
    Surface {
        interface: Interface::Reflect,
        ..face(frame, shape, [1.0, 1.0])
    }
}

/// Collimated light with direction cosines `p`, phase zero at the global origin.
pub fn plane_wave([px, py]: [f64; 2]) -> Source {
    let q = (1.0 - px * px - py * py).sqrt();
    Source::Plane {
        direction: Vec3::new(px, py, q),
        origin: Vec3::new(0.0, 0.0, 0.0),
    }
}

/// A system of wavelength one, lit along the axis.
pub fn lit(screens: Vec<Screen>, trains: Vec<Vec<Surface>>) -> System {
    System {
        wavelength: 1.0,
        source: plane_wave([0.0, 0.0]),
        screens,
        trains,
    }
}
