//! What a scene says about its design by gradients.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::file::decode::number::{acute, count, from_one, not_negative, positive};
use crate::file::scene::estimator::EstimatorTable;
use crate::file::scene::loss_specification::LossSpecification;

/// A design by gradients through the real system: what is free, the losses, and the search.
///
/// Without `[[design.element]]` the phases of the element that `[hologram]` names are designed, if there is one;
/// without `[[design.loss]]` the picture that it names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Design {
    /// Number of iterations.
    #[serde(default = "hundred", deserialize_with = "count")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000))]
    pub iterations: usize,
    /// How the search finds the minimum.
    #[serde(default)]
    pub optimizer: OptimizerKind,
    /// Which beamlets an evaluation follows; all by default. Drawn ones take adam or momentum, and a system without
    /// `[[design.variable]]` whose only other screen is the sensor.
    #[serde(default)]
    pub estimator: Option<EstimatorTable>,
    /// Length of a step of adam or momentum, in radians; 0.2 by default.
    #[serde(default, deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub rate: Option<f64>,
    /// Length of the last step, to which that of the first falls along half a cosine; the same by default.
    #[serde(default, deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub last_rate: Option<f64>,
    /// What the phases of the element of `[hologram]` are at first; `spread` by default.
    #[serde(default)]
    pub start: Option<Start>,
    /// Factor β of the loss −β·log(share of the light in the picture of `[hologram]`), which is added to
    /// 1 − NCC²; 0.01 by default.
    #[serde(default, deserialize_with = "not_negative")]
    #[schemars(extend("minimum" = 0))]
    pub efficiency: Option<f64>,
    /// Number of equal phase levels of the element of `[hologram]`; any phase by default.
    #[serde(default, deserialize_with = "count")]
    #[schemars(extend("minimum" = 2, "maximum" = 1_000_000_000))]
    pub levels: Option<usize>,
    /// Pixels along a side of the blocks of the element of `[hologram]` that have one phase; 1 by default.
    #[serde(default, deserialize_with = "count")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000))]
    pub block: Option<usize>,
    /// Elements whose pixels are designed.
    #[serde(default)]
    pub element: Vec<DesignElement>,
    /// Numbers of the scene that are designed as well.
    #[serde(default)]
    pub variable: Vec<Variable>,
    /// Directions or places from which the light comes, one after the other, instead of the source's own.
    #[serde(default)]
    pub field: Vec<View>,
    /// The losses of the light on the sensor; the sum of all of them counts.
    #[serde(default)]
    pub loss: Vec<LossSpecification>,
    /// Iterations between two checkpoints.
    #[serde(default = "ten", deserialize_with = "count")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000))]
    pub checkpoint: usize,
}

/// An element whose pixels are designed, and what a tool can make of them. What is found goes into the files that
/// its layer names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignElement {
    /// Name of the diffractive element; its first layer of pixels, heights or a sum is designed.
    pub name: String,
    /// What is free in each pixel.
    #[serde(default)]
    pub free: Free,
    /// What the phases are at first; amplitudes start at 1, or with the file.
    #[serde(default = "flat")]
    pub start: Start,
    /// Number of equal levels of phase or height that can be made; any by default.
    #[serde(default, deserialize_with = "count")]
    #[schemars(extend("minimum" = 2, "maximum" = 1_000_000_000))]
    pub levels: Option<usize>,
    /// Pixels along a side of the blocks that have one value: the smallest feature.
    #[serde(default = "one", deserialize_with = "count")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000))]
    pub block: usize,
    /// Radius in blocks of the conic blur before the levels, which makes smaller features rare.
    #[serde(default, deserialize_with = "from_one")]
    #[schemars(extend("minimum" = 1, "maximum" = 1e6))]
    pub blur: Option<f64>,
    /// Price of steps between neighbouring pixels: this times the mean of 2 − 2cos(step) is added to the loss.
    #[serde(default, deserialize_with = "not_negative")]
    #[schemars(extend("minimum" = 0))]
    pub smoothness: f64,
    /// Largest height in micrometres where heights are free; by default one wave of the first wavelength.
    #[serde(default, deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub highest_um: Option<f64>,
}

/// What is free in each pixel of an element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Free {
    /// The phase of a layer of pixels, the same at every wavelength.
    #[default]
    Phase,
    /// The amplitude of a layer of pixels, 0 to 1.
    Amplitude,
    /// Phase and amplitude of a layer of pixels.
    Both,
    /// The phases of the two terms of a sum, each one layer of pixels; the weights are the sum's.
    TwoPhase,
    /// The height of a layer of material, whose phase depends on the wavelength as its index has it.
    Height,
}

/// How a search finds a minimum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OptimizerKind {
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
    /// A quadratic phase that spreads the light over the picture of `[hologram]`.
    #[default]
    Spread,
    /// Random phases.
    Random,
    /// The hologram of the paraxial train.
    Paraxial,
    /// What the files hold that the layer names.
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
    /// The change of the number that matters, which is the unit of its steps. A thousandth of its value by default.
    #[serde(default, deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub scale: Option<f64>,
    /// The smallest value that it may have, as it stands in the scene.
    #[serde(default)]
    pub lowest: Option<f64>,
    /// The largest value that it may have, as it stands in the scene.
    #[serde(default)]
    pub highest: Option<f64>,
}

/// Where the light comes from in one of several runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Direction of a plane source, as in `[source]`.
    #[serde(default, deserialize_with = "acute")]
    pub angle_deg: Option<[f64; 2]>,
    /// Place of a point source, as in `[source]`.
    #[serde(default)]
    pub position_mm: Option<[f64; 3]>,
}

fn flat() -> Start {
    Start::Flat
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
