//! Files of Zemax and OpticStudio (.zmx).
//!
//! | file | what it holds |
//! | --- | --- |
//! | `grid_records` | Grids of values as the file writes them |
//! | `zemax_shape` | Surfaces: from a type and its parameters to a curve, a phase or a turn of the axis |
//! | `zemax_zernike` | Surfaces and phases of Zernike polynomials |
//! | `zemax_grid` | Surfaces and phases by values on a grid |
//! | `zemax_edge` | Apertures of surfaces |
//! | `zemax_surface` | The records of one surface |
//! | `zemax_header` | The records before the surfaces: units, aperture, fields, wavelengths |
//! | `zemax_configuration` | Records that give values to one of several configurations |
//! | `zemax_reader` | A file as a sequential prescription |

pub(crate) mod grid_records;
pub(crate) mod zemax_configuration;
pub(crate) mod zemax_edge;
pub(crate) mod zemax_grid;
pub(crate) mod zemax_header;
pub(crate) mod zemax_reader;
pub(crate) mod zemax_shape;
pub(crate) mod zemax_surface;
pub(crate) mod zemax_zernike;
