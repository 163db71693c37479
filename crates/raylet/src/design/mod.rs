//! Designs: what changes, in which steps, and for which loss.
//!
//! | folder or file | what it holds |
//! | --- | --- |
//! | [`optimizers`] | From value and gradient to the next point |
//! | [`losses`] | Losses: numbers that rate the light on the sensor |
//! | [`constraints`] | From free parameters to pixels that can be made |
//! | [`holograms`] | Iterative Fourier transform algorithms |
//! | [`mirrors`] | Diffractive mirrors on curved substrates |
//! | [`project`] | A design: its free parameters, its loss, and the gradient |
//! | [`run`] | A design under way |
//! | [`estimator`] | Value and gradient from all beamlets, or from drawn ones |
//! | [`exact`] | Numbers written so that reading gives the same bits |

#![expect(
    clippy::indexing_slicing,
    reason = "parameters and pixels are indexed by loops over the sizes of the element they belong to"
)]

pub mod constraints;
pub mod estimator;
pub mod exact;
pub mod holograms;
pub mod losses;
pub mod mirrors;
pub mod optimizers;
pub mod project;
pub mod run;
