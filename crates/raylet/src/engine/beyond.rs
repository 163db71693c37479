//! Where the light of a hop goes next, as far as its directions are kept.
//!
//! Behind a stop or a rim light goes on as it came, so what would miss the end of the following hop does
//! not matter for the result, however it was carried. Elements send light anywhere.

use crate::optics::screen::Act;
use crate::optics::system::{Hop, System};

/// The hops behind one hop up to the next screen that changes directions, or the sensor.
#[derive(Clone, Debug, Default)]
pub struct Beyond<'a> {
    hops: Vec<Hop<'a>>,
}

impl<'a> Beyond<'a> {
    /// Nothing is known of what lies behind: all light is wanted.
    pub fn none() -> &'static Beyond<'static> {
        const { &Beyond { hops: Vec::new() } }
    }

    /// What lies behind hop `number` of a system.
    pub fn of(system: &'a System, number: usize) -> Self {
        let behind = system.hops().skip(number + 1);
        let kept = |hop: &Hop| matches!(hop.from.act, Act::Stop(_)) && hop.from.is_plane();
        Self {
            hops: behind.take_while(kept).collect(),
        }
    }

    /// Whether a ray that arrives at (x, y) with these cosines goes on to where the light is wanted.
    pub fn is_wanted(&self, at: [f64; 2], cosines: [f64; 2]) -> bool {
        let (mut at, mut p) = (at, cosines);
        for hop in &self.hops {
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
