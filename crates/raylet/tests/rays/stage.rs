//! Hops and screens from which the tests build their systems.

use raylet::optics::frame::Frame;
use raylet::optics::screen::Screen;
use raylet::optics::shape::Shape;
use raylet::optics::surface::Surface;
use raylet::optics::system::Hop;
use raylet_testkit::parts::{self, open_screen};

/// A hop that owns its parts.
pub(crate) struct OwnedHop {
    /// Where rays start.
    pub(crate) from: Screen,
    /// The surfaces between.
    pub(crate) train: Vec<Surface>,
    /// Where they end.
    pub(crate) to: Screen,
}

impl OwnedHop {
    pub(crate) fn hop(&self) -> Hop<'_> {
        Hop {
            wavelength: 0.7e-3,
            from: &self.from,
            train: &self.train,
            to: &self.to,
        }
    }
}

/// A screen without edge; light arrives and leaves along `arrives` times its z axis.
pub(crate) fn screen(frame: Frame, index: f64, arrives: f64) -> Screen {
    Screen {
        index,
        arrives,
        ..open_screen(frame)
    }
}

/// A conic by its vertex radius and conic constant.
pub(crate) fn conic(radius: f64, constant: f64) -> Shape {
    parts::conic(1.0 / radius, constant)
}
