//! What should change.

pub mod hologram;
pub mod target;
