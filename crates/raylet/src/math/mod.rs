//! Numbers, no light.

pub mod chirp;
pub mod complex;
pub mod kaiser;
pub mod lanes;
pub mod lines;
pub mod nufft;
pub mod random;
pub mod real;
pub mod tiles;
pub mod vec3;
