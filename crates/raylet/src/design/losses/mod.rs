//! Losses: what is wanted of the light on the sensor, with its gradient.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`likeness`] | Losses that compare the intensity with a picture |
//! | [`loss`] | The traits of losses of intensities and of fields, and sums of losses |
//! | [`overlap`] | The share of the light in a wanted mode, phase included |
//! | [`share`] | Losses that ask how much of the light goes where it is wanted |
//! | [`smoothness`] | A price for steps between neighbouring pixels |
//! | [`spots`] | Losses for spots: brightness and evenness |
//! | [`target`] | The image wanted on the sensor, on any raster |

#[cfg(test)]
pub(crate) mod discrepancy;
pub mod likeness;
pub mod loss;
pub mod overlap;
pub mod share;
pub mod smoothness;
pub mod spots;
pub mod target;
