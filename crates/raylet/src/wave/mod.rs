//! What happens to waves.

#![expect(
    clippy::indexing_slicing,
    reason = "fields, spectra and their axes are indexed by loops over their own sizes"
)]

pub mod beams;
pub mod collect;
pub mod collins;
pub mod cover;
pub mod curved;
pub mod field;
pub mod gather;
pub mod heights;
pub mod imprint;
mod leave;
pub mod metrics;
pub mod opening;
pub mod patch;
pub mod periodic;
pub mod pixel_hop;
pub mod plane;
pub mod propagate;
pub mod raster;
pub mod rayleigh;
pub mod sampling;
pub mod sheets;
pub mod spot;
pub mod stamp;
pub mod tile;
pub mod wavelet;
pub mod window;
