//! A design: its free parameters, its loss, and the gradient of the loss.
//!
//! One flat vector holds the parameters of the pixels of each element that is designed, then those of
//! the system (curvatures, distances, tilts, anything). Every channel, a wavelength or a field, sends light
//! through the system made from them; the losses on their sensors add up.

use ndarray::Array2;
use num_complex::Complex64;

use crate::design::constraints::modulation::{Modulator, Shaped};
use crate::design::estimator::{ChannelEvaluation, Estimator, EvaluationMode};
use crate::design::losses::loss::FieldLoss;
use crate::engine::chain::control_variate::ControlVariate;
use crate::engine::chain::linearised_system::LinearisedSystem;
use crate::engine::chain::linearised_system_error::LinearisedSystemError;
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::plan::settings::Settings;
use crate::engine::progress::{Pulse, uncancelled};
use crate::engine::trace::ray_sensitivity::Variation;
use crate::optics::screen::ScreenKind;
use crate::optics::system::System;

/// One coherent run that a design evaluates.
pub struct Channel {
    /// The losses of the field at the sensor's pixels, [y, x], each with its factor.
    pub losses: Vec<(f64, Box<dyn FieldLoss>)>,
    /// For each element, the phase that it gives this channel's light, divided by the phase that it is designed for.
    /// For heights this is the ratio of (index step)/λ. It is 1 for phases that do not depend on the wavelength, and
    /// for elements beyond the end of the list.
    pub ratios: Vec<f64>,
}

/// An element whose pixels are designed.
pub struct Element {
    /// Number of its screen in the systems, from 0.
    pub screen: usize,
    /// The map from its parameters to the transmission of its pixels.
    pub modulator: Modulator,
}

/// A parameter of the system that is designed.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemParameter {
    /// Name of the parameter, for messages.
    pub name: String,
    /// Value at the start, in the unit of the parameter.
    pub start: f64,
    /// Its change between the two perturbed systems that give its derivative, in the same unit.
    pub step: f64,
}

/// Makes the system of a channel from its parameters; the designed pixels may have any value.
pub(crate) type SystemBuild = Box<dyn Fn(usize, &[f64]) -> Result<System, String> + Send + Sync>;

/// A design: the systems, what may change in them, and the losses.
pub struct Project {
    /// The systems.
    pub build_system: SystemBuild,
    /// The runs that an evaluation takes, each with its light and its losses.
    pub channels: Vec<Channel>,
    /// The elements that are designed.
    pub elements: Vec<Element>,
    /// The parameters of the system that are designed.
    pub system_parameters: Vec<SystemParameter>,
    /// Estimator of value and gradient from drawn beamlets; `None` for exact ones from all beamlets.
    pub estimator: Option<Estimator>,
    /// Settings of each run: method, target error, memory limit.
    pub settings: Settings,
}

/// Why a design cannot go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProjectError {
    /// A system cannot be carried or differentiated.
    #[error(transparent)]
    LinearisedSystem(#[from] LinearisedSystemError),
    /// The parameters make no system.
    #[error("{0}")]
    System(String),
    /// Nothing that a search could compare.
    #[error("a loss or a gradient that is not finite")]
    NotFinite,
    /// An element that is not there.
    #[error("screen {0} has no pixels to design")]
    Pixels(usize),
    /// A loss for another sensor.
    #[error("a loss for {expected:?} pixels (rows, columns) on a sensor of {found:?}")]
    Shape {
        /// What the loss expects.
        expected: (usize, usize),
        /// What the sensor has.
        found: (usize, usize),
    },
}

impl ProjectError {
    /// Whether another point may not have this error: the parameters make no system here, or the light spreads too far
    /// for local bands.
    pub(crate) fn is_of_point(&self) -> bool {
        match self {
            Self::System(_) => true,
            Self::LinearisedSystem(error) => {
                matches!(
                    error,
                    LinearisedSystemError::Simulate(SimulateError::LocalBands(_))
                )
            }
            Self::NotFinite | Self::Pixels(_) | Self::Shape { .. } => false,
        }
    }
}

/// The value and gradient of a design at a point, with its light.
pub struct DesignEvaluation {
    /// The sum of the losses, and of the penalty on steps.
    pub value: f64,
    /// Every loss of every channel, without its factor.
    pub parts: Vec<Vec<f64>>,
    /// Derivative of `value` with respect to each parameter.
    pub gradient: Vec<f64>,
    /// |U|² at the sensor's pixels for each channel, [y, x].
    pub intensities: Vec<Array2<f64>>,
    /// ∫|U|² just behind the first screen of each channel, in mm² for unit amplitude; nothing where local bands carry
    /// its light.
    pub powers: Vec<Option<f64>>,
}

impl DesignEvaluation {
    /// Whether the loss, its parts and its gradient are numbers.
    pub fn is_finite(&self) -> bool {
        let parts = self.parts.iter().flatten().chain(&self.gradient);
        self.value.is_finite() && { parts }.all(|value| value.is_finite())
    }
}

