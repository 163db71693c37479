//! A system whose whole fields are planned once: light through it many times, and gradients back.
//!
//! The forward pass keeps the field on each screen, before and behind it; the adjoint traces the rays again,
//! chunk by chunk. Memory is that of the screens, whatever the number of rays; where the beamlets of the planned
//! system fit into an eighth of the memory limit they are kept, which changes no bit of a result. Plans are
//! frozen so that what is differentiated is one fixed, smooth function.

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::beamlet::beamlet_cache::BeamletCache;
use crate::engine::chain::arriving_light::{
    Arriving, arrival_reach, leaving, receiving_raster, sensor_of,
};
use crate::engine::chain::backend::AdjointSums;
use crate::engine::chain::forward_pass::{ForwardPass, Gradient, PassedLight};
use crate::engine::chain::hop_run::HopRun;
use crate::engine::chain::linearised_system_error::LinearisedSystemError;
use crate::engine::chain::rimmed_variations::{rimmed_variations, surfaces_stay};
use crate::engine::chain::screen_sensitivity::{ScreenFields, pull_act, pull_light};
use crate::engine::monte_carlo::mode_sampling::Draws;
use crate::engine::plan::downstream::Downstream;
use crate::engine::plan::hop_plan::{Plan, along};
use crate::engine::plan::settings::Settings;
use crate::engine::progress::{Cancelled, Pulse};
use crate::engine::rims::rim_screens::Rimmed;
use crate::engine::trace::ray_sensitivity::{Variation, perturbed_hops};
use crate::optics::system::{Hop, System};
use crate::wave::grid::field::{Field, Grid};
use crate::wave::grid::height_stack::HeightStack;
use crate::wave::grid::raster::Raster;
use crate::wave::grid::sampling::apply_screen_adjoint;

/// The frozen choices of a system: how each hop is carried from a whole field.
#[derive(Clone, Debug)]
pub(crate) struct LinearisedFields {
    /// What was planned, with screens at rims: by it beamlets are chosen and corrected.
    planned: Rimmed,
    settings: Settings,
    plans: Vec<Plan>,
    /// For each hop, where the beamlets of the planned system are kept.
    caches: Vec<Vec<BeamletCache>>,
    /// How beamlets are drawn; nothing where all are followed.
    draws: Option<Draws>,
}

impl LinearisedFields {
    /// The plans of whole fields, with nothing kept yet.
    ///
    /// # Errors
    /// When a second screen takes too many samples.
    pub(crate) fn new(
        planned: Rimmed,
        plans: Vec<Plan>,
        settings: &Settings,
    ) -> Result<Self, LinearisedSystemError> {
        let mut linearised = Self {
            settings: settings.shared(planned.system.trains.len()),
            planned,
            plans,
            caches: Vec::new(),
            draws: None,
        };
        linearised.caches = linearised.empty_caches()?;
        Ok(linearised)
    }

    /// This system with beamlets drawn at random instead of followed all. It gives an estimate of the field, and of the
    /// gradient by the pixels with the draws held constant. Free hops stay exact.
    pub(crate) fn drawn(&self, draws: Draws) -> Self {
        Self {
            draws: Some(draws),
            ..self.clone()
        }
    }

    /// A cache for each level of each hop's second screen.
    fn empty_caches(&self) -> Result<Vec<Vec<BeamletCache>>, LinearisedSystemError> {
        let hops = self.planned.system.hops().enumerate();
        let caches = |(number, hop)| {
            let (run, _, reach) = self.run(number, hop, &self.plans)?;
            let levels = run.stack(reach).map_or(1, |stack| stack.len());
            Ok((0..levels).map(|_| BeamletCache::default()).collect())
        };
        hops.map(caches).collect()
    }

    /// The plans, hop by hop.
    pub(crate) fn plans(&self) -> &[Plan] {
        &self.plans
    }

