//! What a scene says about its design by gradients.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::file::number::{not_negative, positive};

/// A design by gradients through the real system: what is free, and how it is sought. The picture wanted is
/// that of `[hologram]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Design {
    /// Number of iterations.
    #[serde(default = "hundred", deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1))]
    pub iterations: usize,
    /// How the minimum is sought.
    #[serde(default)]
    pub optimizer: Optimizer,
    /// Length of a step of adam or momentum, in radians.
    #[serde(default = "rate", deserialize_with = "positive")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: f64,
    /// Length of the last step, to which that of the first falls along half a cosine; the same by default.
    #[serde(default, deserialize_with = "positive")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub last_rate: Option<f64>,
    /// What the phases are at first.
    #[serde(default)]
    pub start: Start,
    /// Factor β of the loss −β·log(share of the light in the picture), which is added to 1 − NCC².
    #[serde(default = "efficiency", deserialize_with = "not_negative")]
    #[schemars(extend("minimum" = 0))]
    pub efficiency: f64,
    /// Number of equal phase levels that can be made; any phase by default.
    #[serde(default, deserialize_with = "positive")]
    #[schemars(extend("minimum" = 2))]
    pub levels: Option<usize>,
    /// Pixels along a side of the blocks that have one phase.
    #[serde(default = "one", deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1))]
    pub block: usize,
    /// Numbers of the scene that are designed as well.
    #[serde(default)]
    pub variable: Vec<Variable>,
    /// Iterations between two checkpoints.
    #[serde(default = "ten", deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1))]
    pub checkpoint: usize,
}

/// How a minimum is sought.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Optimizer {
    /// Limited-memory BFGS with a line search.
    #[default]
    Lbfgs,
    /// Adam with β 0.9 and 0.999.
    Adam,
    /// Gradient descent with momentum 0.9.
    Momentum,
}

/// What the phases of a design are at first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// A quadratic phase that spreads the light over the picture.
    #[default]
    Spread,
    /// Random phases.
    Random,
    /// The hologram of the paraxial train.
    Paraxial,
    /// Those of the file that the layer names.
    File,
    /// Zero.
    Flat,
}

/// A number of the scene that is designed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Variable {
    /// Where it stands, such as `element[1].surface[0].radius_mm`. Radii change by their curvature.
    pub path: String,
    /// By how much it is worth changing it: the unit of its steps. A thousandth of its value by default.
    #[serde(default, deserialize_with = "positive")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale: Option<f64>,
}

fn rate() -> f64 {
    0.2
}

fn efficiency() -> f64 {
    0.01
}

fn one() -> usize {
    1
}

fn ten() -> usize {
    10
}

fn hundred() -> usize {
    100
}
