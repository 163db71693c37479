//! One attempt to propagate the light of a system: its rims, the method that propagates the light, and the run.

use crate::engine::chain::forecast::{
    Chosen, Grids, StaysFree, choose, whole_field_forecast, with_wide_rims,
};
use crate::engine::chain::local_band_run::{local_band_settings, run_local_bands};
use crate::engine::chain::outcome::{Listener, Outcome, Progress};
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::chain::whole_field_run::run_whole_fields;
use crate::engine::plan::hop_plan::Plan;
use crate::engine::plan::settings::{Method, Settings};
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
        let (rimmed, chosen) = with_wide_rims(system, settings, (rimmed, chosen));
        Ok(Self {
            rimmed,
            chosen,
            settings: settings.clone(),
        })
    }

    /// Plans local bands whose large rims cut single beamlets: these take less memory.
    fn with_rims_by_ray(system: &System, settings: &Settings) -> Result<Self, SimulateError> {
        let rimmed = with_rims(system, settings, PixelValues::Fixed);
        Ok(Self {
            chosen: Chosen::LocalBands(local_band_settings(&rimmed.system, settings)?),
            rimmed,
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

    /// Carries the light of the system that was planned. Local bands that were chosen for their speed may need an array that
    /// is too large, which shows on the way: whole fields carry the light then, where they fit into memory.
    ///
    /// # Errors
    /// When a field needs too many samples, no light is left, or `progress` cancels the run.
    pub(crate) fn run(
        self,
        system: &System,
        progress: &Listener,
    ) -> Result<Outcome, SimulateError> {
        let (rimmed, settings) = (self.rimmed, self.settings);
        let by_whole_fields = |rimmed, hops: Vec<(Plan, Grids)>| {
            let plans = hops.into_iter().map(|(plan, _)| plan).collect();
            run_whole_fields(system, rimmed, plans, &settings, progress)
        };
        let bands = match self.chosen {
            Chosen::WholeFields(hops) => return by_whole_fields(rimmed, hops),
            Chosen::LocalBands(bands) => bands,
        };
        let too_large = match run_local_bands(system, &rimmed, &bands, progress) {
            Ok(landed) => return Ok(landed.outcome(rimmed)),
            Err(SimulateError::LocalBands(error)) if error.is_too_large() => error,
            Err(error) => return Err(error),
        };
        if rimmed.is_of_any_size() {
            return Self::with_rims_by_ray(system, &settings)?.run(system, progress);
        }
        if settings.method != Method::Auto {
            return Err(SimulateError::LocalBands(too_large));
        }
        let all_stay: &StaysFree = &|_, _, _| true;
        let hops = whole_field_forecast(&rimmed.system, &settings, all_stay, |_, _| ());
        match hops {
            Ok(hops) => by_whole_fields(rimmed, hops),
            Err(whole) if whole.is_too_large() => Err(SimulateError::TooLarge {
                whole: Box::new(whole),
                bands: too_large,
            }),
            Err(_) => Err(SimulateError::LocalBands(too_large)),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use crate::engine::chain::attempt::Attempt;
    use crate::engine::chain::forecast::Chosen;
    use crate::engine::chain::local_band_run::local_band_settings;
    use crate::engine::chain::outcome::Progress;
    use crate::engine::chain::simulate_error::SimulateError;
    use crate::engine::local_bands::local_band_error::LocalBandError;
    use crate::engine::plan::settings::{Method, Settings};
    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{box_pixels, conic, face, lit, on_axis, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::screen::ScreenKind;
    use crate::optics::shape::Shape;
    use crate::optics::surface::Surface;
    use crate::optics::system::System;

    fn go_on(_: Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// An attempt to carry light by local bands that have no room for it.
    fn without_room(system: &System, method: Method) -> Attempt {
        let settings = Settings {
            method,
            ..Settings::default()
        };
        let planned = Attempt::plan(system, &settings, &go_on).unwrap();
        let mut bands = local_band_settings(&planned.rimmed.system, &settings).unwrap();
        bands.memory_limit = 100_000;
        Attempt {
            chosen: Chosen::LocalBands(bands),
            ..planned
        }
    }

    /// Where local bands were the method of choice and turn out too large, whole fields bring the light; where they were
    /// requested, the error is theirs.
    #[test]
    fn whole_fields_follow_local_bands_that_are_too_large() {
        let pixels = noise((24, 24), 0).mapv(|value| value / value.norm());
        let hologram = screen(on_axis(0.0), box_pixels(pixels, 6.0));
        let system = lit(
            vec![hologram, screen(on_axis(400.0), sensor(16, 2.0))],
            vec![vec![]],
        );
        let expected = Attempt::plan(&system, &Settings::default(), &go_on);
        let expected = expected.unwrap().run(&system, &go_on).unwrap();
        let found = without_room(&system, Method::Auto).run(&system, &go_on);
        assert_eq!(found.unwrap().field.values, expected.field.values);
        let refused = without_room(&system, Method::LocalBands).run(&system, &go_on);
        let refused = refused.unwrap_err();
        let of_bands = |error: &LocalBandError| error.is_too_large();
        assert!(
            matches!(&refused, SimulateError::LocalBands(error) if of_bands(error)),
            "{refused}"
        );
    }

    /// Where a screen at a large rim takes too much memory, the rim cuts beamlets one by one instead.
    #[test]
    fn rims_cut_by_ray_where_their_screens_are_too_large() {
        let stop = screen(on_axis(0.0), ScreenKind::Stop(Aperture::disc(3000.0)));
        let front = face(on_axis(400.0), Shape::Plane, [1.0, 1.5]);
        let back = Surface {
            aperture: Aperture::disc(2400.0),
            ..face(on_axis(1400.0), conic(-1.0 / 20_000.0, 0.0), [1.5, 1.0])
        };
        let system = lit(
            vec![stop, screen(on_axis(41_400.0), sensor(16, 4.0))],
            vec![vec![front, back]],
        );
        let planned = without_room(&system, Method::LocalBands);
        assert!(planned.rimmed.is_of_any_size());
        let by_ray = Attempt::with_rims_by_ray(&system, &planned.settings).unwrap();
        assert!(!by_ray.rimmed.is_of_any_size());
        let with_room = Attempt::plan(&system, &planned.settings, &go_on).unwrap();
        let run = |attempt: Attempt| attempt.run(&system, &go_on).unwrap().field.values;
        let [expected, found, screens] = [by_ray, planned, with_room].map(run);
        assert_eq!(found, expected);
        assert_ne!(found, screens);
    }
}
