//! Measured maps: heights, phases and fields on a grid, in the formats of instruments and of other programs.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `array_file` | The array that a key of a scene names, from a NumPy file or a map |
//! | `map_file` | A map of any of the formats, with its missing samples filled where that is requested |
//! | `measured_map` | A map: samples, pitch, unit, and what must be decided about it |
//! | `map_unit` | Units of lengths and angles, by the names that files give them |
//! | `missing_samples` | Which samples are missing, and the nearest others in their place |
//! | `zygo_map` | Height maps of Zygo's MetroPro (.dat) |
//! | `grid_map` | Grids of values as texts of Zemax (.dat) |
//! | `tiff_map` | Grey pictures (.tif) |
//! | `fits_map` | Images of FITS files |
//! | `hdf5_map` | Arrays of HDF5 files, and their axes |
//! | `maps_test` | Tests: maps byte by byte, and what is refused |
//! | `map_mutations_test` | Tests: altered maps give a map or an error |

pub(crate) mod array_file;
pub(crate) mod fits_map;
pub(crate) mod grid_map;
pub(crate) mod hdf5_map;
pub mod map_file;
#[cfg(test)]
mod map_mutations_test;
pub mod map_unit;
#[cfg(test)]
pub(crate) mod maps_test;
pub mod measured_map;
pub(crate) mod missing_samples;
pub(crate) mod tiff_map;
pub(crate) mod zygo_map;
