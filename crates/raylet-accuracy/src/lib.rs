//! Brute-force diffraction references that share no code with raylet's rays, but for that of the objective.
//!
//! Scalar waves, time factor exp(−iωt), light going +z varies as exp(+ikz). Lengths are in any
//! one unit (mm in raylet), arrays are indexed [y, x], and a transverse direction p is the
//! optical direction cosine (index times cosine), so that a plane wave is
//! exp(ik(p·x + q z)) with q = √(n² − |p|²) and k = 2π/λ of the vacuum.
//!
//! | folder or file | what it holds |
//! | --- | --- |
//! | [`bounds`] | The errors that are allowed |
//! | [`numerics`] | Numbers and shapes that the references are made of |
//! | [`references`] | Diffraction by methods that are slow, simple and not those of the library |
//! | [`objective`] | A photographic objective with an element at its stop, and its field by rays to each pixel |
//! | [`real_size`] | Systems at their real size, what they take and how exact they are |
//! | [`problems`] | The problems on which raylet is measured |
//! | [`gradients`] | Gradients of raylet against adjoints and differences of the references |
//! | [`estimates`] | The errors that raylet reports of random small systems beside their true ones |
//! | [`measured_again`] | The rows of the accuracy report that its tests measure again |
//! | [`designed`] | Systems that raylet has designed |

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
pub mod designed;
pub mod estimates;
pub mod gradients;
pub mod measured_again;
pub mod numerics;
pub mod objective;
pub mod problems;
pub mod real_size;
pub mod references;
