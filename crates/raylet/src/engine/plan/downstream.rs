//! Where the light of a hop goes next, as far as its directions are kept.
//!
//! Behind a stop or a rim light goes on as it came, so what would miss the end of the following hop does
//! not matter for the result, however it was carried. Elements send light anywhere.

use crate::optics::screen::{Act, Screen};
use crate::optics::surface::Surface;
use crate::optics::system::{Hop, System};

/// The hops behind one hop up to the next screen that changes directions, or the sensor.
#[derive(Clone, Debug, Default)]
pub struct Downstream<'a> {
    hops: Vec<Hop<'a>>,
}

impl<'a> Downstream<'a> {
    /// Nothing is known of what lies behind: all light counts.
    pub(crate) fn none() -> &'static Downstream<'static> {
        const { &Downstream { hops: Vec::new() } }
    }

    /// What lies behind hop `number` of a system.
    pub(crate) fn of(system: &'a System, number: usize) -> Self {
        let behind = system.hops().skip(number + 1);
        let kept = |hop: &Hop| matches!(hop.from.act, Act::Stop(_)) && hop.from.is_plane();
        Self {
            hops: behind.take_while(kept).collect(),
        }
    }

    /// Whether the light of a hop goes to the last screen of the system as it came.
    pub(crate) fn reaches_end(system: &'a System, number: usize) -> bool {
        let behind = system.hops().skip(number + 1);
        behind.count() == Self::of(system, number).hops.len()
    }

    /// Whether the light of the hop counts wherever it arrives on the second screen.
    pub(crate) fn ends_here(&self) -> bool {
        self.hops.is_empty()
    }

    /// The surfaces from the first screen of `hop` to where the light goes as it came, and the screen there;
    /// nothing where the light of `hop` ends or is sent elsewhere on its second screen.
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
            if let Act::Stop(aperture) = &hop.from.act
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
