//! The method of a hop of a run: from a field that is sampled as a whole, or by local bands.

use crate::engine::local_bands::settings::LocalBandPlan;
use crate::engine::plan::hop_plan::Plan;

/// The method of a hop of a run, with its plan.
#[derive(Clone, Debug)]
pub enum HopMethod {
    /// From a field on its first screen that is sampled as a whole.
    WholeField(Plan),
    /// Window by window of its first screen.
    LocalBands(LocalBandPlan),
}

impl HopMethod {
    /// The plan of a hop from a whole field; nothing for local bands.
    pub fn whole_field(&self) -> Option<&Plan> {
        match self {
            Self::WholeField(plan) => Some(plan),
            Self::LocalBands(_) => None,
        }
    }

    /// Rays that it expects; zero without rays, and where windows decide how many there are.
    pub fn rays(&self) -> f64 {
        self.whole_field().map_or(0.0, Plan::rays)
    }
}
