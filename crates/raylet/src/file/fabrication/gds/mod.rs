//! Mask files in the format GDSII.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `gds_record` | Records of a GDSII file |
//! | `gds_writer` | Mask files in the format GDSII, written shape by shape |
//! | `gds_elements` | The elements of a GDSII file, one after another |
//! | `gds_painting` | Polygons of a mask file as levels of cells |
//! | `gds_reader` | Mask files in the format GDSII, read back into the levels of cells |
//! | `gds_shapes` | For tests: all polygons of a GDSII file |
//! | `gds_test` | Tests: mask files that are written are read back |
//! | `gds_mutations_test` | Tests: altered mask files and arrays give cells or an error |

pub(crate) mod gds_elements;
#[cfg(test)]
mod gds_mutations_test;
pub(crate) mod gds_painting;
pub mod gds_reader;
pub(crate) mod gds_record;
#[cfg(test)]
pub(crate) mod gds_shapes;
#[cfg(test)]
pub(crate) mod gds_test;
pub(crate) mod gds_writer;
