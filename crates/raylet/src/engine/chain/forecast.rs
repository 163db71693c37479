//! What a run will take: plans, samples and memory of every hop, without running it.

use crate::engine::chain::simulate::{
    SimulateError, arrival_reach, incidence, leaving, receiving_raster,
};
use crate::engine::plan::direction_spread::LightDirections;
use crate::engine::plan::downstream::Downstream;
use crate::engine::plan::hop_plan::{Plan, plan};
use crate::engine::plan::settings::Settings;
use crate::engine::progress::{Cancelled, Reply};
use crate::optics::system::{Hop, System};
use crate::wave::grid::sampling::{Reach, plan_grid};

/// One hop as it would be run.
#[derive(Clone, Debug)]
pub struct Forecast {
    /// Its plan.
    pub plan: Plan,
    /// Samples of the field on its first screen, [ny, nx].
    pub samples: [usize; 2],
    /// Samples that are summed on its second screen, [ny, nx].
    pub sums: [usize; 2],
}

impl Forecast {
    /// Bytes of the largest arrays: the fields on both screens, as they are summed and as they are kept,
    /// and the plane waves of a free hop, before and after the transfer.
    pub fn bytes(&self) -> usize {
        let count = |[ny, nx]: [usize; 2]| nx.saturating_mul(ny);
        let waves = match &self.plan {
            Plan::Free(_, free) => count([0, 1].map(|a| free.bands[a].count)),
            _ => 0,
        };
        let values = count(self.samples) + count(self.sums) + waves;
        values.saturating_mul(2 * size_of::<num_complex::Complex64>())
    }
}

/// Every hop of a system as it would be run.
///
/// # Errors
/// As [`simulate`](crate::engine::chain::simulate::simulate), but for light that is found to be absent.
pub fn forecast(system: &System, settings: &Settings) -> Result<Vec<Forecast>, SimulateError> {
    forecast_with_progress(system, settings, |_, _| ())
}

/// The same; `progress` is called with the number of every hop and the hop before it is planned: some take seconds.
///
/// # Errors
/// As [`forecast`]; when `progress` cancels the work.
pub fn forecast_with_progress<R: Reply>(
    system: &System,
    settings: &Settings,
    mut progress: impl FnMut(usize, &Hop) -> R,
) -> Result<Vec<Forecast>, SimulateError> {
    let (anchor, mut arriving) = incidence(system);
    let mut light = LightDirections {
        anchor,
        usual: arriving,
    };
    let mut list = Vec::new();
    let settings = &settings.shared(system.trains.len());
    for (number, hop) in system.hops().enumerate() {
        Cancelled::check(progress(number, &hop).flow())?;
        let plan = plan(&hop, light, &Downstream::of(system, number), settings)?;
        let reach = Reach {
            arriving,
            leaving: leaving(&plan),
        };
        let grid = plan_grid(
            hop.from,
            reach,
            system.wavelength,
            settings.samples_allowed(),
        )?;
        arriving = arrival_reach(&hop, &plan);
        let [nx, ny] = receiving_raster(&hop, arriving, settings)?.size;
        light = plan.light(&hop, light);
        list.push(Forecast {
            plan,
            samples: grid.shape(),
            sums: [ny, nx],
        });
    }
    Ok(list)
}