/// The frozen plans of all channels, made about some values of the parameters.
pub struct Plans {
    linearised_systems: Vec<LinearisedSystem>,
}

impl Project {
    /// Number of parameters: of all elements, then of the system.
    pub fn len(&self) -> usize {
        self.system_parameters_from() + self.system_parameters.len()
    }

    /// Whether nothing is free.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Index of the first parameter of the system; those of the pixels come before it.
    pub fn system_parameters_from(&self) -> usize {
        self.elements.iter().map(|e| e.modulator.count()).sum()
    }

    /// The phases and amplitudes of each element at a point; `share` of the iterations are done.
    pub fn make(&self, point: &[f64], share: f64) -> Vec<Shaped> {
        let mut from = 0;
        let make = |element: &Element| {
            let part = &point[from..from + element.modulator.count()];
            from += part.len();
            element.modulator.make(part, share)
        };
        self.elements.iter().map(make).collect()
    }

    /// The system of a channel at a point, from what its elements are made of.
    ///
    /// # Errors
    /// When the parameters make no system, or an element is not there.
    pub fn system(
        &self,
        channel: usize,
        made: &[Shaped],
        parameters: &[f64],
    ) -> Result<System, ProjectError> {
        let mut system = (self.build_system)(channel, parameters).map_err(ProjectError::System)?;
        for (index, (element, made)) in self.elements.iter().zip(made).enumerate() {
            let screen = system.screens.get_mut(element.screen);
            let pixels = screen.and_then(|screen| match &mut screen.kind {
                ScreenKind::Doe(doe) => doe.free_pixels_mut(),
                ScreenKind::Stop(_) | ScreenKind::Sensor(_) => None,
            });
            let Some(pixels) = pixels else {
                return Err(ProjectError::Pixels(element.screen));
            };
            let ratio = self.channels[channel].ratio(index);
            pixels.values = element.modulator.transmission(made, ratio);
        }
        Ok(system)
    }

    /// Plans every channel about a point.
    ///
    /// # Errors
    /// When a system cannot be made, carried or differentiated there, or the pulse cancels the work.
    pub fn plan(&self, point: &[f64], share: f64, pulse: &Pulse) -> Result<Plans, ProjectError> {
        let (made, parameters) = (
            self.make(point, share),
            &point[self.system_parameters_from()..],
        );
        let linearised = |channel: usize| {
            let system = self.system(channel, &made, parameters)?;
            let variations = self.variations(channel, &made, parameters)?;
            let settings = &self.settings;
            Ok(LinearisedSystem::new_with(
                &system,
                &variations,
                settings,
                pulse,
            )?)
        };
        let linearised_systems = (0..self.channels.len()).map(linearised);
        Ok(Plans {
            linearised_systems: linearised_systems.collect::<Result<_, ProjectError>>()?,
        })
    }

    /// Value and gradient at a point, `share` of the iterations done.
    ///
    /// # Errors
    /// As [`Project::plan`].
    pub fn evaluate(
        &self,
        plans: &Plans,
        point: &[f64],
        share: f64,
    ) -> Result<DesignEvaluation, ProjectError> {
        self.evaluate_by(plans, point, share, &EvaluationMode::All, &uncancelled)
    }

    /// Exact evaluations of all channels, from which estimates start.
    ///
    /// # Errors
    /// As [`Project::evaluate`]; when a channel has more than one hop, or the pulse cancels the work.
    pub fn control_variates(
        &self,
        plans: &Plans,
        point: &[f64],
        share: f64,
        pulse: &Pulse,
    ) -> Result<Vec<ControlVariate>, ProjectError> {
        let (made, parameters) = (
            self.make(point, share),
            &point[self.system_parameters_from()..],
        );
        let linearised_systems = self
            .channels
            .iter()
            .zip(&plans.linearised_systems)
            .enumerate();
        let control_variate =
            |(index, (channel, linearised)): (usize, (&Channel, &LinearisedSystem))| {
                let system = self.system(index, &made, parameters)?;
                ControlVariate::new(linearised, &system, pulse, |field| {
                    Ok(channel.evaluate(&field.values)?.1)
                })
            };
        linearised_systems.map(control_variate).collect()
    }

