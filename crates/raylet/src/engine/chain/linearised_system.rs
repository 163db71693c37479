//! A system whose plans are made once: light through it many times, and gradients back.
//!
//! The way there keeps the field on each screen, before and behind it; the way back traces the rays again,
//! chunk by chunk. Memory is that of the screens, whatever the number of rays; where the beamlets of the planned
//! system fit into an eighth of the memory limit they are kept, which changes no bit of a result. Plans are
//! frozen so that what is differentiated is one fixed, smooth function.

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::beamlet::beamlet_cache::BeamletCache;
use crate::engine::chain::arriving_light::{
    Arriving, arrival_reach, incidence, leaving, receiving_raster, sensor_grid, sensor_of,
};
use crate::engine::chain::backend::AdjointSums;
use crate::engine::chain::hop_run::{HopAdjointError, HopError, HopRun};
use crate::engine::chain::screen_sensitivity::{ScreenFields, pull_act, pull_light};
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::monte_carlo::mode_sampling::Draws;
use crate::engine::plan::direction_spread::LightDirections;
use crate::engine::plan::downstream::Downstream;
use crate::engine::plan::hop_plan::{Plan, along, plan};
use crate::engine::plan::settings::{Method, Settings};
use crate::engine::progress::{Cancelled, Pulse, uncancelled};
use crate::engine::rims::pixel_light::PixelValues;
use crate::engine::rims::rim_screens::{Rimmed, with_rims};
use crate::engine::trace::ray_sensitivity::{PerturbedHops, Variation};
use crate::optics::system::{Hop, System};
use crate::wave::grid::field::Field;
use crate::wave::grid::height_stack::HeightStack;
use crate::wave::grid::raster::Raster;
use crate::wave::grid::sampling::act_adjoint;

/// Why a system cannot be differentiated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinearisedSystemError {
    /// It cannot be simulated.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// Numbers of the system cannot be sought with drawn beamlets.
    #[error(
        "drawn beamlets have gradients of pixels only, not of the system's numbers; follow all of them"
    )]
    Drawn,
    /// A control variate is of one hop.
    #[error(
        "an anchor takes one element and its sensor, with no rim that cuts light; there are {0} hops"
    )]
    ControlVariate(usize),
    /// The perturbed systems have other parts.
    #[error(
        "with parameter {0} a little smaller or larger the system has other parts, as when a rim begins to \
         cut light: it has no derivative there"
    )]
    Parts(usize),
    /// A system of other hops than the one that was planned.
    #[error("a system of {found} hops where {planned} are planned")]
    Hops {
        /// Hops of the planned system, rims that diffract among them.
        planned: usize,
        /// Those of the other one.
        found: usize,
    },
    /// The surface of a screen changes.
    #[error(
        "parameter {parameter} changes the surface of screen '{screen}'; only its place and its element may \
         change"
    )]
    Substrate {
        /// Index of the parameter.
        parameter: usize,
        /// Name of the screen.
        screen: String,
    },
    /// A method without gradients.
    #[error("gradients go through free hops and beamlets; method '{0}' has none")]
    Method(&'static str),
    /// The system is no longer like the one that was planned.
    #[error(
        "between '{0}' and '{1}' the system is not free any more as when it was planned; let the method be \
         beamlet"
    )]
    Moved(String, String),
}

impl From<Cancelled> for LinearisedSystemError {
    fn from(error: Cancelled) -> Self {
        Self::Simulate(error.into())
    }
}

impl From<HopError> for LinearisedSystemError {
    fn from(error: HopError) -> Self {
        Self::Simulate(error.into())
    }
}

impl From<HopAdjointError> for LinearisedSystemError {
    fn from(error: HopAdjointError) -> Self {
        match error {
            HopAdjointError::NoAdjoint(method) => Self::Method(method),
            HopAdjointError::Cancelled(error) => error.into(),
        }
    }
}

/// The frozen choices of a system: how each hop is carried.
#[derive(Clone, Debug)]
pub struct LinearisedSystem {
    /// What was planned, with screens at rims: by it beamlets are chosen and corrected.
    planned: Rimmed,
    settings: Settings,
    plans: Vec<Plan>,
    /// For each hop, where the beamlets of the planned system are kept.
    caches: Vec<Vec<BeamletCache>>,
    /// How beamlets are drawn; nothing where all are followed.
    draws: Option<Draws>,
}

/// A run that can be gone back.
#[derive(Clone, Debug)]
pub struct ForwardPass {
    /// Complex field at the sensor's pixel centres.
    pub field: Field,
    /// Every screen before it.
    pub screens: Vec<ScreenFields>,
}

