//! The error budget of a run: what became of rays and energy, and what the user should know.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`advice`] | Warnings and hints about a system before a run |
//! | `crossing` | Parts that cross inside their openings |
//! | [`error_budget`] | The expected error of a hop, by cause and altogether |
//! | [`hop_statistics`] | What a hop by local bands did |
//! | `missed_light` | Light that misses an opening: of a beam the first, of rays the next |
//! | `part_advice` | Warnings about the parts of a hop, whatever method carries it |
//! | `lost_light` | Where the light goes that no beamlet follows |
//! | [`run_warnings`] | What a user must know of a result |
//! | [`tally`] | Rays and energy of a hop by fate |
//! | `window_error` | The error of the windows of a beamlet sum, by their distance and period |

pub mod advice;
pub(crate) mod crossing;
pub mod error_budget;
pub mod hop_statistics;
pub(crate) mod lost_light;
pub(crate) mod missed_light;
pub(crate) mod part_advice;
pub mod run_warnings;
pub mod tally;
pub(crate) mod window_error;
