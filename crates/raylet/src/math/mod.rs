//! Numbers, no light.

pub mod complex;
pub mod lanes;
pub mod real;
pub mod vec3;
