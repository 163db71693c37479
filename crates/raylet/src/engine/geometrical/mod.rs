//! Geometrical optics of a whole system: its rays, and the fields that follow from them without diffraction.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`chief_ray`] | The chief ray: through the middle of the screen that limits the light |
//! | [`eikonal`] | The geometrical field on a sensor behind smooth elements, away from caustics |
//! | [`layout_rays`] | A few chief rays through a whole system, for drawings |
//! | [`maslov`] | The geometrical field at a focus, as a sum of plane waves (Maslov) |
//! | [`ray_tube`] | A ray and the width of its ray tube through a whole system of smooth elements |
//! | [`system_trace`] | Single rays through a whole system, surface by surface, and their derivatives |

pub mod chief_ray;
pub mod eikonal;
pub mod layout_rays;
pub mod maslov;
pub mod ray_tube;
pub mod system_trace;
