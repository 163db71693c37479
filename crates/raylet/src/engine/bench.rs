//! A system whose plans are made once: light through it many times, and gradients back.
//!
//! The way there keeps the field on each screen, before and behind it; the way back traces the rays again,
//! chunk by chunk. Memory is that of the screens, whatever the number of rays. Plans are frozen so that what
//! is differentiated is one fixed, smooth function.

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::beyond::Beyond;
use crate::engine::carry::Run;
use crate::engine::plan::Plan;
use crate::engine::rims::with_rims;
use crate::engine::settings::Settings;
use crate::engine::simulate::{
    Arriving, SimulateError, arrival_reach, leaving, plan_all, receiving_raster, sensor_of,
};
use crate::optics::system::{Hop, System};
use crate::wave::field::Field;
use crate::wave::raster::Raster;
use crate::wave::sampling::act_adjoint;
use crate::wave::sheets::Sheets;

/// The frozen choices of a system: how each hop is carried.
#[derive(Clone, Debug)]
pub struct Bench {
    settings: Settings,
    plans: Vec<Plan>,
}

/// What the way there leaves on one screen.
#[derive(Clone, Debug)]
pub struct Passed {
    /// The field that arrived, at the nodes.
    pub arrived: Field,
    /// The field behind the screen.
    pub behind: Field,
}

/// A run that can be gone back.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Complex field at the sensor's pixel centres.
    pub field: Field,
    /// Every screen before it.
    pub screens: Vec<Passed>,
}

impl Trace {
    /// ∫|U|² of the light that arrived at the first screen, over its nodes, in mm² for unit amplitude.
    pub fn incident_power(&self) -> f64 {
        self.screens
            .first()
            .map_or(0.0, |first| first.arrived.power())
    }
}

/// The cotangents of what a system is made of.
#[derive(Clone, Debug, Default)]
pub struct Gradient {
    /// For each screen, of the transmission of its pixels, [y, x]: ∂L/∂Re t + i ∂L/∂Im t; nothing where there
    /// are none.
    pub pixels: Vec<Option<Array2<Complex64>>>,
}

impl Bench {
    /// Plans every hop of a system.
    ///
    /// # Errors
    /// As [`plan_all`].
    pub fn new(system: &System, settings: &Settings) -> Result<Self, SimulateError> {
        sensor_of(system)?;
        let plans = plan_all(system, settings)?;
        let settings = settings.shared(plans.len());
        Ok(Self { settings, plans })
    }

    /// The plans, hop by hop.
    pub fn plans(&self) -> &[Plan] {
        &self.plans
    }

    /// Carries the light of a system with the same screens and trains as the one that was planned.
    ///
    /// # Errors
    /// As [`crate::engine::simulate::simulate`].
    pub fn forward(&self, system: &System) -> Result<Trace, SimulateError> {
        let system = &with_rims(system);
        let mut light = Arriving::from_source(system);
        let mut screens = Vec::new();
        for (number, hop) in system.hops().enumerate() {
            let (run, raster, reach) = self.run(number, hop)?;
            let leaving = leaving(run.plan);
            let (arrived, behind) = light.pass(system, hop.from, leaving, &self.settings)?;
            let (sheets, _) = run.carry(&behind, raster, reach, &|_| ())?;
            screens.push(Passed { arrived, behind });
            light = Arriving {
                sum: Some(sheets),
                brief: light.brief,
                reach,
            };
        }
        let grid = crate::engine::simulate::sensor_grid(sensor_of(system)?);
        let values = match light.sum {
            Some(sheets) => sheets.into_middle(),
            None => Array2::zeros(grid.shape()),
        };
        Ok(Trace {
            field: Field { grid, values },
            screens,
        })
    }

    /// The gradient of a real function of the field on the sensor, from its cotangent there,
    /// ∂L/∂Re U + i ∂L/∂Im U, [y, x].
    ///
    /// # Errors
    /// As [`Bench::forward`].
    pub fn adjoint(
        &self,
        system: &System,
        trace: &Trace,
        field_bar: &Array2<Complex64>,
    ) -> Result<Gradient, SimulateError> {
        let system = &with_rims(system);
        let hops: Vec<Hop> = system.hops().collect();
        let mut pixels = vec![None; hops.len()];
        let mut sheets_bar = vec![field_bar.clone()];
        for (number, hop) in hops.iter().enumerate().rev() {
            let (run, raster, reach) = self.run(number, *hop)?;
            let passed = &trace.screens[number];

            // field behind the screen -> sheets of the next
            let behind_bar = run.carry_adjoint(&passed.behind, raster, reach, &sheets_bar, &|_| ());
            let mut bar = Field {
                grid: passed.behind.grid.clone(),
                values: behind_bar,
            };

            // arrived -> behind
            pixels[number] = act_adjoint(hop.from, &passed.arrived, &mut bar);

            // sheets of this screen -> arrived
            if number > 0 {
                let (before, raster, reach) = self.run(number - 1, hops[number - 1])?;
                let sheets = Sheets {
                    raster,
                    stack: before.stack(reach),
                    values: Vec::new(),
                };
                sheets_bar = sheets.on_adjoint(hop.from, &bar);
            }
        }
        Ok(Gradient { pixels })
    }

    /// A hop with its plan, the raster on which it is summed, and how steep light arrives there.
    fn run<'a>(
        &'a self,
        number: usize,
        hop: Hop<'a>,
    ) -> Result<(Run<'a>, Raster, [f64; 2]), SimulateError> {
        let plan = &self.plans[number];
        let reach = arrival_reach(&hop, plan);
        let raster = receiving_raster(&hop, reach, &self.settings)?;
        let run = Run {
            number,
            hop,
            plan,
            settings: &self.settings,
            beyond: Beyond::none(),
        };
        Ok((run, raster, reach))
    }
}
