//! raylet-paper: the source paper's studies and systems, done again.

#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

pub mod conformal;
pub mod conformal_chart;
pub mod conformal_seen;
pub mod convergence;
pub mod covering;
pub mod covering_chart;
pub mod flat_patch;
pub mod mirror_chart;
pub mod posed;
pub mod trial;
