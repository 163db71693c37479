//! Why a run of a whole system is impossible.

use crate::engine::chain::hop_run::HopError;
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::plan::plan_error::PlanError;
use crate::engine::plan::settings::BYTES_OF_SAMPLE;
use crate::engine::progress::Cancelled;
use crate::math::nufft::NufftError;
use crate::wave::grid::sampling::SamplingError;

/// Why a run is impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulateError {
    /// A hop has no plan.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A screen cannot be sampled.
    #[error(transparent)]
    Sampling(#[from] SamplingError),
    /// The last screen is no sensor.
    #[error("the last screen is '{0}', expected a sensor")]
    NoSensor(String),
    /// Nothing is left of the light.
    #[error("no light leaves screen '{0}'")]
    NoLight(String),
    /// A field came out that is no number.
    #[error("the field on screen '{0}' is not finite")]
    NotFinite(String),
    /// The sum of plane waves cannot be planned.
    #[error(transparent)]
    Sum(#[from] NufftError),
    /// Local bands cannot carry the light.
    #[error(transparent)]
    LocalBands(LocalBandError),
    /// A whole field is too large, and local bands cannot carry the light.
    #[error("{whole}; nor can local bands carry the light, which need no such field: {bands}")]
    TooLarge {
        /// What is too large.
        whole: Box<SimulateError>,
        /// Why local bands cannot carry the light.
        bands: LocalBandError,
    },
    /// The progress callback cancelled the run.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<LocalBandError> for SimulateError {
    fn from(error: LocalBandError) -> Self {
        match error {
            LocalBandError::Cancelled(error) => Self::Cancelled(error),
            error => Self::LocalBands(error),
        }
    }
}

impl SimulateError {
    /// Whether an array or a number of patches is larger than the memory limit allows.
    pub(crate) fn is_too_large(&self) -> bool {
        match self {
            Self::Sampling(SamplingError::TooLarge { .. }) => true,
            Self::Plan(error) => matches!(
                error,
                PlanError::Modes { .. } | PlanError::Patches { .. } | PlanError::Directions { .. }
            ),
            _ => false,
        }
    }
}

impl SimulateError {
    /// The screen that needs too much memory.
    pub(crate) fn too_large(&self) -> Option<&str> {
        match self {
            Self::Sampling(SamplingError::TooLarge { screen, .. }) => Some(screen),
            Self::Plan(
                PlanError::Modes { screen, .. }
                | PlanError::Patches { screen, .. }
                | PlanError::Directions { from: screen, .. },
            ) => Some(screen),
            Self::LocalBands(
                LocalBandError::Windows { screen, .. } | LocalBandError::Tile { screen, .. },
            ) => Some(screen),
            Self::TooLarge { whole, .. } => whole.too_large(),
            _ => None,
        }
    }

    /// The memory limit in bytes at which this array would not be too large; nothing if the run is refused for another
    /// reason. Others may be too large then.
    pub(crate) fn memory_needed(&self) -> Option<usize> {
        match self {
            Self::Sampling(SamplingError::TooLarge {
                needed, needed_y, ..
            }) => {
                let samples = needed.saturating_mul(*needed_y);
                Some(samples.saturating_mul(BYTES_OF_SAMPLE))
            }
            Self::Plan(error) => error.memory_needed(),
            Self::LocalBands(error) => error.memory_needed(),
            Self::TooLarge { whole, bands } => {
                let needs = [whole.memory_needed(), bands.memory_needed()];
                needs.into_iter().flatten().min()
            }
            _ => None,
        }
    }
}

impl From<HopError> for SimulateError {
    fn from(error: HopError) -> Self {
        match error {
            HopError::Sum(error) => Self::Sum(error),
            HopError::Cancelled(error) => Self::Cancelled(error),
        }
    }
}
