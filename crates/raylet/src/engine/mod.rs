//! Who runs which rays.

pub mod backend;
pub mod beamlets;
pub mod budget;
pub mod cpu;
pub mod fan;
pub mod paper;
pub mod plan;
pub mod plane;
pub mod settings;
pub mod simulate;
pub mod tally;
pub mod walk;
