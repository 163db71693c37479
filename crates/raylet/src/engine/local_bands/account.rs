//! What a hop by local bands did.

/// Counts and energies of one hop; those of its parts add.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HopAccount {
    /// Windows with light.
    pub windows: u64,
    /// Plane waves whose coefficients were found.
    pub modes: u64,
    /// Beamlets that reach the target.
    pub beamlets: u64,
    /// Values of beamlets that were summed on the samples of the emitting screen's tiles.
    pub evaluations: u64,
    /// Samples of the largest tile.
    pub largest_tile: u64,
    /// Energy of the plane waves that go on, in units of one window of a unit plane wave.
    pub kept: f64,
    /// Energy of those that are too weak.
    pub weak: f64,
    /// Energy of those whose rays were lost in the train.
    pub lost: f64,
    /// Energy of those that land beside the target.
    pub beside: f64,
    /// Energy times η², the square of what aberration inside beamlets would do.
    pub aberrated: f64,
    /// Energy times the square of what its correction is expected to leave.
    pub left: f64,
}

impl HopAccount {
    /// Adds the account of another part.
    pub fn add(&mut self, other: &Self) {
        self.windows += other.windows;
        self.modes += other.modes;
        self.beamlets += other.beamlets;
        self.evaluations += other.evaluations;
        self.largest_tile = self.largest_tile.max(other.largest_tile);
        self.kept += other.kept;
        self.weak += other.weak;
        self.lost += other.lost;
        self.beside += other.beside;
        self.aberrated += other.aberrated;
        self.left += other.left;
    }

    /// Relative error of the field that aberration inside beamlets would cause, and what its correction leaves.
    pub fn aberration(&self) -> [f64; 2] {
        [self.aberrated, self.left].map(|energy| (energy / self.kept).sqrt())
    }

    /// Relative size of the field that weak plane waves would bring.
    pub fn dropped(&self) -> f64 {
        (self.weak / (self.kept + self.weak)).sqrt()
    }
}
