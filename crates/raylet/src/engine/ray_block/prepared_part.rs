//! Surfaces and screens made ready for blocks of rays.

use fearless_simd::{Simd, SimdBase, SimdMask, f64x8, mask64x8};

use crate::engine::ray_block::bend::Bend;
use crate::engine::ray_block::passage::Passage;
use crate::math::lanes::LANES;
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::frame::Frame;
use crate::optics::refraction::{Coating, Interface};
use crate::optics::screen::Screen;
use crate::optics::shape::Shape;
use crate::optics::surface::Surface;

/// A surface or screen that rays come to from another part.
pub(crate) struct PreparedPart<'a> {
    /// From the axes of the part before to its own.
    pub passage: Passage,
    /// Its shape.
    pub shape: &'a Shape,
    /// Its edge, where rays outside are lost.
    pub edge: Edge<'a>,
    /// What it does to rays.
    pub bend: Bend,
    /// How much of the field it transmits, if it refracts.
    pub coating: Coating,
    /// Refractive index before it.
    pub index: f64,
    /// The sign of the local z along which rays must arrive, if there is one.
    pub arrives: Option<f64>,
}

/// The edge of a part.
pub(crate) enum Edge<'a> {
    /// There is none.
    Open,
    /// A circle with its centre and the square of its radius.
    Circle([f64; 2], f64),
    /// Any other.
    Any(&'a Aperture),
}

impl<'a> PreparedPart<'a> {
    /// A surface after a part with these axes.
    pub(crate) fn surface(before: &Frame, surface: &'a Surface) -> Self {
        let [index, behind] = surface.index;
        Self {
            passage: Passage::new(before, &surface.frame),
            shape: &surface.shape,
            edge: Edge::of(&surface.aperture),
            bend: match surface.interface {
                Interface::Refract => Bend::Refract(index / behind),
                Interface::Reflect => Bend::Reflect,
            },
            coating: surface.coating,
            index,
            arrives: None,
        }
    }

    /// A screen after a part with these axes; it has no edge for rays that come to it, and lets them pass.
    pub(crate) fn screen(before: &Frame, screen: &'a Screen) -> Self {
        Self {
            passage: Passage::new(before, &screen.frame),
            shape: &screen.shape,
            edge: Edge::Open,
            bend: Bend::Pass,
            coating: Coating::Unit,
            index: screen.index,
            arrives: Some(screen.arrives),
        }
    }
}

impl<'a> Edge<'a> {
    /// That of an aperture.
    pub(crate) fn of(aperture: &'a Aperture) -> Self {
        match &aperture.outline {
            Outline::Open => Edge::Open,
            Outline::Disc { radius } => Edge::Circle(aperture.centre, radius * radius),
            _ => Edge::Any(aperture),
        }
    }

    /// Which of eight points are inside.
    #[inline(always)]
    pub(crate) fn contains<S: Simd>(&self, x: f64x8<S>, y: f64x8<S>) -> mask64x8<S> {
        let simd = x.simd;
        match self {
            Edge::Open => mask64x8::splat(simd, true),
            Edge::Circle([cx, cy], square) => {
                let (x, y) = (x - *cx, y - *cy);
                (x * x + y * y).simd_le(f64x8::splat(simd, *square))
            }
            Edge::Any(aperture) => {
                let inside = |i: usize| u64::from(aperture.contains(x[i], y[i])) << i;
                mask64x8::from_bitmask(simd, (0..LANES).map(inside).fold(0, |a, b| a | b))
            }
        }
    }
}
