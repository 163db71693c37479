//! Who runs which rays.

pub mod account;
pub mod advice;
pub mod backend;
pub mod beamlets;
pub mod budget;
pub mod carry;
pub mod census;
pub mod cpu;
pub mod eikonal;
pub mod fan;
pub mod forecast;
pub mod paper;
pub mod plan;
pub mod plane;
pub mod reason;
pub mod reference;
pub mod rims;
pub mod route;
pub mod seat;
pub mod settings;
pub mod simulate;
pub mod sketch;
pub mod survey;
pub mod tally;
pub mod tube;
pub mod walk;
