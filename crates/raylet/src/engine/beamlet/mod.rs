//! Beamlets of one hop: their plan, their errors, and where they land.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `aberration_sample` | Which beamlets are sampled for their aberration, and its interpolation |
//! | `beamlet_aberration` | Cubic and quartic aberration inside one beamlet, and its correction |
//! | `beamlet_cache` | Beamlets that are kept from one run to the next |
//! | `beamlet_error` | Expected errors of beamlets of one width, from real rays |
//! | [`beamlet_launch`] | One beamlet from its place on a screen to its landing on the next |
//! | [`beamlet_plan`] | The plan of a beamlet sum: width, positions, directions and cost |
//! | `beamlet_target` | One beamlet of a patch and the target: where it lands, or why it is discarded |
//! | `beamlet_width` | The choice of the width σ of beamlets and of the distance of their windows |
//! | `discarded_tail` | The energy that the tail of a discarded beamlet would bring to the target |
//! | `mode_histogram` | The energy of all modes by their strength: what a threshold leaves out |
//! | `starting_width` | The width of beamlets about which others are tried |
//! | `workload` | What a beamlet plan will take, counted on a few patches |

pub(crate) mod aberration_sample;
pub(crate) mod beamlet_aberration;
pub(crate) mod beamlet_cache;
pub(crate) mod beamlet_error;
pub mod beamlet_launch;
pub mod beamlet_plan;
pub(crate) mod beamlet_target;
pub(crate) mod beamlet_width;
pub(crate) mod discarded_tail;
pub(crate) mod mode_histogram;
pub(crate) mod starting_width;
pub(crate) mod workload;
