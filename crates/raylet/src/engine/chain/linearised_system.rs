//! A system whose plans are made once: light through it many times, and gradients back.

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::chain::arriving_light::sensor_of;
use crate::engine::chain::forecast::{Chosen, choose_with};
use crate::engine::chain::forward_pass::{ForwardPass, Gradient, PassedLight};
use crate::engine::chain::linearised_bands::{LinearisedBands, SensorCotangent};
use crate::engine::chain::linearised_fields::LinearisedFields;
use crate::engine::chain::linearised_system_error::LinearisedSystemError;
use crate::engine::chain::rimmed_variations::{rimmed_variations, surfaces_stay};
use crate::engine::chain::screen_sensitivity::ScreenFields;
use crate::engine::monte_carlo::mode_sampling::Draws;
use crate::engine::plan::hop_plan::{Plan, along};
use crate::engine::plan::settings::{Method, Settings};
use crate::engine::progress::{Pulse, uncancelled};
use crate::engine::rims::joined_screens::joining_hops;
use crate::engine::rims::pixel_light::PixelValues;
use crate::engine::rims::rim_screens::with_rims_joining;
use crate::engine::trace::ray_sensitivity::{PerturbedHops, Variation, perturbed_hops};
use crate::optics::system::{Hop, System};
use crate::wave::free::propagate::FreeHop;
use crate::wave::grid::field::Field;

/// The frozen choices of a system: how its light is carried.
#[derive(Clone, Debug)]
pub struct LinearisedSystem {
    chain: LinearisedChain,
}

/// The method that propagates the light: from whole fields, or by local bands.
#[derive(Clone, Debug)]
enum LinearisedChain {
    Fields(LinearisedFields),
    Bands(LinearisedBands),
}

impl LinearisedSystem {
    /// Plans every hop of a system, so that it may vary: from whole fields or by local bands, as a run chooses.
    ///
    /// # Errors
    /// As [`crate::engine::chain::simulate::simulate`]; when a variation does not perturb the system, or bends the surface of a
    /// screen and whole fields are requested.
    pub fn new(
        system: &System,
        variations: &[Variation],
        settings: &Settings,
    ) -> Result<Self, LinearisedSystemError> {
        Self::new_with(system, variations, settings, &uncancelled)
    }

    /// [`LinearisedSystem::new`] with a pulse, which is called before each hop is planned.
    ///
    /// # Errors
    /// As [`LinearisedSystem::new`]; when the pulse cancels the work.
    pub fn new_with(
        system: &System,
        variations: &[Variation],
        settings: &Settings,
        pulse: &Pulse,
    ) -> Result<Self, LinearisedSystemError> {
        match settings.method {
            Method::Plane => return Err(LinearisedSystemError::Method("plane")),
            Method::Paper => return Err(LinearisedSystemError::Method("paper")),
            Method::Auto | Method::Beamlet | Method::LocalBands => {}
        }
        sensor_of(system)?;
        let mut settings = settings.for_planning();
        // Whole fields do not follow the surface of a screen that bends.
        let stay = surfaces_stay(system, variations);
        if stay.is_err() && settings.method == Method::Auto {
            settings.method = Method::LocalBands;
        }
        let settings = &settings;
        // Screens that a variation moves apart keep their hop.
        let mut joining = joining_hops(system, PixelValues::Varying);
        for other in variations.iter().flat_map(|one| [&one.below, &one.above]) {
            let there = joining_hops(other, PixelValues::Varying);
            joining
                .iter_mut()
                .zip(there)
                .for_each(|(joins, there)| *joins &= there);
        }
        let planned = with_rims_joining(system, settings, PixelValues::Varying, joining);
        let variations = &rimmed_variations(&planned, variations)?;
        let stays = |number: usize, hop: &Hop, free: &FreeHop| {
            let (_, perturbed) = perturbed_hops(variations, number, hop);
            perturbed.iter().all(|n| is_free(free, n))
        };
        let chosen = choose_with(&planned.system, settings, &stays, |_, _| pulse())?;
        let chain = match chosen {
            Chosen::WholeFields(hops) => {
                stay?;
                let plans = hops.into_iter().map(|(plan, _)| plan).collect();
                LinearisedChain::Fields(LinearisedFields::new(planned, plans, settings)?)
            }
            Chosen::LocalBands(settings) => {
                LinearisedChain::Bands(LinearisedBands { planned, settings })
            }
        };
        Ok(Self { chain })
    }

    /// This system with beamlets drawn at random instead of followed all. It gives an estimate of the field, and of the
    /// gradient by the pixels with the draws held constant. Free hops stay exact, and local bands follow all beamlets.
    pub fn drawn(&self, draws: Draws) -> Self {
        let chain = match &self.chain {
            LinearisedChain::Fields(fields) => LinearisedChain::Fields(fields.drawn(draws)),
            LinearisedChain::Bands(bands) => LinearisedChain::Bands(bands.clone()),
        };
        Self { chain }
    }

