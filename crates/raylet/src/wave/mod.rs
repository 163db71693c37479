//! What happens to waves.

pub mod collins;
pub mod curved;
pub mod field;
pub mod gather;
pub mod heights;
pub mod metrics;
pub mod patch;
pub mod periodic;
pub mod plane;
pub mod propagate;
pub mod raster;
pub mod rayleigh;
pub mod sampling;
pub mod sheets;
pub mod stamp;
pub mod tile;
pub mod wavelet;
pub mod window;
