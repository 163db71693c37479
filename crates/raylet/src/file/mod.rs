//! How it is written down.

pub mod catalog;
