//! What a reference will take: method, reason, samples and seconds of every step, without running it.

use crate::engine::chain::arriving_light::{Arriving, receiving_raster};
use crate::engine::chain::needed_memory::least_limit;
use crate::engine::chain::reference::{
    ReferenceError, ReferenceOptions, Ways, finer_reach, padded, ways,
};
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::free::free_method::{Approach, FreeMethod, Route};
use crate::engine::plan::cost_model::references;
use crate::engine::plan::settings::Settings;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::{Hop, System};
use crate::wave::free::rayleigh::PAIRS_PER_SECOND;
use crate::wave::grid::sampling::{Reach, plan_grid};

/// One step of a reference as it would be carried.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferencePlan {
    /// Names of its first and last screen.
    pub screens: [String; 2],
    /// Its method.
    pub approach: Approach,
    /// Why this method: that it was chosen, or what stands against those before it.
    pub why: String,
    /// Seconds that it takes on all threads, about.
    pub seconds: f64,
}

impl ReferencePlan {
    /// The step in one line.
    pub fn line(&self) -> String {
        let ([from, to], name) = (&self.screens, self.approach.name());
        format!(
            "{from} to {to}: {name}, about {:.1} s ({})",
            self.seconds, self.why
        )
    }
}

/// Every step of the reference of a system.
///
/// # Errors
/// As [`reference`](fn@crate::engine::chain::reference::reference), except for sums that take too long and light that
/// does not arrive.
pub fn reference_forecast(
    system: &System,
    settings: &Settings,
    choice: ReferenceOptions,
) -> Result<Vec<ReferencePlan>, ReferenceError> {
    let settings = &padded(settings);
    match ways(system, settings, choice.approach)? {
        Ways::Hops(routes) => by_hops(system, settings, &routes),
        Ways::Refraction(why) => Ok(vec![by_rays(system, why)]),
    }
}

/// The steps of a reference that goes hop by hop.
fn by_hops(
    system: &System,
    settings: &Settings,
    routes: &[Route],
) -> Result<Vec<ReferencePlan>, ReferenceError> {
    let mut arriving = Arriving::from_source(system).reach;
    let mut list = Vec::new();
    for (hop, Route { method, why }) in system.hops().zip(routes) {
        let (leaving, next) = finer_reach(&hop, method)?;
        let reach = Reach { arriving, leaving };
        let allowed = settings.samples_allowed();
        let grid =
            plan_grid(hop.from, reach, system.wavelength, allowed).map_err(SimulateError::from)?;
        let raster = receiving_raster(&hop, next, settings)?;
        let [samples, points] = [grid.shape(), raster.size].map(count);
        list.push(ReferencePlan {
            screens: [hop.from.name.clone(), hop.to.name.clone()],
            approach: method.approach(),
            why: why.clone(),
            seconds: seconds(&hop, method, [samples, points]),
        });
        arriving = next;
    }
    Ok(list)
}

fn count([a, b]: [usize; 2]) -> f64 {
    a as f64 * b as f64
}

/// Seconds of a hop on all threads, from its samples and the points where it is summed.
fn seconds(hop: &Hop, method: &FreeMethod, [samples, points]: [f64; 2]) -> f64 {
    let work = match method {
        FreeMethod::AngularSpectrum(_, plan) => {
            let waves = count([0, 1].map(|a| plan.bands[a].count));
            references::WAVE * (samples + waves + points)
        }
        FreeMethod::RayleighSommerfeld(_) => {
            let lit = samples * open_share(hop.from);
            lit * points / PAIRS_PER_SECOND + references::SAMPLE * samples
        }
        FreeMethod::Collins(_) => references::WAVE * (samples + points),
    };
    work / rayon::current_num_threads() as f64
}

/// The share of a screen's box that its aperture leaves open, about.
fn open_share(screen: &Screen) -> f64 {
    let aperture = match &screen.kind {
        ScreenKind::Doe(doe) => &doe.aperture,
        ScreenKind::Stop(aperture) => aperture,
        ScreenKind::Sensor(_) => return 1.0,
    };
    screen.bounds().map_or(1.0, |[x0, x1, y0, y1]| {
        aperture.coverage(x0, x1, y0, y1).clamp(0.0, 1.0)
    })
}

/// The step of a reference that follows one ray per pixel through the whole system.
fn by_rays(system: &System, why: String) -> ReferencePlan {
    let name = |screen: Option<&Screen>| screen.map(|one| one.name.clone()).unwrap_or_default();
    let pixels = match system.screens.last().map(|screen| &screen.kind) {
        Some(ScreenKind::Sensor(sensor)) => count(sensor.pixels),
        _ => 0.0,
    };
    let parts = system.screens.len() + system.trains.iter().map(Vec::len).sum::<usize>();
    let work = references::RAY_AT_PART * pixels * parts as f64;
    ReferencePlan {
        screens: [name(system.screens.first()), name(system.screens.last())],
        approach: Approach::Refraction,
        why,
        seconds: work / rayon::current_num_threads() as f64,
    }
}

/// The memory limit in bytes with which the whole reference of a system can be planned; nothing if memory is not what it
/// lacks.
pub fn needed_for_reference(
    system: &System,
    settings: &Settings,
    choice: ReferenceOptions,
) -> Option<usize> {
    least_limit(settings.clone(), |trial| {
        match reference_forecast(system, trial, choice) {
            Err(ReferenceError::Run(error)) => Err(error),
            _ => Ok(()),
        }
    })
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;
    use std::sync::Mutex;

    use crate::engine::chain::outcome::Progress;
    use crate::engine::chain::reference::{ReferenceOptions, reference};
    use crate::engine::chain::reference_forecast::reference_forecast;
    use crate::engine::plan::settings::Settings;
    use crate::fixtures::parts::{lit, on_axis, screen, sensor};
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::Aperture;
    use crate::optics::frame::Frame;
    use crate::optics::screen::ScreenKind;

    /// A sum of many nodes reports after the first points, not after thousands of them: by the seconds of its plan.
    #[test]
    fn the_first_note_of_a_long_sum_comes_within_a_second() {
        let first = screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(150.0)));
        let tilted = on_axis(1000.0).tilted([0.1, 0.0, 0.0]);
        let last = screen(tilted.moved(Vec3::new(1.0, 2.0, 0.0)), sensor(72, 5.0));
        let system = lit(vec![first, last], vec![vec![]]);
        let (settings, choice) = (Settings::default(), ReferenceOptions::default());
        let plan = reference_forecast(&system, &settings, choice).unwrap();
        let seconds = plan[0].seconds;
        let noted = Mutex::new(0.0);
        let stop = |progress: Progress| {
            if progress.done == 0.0 {
                return ControlFlow::Continue(());
            }
            *noted.lock().unwrap() = progress.done;
            ControlFlow::Break(())
        };
        assert!(reference(&system, &settings, choice, &stop).is_err());
        let done = *noted.lock().unwrap();
        assert!(
            done > 0.0 && seconds > 3.0 && done * seconds < 1.0,
            "{done:e} of {seconds} s"
        );
    }
}
