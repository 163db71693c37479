//! Losses: numbers that rate the light on the sensor, with their gradients.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `discrepancy` | For tests: how far the gradient of a loss is from differences of its values |
//! | [`likeness`] | Losses that compare the intensity with a picture |
//! | [`loss`] | The traits of losses of intensities and of fields, and sums of losses |
//! | [`overlap`] | The share of the light in a target mode, phase included |
//! | [`share`] | Losses by the share of the light that goes to its target |
//! | [`smoothness`] | A penalty on steps between neighbouring pixels |
//! | [`spots`] | Losses for spots: brightness and evenness |
//! | [`target`] | The target image on the sensor, on any raster |

#[cfg(test)]
pub(crate) mod discrepancy;
pub mod likeness;
pub mod loss;
pub mod overlap;
pub mod share;
pub mod smoothness;
pub mod spots;
pub mod target;
