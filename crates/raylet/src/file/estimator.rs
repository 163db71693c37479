//! Which beamlets a design's looks follow.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::design::estimator as design;
use crate::file::design::{Design, Optimizer};
use crate::file::fault::Fault;
use crate::file::number::positive;
use crate::file::scene::Scene;
use crate::optics::system::System;

/// Beamlets that are drawn instead of followed all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Estimator {
    /// How.
    pub kind: Drawing,
    /// Beamlets drawn of each patch.
    #[serde(default = "sixty_four", deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1))]
    pub each: usize,
    /// Iterations from one exact look to the next, for `control_variate`.
    #[serde(default = "ten", deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1))]
    pub refresh: usize,
    /// Temperature of the soft maximum, for `gumbel`.
    #[serde(default = "unity", deserialize_with = "positive")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub temperature: f64,
}

/// How beamlets are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Drawing {
    /// Without replacement, for what has changed since the last exact look.
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

/// Which beamlets are followed.
///
/// # Errors
/// Drawn ones with what they cannot serve.
pub fn estimator(
    scene: &Scene,
    asked: &Design,
    system: &System,
) -> Result<design::Estimator, Fault> {
    let Some(given) = &asked.estimator else {
        return Ok(design::Estimator::Exact);
    };
    let fault = |found: &str, expected: &str| Err(scene.fault("design.estimator", found, expected));
    if asked.optimizer == Optimizer::Lbfgs {
        return fault(
            "drawn beamlets with the optimizer lbfgs",
            "adam or momentum, which bear noise",
        );
    }
    if !asked.variable.is_empty() {
        return fault(
            "drawn beamlets and numbers that are designed",
            "one of the two",
        );
    }
    if given.kind == Drawing::ControlVariate && system.trains.len() != 1 {
        return fault(
            "a control variate with several screens before the sensor",
            "one element and the sensor",
        );
    }
    let (each, refresh) = (given.each, given.refresh);
    Ok(match given.kind {
        Drawing::ControlVariate => design::Estimator::ControlVariate { each, refresh },
        Drawing::WithoutReplacement => design::Estimator::WithoutReplacement { each },
        Drawing::Multinomial => design::Estimator::Multinomial { each },
        Drawing::Gumbel => design::Estimator::Gumbel {
            each,
            temperature: given.temperature,
        },
    })
}
