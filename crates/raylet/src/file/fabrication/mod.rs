//! Files that foundries and other programs take of an element.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `export_choices` | What a user chooses for the files of a foundry |
//! | `export_report` | What an export reports: what was written, what was rounded, and what the file does not hold |
//! | `relief` | The relief that makes a phase: height = φ λ / (2π (n − n₀)) |
//! | `cell_rows` | The cells of an element, row by row |
//! | `npy_rows` | A NumPy file (.npy) row by row |
//! | `open_part` | The cells of an element that its aperture leaves open |
//! | `designed_levels` | The levels of an element that its scene states |
//! | `element_cells` | The cells of an element of a scene |
//! | `array_cells` | The cells of an array, or those of a mask file that is read |
//! | `levels` | Levels: from the value of a cell to the number of the step that a foundry makes |
//! | `level_survey` | The levels of all cells: rounding, the smallest feature, the tile that repeats |
//! | `masks` | Cells as the shapes of a mask file, whatever its format, and the format DXF |
//! | `gds` | Mask files in the format GDSII |
//! | `oasis` | Mask files in the format OASIS |
//! | `made_values` | The values that a file gets: as they are, or on levels, or as heights instead of phases |
//! | `value_files` | Values of cells as numbers: NumPy arrays, comma-separated values, grid files of Zemax OpticStudio |
//! | `stl` | A relief as a closed surface of triangles (.stl) |
//! | `height_image` | Values of cells as a grey picture (PNG), with what a grey level means in a text beside it |
//! | `radial_fit` | Coefficients of a phase that depends on the radius alone |
//! | `export` | An element as files that a foundry takes: the source, the format, and the report |
//! | `export_test` | Tests: reliefs, pictures, tables and grid files of asymmetric elements, read back |

pub(crate) mod array_cells;
pub(crate) mod cell_rows;
pub(crate) mod designed_levels;
pub(crate) mod element_cells;
pub mod export;
pub mod export_choices;
pub mod export_report;
#[cfg(test)]
mod export_test;
pub mod gds;
pub(crate) mod height_image;
pub(crate) mod level_survey;
pub(crate) mod levels;
pub(crate) mod made_values;
pub(crate) mod masks;
pub(crate) mod npy_rows;
pub(crate) mod oasis;
pub(crate) mod open_part;
pub(crate) mod radial_fit;
pub(crate) mod relief;
pub(crate) mod stl;
pub(crate) mod value_files;
