//! A prescription row: shape, place, clear aperture, and what happens to light there.

use crate::optics::aperture::Aperture;
use crate::optics::bend::{Coating, Interface};
use crate::optics::frame::Frame;
use crate::optics::shape::Shape;

/// One refracting or reflecting surface at one wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Its shape in its own frame.
    pub shape: Shape,
    /// Where it stands.
    pub frame: Frame,
    /// The part of it that is used.
    pub aperture: Aperture,
    /// Refracting or reflecting.
    pub interface: Interface,
    /// Its field transmission.
    pub coating: Coating,
    /// Refractive index before and after it.
    pub index: [f64; 2],
}
