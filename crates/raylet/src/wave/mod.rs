//! What happens to waves.

#![expect(
    clippy::indexing_slicing,
    reason = "fields, spectra and their axes are indexed by loops over their own sizes"
)]

pub mod aperture_coverage;
pub mod beamlet_kernel;
pub mod beams;
pub mod collect;
pub mod collins;
pub mod curved;
mod emission_spectrum;
pub mod field;
pub mod gather;
pub mod height_stack;
pub mod heights;
pub mod metrics;
pub mod patch;
pub mod periodic;
pub mod pixel_hop;
pub mod plane;
pub mod propagate;
pub mod raster;
pub mod rayleigh;
pub mod sampling;
pub mod spot;
pub mod tile;
pub mod transmission;
pub mod wavelet;
pub mod window;
pub mod window_coverage;
