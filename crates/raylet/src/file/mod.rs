//! How it is written down.

pub mod around;
pub mod array;
pub mod arrays;
pub mod blame;
pub mod build;
mod called;
pub mod catalog;
mod check;
pub mod checkpoint;
pub mod comparison;
mod decode;
pub mod design;
pub mod document;
pub mod element;
pub mod estimator;
pub mod fault;
pub mod folder;
pub mod hidden;
pub mod hologram;
pub mod image;
#[cfg(test)]
mod killed_test;
pub mod layer;
pub mod lock;
pub mod machine;
#[cfg(test)]
mod magnitude_test;
pub mod material;
pub mod memory;
mod misfit;
mod npy_header;
pub mod npz;
mod number;
pub mod opening;
pub mod origin;
pub mod own_file;
pub mod partial;
pub mod phase_file;
pub mod pixel_part;
mod place;
pub mod prescription;
pub mod project;
mod quantity;
mod regular_file;
pub mod report;
pub mod results;
pub mod rim;
pub mod run_folder;
pub mod sag;
pub mod scene;
#[cfg(test)]
mod scene_test;
#[cfg(test)]
mod schema_test;
pub mod seal;
pub mod settings;
pub mod step;
#[cfg(test)]
mod surfaces_test;
pub mod sweep;
mod table;
pub mod unfinished;
pub mod variable;
pub mod wanted;
pub mod wish;
