//! Numbers, no light.

pub mod complex;
pub mod real;
pub mod vec3;
