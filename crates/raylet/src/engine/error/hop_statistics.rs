//! What a hop by local bands did.

use crate::engine::error::tally::{Fate, Tally};

/// Counts and energies of one hop; those of its parts add.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HopStatistics {
    /// Windows with light.
    pub windows: u64,
    /// Plane waves whose coefficients were found.
    pub modes: u64,
    /// Values of beamlets that were summed on the samples of the emitting screen's tiles.
    pub evaluations: u64,
    /// Values of the largest array of a tile: samples, nodes of the element, or plane waves of a window. Tiles with more of
    /// them than memory allows are not worked on.
    pub largest_array: u64,
    /// Beamlets and energy by fate, in units of one window of a unit plane wave.
    pub tally: Tally,
}

impl HopStatistics {
    /// Adds the statistics of another part.
    pub(crate) fn add(&mut self, other: &Self) {
        self.windows += other.windows;
        self.modes += other.modes;
        self.evaluations += other.evaluations;
        self.note_array(other.largest_array);
        self.tally.merge(&other.tally);
    }

    /// Takes note of an array of so many values.
    pub(crate) fn note_array(&mut self, values: u64) {
        self.largest_array = self.largest_array.max(values);
    }

    /// Beamlets that reach the target.
    pub fn beamlets(&self) -> u64 {
        self.tally.rays(Fate::Arrived)
    }
}
