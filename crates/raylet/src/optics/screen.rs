//! Screens: where a field lives, and what acts on it there.

use crate::optics::aperture::Aperture;
use crate::optics::doe::Doe;
use crate::optics::frame::Frame;

/// A plane on which the complex field is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Screen {
    /// Name shown to users.
    pub name: String,
    /// Its place; the field is a function of its local x and y.
    pub frame: Frame,
    /// What acts there.
    pub act: Act,
    /// Refractive index around it.
    pub index: f64,
    /// +1 when light arrives towards the local +z, −1 when it arrives towards −z.
    pub arrives: f64,
}

/// What happens to light on a screen.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// An opening: what is outside is blocked.
    Stop(Aperture),
    /// A diffractive element.
    Doe(Doe),
    /// The end: a grid of sample points at the pixel centres.
    Sensor(Sensor),
}

/// The sample points of a sensor: `pixels` [nx, ny] of `pitch` mm, centred on the screen's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Number of pixels along x and y.
    pub pixels: [usize; 2],
    /// Distance of neighbouring pixels along x and y, in mm.
    pub pitch: [f64; 2],
}

impl Screen {
    /// +1 when light leaves towards the local +z, −1 when it leaves towards −z.
    pub fn leaves(&self) -> f64 {
        match &self.act {
            Act::Doe(doe) if doe.reflect => -self.arrives,
            _ => self.arrives,
        }
    }

    /// The part of the screen that matters, `[x_min, x_max, y_min, y_max]` in mm: the opening of a stop
    /// or element, the outline of a sensor; nothing when it has no edge.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        match &self.act {
            Act::Stop(aperture) => aperture.bounds(),
            Act::Doe(doe) => doe.bounds(),
            Act::Sensor(sensor) => {
                let half = |i: usize| 0.5 * sensor.pixels[i] as f64 * sensor.pitch[i];
                Some([-half(0), half(0), -half(1), half(1)])
            }
        }
    }
}
