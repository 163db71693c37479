//! Grids of pixels of diffractive elements.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`active_area`] | The part of each pixel that has its value, and the gap around it |
//! | [`fringing`] | The phase between the pixels of a modulator: fly-back where it wraps, crosstalk of neighbours |
//! | `pixel_axes` | Elements on the axes of their pixels, so that these are centred and along x and y |
//! | [`pixel_grid`] | A grid of pixels, and what lies between their centres |
//! | `pixel_shares` | Which pixels along an axis take part in a value between their centres, and with what shares |

pub mod active_area;
pub mod fringing;
pub(crate) mod pixel_axes;
pub mod pixel_grid;
pub(crate) mod pixel_shares;
