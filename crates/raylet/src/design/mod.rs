//! What should change.

pub mod conformal;
pub mod hologram;
pub mod near;
pub mod patterns;
pub mod problems;
pub mod smiley;
pub mod start;
pub mod target;
