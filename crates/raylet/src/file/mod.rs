//! How it is written down.

pub mod array;
pub mod arrays;
pub(crate) mod axis;
pub mod blame;
pub mod build;
pub mod catalog;
pub mod chart;
mod check;
pub mod colour;
pub mod comparison;
pub mod contrast;
pub mod convergence;
mod decode;
pub mod element;
pub mod fault;
pub mod figure;
pub mod folder;
pub mod hidden;
pub mod hologram;
pub mod image;
pub(crate) mod label;
pub mod layer;
pub mod layout;
pub mod machine;
pub mod material;
mod misfit;
pub mod npz;
mod number;
pub mod opening;
pub mod origin;
pub mod output;
pub mod panel;
pub mod partial;
pub mod phase_file;
pub mod picture;
pub mod pictures;
mod place;
pub mod prescription;
pub mod report;
pub mod results;
pub mod sag;
pub mod scene;
#[cfg(test)]
mod scene_test;
#[cfg(test)]
mod schema_test;
pub mod section;
pub mod settings;
pub mod step;
#[cfg(test)]
mod surfaces_test;
pub(crate) mod svg;
mod table;
pub mod trial;
