//! How it is written down.

pub mod catalog;
pub mod fault;
pub mod origin;
