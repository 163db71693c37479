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
//! | `target` | The part of the next screen that beamlets must reach |
//! | `chirped_beamlet` | One beamlet with the curvature of its carrier, and the aberration inside it |
//! | `window_directions` | Which directions lead from a window to the target |
//! | `source_windows` | A smooth source: one beamlet a window |
//! | `tile_run` | One tile: from the light that arrives to the beamlets that leave |
//! | `emission` | The beamlets of one window |
//! | [`window_widths`] | How wide the windows of each screen may be |
//! | [`account`] | What a hop did |
//! | [`carry`] | The loop over tiles and hops |

pub mod account;
pub mod carry;
pub(crate) mod chirped_beamlet;
pub(crate) mod emission;
pub(crate) mod held_light;
pub mod settings;
pub(crate) mod source_windows;
pub(crate) mod target;
pub(crate) mod tile_run;
pub(crate) mod window_directions;
pub mod window_widths;
