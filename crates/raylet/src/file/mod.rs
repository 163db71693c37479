//! How it is written down.

pub(crate) mod axis;
pub mod catalog;
pub mod chart;
pub mod colour;
pub mod figure;
pub mod image;
pub(crate) mod label;
pub mod layout;
pub mod panel;
pub mod picture;
pub(crate) mod svg;
