//! Numbers, no light.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `band_limit` | Values between samples of what has a limited band |
//! | `bessel` | Bessel functions of whole order, by sums over equal steps of their integrals, which are exact to rounding |
//! | [`chebyshev`] | Interpolation on Chebyshev points, for functions whose oscillation is known |
//! | [`chirp`] | Exact Fourier sums between uniform combs of points, of any pitch on either side |
//! | `commensurate_dft` | Fourier sums between combs whose steps fit each other: one fast Fourier transform |
//! | [`complex`] | Complex numbers over any real type, and the symmetric 2×2 matrices that hold a beamlet's curvature |
//! | `double` | Twice the usual precision, for phases |
//! | [`draw`] | Drawing from a list of weights, with and without replacement |
//! | [`erfc`] | The complementary error function |
//! | `hilbert` | The order of grid cells along Hilbert's curve, on which near cells stay near |
//! | `interleaved_dft` | Exact Fourier sums from interleaved combs: grids whose cells hold the same few nodes each |
//! | `jet` | A number that carries first and second derivatives with respect to two inputs |
//! | `kaiser` | The Kaiser–Bessel bump, by which non-uniform Fourier sums pass through a uniform grid |
//! | `lanes` | Eight numbers at once: exponentials and phases for the hot loops |
//! | `lines` | One-dimensional transforms along every row of an array, shared among the threads |
//! | [`nufft`] | Fourier sums over scattered points, at a chosen tolerance: the non-uniform fast Fourier transform |
//! | [`part`] | Parts of arrays by rows and columns |
//! | [`random`] | Random numbers as addresses: a pure function of a seed and of where the number is used |
//! | [`real`] | One number in a formula: a plain `f64`, or a number that carries tangents |
//! | [`simd_level`] | The vector instructions of the hot loops |
//! | `sinc` | The transform of a box |
//! | `spline` | Cubic splines through equally spaced values: twice continuously differentiable, exact for cubics |
//! | `tiles` | Carries strengths of scattered points to a periodic grid, and values of the grid to the points |
//! | [`vec3`] | Vectors of three-dimensional space, generic over the kind of number |

#![expect(
    clippy::indexing_slicing,
    reason = "arrays and lists of numbers whose sizes are made, or asserted, beside the loops that run over them"
)]

pub(crate) mod band_limit;
pub(crate) mod bessel;
pub mod chebyshev;
pub mod chirp;
pub(crate) mod commensurate_dft;
pub mod complex;
mod double;
pub mod draw;
pub mod erfc;
pub(crate) mod hilbert;
pub(crate) mod interleaved_dft;
pub(crate) mod jet;
mod kaiser;
pub(crate) mod lanes;
pub(crate) mod lines;
pub mod nufft;
pub mod part;
pub mod random;
pub mod real;
pub mod simd_level;
pub(crate) mod sinc;
pub(crate) mod spline;
mod tiles;
pub mod vec3;
