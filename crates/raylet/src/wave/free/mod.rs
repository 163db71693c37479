//! Hops without rays, and direct sums of diffraction integrals.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`propagate`] | Hops without rays, from a plane or curved screen to a parallel plane, and their adjoint |
//! | `emission_spectrum` | From the field on a screen to the plane waves of a free hop, and back |
//! | `pixel_hop` | A free hop from the pixels of a curved mirror to a parallel plane, fast enough for a design |
//! | `pixel_hop_test` | Tests: such hops from large pixels against the direct integral |
//! | [`free_plan`] | The slabs that a free hop crosses, and the plane waves that it takes |
//! | `surface_tilt` | The tilt of a curved screen in the plane waves that it sends, from neighbouring plane waves |
//! | `slab_transfer` | What plane waves meet on their way through plane-parallel slabs |
//! | [`collins`] | Collins' integral through a centred paraxial train |
//! | [`rayleigh`] | The first Rayleigh–Sommerfeld integral by direct sum |

pub mod collins;
mod emission_spectrum;
pub mod free_plan;
pub(crate) mod pixel_hop;
#[cfg(test)]
mod pixel_hop_test;
pub mod propagate;
pub mod rayleigh;
mod slab_transfer;
mod surface_tilt;
