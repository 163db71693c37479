//! Files that foundries and other programs take of an element.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `export_choices` | What a user chooses for the files of a foundry |
//! | `export_report` | What an export reports: what was written, what was rounded, and what the file does not hold |
//! | `relief` | The relief that makes a phase: height = φ λ / (2π (n − n₀)) |
//! | `cell_rows` | The cells of an element, row by row |
//! | `npy_rows` | A NumPy file (.npy) row by row |
//! | `element_cells` | The cells of an element of a scene, or of an array |
//! | `levels` | Levels: from the value of a cell to the number of the step that a foundry makes |
//! | `level_survey` | The levels of all cells: rounding, the smallest feature, the tile that repeats |
//! | `rectangles` | Cells of equal value as few rectangles |
//! | `mask_plan` | How cells become shapes of a mask file: layers, coordinates, the tile |
//! | `gds_record` | Records of a GDSII file |
//! | `gds_writer` | Mask files in the format GDSII, written while rows are read |
//! | `gds_elements` | The elements of a GDSII file, one after another |
//! | `gds_painting` | Polygons of a mask file as levels of cells |
//! | `gds_reader` | Mask files in the format GDSII, read back into the levels of cells |
//! | `made_values` | The values that a file gets: as they are, or on levels, or as heights instead of phases |
//! | `value_files` | Values of cells as numbers: NumPy arrays, comma-separated values, grid files of Zemax OpticStudio |
//! | `stl` | A relief as a closed surface of triangles (.stl) |
//! | `height_image` | Values of cells as a grey picture (PNG), with what a grey level means in a text beside it |
//! | `radial_fit` | Coefficients of a phase that depends on the radius alone |
//! | `export` | An element as files that a foundry takes: the source, the format, and the report |
//! | `gds_test` | Tests: mask files that are written are read back |
//! | `gds_mutations_test` | Tests: altered mask files and arrays give cells or an error |
//! | `export_test` | Tests: reliefs, pictures, tables and grid files of asymmetric elements, read back |

pub(crate) mod cell_rows;
pub(crate) mod element_cells;
pub mod export;
pub mod export_choices;
pub mod export_report;
#[cfg(test)]
mod export_test;
pub(crate) mod gds_elements;
#[cfg(test)]
mod gds_mutations_test;
pub(crate) mod gds_painting;
pub mod gds_reader;
pub(crate) mod gds_record;
#[cfg(test)]
mod gds_test;
pub(crate) mod gds_writer;
pub(crate) mod height_image;
pub(crate) mod level_survey;
pub(crate) mod levels;
pub(crate) mod made_values;
pub(crate) mod mask_plan;
pub(crate) mod npy_rows;
pub(crate) mod radial_fit;
pub(crate) mod rectangles;
pub(crate) mod relief;
pub(crate) mod stl;
pub(crate) mod value_files;
