//! What should change.

pub mod hologram;
pub mod patterns;
pub mod target;
