//! The waves that rays carry: beamlets and plane waves, and their coherent sums.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`wavelet`] | Beamlets: the Gaussian that a ray carries, in flight and at surfaces |
//! | [`beams`] | Beamlets of rays that another tracer followed |
//! | `beamlet_kernel` | One beamlet on a few rows of a raster |
//! | `raster_rows` | Rows of a raster in blocks of eight |
//! | `block_walk` | The values of a beamlet from block to block |
//! | `column_values` | Its values along the rows of a block, from column to column |
//! | [`beamlet_sum`] | The coherent sum of beamlets on a uniform grid, and its adjoint |
//! | `direction_sectors` | The same of beamlets that are wide beside the pixels, on a coarser grid for each range of directions |
//! | [`plane`] | Plane waves that arrive on a screen, and their coherent sum |
//! | [`secondary_ray_sum`] | The sum of rays of another tracer on a sensor, and its adjoint |

pub(crate) mod beamlet_kernel;
pub mod beamlet_sum;
pub mod beams;
pub(crate) mod block_walk;
pub(crate) mod column_values;
pub(crate) mod direction_sectors;
pub mod plane;
pub(crate) mod raster_rows;
pub mod secondary_ray_sum;
pub mod wavelet;
