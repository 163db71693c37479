//! Why a system cannot be differentiated.

use crate::engine::chain::hop_run::{HopAdjointError, HopError};
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::progress::Cancelled;

/// Why a system cannot be differentiated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinearisedSystemError {
    /// It cannot be simulated.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// Parameters of the system cannot be designed with drawn beamlets.
    #[error(
        "drawn beamlets have gradients of pixels only, not of the system's parameters; follow all of them"
    )]
    Drawn,
    /// A control variate is of one hop.
    #[error(
        "a control variate takes one element and its sensor, with no rim that cuts light; there are {0} hops"
    )]
    ControlVariate(usize),
    /// The perturbed systems have other parts.
    #[error(
        "with parameter {0} a little smaller or larger the system has other parts, as when a rim begins to \
         cut light: it has no derivative there"
    )]
    Parts(usize),
    /// A system of other hops than the one that was planned.
    #[error("a system of {found} hops where {planned} are planned")]
    Hops {
        /// Hops of the planned system, rims that diffract among them.
        planned: usize,
        /// Those of the other one.
        found: usize,
    },
    /// The surface of a screen changes.
    #[error(
        "parameter {parameter} changes the surface of screen '{screen}', which whole fields do not follow; local bands do \
         (method local_bands)"
    )]
    Substrate {
        /// Index of the parameter.
        parameter: usize,
        /// Name of the screen.
        screen: String,
    },
    /// Local bands have no whole fields from which beamlets could be drawn.
    #[error(
        "a control variate takes whole fields, and local bands carry this system; set the method to beamlet, or leave the \
         estimator out"
    )]
    LocalBands,
    /// A method without gradients.
    #[error("gradients go through free hops and beamlets; method '{0}' has none")]
    Method(&'static str),
    /// The system is no longer like the one that was planned.
    #[error(
        "between '{0}' and '{1}' the system is not free any more as when it was planned; set the method to \
         beamlet"
    )]
    Moved(String, String),
}

impl From<Cancelled> for LinearisedSystemError {
    fn from(error: Cancelled) -> Self {
        Self::Simulate(error.into())
    }
}

impl From<HopError> for LinearisedSystemError {
    fn from(error: HopError) -> Self {
        Self::Simulate(error.into())
    }
}

impl From<HopAdjointError> for LinearisedSystemError {
    fn from(error: HopAdjointError) -> Self {
        match error {
            HopAdjointError::NoAdjoint(method) => Self::Method(method),
            HopAdjointError::NotFree(from, to) => Self::Moved(from, to),
            HopAdjointError::Cancelled(error) => error.into(),
        }
    }
}

impl From<LocalBandError> for LinearisedSystemError {
    fn from(error: LocalBandError) -> Self {
        Self::Simulate(error.into())
    }
}
