//! Local bands: screens that are never held as a whole.
//!
//! A window of a screen sees only the light that crosses it. For a block of windows, the beamlets that arrive there are
//! summed about a local carrier, on a grid for what is left beside it; each window is multiplied by the element, turned
//! into plane waves, and sends chirped beamlets on. A run holds the beamlets between two screens, and one tile a thread.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`settings`] | What may be chosen about a run |
//! | `held_light` | The light that arrives at a screen: of the source, or as beamlets |
//! | `source` | The light of a source: its aperture, its windows, what these depart by |
//! | `target` | The part of the next screen that beamlets must reach |
//! | `chirped_beamlet` | One beamlet with the curvature of its carrier, and the aberration inside it |
//! | `onward_way` | The way of light through bare apertures and smooth elements, to another element or the sensor |
//! | `passing_light` | The beamlets that pass a bare aperture without touching its edge |
//! | `window_directions` | Which directions lead from a window to the target |
//! | `tile_plan` | One tile before its light goes on: carriers, samples, windows that see the target |
//! | `tile_run` | One tile: from the light that arrives to the beamlets that leave, and back |
//! | `edge_band` | The light of an edge that the nodes of its tile do not resolve |
//! | `edge_light` | The light that an edge sends to a sensor far beside its own way, by an integral along the edge |
//! | `edge_workload` | What light that an edge sends far asks for: the width of windows, and work |
//! | `window_light` | The light under one window, from the samples of its tile |
//! | `emission` | The beamlets of one window |
//! | [`window_widths`] | How wide the windows of each screen may be |
//! | `outside_aberration` | The aberration of windows whose centres lie outside an aperture |
//! | `workload` | What a run will take, by rays of the source |
//! | [`local_band_error`] | Why local bands cannot carry the light of a system |
//! | `hop_changes` | How a hop changes with the parameters of a system: rays, element, source |
//! | `hop_cotangents` | Cotangents of a hop: of what it sends, and of what arrives |
//! | `hop_step` | One hop: all its tiles, forward and back |
//! | [`carry`] | The loop over hops, forward and back |

pub mod carry;
pub(crate) mod chirped_beamlet;
pub(crate) mod edge_band;
pub(crate) mod edge_light;
pub(crate) mod edge_workload;
pub(crate) mod emission;
pub(crate) mod held_light;
pub(crate) mod hop_changes;
pub(crate) mod hop_cotangents;
pub(crate) mod hop_step;
pub mod local_band_error;
pub(crate) mod onward_way;
pub(crate) mod outside_aberration;
pub(crate) mod passing_light;
pub mod settings;
pub(crate) mod source;
pub(crate) mod target;
pub(crate) mod tile_plan;
pub(crate) mod tile_run;
pub(crate) mod window_directions;
pub(crate) mod window_light;
pub mod window_widths;
pub(crate) mod workload;
