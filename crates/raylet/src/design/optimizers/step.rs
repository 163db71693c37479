//! What an optimiser returns when a value and a gradient are reported to it.

use serde::{Deserialize, Serialize};

use crate::design::optimizers::space::SpaceError;

/// The verdict of an optimiser on the point whose value was reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// It ends an iteration: the search goes on from it. The very first point counts as one.
    Accepted,
    /// It was a trial of a line search, which tries another one.
    Trial,
    /// The line search found nothing better. The search goes on from the last accepted point, without
    /// what it remembered.
    Restarted,
    /// The search is over; [`Stop`] says why.
    Finished(Stop),
}

/// Why a search is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stop {
    /// The gradient is below its limit.
    Flat,
    /// The change of the value is below its limit.
    Still,
    /// Steepest descent finds nothing better either, because of rounding or because the gradient is not the value's.
    Stuck,
    /// The value or the gradient is not a number.
    NotFinite,
}

/// Why an optimiser cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OptimizerError {
    /// The starting point does not fit the parameters.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// A setting without meaning.
    #[error("{name} is {value}; expected {expected}")]
    Setting {
        /// Its name.
        name: &'static str,
        /// What was found.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
}

/// Refuses a setting that is not `good`.
///
/// # Errors
/// When it is not.
pub(crate) fn demand(
    good: bool,
    name: &'static str,
    value: f64,
    expected: &'static str,
) -> Result<(), OptimizerError> {
    if good {
        return Ok(());
    }
    Err(OptimizerError::Setting {
        name,
        value,
        expected,
    })
}

/// Whether a number is one whose square is finite, as values, slopes and steps of a search are.
pub fn is_moderate(number: f64) -> bool {
    number.abs() < 1e150
}

/// Why a search that was read is none of these parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SavedError {
    /// By another method.
    #[error("a search by another method")]
    Method,
    /// With other settings, bounds or scales.
    #[error("a search with other settings, bounds or scales")]
    Settings,
    /// A list of another length, or with what no search leaves.
    #[error("a search whose {0} no search leaves so")]
    Content(&'static str),
}
