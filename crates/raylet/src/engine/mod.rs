//! Who runs which rays.

pub mod budget;
pub mod walk;
