//! What a run will take: plans, samples and memory of every hop, without running it.

use crate::engine::plan::{Plan, plan};
use crate::engine::settings::Settings;
use crate::engine::simulate::{
    SimulateError, arrival_reach, chief, incidence, leaving, pitch_of, receiving_raster,
};
use crate::optics::system::System;
use crate::wave::sampling::{Reach, plan_grid};

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
    /// Bytes of the fields on both screens, twice over: as they are summed and as they are kept.
    pub fn bytes(&self) -> usize {
        let count = |[ny, nx]: [usize; 2]| nx.saturating_mul(ny);
        let samples = count(self.samples).saturating_add(count(self.sums));
        samples.saturating_mul(2 * size_of::<num_complex::Complex64>())
    }
}

/// Every hop of a system as it would be run.
///
/// # Errors
/// As [`simulate`](crate::engine::simulate::simulate), but for light that is found to be absent.
pub fn forecast(system: &System, settings: &Settings) -> Result<Vec<Forecast>, SimulateError> {
    let (mut anchor, mut arriving) = incidence(system);
    let mut list = Vec::new();
    for hop in system.hops() {
        let plan = plan(&hop, anchor, pitch_of(hop.to), settings)?;
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
        anchor = chief(&hop, anchor);
        list.push(Forecast {
            plan,
            samples: grid.shape(),
            sums: [ny, nx],
        });
    }
    Ok(list)
}
