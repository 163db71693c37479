//! A hop carried by plane wavelets with a prefactor.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`plane_wavelets`] | The plan of a plane wavelet sum, and the sum as a non-uniform FFT |

pub mod plane_wavelets;
