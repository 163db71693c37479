//! Diffraction by methods that are slow, simple and not those of the library.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`rayleigh_sommerfeld`] | Pixels to any points in free space, by direct sum |
//! | [`collins`] | Pixels through a paraxial ABCD train, by direct sum |
//! | [`spectrum`] | Plane waves on a lattice, through plane-parallel slabs, to sensor points |
//! | [`surface`] | A curved refracting surface's sag and the samples on its aperture |
//! | [`interface`] | Plane waves to such a surface and back |
//! | [`direct`] | Samples anywhere in space and the sum over them |
//! | [`mod@axisymmetric_train`] | Trains of any size that are figures of revolution, by Hankel transforms |
//! | [`mod@lens_train`] | These joined to a train of small, strongly refracting lenses and pixel planes |

pub mod axisymmetric_train;
pub mod collins;
pub mod direct;
pub mod interface;
pub mod lens_train;
pub mod rayleigh_sommerfeld;
pub mod spectrum;
pub mod surface;
