//! What may be chosen about a run with local bands.

use std::f64::consts::{PI, TAU};

use crate::engine::error::window_error::{left_by_lattice, period_error, ripple};
use crate::wave::local_bands::edge_mask::PASSBAND;
use crate::wave::local_bands::tiling::WindowShape;

/// The settings of a run by local bands.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalBandSettings {
    /// Width σ of the windows of each screen but the last, in mm.
    pub sigmas: Vec<f64>,
    /// Distance of neighbouring windows in σ.
    pub step: f64,
    /// Period of the plane waves of a window in σ.
    pub period: f64,
    /// Plane waves weaker than this share of the strongest are left out; beamlets end at this share of their peak.
    pub threshold: f64,
    /// The relative error that plane waves which are left out may cause; nothing where `threshold` decides on them.
    pub dropped: Option<f64>,
    /// Windows along each side of a tile.
    pub tile: usize,
    /// Nodes per σ where an edge cuts a window.
    pub edge_nodes: f64,
    /// Whether what an edge sends to a sensor beyond usual nodes is summed along the edge, also where finer nodes resolve it.
    pub edge_sums: bool,
    /// Whether the aberration inside beamlets is corrected.
    pub corrected: bool,
    /// Whether the aperture of the first screen cuts light, where that screen is a stop.
    pub aperture: SourceAperture,
    /// Most bytes that the beamlets of a run may take.
    pub memory_limit: usize,
}

/// The windows of one hop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalBandPlan {
    /// Width σ in mm.
    pub sigma: f64,
    /// Distance of neighbouring windows in σ.
    pub step: f64,
    /// Period of the plane waves of a window in σ.
    pub period: f64,
    /// Number of windows along x and y of the first screen's box.
    pub windows: [usize; 2],
    /// Whether they are of a smooth source, which has one direction in each.
    pub smooth: bool,
    /// Whether the aberration inside beamlets is corrected.
    pub corrected: bool,
}

/// Whether the aperture of the first screen cuts light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SourceAperture {
    /// It does not: it only limits the places of windows. For apertures that are wider than the next one.
    #[default]
    Soft,
    /// It cuts the light, which is diffracted.
    Hard,
}

/// Distance of the windows of a smooth source in σ: their sum is even to 1e-5.
pub(crate) const SOURCE_STEP: f64 = 1.25;

/// Bytes of the memory limit for each value of a tile's array: it takes this part of the memory at most.
const SHARE_OF_ARRAY: usize = 32;
pub(crate) const BYTES_OF_VALUE: usize = SHARE_OF_ARRAY * size_of::<num_complex::Complex64>();

/// What a window takes in memory at least, in bytes: some of its beamlets.
pub(crate) const BYTES_OF_WINDOW: usize = 256;

/// The usual distance of windows in σ.
pub const STEP: f64 = 1.25;

/// Usual windows along each side of a tile.
pub(crate) const TILE: usize = 4;

impl LocalBandPlan {
    /// The relative error of the field that the lattice and the period of windows bring, with this root mean square
    /// cubic phase inside beamlets (rad): what the lattice leaves of that phase, and the tails of neighbouring periods. A smooth
    /// source has no spectra with a period, and Gaussians that add up to one nearly.
    pub(crate) fn window_error(&self, cubic_phase: f64) -> f64 {
        match self.smooth {
            true => ripple(self.step),
            false => (left_by_lattice(self.step) * cubic_phase).hypot(period_error(self.period)),
        }
    }

    /// The part of dropped plane waves that shows in the field, as a ratio of amplitudes: there are (period/step)²
    /// times more plane waves than the field has numbers, and the sum over windows cancels what no field has.
    pub(crate) fn share_of_dropped(&self) -> f64 {
        self.step / self.period
    }
}

impl LocalBandSettings {
    /// The usual settings with these widths of windows.
    pub fn new(sigmas: Vec<f64>) -> Self {
        Self {
            sigmas,
            step: STEP,
            period: 6.5,
            threshold: 1e-3,
            dropped: None,
            tile: TILE,
            edge_nodes: 16.0,
            edge_sums: false,
            corrected: true,
            aperture: SourceAperture::Soft,
            memory_limit: 4 << 30,
        }
    }

    /// How far from a window's centre, in σ, an edge counts in directions that the usual nodes do not resolve.
    ///
    /// An edge at a depth of d σ sends the share exp(-d²)/(2π√π·kσs) of the energy of a window of a plane wave beyond the
    /// direction s, and nodes of a pitch of σ over n resolve kσs = 2πn times their passband. That share may be the square of the
    /// error which dropped plane waves may cause.
    pub(crate) fn seen_edge(&self) -> f64 {
        let resolved = PASSBAND * TAU * self.edge_nodes;
        let beyond = 1.0 / (TAU * PI.sqrt() * resolved);
        let allowed = self.dropped.unwrap_or(self.threshold).powi(2);
        (beyond / allowed).ln().max(0.0).sqrt()
    }

    /// The direction beside light of a wavenumber `k` up to which usual nodes at an edge resolve it, under windows of a width in mm.
    pub(crate) fn resolved(&self, k: f64, sigma: f64) -> f64 {
        PASSBAND * TAU * self.edge_nodes / (k * sigma)
    }

    /// Complex values that one array of a tile may have.
    pub(crate) fn values_allowed(&self) -> u64 {
        (self.memory_limit / BYTES_OF_VALUE) as u64
    }

    /// Windows that a screen may have.
    pub(crate) fn windows_allowed(&self) -> usize {
        self.memory_limit / BYTES_OF_WINDOW
    }

    /// The windows of a screen; nothing where no width is given.
    pub(crate) fn windows(&self, screen: usize) -> Option<WindowShape> {
        let sigma = *self.sigmas.get(screen)?;
        (sigma > 0.0).then_some(WindowShape {
            sigma,
            step: self.step,
            period: self.period,
        })
    }
}
