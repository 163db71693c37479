//! What happens to waves.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`aperture_coverage`] | How much an opening lets through of what each node stands for |
//! | [`beamlet_kernel`] | One beamlet on a few rows of a raster |
//! | [`beams`] | Beamlets of rays that another tracer followed |
//! | [`collect`] | The sum of rays of another tracer on a sensor, and its adjoint |
//! | [`collins`] | Collins' integral through a centred paraxial train |
//! | [`curved`] | Patches of a field on a curved screen and their plane waves |
//! | `emission_spectrum` | From the field on a screen to the plane waves of a free hop, and back |
//! | [`field`] | Complex fields on the nodes of a plane grid |
//! | [`gather`] | The coherent sum of beamlets on a uniform grid, and its adjoint |
//! | [`height_stack`] | A field as it is summed: on a plane, or on levels around a curved screen |
//! | [`heights`] | The levels around a curved screen, and interpolation between them |
//! | [`metrics`] | How alike two fields are, and how large a spot is |
//! | [`patch`] | Patches of a field and their plane waves |
//! | [`periodic`] | The angular spectrum of a frame that repeats |
//! | [`pixel_hop`] | A free hop from the pixels of a curved mirror to a parallel plane, quick enough for a design |
//! | [`plane`] | Plane waves that arrive on a screen, and their coherent sum |
//! | [`propagate`] | Hops without rays, from a plane or curved screen to a parallel plane, and their adjoint |
//! | [`raster`] | Uniform grids of sample points |
//! | [`rayleigh`] | The first Rayleigh–Sommerfeld integral by direct sum |
//! | [`sampling`] | Where a screen's field is sampled, and what the screen does to it there |
//! | [`spot`] | One window about any point of a screen, and its plane waves |
//! | [`tile`] | Square patches of a field with sharp edges, anywhere on it, and their plane waves |
//! | [`transmission`] | What an element does at the nodes of a grid, and the way back to phases and pixels |
//! | [`wavelet`] | Beamlets: the Gaussian that a ray carries, in flight and at surfaces |
//! | [`window`] | Gaussian windows on a regular lattice, divided by their coverage |
//! | [`window_coverage`] | What windows about scattered points add up to |

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
