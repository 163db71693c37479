//! Which beamlets the evaluations of a design follow.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::file::decode::number::{count, positive};

/// Beamlets that are drawn instead of followed all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Estimator {
    /// How.
    pub kind: Drawing,
    /// Beamlets drawn of each patch.
    #[serde(default = "sixty_four", deserialize_with = "count")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000))]
    pub each: usize,
    /// Iterations from one exact evaluation to the next, for `control_variate`.
    #[serde(default = "ten", deserialize_with = "count")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000))]
    pub refresh: usize,
    /// Temperature of the soft maximum, for `gumbel`.
    #[serde(default = "unity", deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub temperature: f64,
}

/// How beamlets are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Drawing {
    /// Without replacement, for what has changed since the last exact evaluation.
    ControlVariate,
    /// Without replacement.
    WithoutReplacement,
    /// Independently, held constant on the way back, as in the source paper's public code.
    Multinomial,
    /// The same, with the gradient of a soft maximum, as in the source paper's text.
    Gumbel,
}

fn ten() -> usize {
    10
}

fn sixty_four() -> usize {
    64
}

fn unity() -> f64 {
    1.0
}
