//! Random estimates of a hop: the source paper's method, and beamlets that are drawn.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `batch_spread` | The spread of equal, independent batches of a random sum |
//! | `drawn_rays` | Rays of drawn modes, in columns: their starts, where they land, and what they bring |
//! | [`mode_sampling`] | Beamlets that are drawn from the modes of a patch: probabilities, weights and their adjoint |
//! | [`paper`] | The source paper's method: patches anywhere, drawn modes, plain plane waves |
//! | [`paper_plan`] | The plan of the source paper's method: where patches stand, and which modes they have |
//! | [`repeated_runs`] | The mean of random runs and its standard error |
//! | `tangent_patch` | The plane that touches a screen at a patch, and the plane waves that leave it |
//! | `tangent_patch_error` | The error of flat patches on a curved screen |

pub(crate) mod batch_spread;
pub(crate) mod drawn_rays;
pub mod mode_sampling;
pub mod paper;
pub mod paper_plan;
pub mod repeated_runs;
pub(crate) mod tangent_patch;
pub(crate) mod tangent_patch_error;
