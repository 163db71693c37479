//! What happens to waves.

pub mod collins;
pub mod field;
pub mod gather;
pub mod patch;
pub mod propagate;
pub mod sampling;
pub mod wavelet;
pub mod window;
