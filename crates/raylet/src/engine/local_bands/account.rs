//! What a hop by local bands did.

use crate::engine::error::tally::{Fate, Tally};

/// Counts and energies of one hop; those of its parts add.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HopAccount {
    /// Windows with light.
    pub windows: u64,
    /// Plane waves whose coefficients were found.
    pub modes: u64,
    /// Values of beamlets that were summed on the samples of the emitting screen's tiles.
    pub evaluations: u64,
    /// Samples of the largest tile.
    pub largest_tile: u64,
    /// Beamlets and energy by fate, in units of one window of a unit plane wave.
    pub tally: Tally,
}

impl HopAccount {
    /// Adds the account of another part.
    pub(crate) fn add(&mut self, other: &Self) {
        self.windows += other.windows;
        self.modes += other.modes;
        self.evaluations += other.evaluations;
        self.largest_tile = self.largest_tile.max(other.largest_tile);
        self.tally.merge(&other.tally);
    }

    /// Beamlets that reach the target.
    pub fn beamlets(&self) -> u64 {
        self.tally.rays(Fate::Arrived)
    }
}
