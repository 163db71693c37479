//! What happens to waves.

pub mod field;
pub mod gather;
pub mod patch;
pub mod plane;
pub mod propagate;
pub mod sampling;
pub mod tile;
pub mod wavelet;
pub mod window;
