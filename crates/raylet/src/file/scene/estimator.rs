//! Which beamlets the evaluations of a design follow.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::design::estimator::EstimatorKind;
use crate::file::decode::number::{count, positive};

/// Beamlets that are drawn instead of followed all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EstimatorTable {
    /// How.
    pub kind: EstimatorKind,
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

fn ten() -> usize {
    10
}

fn sixty_four() -> usize {
    64
}

fn unity() -> f64 {
    1.0
}
