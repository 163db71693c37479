//! A prescription row: shape, place, clear aperture, and what happens to light there.

use crate::math::real::Real;
use crate::math::vec3::Vec3;
use crate::optics::aperture::Aperture;
use crate::optics::frame::{Axes, Frame};
use crate::optics::ray::Loss;
use crate::optics::refraction::{Coating, Interface};
use crate::optics::shape::{Height, Shape};

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

impl Surface {
    /// The surface without its edge.
    pub(crate) fn without_edge(&self) -> Self {
        Self {
            aperture: Aperture::OPEN,
            ..self.clone()
        }
    }
}

/// The surfaces of a train without their edges.
pub(crate) fn without_edges(train: &[Surface]) -> Vec<Surface> {
    train.iter().map(Surface::without_edge).collect()
}

/// A surface as a ray of numbers `T` meets it: one that stands still, or one that moves and bends.
pub(crate) trait Face<T: Real> {
    /// Its axes.
    type Axes: Axes<T>;
    /// The surface as it is.
    fn surface(&self) -> &Surface;
    /// Where it stands.
    fn axes(&self) -> &Self::Axes;
    /// Refractive index before and after it.
    fn index(&self) -> [T; 2];
    /// Height and derivatives at (x, y); nothing where the surface does not exist.
    fn height(&self, x: T, y: T) -> Option<Height<T>>;
    /// The distance along a ray (local position and unit direction) to it.
    ///
    /// # Errors
    /// [`Loss::Missed`] when they do not meet.
    fn meet(&self, position: Vec3<T>, direction: Vec3<T>) -> Result<T, Loss>;
}

impl<T: Real> Face<T> for Surface {
    type Axes = Frame;
    #[inline(always)]
    fn surface(&self) -> &Surface {
        self
    }
    #[inline(always)]
    fn axes(&self) -> &Frame {
        &self.frame
    }
    #[inline(always)]
    fn index(&self) -> [T; 2] {
        self.index.map(T::constant)
    }
    #[inline(always)]
    fn height(&self, x: T, y: T) -> Option<Height<T>> {
        self.shape.height(x, y)
    }
    #[inline(always)]
    fn meet(&self, position: Vec3<T>, direction: Vec3<T>) -> Result<T, Loss> {
        self.shape.meet(position, direction)
    }
}
