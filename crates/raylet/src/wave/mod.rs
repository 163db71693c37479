//! Waves: fields, their patches, beamlets, and hops without rays.
//!
//! | folder | what it holds |
//! | --- | --- |
//! | [`grid`] | Fields on grids: where a field is sampled, and what a screen does to it there |
//! | [`patches`] | Fields cut into patches, and the plane waves of each patch |
//! | [`beamlet`] | The waves that rays carry, and their coherent sums |
//! | [`local_bands`] | Light that is known piece by piece, each about its own carrier |
//! | [`free`] | Hops without rays, and direct sums of diffraction integrals |

#![expect(
    clippy::indexing_slicing,
    reason = "fields, spectra and their axes are indexed by loops over their own sizes"
)]

pub mod beamlet;
pub mod free;
pub mod grid;
pub mod local_bands;
pub mod patches;