/// The cotangents of what a system is made of.
#[derive(Clone, Debug, Default)]
pub struct Gradient {
    /// For each screen, of the transmission of its pixels, [y, x]: ∂L/∂Re t + i ∂L/∂Im t; nothing where there
    /// are none.
    pub pixels: Vec<Option<Array2<Complex64>>>,
    /// ∂L/∂q for each parameter.
    pub parameters: Vec<f64>,
}

impl LinearisedSystem {
    /// Plans every hop of a system, so that it may vary.
    ///
    /// # Errors
    /// As [`crate::engine::chain::simulate::simulate`]; when a variation is no neighbour of the system.
    pub fn new(
        system: &System,
        variations: &[Variation],
        settings: &Settings,
    ) -> Result<Self, LinearisedSystemError> {
        Self::new_with(system, variations, settings, &uncancelled)
    }

    /// The same, with a pulse that is called before each hop is planned.
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
            Method::LocalBands => return Err(LinearisedSystemError::Method("local_bands")),
            Method::Auto | Method::Beamlet => {}
        }
        sensor_of(system)?;
        let planned = with_rims(system, settings, PixelValues::Varying);
        let system = &planned.system;
        let variations = &rimmed(&planned, variations)?;
        let settings = settings.shared(system.trains.len());
        let (anchor, usual) = incidence(system);
        let mut light = LightDirections { anchor, usual };
        let mut plans = Vec::new();
        for (number, hop) in system.hops().enumerate() {
            Cancelled::check(pulse())?;
            let downstream = &Downstream::of(system, number);
            let mut chosen =
                plan(&hop, light, downstream, &settings).map_err(SimulateError::from)?;
            let stays = |free| {
                let (_, perturbed) = perturbed(variations, number, &hop);
                perturbed.iter().all(|n| is_free(free, n))
            };
            if let Plan::Free(free, _) = &chosen
                && !stays(free)
            {
                let by_beamlets = Settings {
                    method: Method::Beamlet,
                    ..settings.clone()
                };
                chosen =
                    plan(&hop, light, downstream, &by_beamlets).map_err(SimulateError::from)?;
            }
            light = chosen.light(&hop, light);
            plans.push(chosen);
        }
        let mut linearised = Self {
            planned,
            settings,
            plans,
            caches: Vec::new(),
            draws: None,
        };
        linearised.caches = linearised.empty_caches()?;
        Ok(linearised)
    }

    /// The same, with beamlets drawn instead of followed all: an estimate of the field, and of the pixels'
    /// gradient with the draws held constant. Free hops stay exact.
    pub fn drawn(&self, draws: Draws) -> Self {
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
    pub fn plans(&self) -> &[Plan] {
        &self.plans
    }

    /// Carries the light of a system with the same screens and trains as the one that was planned.
    ///
    /// # Errors
    /// As [`crate::engine::chain::simulate::simulate`]; when the system is not like the one that was planned.
    pub fn forward(&self, system: &System) -> Result<ForwardPass, LinearisedSystemError> {
        self.forward_with(system, &uncancelled)
    }

    /// The same, with a pulse that is called after each chunk of work.
    ///
    /// # Errors
    /// As [`LinearisedSystem::forward`]; when the pulse cancels the work.
    pub fn forward_with(
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
            let (sheets, _) = run.carry(&behind, raster, reach, &|_| pulse())?;
            screens.push(ScreenFields { arrived, behind });
            light = Arriving {
                sum: Some(sheets),
                directions: light.directions,
                reach,
            };
        }
        let grid = sensor_grid(sensor_of(system)?);
        let values = match light.sum {
            Some(sheets) => sheets.into_middle(),
            None => Array2::zeros(grid.shape()),
        };
        Ok(ForwardPass {
            field: Field { grid, values },
            screens,
        })
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

    /// The same, with a pulse that is called after each chunk of work.
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
        if self.draws.is_some() && !variations.is_empty() {
            return Err(LinearisedSystemError::Drawn);
        }
        let system = &self.planned.like(system);
        let variations = &rimmed(&self.planned, variations)?;
        let plans = self.plans_for(system)?;
        let hops: Vec<Hop> = system.hops().collect();
        let mut gradient = Gradient {
            pixels: vec![None; hops.len()],
            parameters: vec![0.0; variations.len()],
        };
        let mut sheets_bar = vec![field_bar.clone()];
        for (number, hop) in hops.iter().enumerate().rev() {
            Cancelled::check(pulse())?;
            let (run, raster, reach) = self.run(number, *hop, &plans)?;
            let passed = &trace.screens[number];

            // field behind the screen -> sheets of the next
            let mut bar = Field::zeros(passed.behind.grid.clone());
            let (moving, perturbed) = perturbed(variations, number, hop);
            let mut pulled = vec![0.0; moving.len()];
            let mut back = AdjointSums {
                from_bar: &mut bar.values,
                perturbed: &perturbed,
                parameters: &mut pulled,
                pulse,
            };
            run.carry_adjoint(&passed.behind, raster, reach, &sheets_bar, &mut back)?;
            let parts = moving.into_iter().zip(pulled);
            parts.for_each(|(parameter, part)| gradient.parameters[parameter] += part);

            // arrived -> behind
            for (total, variation) in gradient.parameters.iter_mut().zip(variations) {
                *total += pull_act(variation, number, passed, &bar);
            }
            gradient.pixels[number] = act_adjoint(hop.from, &passed.arrived, &mut bar);

            // sheets of this screen, or the source -> arrived
            if number > 0 {
                sheets_bar = self.sheets_bar_before(number - 1, hops[number - 1], &plans, &bar)?;
            } else {
                for (total, variation) in gradient.parameters.iter_mut().zip(variations) {
                    *total += pull_light(variation, passed, &bar);
                }
            }
        }
        // Of the screens of the system as it was given only.
        let own = self.planned.own.iter();
        gradient.pixels = own.map(|at| gradient.pixels[*at].take()).collect();
        Ok(gradient)
    }

    /// The cotangents of the sheets on which a hop is summed, from that of the field that arrives at its second
    /// screen.
    fn sheets_bar_before(
        &self,
        number: usize,
        hop: Hop,
        plans: &[Plan],
        arrived_bar: &Field,
    ) -> Result<Vec<Array2<Complex64>>, LinearisedSystemError> {
        let (run, raster, reach) = self.run(number, hop, plans)?;
        let sheets = HeightStack {
            raster,
            stack: run.stack(reach),
            values: Vec::new(),
        };
        Ok(sheets.on_adjoint(hop.to, arrived_bar))
    }

    /// The light of a system of one hop, before and behind its element.
    ///
    /// # Errors
    /// [`LinearisedSystemError::ControlVariate`] for more; as [`LinearisedSystem::forward`].
    pub fn pass(&self, system: &System) -> Result<ScreenFields, LinearisedSystemError> {
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
    /// As [`LinearisedSystem::pass`]; when the pulse cancels the work.
    pub fn through(
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
        let grid = sensor_grid(sensor_of(&system)?);
        Ok(Field { grid, values })
    }

    /// The conjugate transpose of [`LinearisedSystem::through`], held by `drawn_dot_product` in the crate's tests: the
    /// cotangent behind the element. Of the light there, only what is drawn or too weak counts.
    ///
    /// # Errors
    /// As [`LinearisedSystem::through`].
    pub fn through_adjoint(
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
            let sheets_bar = std::slice::from_ref(field_bar);
            run.carry_adjoint(behind, raster, reach, sheets_bar, &mut back)?;
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
        };
        Ok((run, raster, reach))
    }
}

