//! Grids of pixels of diffractive elements.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`active_area`] | The part of each pixel that has its value, and the gap around it |
//! | [`pixel_grid`] | A centred grid of pixels, and what lies between their centres |

pub mod active_area;
pub mod pixel_grid;