    /// Carries the light of a system with the same screens and trains as the one that was planned; the pulse is called
    /// after each chunk of work.
    ///
    /// # Errors
    /// As [`crate::engine::chain::simulate::simulate`]; when the system is not like the one that was planned; when the
    /// pulse cancels the work.
    pub(crate) fn forward(
        &self,
        system: &System,
        pulse: &Pulse,
    ) -> Result<ForwardPass, LinearisedSystemError> {
        let system = &self.planned.like(system);
        let plans = self.plans_for(system)?;
        let mut light = Arriving::from_source(system);
        let mut screens = Vec::new();
        for (number, hop) in system.hops().enumerate() {
            Cancelled::check(pulse())?;
            let (run, raster, reach) = self.run(number, hop, &plans)?;
            let leaving = leaving(run.plan);
            let (arrived, behind) = light.pass(system, hop.from, leaving, &self.settings)?;
            let (levels, _) = run.carry(&behind, raster, reach, &|_| pulse())?;
            screens.push(ScreenFields { arrived, behind });
            light = Arriving {
                sum: Some(levels),
                directions: light.directions,
                reach,
            };
        }
        let grid = Grid::of(sensor_of(system)?);
        let values = match light.sum {
            Some(levels) => levels.into_middle(),
            None => Array2::zeros(grid.shape()),
        };
        Ok(ForwardPass {
            field: Field { grid, values },
            light: PassedLight::Fields(screens),
        })
    }

    /// The gradient of a real function of the field on the sensor, from its cotangent there,
    /// ∂L/∂Re U + i ∂L/∂Im U, [y, x]; the pulse is called after each chunk of work.
    ///
    /// # Errors
    /// As [`LinearisedFields::forward`].
    pub(crate) fn adjoint(
        &self,
        system: &System,
        variations: &[Variation],
        trace: &ForwardPass,
        field_bar: &Array2<Complex64>,
        pulse: &Pulse,
    ) -> Result<Gradient, LinearisedSystemError> {
        if self.draws.is_some() && !variations.is_empty() {
            return Err(LinearisedSystemError::Drawn);
        }
        let system = &self.planned.like(system);
        let variations = &rimmed_variations(&self.planned, variations)?;
        surfaces_stay(system, variations)?;
        let plans = self.plans_for(system)?;
        let hops: Vec<Hop> = system.hops().collect();
        let mut gradient = Gradient {
            pixels: vec![None; hops.len()],
            parameters: vec![0.0; variations.len()],
        };
        let mut levels_bar = vec![field_bar.clone()];
        let (planned, found) = (hops.len(), trace.screens().len());
        if planned != found {
            return Err(LinearisedSystemError::Hops { planned, found });
        }
        for ((number, hop), passed) in hops.iter().enumerate().zip(trace.screens()).rev() {
            Cancelled::check(pulse())?;
            let (run, raster, reach) = self.run(number, *hop, &plans)?;

            // field behind the screen -> levels of the next
            let mut bar = Field::zeros(passed.behind.grid.clone());
            let (moving, perturbed) = perturbed_hops(variations, number, hop);
            let mut pulled = vec![0.0; moving.len()];
            let mut back = AdjointSums {
                from_bar: &mut bar.values,
                perturbed: &perturbed,
                parameters: &mut pulled,
                pulse,
            };
            run.carry_adjoint(&passed.behind, raster, reach, &levels_bar, &mut back)?;
            let parts = moving.into_iter().zip(pulled);
            parts.for_each(|(parameter, part)| gradient.parameters[parameter] += part);

            // arrived -> behind
            for (total, variation) in gradient.parameters.iter_mut().zip(variations) {
                *total += pull_act(variation, number, passed, &bar);
            }
            gradient.pixels[number] = apply_screen_adjoint(hop.from, &passed.arrived, &mut bar);

            // levels of this screen, or the source -> arrived
            if number > 0 {
                levels_bar = self.levels_bar_before(number - 1, hops[number - 1], &plans, &bar)?;
            } else {
                for (total, variation) in gradient.parameters.iter_mut().zip(variations) {
                    *total += pull_light(variation, passed, &bar);
                }
            }
        }
        gradient.pixels = self.planned.of_given(gradient.pixels);
        Ok(gradient)
    }

    /// The cotangents of the levels on which a hop is summed, from that of the field that arrives at its second
    /// screen.
    fn levels_bar_before(
        &self,
        number: usize,
        hop: Hop,
        plans: &[Plan],
        arrived_bar: &Field,
    ) -> Result<Vec<Array2<Complex64>>, LinearisedSystemError> {
        let (run, raster, reach) = self.run(number, hop, plans)?;
        let levels = HeightStack {
            raster,
            stack: run.stack(reach),
            values: Vec::new(),
        };
        Ok(levels.on_adjoint(hop.to, arrived_bar))
    }

