//! Fast Fourier transforms of complex numbers in double precision.
//!
//! The transforms are those of `rustfft`, which is generic: each crate that makes a plan with it compiles all of its
//! kernels again. This crate makes the plans for all others, so that the kernels are compiled once.

#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

use std::sync::Arc;

pub use rustfft::Fft;
use rustfft::FftPlanner;

/// Plans transforms, and keeps what several plans share, such as tables of roots of unity.
pub struct Planner(FftPlanner<f64>);

impl Default for Planner {
    fn default() -> Self {
        Self::new()
    }
}

impl Planner {
    /// A planner that keeps nothing yet.
    #[inline(never)]
    pub fn new() -> Self {
        Self(FftPlanner::new())
    }

    /// The plan of X_m = Σ_j x_j exp(−2πi jm/length), without a factor in front. A length of zero transforms nothing.
    #[inline(never)]
    pub fn forward(&mut self, length: usize) -> Arc<dyn Fft<f64>> {
        self.0.plan_fft_forward(length)
    }

    /// The plan of x_j = Σ_m X_m exp(+2πi jm/length), without a factor in front.
    #[inline(never)]
    pub fn inverse(&mut self, length: usize) -> Arc<dyn Fft<f64>> {
        self.0.plan_fft_inverse(length)
    }
}
