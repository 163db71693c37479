//! Who runs which rays.

pub mod account;
pub mod advice;
pub mod backend;
pub mod beamlets;
pub mod budget;
pub mod cpu;
pub mod fan;
pub mod forecast;
pub mod paper;
pub mod plan;
pub mod plane;
pub mod reason;
pub mod settings;
pub mod simulate;
pub mod sketch;
pub mod tally;
pub mod walk;