    /// The light of a system of one hop, before and behind its element.
    ///
    /// # Errors
    /// [`LinearisedSystemError::ControlVariate`] for more; as [`LinearisedFields::forward`].
    pub(crate) fn pass(&self, system: &System) -> Result<ScreenFields, LinearisedSystemError> {
        let (system, plans) = self.one_hop(system)?;
        let light = Arriving::from_source(&system);
        let (from, leaving) = (&system.screens[0], leaving(&plans[0]));
        let (arrived, behind) = light.pass(&system, from, leaving, &self.settings)?;
        Ok(ScreenFields { arrived, behind })
    }

    /// Carries a field behind the element of such a system to its sensor; the pulse is called after each chunk of
    /// work.
    ///
    /// # Errors
    /// As [`LinearisedFields::pass`]; when the pulse cancels the work.
    pub(crate) fn propagate(
        &self,
        system: &System,
        behind: &Field,
        pulse: &Pulse,
    ) -> Result<Field, LinearisedSystemError> {
        let (system, plans) = self.one_hop(system)?;
        let mut values = Array2::zeros((0, 0));
        for hop in system.hops() {
            let (run, raster, reach) = self.run(0, hop, &plans)?;
            values = run
                .carry(behind, raster, reach, &|_| pulse())?
                .0
                .into_middle();
        }
        let grid = Grid::of(sensor_of(&system)?);
        Ok(Field { grid, values })
    }

    /// The conjugate transpose of [`LinearisedFields::propagate`], held by `drawn_dot_product` in the crate's tests: the
    /// cotangent behind the element. Only modes that are drawn, or too weak to be followed, contribute.
    ///
    /// # Errors
    /// As [`LinearisedFields::propagate`].
    pub(crate) fn propagate_adjoint(
        &self,
        system: &System,
        behind: &Field,
        field_bar: &Array2<Complex64>,
        pulse: &Pulse,
    ) -> Result<Field, LinearisedSystemError> {
        let (system, plans) = self.one_hop(system)?;
        let mut bar = Field::zeros(behind.grid.clone());
        for hop in system.hops() {
            let (run, raster, reach) = self.run(0, hop, &plans)?;
            let mut back = AdjointSums {
                from_bar: &mut bar.values,
                perturbed: &[],
                parameters: &mut [],
                pulse,
            };
            let levels_bar = std::slice::from_ref(field_bar);
            run.carry_adjoint(behind, raster, reach, levels_bar, &mut back)?;
        }
        Ok(bar)
    }

    /// A system of one hop as it is planned, and its plan.
    fn one_hop(&self, system: &System) -> Result<(System, Vec<Plan>), LinearisedSystemError> {
        let system = self.planned.like(system);
        match system.trains.len() {
            1 => {
                let plans = self.plans_for(&system)?;
                Ok((system, plans))
            }
            more => Err(LinearisedSystemError::ControlVariate(more)),
        }
    }

    /// The plans for a system that has changed a little: free hops have its distances.
    fn plans_for(&self, system: &System) -> Result<Vec<Plan>, LinearisedSystemError> {
        let update = |(plan, hop): (&Plan, Hop)| match plan {
            Plan::Free(free, waves) => match along(free, &hop) {
                Some(free) => Ok(Plan::Free(free, *waves)),
                None => Err(LinearisedSystemError::Moved(
                    hop.from.name.clone(),
                    hop.to.name.clone(),
                )),
            },
            other => Ok(other.clone()),
        };
        if self.plans.len() != system.trains.len() {
            let (planned, found) = (self.plans.len(), system.trains.len());
            return Err(LinearisedSystemError::Hops { planned, found });
        }
        self.plans.iter().zip(system.hops()).map(update).collect()
    }

    /// A hop with its plan, the raster on which it is summed, and how steep light arrives there.
    fn run<'a>(
        &'a self,
        number: usize,
        hop: Hop<'a>,
        plans: &'a [Plan],
    ) -> Result<(HopRun<'a>, Raster, [f64; 2]), LinearisedSystemError> {
        let plan = &plans[number];
        let reach = arrival_reach(&hop, plan);
        let raster = receiving_raster(&hop, reach, &self.settings)?;
        let planned = self.planned.system.hops().nth(number);
        let planned = planned.filter(|planned| !planned.is_same(&hop));
        let caches = self.caches.get(number).map_or(&[][..], Vec::as_slice);
        let run = HopRun {
            number,
            hop,
            planned,
            plan,
            settings: &self.settings,
            downstream: Downstream::none(),
            caches: if planned.is_none() { caches } else { &[] },
            draws: self.draws,
            shared: None,
        };
        Ok((run, raster, reach))
    }
}