/// The variations with a screen at every rim, as the system has them.
fn rimmed(
    planned: &Rimmed,
    variations: &[Variation],
) -> Result<Vec<Variation>, LinearisedSystemError> {
    let system = &planned.system;
    let mut list = Vec::new();
    for (parameter, variation) in variations.iter().enumerate() {
        let [below, above] =
            [&variation.below, &variation.above].map(|system| planned.like(system));
        for other in [&below, &above] {
            let trains = other.trains.iter().zip(&system.trains);
            let alike = other.trains.len() == system.trains.len()
                && trains.into_iter().all(|(a, b)| a.len() == b.len());
            if !alike {
                return Err(LinearisedSystemError::Parts(parameter));
            }
            for (screen, here) in other.screens.iter().zip(&system.screens) {
                if screen.shape != here.shape {
                    let screen = here.name.clone();
                    return Err(LinearisedSystemError::Substrate { parameter, screen });
                }
            }
        }
        list.push(Variation {
            below,
            above,
            distance: variation.distance,
        });
    }
    Ok(list)
}

/// One hop of those variations in which its rays run otherwise, with their numbers.
fn perturbed<'v>(
    variations: &'v [Variation],
    number: usize,
    hop: &Hop,
) -> (Vec<usize>, Vec<PerturbedHops<'v>>) {
    let pair = |variation: &'v Variation| {
        Some(PerturbedHops {
            below: variation.below.hops().nth(number)?,
            above: variation.above.hops().nth(number)?,
            distance: variation.distance,
        })
    };
    let all = variations.iter().enumerate();
    let all = all.filter_map(|(i, variation)| pair(variation).map(|n| (i, n)));
    all.filter(|(_, n)| !(n.below.is_same(hop) && n.above.is_same(hop)))
        .unzip()
}

/// Whether both perturbed ones of a free hop are free.
fn is_free(free: &crate::wave::free::propagate::FreeHop, perturbed: &PerturbedHops) -> bool {
    along(free, &perturbed.below).is_some() && along(free, &perturbed.above).is_some()
}
