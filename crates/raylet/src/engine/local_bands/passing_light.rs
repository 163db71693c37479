//! The light of a smooth source that passes bare apertures without touching their edges.
//!
//! Where a bare aperture is open, light goes on as it came. So of a smooth source the beamlets that land well inside are launched
//! again at the source, on the way past the aperture to the next screen, as if it were not there. Only the others are summed and
//! cut into windows, next to the edge. The aberration inside a beamlet grows with the way: where it is too large on the longer one,
//! the beamlets of a tile are summed as well.

use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::source::source_aberration::{SourceAberration, source_aberration};
use crate::optics::aperture::Aperture;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::source::Source;
use crate::optics::surface::Surface;
use crate::optics::system::{Hop, System};
use crate::wave::beamlet::wavelet::Arrival;

/// What the beamlets of a source that have passed all apertures so far start with, tile by tile.
pub(crate) type PassingStarts = Vec<Vec<ChirpedStart>>;

/// The part of the cubic phase inside such beamlets that is left in the field. Among alike neighbours it cancels; where those begin
/// that touch the edge, it does not. Behind a rim of the double Gauss lens, with windows of 0.21 and 0.11 mm, it is 0.1 and 0.08.
pub(crate) const LEFT_OF_CUBIC: f64 = 0.1;

/// Tiles pass whose beamlets leave at most so many times what is allowed on average.
const AT_MOST: f64 = 10.0;

/// The way of such light from the source to a screen.
pub(crate) struct OpenWay<'a> {
    wavelength: f64,
    from: &'a Screen,
    train: Vec<Surface>,
    to: &'a Screen,
}

impl<'a> OpenWay<'a> {
    /// To the end of the hop with this number; nothing where there is none.
    pub(crate) fn to_end_of(system: &'a System, number: usize) -> Option<Self> {
        Some(Self {
            wavelength: system.wavelength,
            from: system.screens.first()?,
            train: system.trains.get(..=number)?.concat(),
            to: system.screens.get(number + 1)?,
        })
    }

    /// As one hop.
    pub(crate) fn hop(&self) -> Hop<'_> {
        Hop {
            wavelength: self.wavelength,
            from: self.from,
            train: &self.train,
            to: self.to,
        }
    }
}

/// The bare aperture in a plane that a screen is; nothing for other screens.
pub(crate) fn bare(screen: &Screen) -> Option<&Aperture> {
    match &screen.kind {
        ScreenKind::Stop(aperture) if screen.is_plane() && screen.behind.is_none() => {
            Some(aperture)
        }
        _ => None,
    }
}

/// A bare aperture that light may pass.
pub(crate) struct OpenGate<'a> {
    aperture: &'a Aperture,
    source: &'a Source,
    /// The way on to the screen behind it.
    onward: OpenWay<'a>,
    /// The aberration inside beamlets on that way may be as large as this.
    allowed: f64,
}

impl<'a> OpenGate<'a> {
    /// At the end of the hop with this number; nothing where no bare aperture in a plane stands there.
    pub(crate) fn at_end_of(system: &'a System, number: usize, allowed: f64) -> Option<Self> {
        let screen = system.screens.get(number + 1)?;
        Some(Self {
            aperture: bare(screen)?,
            source: &system.source,
            onward: OpenWay::to_end_of(system, number + 1)?,
            allowed,
        })
    }

    /// Whether the beamlets of a tile may pass, by the aberration inside the middle one of them.
    pub(crate) fn lets_pass(&self, tile: &[ChirpedStart]) -> bool {
        let middle = tile.get(tile.len() / 2);
        let found =
            middle.and_then(|middle| source_aberration(middle, &self.onward.hop(), self.source));
        let left = |found: SourceAberration| found.error().with_part_of_cubic(LEFT_OF_CUBIC).left;
        found.is_some_and(|found| left(found) <= AT_MOST * self.allowed)
    }

    /// Whether a beamlet that ends at the share `edge` of its peak does not touch the edge of the aperture.
    pub(crate) fn holds(&self, beamlet: &Arrival, k: f64, edge: f64) -> bool {
        let [x, y] = beamlet.at;
        let reach = beamlet.footprint(k, edge);
        self.aperture.depth(x, y) > reach[0].max(reach[1])
    }
}
