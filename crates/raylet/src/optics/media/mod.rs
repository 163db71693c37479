//! What light travels in.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`medium`] | A medium and its index of refraction as a function of wavelength |
//! | [`dispersion`] | Dispersion: how an index of refraction depends on the wavelength |
//! | [`catalog`] | Glasses by name: catalogues of the makers and a list of single materials, with their sources |

pub mod catalog;
pub mod dispersion;
pub mod medium;