    /// [`Project::evaluate`] with the beamlets that `mode` follows.
    ///
    /// # Errors
    /// As [`Project::evaluate`], `EvaluationMode::forward` and `EvaluationMode::back`; when the pulse cancels the work.
    pub fn evaluate_by(
        &self,
        plans: &Plans,
        point: &[f64],
        share: f64,
        mode: &EvaluationMode,
        pulse: &Pulse,
    ) -> Result<DesignEvaluation, ProjectError> {
        let (made, parameters) = (
            self.make(point, share),
            &point[self.system_parameters_from()..],
        );
        let mut evaluation = DesignEvaluation {
            value: 0.0,
            parts: Vec::new(),
            gradient: vec![0.0; self.len()],
            intensities: Vec::new(),
            powers: Vec::new(),
        };
        for (index, (channel, linearised)) in self
            .channels
            .iter()
            .zip(&plans.linearised_systems)
            .enumerate()
        {
            let system = self.system(index, &made, parameters)?;
            let seen = ChannelEvaluation {
                index,
                linearised,
                system: &system,
                pulse,
            };
            let trace = mode.forward(&seen)?;
            let (parts, field_bar) = channel.evaluate(&trace.field.values)?;
            evaluation.value += channel.total(&parts);
            let variations = self.variations(index, &made, parameters)?;
            let gradient = mode.back(&seen, &variations, &trace, &field_bar)?;
            self.gather(&made, channel, &gradient.pixels, &mut evaluation.gradient);
            let from = self.system_parameters_from();
            add(&mut evaluation.gradient[from..], &gradient.parameters);
            evaluation.parts.push(parts);
            evaluation.powers.push(trace.power_behind());
            evaluation.intensities.push(trace.field.intensity());
        }
        let mut from = 0;
        for (element, made) in self.elements.iter().zip(&made) {
            let count = element.modulator.count();
            if let Some((price, back)) = element.modulator.price(made) {
                evaluation.value += price;
                add(&mut evaluation.gradient[from..from + count], &back);
            }
            from += count;
        }
        Ok(evaluation)
    }

    /// The value alone.
    ///
    /// # Errors
    /// As [`Project::evaluate`].
    pub fn value(&self, plans: &Plans, point: &[f64], share: f64) -> Result<f64, ProjectError> {
        let (made, parameters) = (
            self.make(point, share),
            &point[self.system_parameters_from()..],
        );
        let mut value = 0.0;
        for (index, (channel, linearised)) in self
            .channels
            .iter()
            .zip(&plans.linearised_systems)
            .enumerate()
        {
            let trace = linearised.forward(&self.system(index, &made, parameters)?)?;
            value += channel.total(&channel.evaluate(&trace.field.values)?.0);
        }
        let prices = self.elements.iter().zip(&made);
        let prices = prices.filter_map(|(element, made)| element.modulator.price(made));
        Ok(value + prices.map(|(price, _)| price).sum::<f64>())
    }

    /// Adds what the pixels of all elements give back to their parameters.
    fn gather(
        &self,
        made: &[Shaped],
        channel: &Channel,
        pixels: &[Option<Array2<Complex64>>],
        gradient: &mut [f64],
    ) {
        let mut from = 0;
        for (index, (element, made)) in self.elements.iter().zip(made).enumerate() {
            let (modulator, ratio) = (&element.modulator, channel.ratio(index));
            if let Some(Some(bar)) = pixels.get(element.screen) {
                let back = modulator.transmission_adjoint(made, ratio, bar.view());
                add(&mut gradient[from..], &back);
            }
            from += modulator.count();
        }
    }

    /// The perturbed systems that give the derivatives with respect to the parameters of the system.
    fn variations(
        &self,
        channel: usize,
        made: &[Shaped],
        parameters: &[f64],
    ) -> Result<Vec<Variation>, ProjectError> {
        let system = |moved: &[f64]| self.system(channel, made, moved);
        let variation = |(i, parameter): (usize, &SystemParameter)| {
            Variation::new(parameters, i, parameter.step, system)
        };
        self.system_parameters
            .iter()
            .enumerate()
            .map(variation)
            .collect()
    }
}

impl Channel {
    /// See [`Channel::ratios`].
    fn ratio(&self, element: usize) -> f64 {
        self.ratios.get(element).copied().unwrap_or(1.0)
    }

    /// The losses with their factors.
    fn total(&self, parts: &[f64]) -> f64 {
        let terms = self.losses.iter().zip(parts);
        terms.map(|((factor, _), part)| factor * part).sum()
    }

    /// Every loss, and the cotangent of the field.
    fn evaluate(
        &self,
        field: &Array2<Complex64>,
    ) -> Result<(Vec<f64>, Array2<Complex64>), ProjectError> {
        let mut field_bar = Array2::zeros(field.dim());
        let mut parts = Vec::new();
        for (factor, loss) in &self.losses {
            let (expected, found) = (loss.pixels(), field.dim());
            if expected != found {
                return Err(ProjectError::Shape { expected, found });
            }
            let found = loss.evaluate_field(field.view());
            field_bar.zip_mut_with(&found.bar, |total, bar| *total += bar * factor);
            parts.push(found.value);
        }
        Ok((parts, field_bar))
    }
}

/// Adds part to part.
fn add(totals: &mut [f64], parts: &[f64]) {
    let pairs = totals.iter_mut().zip(parts);
    pairs.for_each(|(total, part)| *total += part);
}
