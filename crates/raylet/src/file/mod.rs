//! How it is written down.

pub mod array;
pub mod arrays;
pub mod catalog;
mod check;
mod decode;
pub mod element;
pub mod fault;
pub mod layer;
pub mod material;
mod misfit;
mod number;
pub mod origin;
pub mod scene;
#[cfg(test)]
mod scene_test;
#[cfg(test)]
mod schema_test;
pub mod settings;
