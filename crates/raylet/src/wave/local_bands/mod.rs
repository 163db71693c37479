//! Light that is known only piece by piece: each piece on a grid of its own, about a carrier of its own.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`carrier`] | The plane wave with curvature that runs along with a piece of light |
//! | `local_band` | The directions beside its carrier that a piece of light has |
//! | `tiling` | Windows over a screen, and the tiles in which they are worked on |
//! | [`gather`] | Beamlets summed on the samples of one tile, and back |
//! | `element_samples` | The transmission of an element at the nodes of one tile |
//! | [`window_transform`] | From the samples under one window to its plane waves, and back |

pub mod carrier;
pub(crate) mod element_samples;
pub mod gather;
pub(crate) mod local_band;
pub(crate) mod tiling;
pub mod window_transform;
