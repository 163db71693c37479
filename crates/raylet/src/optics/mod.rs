//! What the parts are.

#![expect(
    clippy::indexing_slicing,
    reason = "axes are 0 and 1, and grids of pixels and heights are indexed by what their own sizes bound"
)]

pub mod aperture;
pub mod bundle;
pub mod conic;
pub mod dispersion;
pub mod doe;
pub mod frame;
pub mod freeform;
pub mod height;
pub mod medium;
pub mod moments;
pub mod paraxial;
pub mod polygon;
pub mod profile;
pub mod ray;
pub mod refraction;
pub mod sag_grid;
pub mod screen;
pub mod shape;
pub mod source;
pub mod surface;
pub mod surface_coordinates;
pub mod system;
pub mod toric;
