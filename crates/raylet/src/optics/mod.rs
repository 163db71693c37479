//! The parts of an optical system.
//!
//! | file or folder | what it holds |
//! | --- | --- |
//! | [`assembly`] | Systems from parts laid one behind another, in code and from scenes |
//! | [`beams`] | Kinds of light that sources send |
//! | [`phase`] | Analytic phases of diffractive elements |
//! | [`pixels`] | Grids of pixels of diffractive elements |
//! | [`media`] | What light travels in: indices of refraction, the catalogue of glasses |
//! | [`aperture`] | Clear apertures and the share of a small cell that lies inside them |
//! | [`bundle`] | Rays of any tracer on a screen, in plain arrays, and the faults that such arrays may have |
//! | [`conic`] | Spheres and conics of revolution, with even powers of the radius on top |
//! | `deflection` | What an element on a surface, and the interface under it, do to a ray |
//! | [`doe`] | Diffractive optical elements: a complex transmission over a plane |
//! | [`frame`] | Where a part stands: an origin and three orthonormal axes in global coordinates |
//! | [`freeform`] | Sag terms that are added to a conic, each written once as a formula for z(x, y) |
//! | [`height`] | The height of a surface over its local plane, with derivatives |
//! | `intersection` | Where rays meet surfaces without a formula, by Newton's method |
//! | `moments` | Integrals of polynomials over the part of a cell that an aperture leaves open |
//! | [`paraxial`] | Paraxial optics of centred trains: ray matrices, focal lengths, principal planes |
//! | [`polygon`] | Areas inside polygons |
//! | [`ray`] | A ray: a point, a direction, and the optical path behind it |
//! | [`refraction`] | What an interface does to a direction and to the amplitude of the field |
//! | [`sag_grid`] | A surface given by heights on a grid, with a smooth spline between them |
//! | [`screen`] | Screens: where a field lives, and what acts on it there |
//! | [`shape`] | Surface shapes: height over the local plane, its derivatives, and where a ray meets it |
//! | [`source`] | Where the light comes from: the field it puts on the first screen |
//! | [`surface`] | A prescription row: shape, place, clear aperture, and what happens to light there |
//! | [`surface_coordinates`] | A curved surface's own coordinates: lengths along it instead of their projections |
//! | [`system`] | A whole optical system at one wavelength: screens joined by trains of surfaces |
//! | [`toric`] | Surfaces with two curvatures: biconics, cylinders and toroids |
//! | [`zernike`] | Sums of Zernike polynomials |

#![expect(
    clippy::indexing_slicing,
    reason = "axes are 0 and 1, and grids of pixels and heights are indexed by what their own sizes bound"
)]

pub mod aperture;
pub mod assembly;
pub mod beams;
pub mod bundle;
pub mod conic;
pub(crate) mod deflection;
pub mod doe;
pub mod frame;
pub mod freeform;
pub mod height;
pub(crate) mod intersection;
pub mod media;
pub(crate) mod moments;
pub mod paraxial;
pub mod phase;
pub mod pixels;
pub mod polygon;
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
pub mod zernike;
