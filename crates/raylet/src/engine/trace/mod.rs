//! Rays through one hop: where they start, how they go through the train, and how that changes.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `bounding_sphere` | A sphere about a surface within its aperture, and the directions in which it is seen |
//! | `complex_rate` | The derivative of complex values from their values a little below and above |
//! | `direction_search` | Which directions of a screen lead to the target, found with a coarse set of rays |
//! | `launch_plane` | The plane from which rays and beamlets leave a screen: on a curved screen the tangent plane |
//! | [`ray_sensitivity`] | Derivatives of rays by the parameters of a system, from two perturbed systems |
//! | [`ray_trace`] | The trace of one ray from screen to screen through a train of surfaces |
//! | `surface_trace` | The same in the coordinates of the light on curved screens and interfaces |

pub(crate) mod bounding_sphere;
pub(crate) mod complex_rate;
pub(crate) mod direction_search;
pub(crate) mod launch_plane;
pub mod ray_sensitivity;
pub mod ray_trace;
pub(crate) mod surface_trace;
