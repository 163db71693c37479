//! Cells as the shapes of a mask file, whatever its format.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `rectangles` | Cells of equal value as few rectangles |
//! | `mask_plan` | How cells become shapes of a mask file: layers, coordinates, the tile |
//! | `database_units` | Lengths in the whole database units of a mask file |
//! | `drawn_part` | The part of a cell that is drawn: gaps between cells, and the bias of an etch |
//! | `outline` | The outline of an aperture as polygons |
//! | `mask_file` | What a mask file holds: structures, rectangles, polygons, arrays |
//! | `dxf_writer` | Mask files in the format DXF |
//! | `dxf_test` | Tests: files of the format DXF hold the shapes of those of the format GDSII |
//! | `drawing_test` | Tests: apertures, gaps and etches, against a picture in database units, and read back |

pub(crate) mod database_units;
#[cfg(test)]
mod drawing_test;
pub(crate) mod drawn_part;
#[cfg(test)]
mod dxf_test;
pub(crate) mod dxf_writer;
pub(crate) mod mask_file;
pub(crate) mod mask_plan;
pub(crate) mod outline;
pub(crate) mod rectangles;