    /// The plans of whole fields, hop by hop; none for local bands.
    pub fn plans(&self) -> &[Plan] {
        match &self.chain {
            LinearisedChain::Fields(fields) => fields.plans(),
            LinearisedChain::Bands(_) => &[],
        }
    }

    /// Propagates the light of a system with the same screens and trains as the one that was planned. The record holds
    /// the field on the sensor.
    ///
    /// # Errors
    /// As [`crate::engine::chain::simulate::simulate`]; when the system is not like the one that was planned.
    pub fn forward(&self, system: &System) -> Result<ForwardPass, LinearisedSystemError> {
        self.forward_with(system, &uncancelled)
    }

    /// [`LinearisedSystem::forward`] with a pulse, which is called after each chunk of work.
    ///
    /// # Errors
    /// As [`LinearisedSystem::forward`]; when the pulse cancels the work.
    pub fn forward_with(
        &self,
        system: &System,
        pulse: &Pulse,
    ) -> Result<ForwardPass, LinearisedSystemError> {
        match &self.chain {
            LinearisedChain::Fields(fields) => fields.forward(system, pulse),
            LinearisedChain::Bands(bands) => bands.forward(system, pulse),
        }
    }

    /// The gradient of a real function of the field on the sensor, from its cotangent there,
    /// ∂L/∂Re U + i ∂L/∂Im U, [y, x].
    ///
    /// # Errors
    /// As [`LinearisedSystem::forward`].
    pub fn adjoint(
        &self,
        system: &System,
        variations: &[Variation],
        trace: &ForwardPass,
        field_bar: &Array2<Complex64>,
    ) -> Result<Gradient, LinearisedSystemError> {
        self.adjoint_with(system, variations, trace, field_bar, &uncancelled)
    }

    /// [`LinearisedSystem::adjoint`] with a pulse, which is called after each chunk of work.
    ///
    /// # Errors
    /// As [`LinearisedSystem::forward`]; when the pulse cancels the work.
    pub fn adjoint_with(
        &self,
        system: &System,
        variations: &[Variation],
        trace: &ForwardPass,
        field_bar: &Array2<Complex64>,
        pulse: &Pulse,
    ) -> Result<Gradient, LinearisedSystemError> {
        match (&self.chain, &trace.light) {
            (LinearisedChain::Bands(bands), PassedLight::Beamlets(kept)) => {
                let back = SensorCotangent {
                    field_bar,
                    variations,
                    pulse,
                };
                bands.adjoint(system, kept, &back)
            }
            (LinearisedChain::Bands(_), PassedLight::Fields(_)) => {
                Err(LinearisedSystemError::LocalBands)
            }
            (LinearisedChain::Fields(fields), _) => {
                fields.adjoint(system, variations, trace, field_bar, pulse)
            }
        }
    }

    /// The light of a system of one hop, before and behind its element.
    ///
    /// # Errors
    /// [`LinearisedSystemError::ControlVariate`] for more, [`LinearisedSystemError::LocalBands`] without whole fields;
    /// as [`LinearisedSystem::forward`].
    pub fn pass(&self, system: &System) -> Result<ScreenFields, LinearisedSystemError> {
        self.fields()?.pass(system)
    }

    /// Carries a field behind the element of such a system to its sensor; the pulse is called after each chunk of
    /// work.
    ///
    /// # Errors
    /// As [`LinearisedSystem::pass`]; when the pulse cancels the work.
    pub fn propagate(
        &self,
        system: &System,
        behind: &Field,
        pulse: &Pulse,
    ) -> Result<Field, LinearisedSystemError> {
        self.fields()?.propagate(system, behind, pulse)
    }

    /// The conjugate transpose of [`LinearisedSystem::propagate`], held by `drawn_dot_product` in the crate's tests: the
    /// cotangent behind the element. Only modes that are drawn, or too weak to be followed, contribute.
    ///
    /// # Errors
    /// As [`LinearisedSystem::propagate`].
    pub fn propagate_adjoint(
        &self,
        system: &System,
        behind: &Field,
        field_bar: &Array2<Complex64>,
        pulse: &Pulse,
    ) -> Result<Field, LinearisedSystemError> {
        (self.fields()?).propagate_adjoint(system, behind, field_bar, pulse)
    }

    fn fields(&self) -> Result<&LinearisedFields, LinearisedSystemError> {
        match &self.chain {
            LinearisedChain::Fields(fields) => Ok(fields),
            LinearisedChain::Bands(_) => Err(LinearisedSystemError::LocalBands),
        }
    }
}

/// Whether both perturbed ones of a free hop are free.
fn is_free(free: &FreeHop, perturbed: &PerturbedHops) -> bool {
    along(free, &perturbed.below).is_some() && along(free, &perturbed.above).is_some()
}
