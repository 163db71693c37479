//! One ray of the source's light on a screen, with its energy.

use crate::optics::system::Hop;

/// A ray that stands on a screen before the screen acts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SourceRay {
    /// Its place in mm.
    pub at: [f64; 2],
    /// Its optical direction cosines.
    pub p: [f64; 2],
    /// The energy it represents.
    pub energy: f64,
    /// Half the widths of the optical cosines that it stands for; zero for light of one direction.
    pub spread: [f64; 2],
}

/// The normal cosine of a direction: what a plane wave of unit amplitude carries through the screen.
pub(crate) fn obliquity(hop: &Hop, p: [f64; 2]) -> f64 {
    let sine = p[0].hypot(p[1]) / hop.from.index_behind();
    (1.0 - sine * sine).max(0.0).sqrt()
}
