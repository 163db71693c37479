//! What happens to waves.

pub mod collins;
pub mod field;
pub mod gather;
pub mod metrics;
pub mod patch;
pub mod plane;
pub mod propagate;
pub mod raster;
pub mod sampling;
pub mod stamp;
pub mod tile;
pub mod wavelet;
pub mod window;
