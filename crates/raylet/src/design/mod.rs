//! What should change.

pub mod conformal;
pub mod hologram;
pub mod patterns;
pub mod target;
