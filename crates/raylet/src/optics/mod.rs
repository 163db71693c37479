//! What the parts are.

pub mod aperture;
pub mod bend;
pub mod dispersion;
pub mod doe;
pub mod frame;
pub mod freeform;
pub mod medium;
pub mod paraxial;
pub mod profile;
pub mod ray;
pub mod screen;
pub mod shape;
pub mod source;
pub mod surface;
pub mod system;
