//! Progress callbacks of long work, and how they cancel it.

use std::ops::ControlFlow;

/// What a progress callback returns: nothing, or `ControlFlow::Break(())` to cancel the work.
pub trait Reply {
    /// Whether the work goes on.
    fn flow(self) -> ControlFlow<()>;
}

impl Reply for () {
    fn flow(self) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl Reply for ControlFlow<()> {
    fn flow(self) -> ControlFlow<()> {
        self
    }
}

/// A callback that long work calls again and again, from any thread; `Break` cancels the work.
pub type Pulse<'a> = dyn Fn() -> ControlFlow<()> + Sync + 'a;

/// A pulse that receives the share of the work that is done, 0 to 1.
pub(crate) type ShareDone<'a> = dyn Fn(f64) -> ControlFlow<()> + Sync + 'a;

/// The pulse of work that nobody cancels.
pub fn uncancelled() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The error of work that its progress callback cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled by the progress callback")]
pub struct Cancelled;

impl Cancelled {
    /// Goes on, or ends the work with this error, as a callback replied.
    ///
    /// # Errors
    /// When the reply is `Break`.
    pub fn check(reply: ControlFlow<()>) -> Result<(), Self> {
        match reply {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Self),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use ndarray::Array2;

    use crate::design::holograms::near::{NearTask, design};
    use crate::engine::chain::forecast::forecast_with_progress;
    use crate::engine::chain::linearised_system::LinearisedSystem;
    use crate::engine::chain::linearised_system_error::LinearisedSystemError;
    use crate::engine::chain::outcome::Progress;
    use crate::engine::chain::reference::{ReferenceError, ReferenceOptions, reference};
    use crate::engine::chain::simulate::simulate;
    use crate::engine::chain::simulate_error::SimulateError;
    use crate::engine::free::free_method::Approach;
    use crate::engine::plan::settings::{Method, Paper, Settings};
    use crate::engine::progress::{Cancelled, Reply, uncancelled};
    use crate::fixtures::paper_systems::{NEAR, PITCH, WAVELENGTH, near_hologram, open};
    use crate::optics::pixels::pixel_grid::PixelForm;
    use crate::optics::system::System;

    const CANCELLED: SimulateError = SimulateError::Cancelled(Cancelled);

    fn system() -> System {
        near_hologram(&Array2::zeros((20, 20)), PixelForm::Point)
    }

    /// Breaks within a hop, and counts how often it was called from then on.
    fn breaks_within(here: &Progress, breaks: &AtomicUsize) -> ControlFlow<()> {
        if here.done == 0.0 {
            return ControlFlow::Continue(());
        }
        breaks.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Break(())
    }

    #[test]
    fn a_break_cancels_a_run_at_once_slow() {
        for method in [
            Method::Auto,
            Method::Beamlet,
            Method::LocalBands,
            Method::Plane,
            Method::Paper,
        ] {
            let settings = Settings {
                method,
                paper: Paper {
                    rays: 40,
                    secondary: 20,
                    ..Paper::default()
                },
                ..Settings::default()
            };
            let breaks = AtomicUsize::new(0);
            let run = simulate(&system(), &settings, &|here| breaks_within(&here, &breaks));
            assert_eq!(run.err(), Some(CANCELLED), "{method:?}");
            assert_eq!(breaks.into_inner(), 1, "{method:?}");
        }
    }

    #[test]
    fn a_break_cancels_references_and_forecasts() {
        for approach in [Approach::AngularSpectrum, Approach::RayleighSommerfeld] {
            let choice = ReferenceOptions {
                approach,
                ..ReferenceOptions::default()
            };
            let breaks = AtomicUsize::new(0);
            let run = reference(&system(), &Settings::default(), choice, &|here| {
                breaks_within(&here, &breaks)
            });
            assert_eq!(run.err(), Some(ReferenceError::Run(CANCELLED)));
            assert_eq!(breaks.into_inner(), 1);
        }
        let planned = forecast_with_progress(&system(), &Settings::default(), |_, _| {
            ControlFlow::Break(())
        });
        assert_eq!(planned.err(), Some(CANCELLED));
    }

    #[test]
    fn a_break_cancels_gradients_and_holograms() {
        let stop = || ControlFlow::Break(());
        let cancelled = Some(LinearisedSystemError::Simulate(CANCELLED));
        let (system, settings) = (system(), Settings::default());
        let planned = LinearisedSystem::new_with(&system, &[], &settings, &stop);
        assert_eq!(planned.err(), cancelled);
        let planned = LinearisedSystem::new_with(&system, &[], &settings, &uncancelled).unwrap();
        assert_eq!(planned.forward_with(&system, &stop).err(), cancelled);
        let pass = planned.forward(&system).unwrap();
        let back = planned.adjoint_with(&system, &[], &pass, &pass.field.values, &stop);
        assert_eq!(back.err(), cancelled);

        let task = NearTask {
            wavelength: WAVELENGTH,
            pitch: PITCH,
            distance: NEAR,
            amplitude: open(20),
            target: open(20),
            iterations: 3,
        };
        let mut seen = Vec::new();
        let found = design(&task, &mut |iteration, _| {
            seen.push(iteration);
            match iteration {
                1 => ControlFlow::Break(()),
                _ => ControlFlow::Continue(()),
            }
        });
        assert_eq!((found.err(), seen), (Some(Cancelled), vec![0, 1]));
    }

    #[test]
    fn nothing_is_a_reply_that_goes_on() {
        assert_eq!(Cancelled::check(().flow()), Ok(()));
        assert_eq!(
            Cancelled::check(ControlFlow::Break(()).flow()),
            Err(Cancelled)
        );
    }
}
