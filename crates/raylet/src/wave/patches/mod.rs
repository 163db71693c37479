//! Fields cut into patches, and the plane waves of each patch.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`window`] | Gaussian windows on a regular lattice, divided by their coverage |
//! | `window_coverage` | The sum of windows about scattered points |
//! | [`patch`] | Patches of a field and their plane waves |
//! | `curved` | Patches of a field on a curved screen and their plane waves |
//! | [`local_spectrum`] | One window about any point of a screen, and its plane waves |
//! | [`tile`] | Square patches of a field with sharp edges, anywhere on it, and their plane waves |

pub(crate) mod curved;
pub mod local_spectrum;
pub mod patch;
pub mod tile;
pub mod window;
pub(crate) mod window_coverage;
