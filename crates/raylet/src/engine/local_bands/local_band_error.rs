//! Why local bands cannot carry the light of a system.

use crate::engine::local_bands::settings::{BYTES_OF_VALUE, BYTES_OF_WINDOW};
use crate::engine::progress::Cancelled;

/// Why local bands cannot carry the light of a system.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LocalBandError {
    /// A screen has no edge.
    #[error("screen '{0}' has no edge; give its element an aperture")]
    Boundless(String),
    /// An element reflects and has another medium behind it.
    #[error("screen '{0}' reflects light, and has another medium behind it")]
    Mirror(String),
    /// An element has layers that are neither phases nor pixels of one lattice.
    #[error("the layers of screen '{0}' are not all phases and pixels over x and y of one lattice")]
    Layers(String),
    /// No width of windows is given for a screen.
    #[error("no width of windows is given for screen '{0}'")]
    NoWidth(String),
    /// The last screen is no sensor.
    #[error("the last screen is no sensor")]
    NoSensor,
    /// The beamlets take too much memory.
    #[error(
        "the beamlets on their way to screen '{screen}' take more memory than the limit of {limit_mb} MB"
    )]
    Memory {
        /// The screen.
        screen: String,
        /// The memory limit in MB.
        limit_mb: usize,
    },
    /// A screen has too many windows.
    #[error(
        "screen '{screen}' takes {windows:?} windows, more than the {allowed} that the memory limit allows"
    )]
    Windows {
        /// The screen.
        screen: String,
        /// Windows along x and y.
        windows: [usize; 2],
        /// Windows allowed altogether.
        allowed: usize,
    },
    /// An array of a tile is too large.
    #[error(
        "a few windows of screen '{screen}' take an array of {values} values, more than the {allowed} that the memory \
         limit allows"
    )]
    Tile {
        /// The screen.
        screen: String,
        /// Values of the array.
        values: u64,
        /// Values allowed.
        allowed: u64,
    },
    /// The progress callback cancelled the run.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Nothing is left of the light.
    #[error("no light reaches screen '{0}'")]
    NoLight(String),
}

impl LocalBandError {
    /// Whether beamlets, windows or an array take more memory than the limit allows.
    pub(crate) fn is_too_large(&self) -> bool {
        matches!(
            self,
            Self::Memory { .. } | Self::Windows { .. } | Self::Tile { .. }
        )
    }

    /// The memory limit in bytes at which this array would not be too large; nothing for another reason, and where it is
    /// unknown.
    pub(crate) fn memory_needed(&self) -> Option<usize> {
        match self {
            Self::Windows { windows, .. } => {
                let count = windows[0].saturating_mul(windows[1]);
                Some(count.saturating_mul(BYTES_OF_WINDOW))
            }
            Self::Tile { values, .. } => {
                let count = usize::try_from(*values).unwrap_or(usize::MAX);
                Some(count.saturating_mul(BYTES_OF_VALUE))
            }
            _ => None,
        }
    }
}
