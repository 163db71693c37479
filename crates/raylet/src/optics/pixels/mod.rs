//! Grids of pixels of diffractive elements.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`active_area`] | The part of each pixel that has its value, and the gap around it |
//! | [`fringing`] | The phase between the pixels of a modulator: fly-back where it wraps, crosstalk of neighbours |
//! | [`pixel_grid`] | A centred grid of pixels, and what lies between their centres |
//! | `pixel_shares` | Which pixels along an axis take part in a value between their centres, and with what shares |

pub mod active_area;
pub mod fringing;
pub mod pixel_grid;
pub(crate) mod pixel_shares;
