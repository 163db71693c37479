//! Brute-force diffraction references that share no code with raylet's rays.
//!
//! Scalar waves, time factor exp(−iωt), light going +z varies as exp(+ikz). Lengths are in any
//! one unit (mm in raylet), arrays are indexed [y, x], and a transverse direction p is the
//! optical direction cosine (index times cosine), so that a plane wave is
//! exp(ik(p·x + q z)) with q = √(n² − |p|²) and k = 2π/λ of the vacuum.
//!
//! In import order:
//! [`bounds`]: the errors that are allowed;
//! [`phase`], [`quadrature`], [`dense`], [`fourier`]: numbers;
//! [`pixels`]: a plane of box pixels; [`disc`]: a hard disc on a grid and its spectrum;
//! [`rayleigh_sommerfeld`]: pixels to any points in free space, by direct sum;
//! [`collins`]: pixels through a paraxial ABCD train, by direct sum;
//! [`spectrum`]: plane waves on a lattice, through plane-parallel slabs, to sensor points;
//! [`surface`]: a curved refracting surface's sag and the samples on its aperture;
//! [`interface`]: plane waves to such a surface and back;
//! [`mirror`]: diffractive mirrors on a Gaussian bump, by direct sum over the true surface;
//! [`direct`]: samples anywhere in space and the sum over them; [`tilted`], [`fold`]: what is tilted or folded;
//! [`mod@bench`]: these joined to a train of small, strongly refracting lenses and pixel planes;
//! [`dim`]: lenses that send little light to their sensors;
//! [`gradients`], [`sensitivity`]: adjoints and differences of these against raylet's gradients;
//! [`designed`]: systems that raylet has designed;
//! [`estimates`]: the errors that raylet tells of random small systems beside their true ones.

#![expect(
    clippy::indexing_slicing,
    reason = "sums over grids and samples that are made beside the loops; nothing a user hands over is read"
)]
#![deny(
    clippy::expect_used,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

pub mod bounds;

pub mod phase;
pub mod quadrature;

pub mod dense;
pub mod fourier;

pub mod pixels;

pub mod disc;

pub mod rayleigh_sommerfeld;

pub mod collins;

pub mod spectrum;

pub mod surface;

pub mod interface;

pub mod bench;

pub mod problems;

pub mod mirror;

pub mod direct;

pub mod strong;

pub mod tilted;

pub mod fold;

pub mod slanted;

pub mod gradient_error;

pub mod gradients;

pub mod sensitivity;

pub mod designed;

pub mod estimates;

pub mod dim;

pub mod suite;
