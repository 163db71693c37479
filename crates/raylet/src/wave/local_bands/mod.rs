//! Light that is known only piece by piece: each piece on a grid of its own, about a carrier of its own.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `carrier` | The plane wave with curvature that runs along with a piece of light |
//! | `local_band` | The directions beside its carrier that a piece of light has |
//! | `tiling` | Windows over a screen, and the tiles in which they are worked on |
//! | `gather` | Beamlets summed on the samples of one tile, and back |
//! | `aperture_scan` | The open shares of many cells |
//! | `edge_mask` | An aperture at the nodes of one tile, with a limited band |
//! | `edge_points` | Points along the edge of an aperture, for integrals along it |
//! | `edge_sum` | What an edge under one window sends far beside the way of the light, as an integral along it |
//! | `element_phase` | The smooth part of an element's phase under a tile |
//! | `element_samples` | The transmission of an element at the nodes of one tile |
//! | `element_values` | The same by rows: phases alone, pixels alone, or anything |
//! | `vortex_core` | The core of a vortex at the equal nodes of one tile |
//! | `open_nodes` | What an aperture leaves open at the nodes of one tile |
//! | `pixel_parts` | The parts of a pixel over which arriving light is linear |
//! | `reused_array` | Large arrays of a tile, whose memory the next tile uses again |
//! | `fourier_axis` | What Fourier sums along one axis of a window are about |
//! | `fourier_matrix` | Fourier sums from nodes to plane waves, as a matrix |
//! | `folded_fourier` | The same by fast transforms, where the period is a whole number of cells |
//! | `window_transform` | From the samples under one window to its plane waves, and back |

pub(crate) mod aperture_scan;
pub(crate) mod carrier;
pub(crate) mod edge_mask;
pub(crate) mod edge_points;
pub(crate) mod edge_sum;
pub(crate) mod element_phase;
pub(crate) mod element_samples;
mod element_values;
pub(crate) mod folded_fourier;
pub(crate) mod fourier_axis;
pub(crate) mod fourier_matrix;
pub(crate) mod gather;
pub(crate) mod local_band;
pub(crate) mod open_nodes;
pub(crate) mod pixel_parts;
pub(crate) mod reused_array;
pub(crate) mod tiling;
mod vortex_core;
pub(crate) mod window_transform;
