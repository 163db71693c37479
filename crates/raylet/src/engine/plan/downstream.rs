//! The hops that follow a hop, as far as the directions of its light are kept.
//!
//! A stop or a rim does not change directions, so light that would miss the end of the following hop does
//! not matter for the result, whatever method propagated it. Elements send light in all directions.

use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::surface::Surface;
use crate::optics::system::{Hop, System};

/// The hops behind one hop up to the next screen that changes directions, or the sensor.
#[derive(Clone, Debug, Default)]
pub struct Downstream<'a> {
    hops: Vec<Hop<'a>>,
}

impl<'a> Downstream<'a> {
    /// No hops: all light that arrives on the second screen counts.
    pub(crate) fn none() -> &'static Downstream<'static> {
        const { &Downstream { hops: Vec::new() } }
    }

    /// The hops behind hop `number` of a system.
    pub(crate) fn of(system: &'a System, number: usize) -> Self {
        let behind = system.hops().skip(number + 1);
        let kept = |hop: &Hop| matches!(hop.from.kind, ScreenKind::Stop(_)) && hop.from.is_plane();
        Self {
            hops: behind.take_while(kept).collect(),
        }
    }

    /// Whether no screen between hop `number` and the last screen of the system changes the directions of light.
    pub(crate) fn reaches_end(system: &'a System, number: usize) -> bool {
        let behind = system.hops().skip(number + 1);
        behind.count() == Self::of(system, number).hops.len()
    }

    /// Whether the light of the hop counts wherever it arrives on the second screen.
    pub(crate) fn ends_here(&self) -> bool {
        self.hops.is_empty()
    }

    /// The surfaces between the first screen of `hop` and the last screen that its light reaches in unchanged
    /// directions, and that screen; `None` where the second screen of `hop` is the sensor or changes the directions.
    pub(crate) fn joined(&self, hop: &Hop) -> Option<(Vec<Surface>, &'a Screen)> {
        let last = self.hops.last()?;
        let behind = self.hops.iter().flat_map(|hop| hop.train);
        let train = hop.train.iter().chain(behind).cloned().collect();
        Some((train, last.to))
    }

    /// Whether a ray that arrives at (x, y) with these cosines goes on to where the light counts.
    pub(crate) fn is_relevant(&self, at: [f64; 2], cosines: [f64; 2]) -> bool {
        let (mut at, mut p) = (at, cosines);
        for hop in &self.hops {
            if let ScreenKind::Stop(aperture) = &hop.from.kind
                && !aperture.contains(at[0], at[1])
            {
                return false;
            }
            let Ok(landing) = hop.trace(at, p, &mut ()) else {
                return false;
            };
            (at, p) = (landing.at, landing.cosines);
        }
        let Some(bounds) = self.hops.last().and_then(|hop| hop.to.bounds()) else {
            return true;
        };
        (0..2).all(|a| (bounds[2 * a]..=bounds[2 * a + 1]).contains(&at[a]))
    }
}
