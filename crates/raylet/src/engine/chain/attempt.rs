//! One attempt to propagate the light of a system: its rims, the method that propagates the light, and the run.

use crate::engine::chain::forecast::{Chosen, Grids, choose};
use crate::engine::chain::local_band_run::run_local_bands;
use crate::engine::chain::outcome::{Listener, Outcome, Progress};
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::chain::whole_field_run::run_whole_fields;
use crate::engine::plan::hop_plan::Plan;
use crate::engine::plan::settings::Settings;
use crate::engine::rims::pixel_light::PixelValues;
use crate::engine::rims::rim_screens::{Rimmed, with_rims};
use crate::optics::system::{Hop, System};

/// An attempt that is planned.
pub(crate) struct Attempt {
    /// The system with a screen at every rim that matters.
    rimmed: Rimmed,
    /// The method that propagates its light.
    chosen: Chosen,
    /// The choices that it was planned with, its target error among them.
    settings: Settings,
}

impl Attempt {
    /// Plans an attempt; `progress` is called before each hop is planned.
    ///
    /// # Errors
    /// When a screen has no edge or needs too many samples, no ray gets through a hop, or `progress` cancels the run.
    pub(crate) fn plan(
        system: &System,
        settings: &Settings,
        progress: &Listener,
    ) -> Result<Self, SimulateError> {
        let rimmed = with_rims(system, settings, PixelValues::Fixed);
        let planning = |hop, planned: &Hop| {
            progress(Progress {
                attempt: 0,
                hop,
                hops: rimmed.system.trains.len(),
                to: &planned.to.name,
                done: 0.0,
                rays: 0.0,
            })
        };
        let chosen = choose(&rimmed.system, settings, planning)?;
        Ok(Self {
            rimmed,
            chosen,
            settings: settings.clone(),
        })
    }

    /// The hops that are carried from whole fields; none by local bands.
    pub(crate) fn whole_fields(&self) -> &[(Plan, Grids)] {
        match &self.chosen {
            Chosen::WholeFields(hops) => hops,
            Chosen::LocalBands(_) => &[],
        }
    }

    /// Carries the light of the system that was planned.
    ///
    /// # Errors
    /// When a field needs too many samples, no light is left, or `progress` cancels the run.
    pub(crate) fn run(
        self,
        system: &System,
        progress: &Listener,
    ) -> Result<Outcome, SimulateError> {
        match self.chosen {
            Chosen::WholeFields(hops) => {
                let plans = hops.into_iter().map(|(plan, _)| plan).collect();
                run_whole_fields(system, self.rimmed, plans, &self.settings, progress)
            }
            Chosen::LocalBands(bands) => run_local_bands(system, self.rimmed, &bands, progress),
        }
    }
}
