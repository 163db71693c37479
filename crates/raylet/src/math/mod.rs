//! Numbers, no light.

#![expect(
    clippy::indexing_slicing,
    reason = "arrays and lists of numbers whose sizes are made, or asserted, beside the loops that run over them"
)]

pub mod chebyshev;
pub mod chirp;
pub mod commensurate_dft;
pub mod complex;
mod double;
pub mod draw;
pub mod erfc;
pub mod hilbert;
pub mod interleaved_dft;
pub mod jet;
mod kaiser;
pub mod lanes;
pub(crate) mod lines;
#[cfg(test)]
pub(crate) mod noise;
pub mod nufft;
pub mod part;
pub mod random;
pub mod real;
pub mod simd_packet;
pub mod spline;
mod tiles;
pub mod vec3;
