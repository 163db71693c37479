//! Many rays at once, in columns: eight in each vector of the processor, surface by surface.
//!
//! A block holds its rays on the axes of the part where they are. Each surface is one loop over the block. A lost ray has
//! no numbers from there on, and its reason. No ray depends on those beside it.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `block` | Rays in columns, and what became of them |
//! | `passage` | From the axes of one part to those of the next |
//! | `lane_vec3` | Vectors of eight rays |
//! | `lane_shape` | Where eight rays meet a shape, and its normal there |
//! | `lane_asphere` | The same for a conic with powers of the radius |
//! | `bend` | Refraction and reflection of eight rays, and of their derivatives |
//! | `prepared_part` | Surfaces and screens made ready for blocks of rays |
//! | `block_step` | A block through one part |
//! | `part_change` | How a part changes with a parameter of a system |
//! | `parameter_tangents` | Derivatives of the rays of a block by parameters of a system |
//! | `parameter_gradient` | Derivatives of a number by the parameters, from those by the rays: the way back |
//! | [`ray_origins`] | Where and how many rays start |
//! | [`system_rays`] | Rays through a whole system, with what they meet on the way |
//! | [`system_derivatives`] | The same with derivatives by parameters of the system, of rays or of a number |
//! | `tangents` | Derivatives of the rays of a block by their starts |
//! | `lane_complex` | Eight complex numbers |
//! | `lane_beamlets` | Beamlets that the rays of a block carry |
//! | [`hop_rays`] | Rays, and their Jacobians, from screen to screen |
//! | `system_derivatives_test` | Tests: derivatives are those of single rays |
//! | `hop_rays_test` | Tests: they are single rays, for every shape |

pub(crate) mod bend;
pub(crate) mod block;
pub(crate) mod block_step;
pub mod hop_rays;
#[cfg(test)]
mod hop_rays_test;
pub(crate) mod lane_asphere;
pub(crate) mod lane_beamlets;
pub(crate) mod lane_complex;
pub(crate) mod lane_shape;
pub(crate) mod lane_vec3;
pub(crate) mod parameter_gradient;
pub(crate) mod parameter_tangents;
pub(crate) mod part_change;
pub(crate) mod passage;
pub(crate) mod prepared_part;
pub mod ray_origins;
pub mod system_derivatives;
#[cfg(test)]
mod system_derivatives_test;
pub mod system_rays;
pub(crate) mod tangents;
