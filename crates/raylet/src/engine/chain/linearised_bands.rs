//! A system whose windows are chosen once: light through it by local bands, many times, and gradients back.
//!
//! The forward pass keeps the beamlets on each screen; the adjoint plans each tile again. Window widths are frozen;
//! carriers and plane waves are found again for each system, which changes the field by no more than what is dropped.

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::chain::arriving_light::sensor_of;
use crate::engine::chain::forward_pass::{ForwardPass, Gradient, PassedLight};
use crate::engine::chain::linearised_system_error::LinearisedSystemError;
use crate::engine::chain::rimmed_variations::rimmed_variations;
use crate::engine::local_bands::carry::{
    KeptHop, LocalBandCotangent, carry_kept, carry_kept_adjoint,
};
use crate::engine::local_bands::settings::LocalBandSettings;
use crate::engine::progress::Pulse;
use crate::engine::rims::rim_screens::Rimmed;
use crate::engine::trace::ray_sensitivity::Variation;
use crate::optics::system::System;
use crate::wave::grid::field::{Field, Grid};

/// The frozen choices of a system: the windows of its screens.
#[derive(Clone, Debug)]
pub(crate) struct LinearisedBands {
    /// The system that was planned, with a screen at every rim that matters.
    pub planned: Rimmed,
    /// The widths of its windows and the other settings of local bands.
    pub settings: LocalBandSettings,
}

/// The input of the adjoint: the cotangent of the field on the sensor, and the parameters.
pub(crate) struct SensorCotangent<'a> {
    /// ∂L/∂Re U + i ∂L/∂Im U at the sensor's pixels, [y, x].
    pub field_bar: &'a Array2<Complex64>,
    /// The parameters.
    pub variations: &'a [Variation],
    /// Called after each chunk of work.
    pub pulse: &'a Pulse<'a>,
}

impl LinearisedBands {
    /// Carries the light of a system with the same screens and trains as the one that was planned; the pulse is called
    /// after each chunk of work.
    ///
    /// # Errors
    /// As [`crate::engine::chain::simulate::simulate`]; when the pulse cancels the work.
    pub(crate) fn forward(
        &self,
        system: &System,
        pulse: &Pulse,
    ) -> Result<ForwardPass, LinearisedSystemError> {
        let system = &self.like(system)?;
        let (outcome, kept) = carry_kept(system, &self.settings, &|_| pulse())?;
        Ok(ForwardPass {
            field: outcome.field,
            light: PassedLight::Beamlets(kept),
        })
    }

    /// The gradient of a real function of the field on the sensor, from what [`LinearisedBands::forward`] kept.
    ///
    /// # Errors
    /// As [`LinearisedBands::forward`]; when a variation does not perturb the system.
    pub(crate) fn adjoint(
        &self,
        system: &System,
        kept: &[KeptHop],
        back: &SensorCotangent,
    ) -> Result<Gradient, LinearisedSystemError> {
        let system = &self.like(system)?;
        let variations = &rimmed_variations(&self.planned, back.variations)?;
        let field = &Field {
            grid: Grid::of(sensor_of(system)?),
            values: back.field_bar.clone(),
        };
        let cotangent = LocalBandCotangent {
            field,
            variations,
            pulse: back.pulse,
        };
        let found = carry_kept_adjoint(system, &self.settings, kept, &cotangent)?;
        Ok(Gradient {
            pixels: self.planned.of_given(found.pixels),
            parameters: found.parameters,
        })
    }

    /// A system with screens at the same rims as the one that was planned.
    fn like(&self, system: &System) -> Result<System, LinearisedSystemError> {
        let system = self.planned.like(system);
        let (planned, found) = (self.settings.sigmas.len(), system.trains.len());
        if planned != found {
            return Err(LinearisedSystemError::Hops { planned, found });
        }
        Ok(system)
    }
}
