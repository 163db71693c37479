//! Who runs which rays.

pub mod walk;
