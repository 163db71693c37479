//! Numbers and shapes that the references are made of.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`phase`] | The phase factor exp(iφ), written so that a loop over it vectorises |
//! | [`bessel`] | The Bessel functions J₀ and J₁ along a list of arguments, in loops that vectorise |
//! | [`quadrature`] | Gauss–Legendre quadrature on an interval |
//! | [`dense`] | Products of dense complex matrices on all cores |
//! | [`fourier`] | Fourier transforms of centred squares |
//! | [`pixels`] | A plane of box pixels |
//! | [`disc`] | A hard disc on a grid and its spectrum |

pub mod bessel;
pub mod dense;
pub mod disc;
pub mod fourier;
pub mod phase;
pub mod pixels;
pub mod quadrature;
