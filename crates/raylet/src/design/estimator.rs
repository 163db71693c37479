//! How a design finds value and gradient: from all beamlets, or from some that are drawn.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::engine::chain::control_variate::ControlVariate;
use crate::engine::chain::forward_pass::{ForwardPass, Gradient};
use crate::engine::chain::linearised_system::LinearisedSystem;
use crate::engine::chain::linearised_system_error::LinearisedSystemError;
use crate::engine::monte_carlo::mode_sampling::{Drawing, Draws};
use crate::engine::progress::Pulse;
use crate::engine::trace::ray_sensitivity::Variation;
use crate::optics::system::System;

/// How beamlets are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EstimatorKind {
    /// Without replacement, for what has changed since the last exact evaluation.
    ControlVariate,
    /// Without replacement.
    WithoutReplacement,
    /// Independently; gradients hold the draws constant, as in the source paper's public code.
    Multinomial,
    /// Independently; gradients are those of a soft maximum, as in the source paper's text.
    Gumbel,
}

/// An estimator of value and gradient from beamlets that are drawn in each evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimator {
    /// Rule by which beamlets are drawn.
    pub kind: EstimatorKind,
    /// Number of draws from each patch.
    pub each: usize,
    /// Iterations from one exact evaluation to the next; for control variates.
    pub refresh: usize,
    /// Temperature of the soft maximum; for Gumbel's noise.
    pub temperature: f64,
}

impl Estimator {
    /// The draws of an iteration, by a seed of its own.
    pub fn draws(&self, seed: u64, iteration: usize) -> Draws {
        let drawing = match self.kind {
            EstimatorKind::ControlVariate | EstimatorKind::WithoutReplacement => {
                Drawing::WithoutReplacement
            }
            EstimatorKind::Multinomial => Drawing::Multinomial,
            EstimatorKind::Gumbel => Drawing::Gumbel {
                temperature: self.temperature,
            },
        };
        // Another seed for every iteration, the same again when a run is resumed.
        let seed = seed ^ (iteration as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        Draws {
            drawing,
            each: self.each,
            seed,
        }
    }

    /// Whether an iteration begins with an exact evaluation, from which estimates start.
    pub fn renews_control_variates(&self, iteration: usize) -> bool {
        self.kind == EstimatorKind::ControlVariate && iteration.is_multiple_of(self.refresh.max(1))
    }
}

/// The beamlets from which a point of a design is evaluated.
#[derive(Clone, Copy)]
pub enum EvaluationMode<'a> {
    /// From all beamlets.
    All,
    /// From drawn beamlets.
    Drawn(Draws),
    /// From an exact evaluation of each channel, and drawn beamlets for what has changed since.
    From(&'a [ControlVariate], Draws),
}

/// One channel of a design during an evaluation.
#[derive(Clone, Copy)]
pub(crate) struct ChannelEvaluation<'a> {
    /// Its index among the channels.
    pub index: usize,
    /// Its frozen plans.
    pub linearised: &'a LinearisedSystem,
    /// The system that its light goes through.
    pub system: &'a System,
    /// Called after each chunk of work; it may cancel the evaluation.
    pub pulse: &'a Pulse<'a>,
}

impl EvaluationMode<'_> {
    /// The light of a channel.
    ///
    /// # Errors
    /// As [`LinearisedSystem::forward_with`] and [`ControlVariate::forward`].
    pub(crate) fn forward(
        &self,
        channel: &ChannelEvaluation,
    ) -> Result<ForwardPass, LinearisedSystemError> {
        let ChannelEvaluation {
            index,
            linearised,
            system,
            pulse,
        } = *channel;
        match self {
            Self::All => linearised.forward_with(system, pulse),
            Self::Drawn(draws) => linearised.drawn(*draws).forward_with(system, pulse),
            Self::From(control_variates, draws) => {
                control_variates[index].forward(&linearised.drawn(*draws), system, pulse)
            }
        }
    }

    /// The adjoint of [`EvaluationMode::forward`]: its conjugate transpose, except for control variates and Gumbel's
    /// draws.
    ///
    /// # Errors
    /// As [`LinearisedSystem::adjoint_with`] and [`ControlVariate::forward_adjoint`].
    pub(crate) fn back(
        &self,
        channel: &ChannelEvaluation,
        variations: &[Variation],
        trace: &ForwardPass,
        field_bar: &ndarray::Array2<num_complex::Complex64>,
    ) -> Result<Gradient, LinearisedSystemError> {
        let ChannelEvaluation {
            index,
            linearised,
            system,
            pulse,
        } = *channel;
        match self {
            Self::All => linearised.adjoint_with(system, variations, trace, field_bar, pulse),
            Self::Drawn(draws) => linearised
                .drawn(*draws)
                .adjoint_with(system, variations, trace, field_bar, pulse),
            Self::From(..) if !variations.is_empty() => Err(LinearisedSystemError::Drawn),
            Self::From(control_variates, draws) => {
                let drawn = linearised.drawn(*draws);
                control_variates[index].forward_adjoint(&drawn, system, trace, field_bar, pulse)
            }
        }
    }
}
