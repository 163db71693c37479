//! Who runs which rays.

pub mod backend;
pub mod beamlets;
pub mod budget;
pub mod census;
pub mod cpu;
pub mod fan;
pub mod plan;
pub mod rims;
pub mod settings;
pub mod simulate;
pub mod tally;
pub mod walk;
