//! Numbers, no light.

pub mod chirp;
pub mod complex;
pub mod lanes;
pub mod lines;
pub mod random;
pub mod real;
pub mod vec3;
