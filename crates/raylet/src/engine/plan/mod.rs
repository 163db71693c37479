//! The plan of a hop: which method carries it, with which settings, and what is known of the light before.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `cost_model` | Measured seconds of one core, for forecasts and the choice of a method |
//! | [`direction_spread`] | The directions of the light on a screen, as far as they are known before it is computed |
//! | [`downstream`] | Where the light of a hop goes next |
//! | [`hop_method`] | How a hop of a run is carried: from a whole field or by local bands |
//! | [`hop_plan`] | The choice of a method for a hop |
//! | `method_reason` | The reason for the method of a hop, in words |
//! | [`plan_error`] | Why a hop has no plan |
//! | [`work`] | What a hop takes: rays, values and seconds |
//! | [`settings`] | The choices of a user about a run |

pub(crate) mod cost_model;
pub mod direction_spread;
pub mod downstream;
pub mod hop_method;
pub mod hop_plan;
pub(crate) mod method_reason;
pub mod plan_error;
pub mod settings;
pub mod work;
