//! Fields on grids: where a field is sampled, what a screen does to it there, and how fields compare.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`raster`] | Uniform grids of sample points |
//! | [`field`] | Complex fields on the nodes of a plane grid |
//! | [`sampling`] | Where a screen's field is sampled, and what the screen does to it there |
//! | `screen_axis` | The nodes of a screen along one axis: cells with enough Gauss nodes each |
//! | `cell_polynomials` | Polynomials over the cells of an axis, as their Gauss nodes have them |
//! | `singular_cells` | The transmission in the cells about a vortex core or the tip of an axicon |
//! | `aperture_coverage` | The open share of the cell of each node |
//! | [`transmission`] | The transmission of an element at the nodes of a grid, and its adjoint for phases and pixels |
//! | [`heights`] | The levels around a curved screen, and interpolation between them |
//! | [`height_stack`] | A field as it is summed: on a plane, or on levels around a curved screen |
//! | `mean_cosine` | How steeply the light of a field crosses its plane |
//! | [`metrics`] | How alike two fields are, and how large a spot is |

pub(crate) mod aperture_coverage;
pub(crate) mod cell_polynomials;
pub mod field;
pub mod height_stack;
pub mod heights;
pub(crate) mod mean_cosine;
pub mod metrics;
pub mod raster;
pub mod sampling;
pub(crate) mod screen_axis;
pub(crate) mod singular_cells;
pub mod transmission;
