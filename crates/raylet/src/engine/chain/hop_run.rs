//! The run of one hop, from the field behind the first screen to the light before the second, and its adjoint.
//! `chain_dot_product_slow` in the crate's tests checks the adjoint.

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::beamlet::beamlet_cache::BeamletCache;
use crate::engine::beamlet::beamlet_plan::BeamletPlan;
use crate::engine::chain::backend::{AdjointSums, Backend, Job, Kept, SharedByLevels};
use crate::engine::chain::beamlet_propagation::BeamletPropagation;
use crate::engine::chain::patch_cutter::Cutter;
use crate::engine::error::tally::{Fate, Tally};
use crate::engine::free::spot_check::SpotCheck;
use crate::engine::monte_carlo::mode_sampling::Draws;
use crate::engine::monte_carlo::paper::PaperRun;
use crate::engine::monte_carlo::paper_plan::DrawAddress;
use crate::engine::plan::downstream::Downstream;
use crate::engine::plan::hop_plan::{Plan, along};
use crate::engine::plan::settings::Settings;
use crate::engine::plane_wave::plane_wavelets::PlaneRun;
use crate::engine::progress::{Cancelled, ShareDone};
use crate::engine::trace::ray_sensitivity::PerturbedHops;
use crate::math::nufft::NufftError;
use crate::math::vec3::Vec3;
use crate::optics::screen::Screen;
use crate::optics::shape::Shape;
use crate::optics::system::Hop;
use crate::wave::beamlet::beamlet_sum::Canvas;
use crate::wave::beamlet::plane::PlaneSum;
use crate::wave::free::free_plan::FreePlan;
use crate::wave::free::propagate::{EmittedField, FreeHop, PerturbedFreeHops};
use crate::wave::grid::field::Field;
use crate::wave::grid::height_stack::HeightStack;
use crate::wave::grid::heights::{Heights, Stack, normal_cosines};
use crate::wave::grid::raster::Raster;

/// Why a hop cannot be carried.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum HopError {
    /// A sum of plane waves cannot be planned.
    #[error(transparent)]
    Sum(#[from] NufftError),
    /// The progress callback cancelled it.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Why a hop has no adjoint.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum HopAdjointError {
    /// Its method, by the name in scenes, has no adjoint.
    #[error("method '{0}' has no adjoint")]
    NoAdjoint(&'static str),
    /// A perturbed system, with its two screens, is not free where the system itself is.
    #[error("between '{0}' and '{1}' a perturbed system is not free")]
    NotFree(String, String),
    /// The progress callback cancelled it.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A hop with its plan.
#[derive(Clone, Copy)]
pub(crate) struct HopRun<'a> {
    /// Its number in the system, from 0.
    pub number: usize,
    /// Screens and train.
    pub hop: Hop<'a>,
    /// The hop that was planned, if `hop` is a slightly changed one.
    pub planned: Option<Hop<'a>>,
    /// The method by which it is propagated, with its plan.
    pub plan: &'a Plan,
    /// Thresholds.
    pub settings: &'a Settings,
    /// The hops behind this one, as far as its directions are kept.
    pub downstream: &'a Downstream<'a>,
    /// Memory that may keep beamlets for the next run of the hop, one for each level of the second screen.
    pub caches: &'a [BeamletCache],
    /// How beamlets are drawn; nothing where all are followed.
    pub draws: Option<Draws>,
    /// What it shares with the hops to other levels of a curved second screen.
    pub shared: Option<SharedByLevels<'a>>,
}

impl<'a> HopRun<'a> {
    /// A hop, with its place in the system, as it was planned; no beamlets are kept.
    pub(crate) fn new(
        number: usize,
        hop: Hop<'a>,
        plan: &'a Plan,
        settings: &'a Settings,
        downstream: &'a Downstream<'a>,
    ) -> Self {
        Self {
            number,
            hop,
            planned: None,
            plan,
            settings,
            downstream,
            caches: &[],
            draws: None,
            shared: None,
        }
    }

    /// Carries a field to a raster of the second screen; to levels around it when it is curved, as many as
    /// light with direction cosines up to `reach` needs. The tally is that of the middle level.
    ///
    /// # Errors
    /// When a sum of plane waves cannot be planned, or `progress` cancels the hop.
    pub(crate) fn carry(
        &self,
        field: &Field,
        raster: Raster,
        reach: [f64; 2],
        progress: &ShareDone,
    ) -> Result<(HeightStack, Tally), HopError> {
        let to = self.hop.to;
        if to.is_plane() {
            let (values, tally) = self.carry_to_plane(field, &raster, progress)?;
            return Ok((HeightStack::plane(raster, values), tally));
        }

        // One plane at each level, and what they give together.
        let levels = self.receiving_levels(reach);
        let spectra = self.spectra(field, &levels, |_| true);
        let shared = self.shared(&levels, spectra.as_ref());
        let stack = &levels.stack;
        let (mut values, mut tally) = (Vec::new(), Tally::default());
        for (number, level) in stack.levels.at.iter().enumerate() {
            let (plane, planned) = self.planes(*level);
            let plan = self.plan.moved(*level);
            let run = HopRun {
                shared: Some(shared),
                ..self.on_planes(number, &plane, planned.as_ref(), &plan)
            };
            let before = number as f64 / stack.len() as f64;
            let part = |done: f64| progress(before + done / stack.len() as f64);
            let (landed, counts) = run.carry_to_plane(field, &raster, &part)?;
            if number == stack.len() / 2 {
                tally = counts;
            }
            values.push(landed);
        }
        let height_stack = HeightStack {
            raster,
            stack: Some(levels.stack),
            values,
        };
        Ok((height_stack, tally))
    }

    /// One level of the second screen, and of the planned one if it is another.
    fn planes(&self, level: f64) -> (Screen, Option<Screen>) {
        let planned = self.planned.map(|planned| level_of(planned.to, level));
        (level_of(self.hop.to, level), planned)
    }

    /// The same run to a level.
    fn on_planes<'b>(
        &'b self,
        number: usize,
        plane: &'b Screen,
        planned: Option<&'b Screen>,
        plan: &'b Plan,
    ) -> HopRun<'b> {
        let planned = self.planned.zip(planned);
        HopRun {
            hop: Hop {
                to: plane,
                ..self.hop
            },
            planned: planned.map(|(hop, to)| Hop { to, ..hop }),
            plan,
            caches: self.caches.get(number..).unwrap_or_default(),
            ..*self
        }
    }

    /// The levels around a curved second screen, for light with direction cosines up to `reach`.
    fn receiving_levels(&self, reach: [f64; 2]) -> ReceivingLevels {
        let stack = stack(self.hop.to, reach, self.hop.wavenumber());
        let [middle, apart] = stack.middle();
        let n = self.hop.to.index;
        let slope = |p: f64| p / (n * n - p * p).max(f64::MIN_POSITIVE).sqrt();
        ReceivingLevels {
            middle: self.planes(middle),
            aside: reach.map(|p| apart * slope(p)),
            stack,
        }
    }

    /// What the hops to all levels share, with the spectra of the patches if they are known.
    fn shared<'b>(
        &'b self,
        levels: &'b ReceivingLevels,
        spectra: Option<&'b Kept>,
    ) -> SharedByLevels<'b> {
        let (plane, planned) = &levels.middle;
        SharedByLevels {
            middle: match self.planned.zip(planned.as_ref()) {
                Some((hop, to)) => Hop { to, ..hop },
                None => Hop {
                    to: plane,
                    ..self.hop
                },
            },
            aside: levels.aside,
            spectra,
        }
    }

    /// The spectra of the patches of a field in the directions of all levels; nothing where they are not needed, or the method
    /// has no patches.
    fn spectra(
        &self,
        field: &Field,
        levels: &ReceivingLevels,
        needed: fn(&Job) -> bool,
    ) -> Option<Kept> {
        let Plan::Beamlets(plan) = self.plan else {
            return None;
        };
        let settings = &self.settings.aiming_at(plan.target_error);
        let run = HopRun {
            shared: Some(self.shared(levels, None)),
            ..*self
        };
        let job = run.job(plan, settings);
        needed(&job).then(|| Cutter::new(&job, field).keep())
    }

    /// The run as a job for beamlets.
    fn job<'b>(&'b self, plan: &'b BeamletPlan, settings: &'b Settings) -> Job<'b> {
        Job {
            hop: self.hop,
            planned: self.planned,
            plan,
            settings,
            downstream: self.downstream,
            cache: self.caches.first(),
            draws: self.draws.map(|draws| (draws, self.number as u32)),
            shared: self.shared,
        }
    }

    /// The levels around the second screen on which [`HopRun::carry`] sums light; nothing for a plane one.
    pub(crate) fn stack(&self, reach: [f64; 2]) -> Option<Stack> {
        let to = self.hop.to;
        (!to.is_plane()).then(|| stack(to, reach, self.hop.wavenumber()))
    }

    /// The conjugate transpose of [`HopRun::carry`]: from the levels of the second screen, one array each, to the
    /// nodes of `field`, and to the parameters of the hop.
    ///
    /// # Errors
    /// When the method of the hop has no adjoint, or the pulse of `back` cancels the hop.
    pub(crate) fn carry_adjoint(
        &self,
        field: &Field,
        raster: Raster,
        reach: [f64; 2],
        levels_bar: &[Array2<Complex64>],
        back: &mut AdjointSums,
    ) -> Result<(), HopAdjointError> {
        let to = self.hop.to;
        if to.is_plane() {
            return self.carry_to_plane_adjoint(field, &raster, &levels_bar[0], back);
        }
        let levels = self.receiving_levels(reach);
        let spectra = self.spectra(field, &levels, |job| job.adjoint_needs_spectra());
        let shared = self.shared(&levels, spectra.as_ref());
        for (number, (level, bar)) in levels.stack.levels.at.iter().zip(levels_bar).enumerate() {
            let (plane, planned) = self.planes(*level);
            let plan = self.plan.moved(*level);
            let run = HopRun {
                shared: Some(shared),
                ..self.on_planes(number, &plane, planned.as_ref(), &plan)
            };

            // The perturbed planes at the same level.
            let pairs: Vec<[Screen; 2]> = back
                .perturbed
                .iter()
                .map(|n| [level_of(n.below.to, *level), level_of(n.above.to, *level)])
                .collect();
            let level = back.perturbed.iter().zip(&pairs);
            let perturbed: Vec<PerturbedHops> = level.map(|(n, pair)| at_level(n, pair)).collect();
            let mut back = AdjointSums {
                from_bar: back.from_bar,
                perturbed: &perturbed,
                parameters: back.parameters,
                pulse: back.pulse,
            };
            run.carry_to_plane_adjoint(field, &raster, bar, &mut back)?;
        }
        Ok(())
    }

    /// The error of a free hop at a few points of the middle level of what it brought, by the direct sum over a field behind
    /// its first screen, which may stand on other samples than those that were carried.
    pub(crate) fn spot_check(&self, field: &Field, brought: &HeightStack) -> Option<f64> {
        let middle = brought.values.len() / 2;
        let level = (brought.stack.as_ref()).and_then(|stack| stack.levels.at.get(middle));
        let plane = level.map(|level| level_of(self.hop.to, *level));
        let plan = level.map(|level| self.plan.moved(*level));
        let Plan::Free(free, _) = plan.as_ref().unwrap_or(self.plan) else {
            return None;
        };
        let check = SpotCheck {
            hop: &Hop {
                to: plane.as_ref().unwrap_or(self.hop.to),
                ..self.hop
            },
            free,
            field,
            raster: &brought.raster,
            values: brought.values.get(middle)?,
        };
        check.error(self.settings.seed)
    }

    fn carry_to_plane(
        &self,
        field: &Field,
        raster: &Raster,
        progress: &ShareDone,
    ) -> Result<(Array2<Complex64>, Tally), HopError> {
        let (hop, settings) = (self.hop, self.settings);
        let planes = || PlaneSum::new(*raster, hop.wavenumber(), settings.nufft_tolerance);
        Ok(match self.plan {
            Plan::Free(free, plan) => FreeRun { hop, free, plan }.carry(field, raster),
            Plan::Beamlets(plan) => {
                let settings = &settings.aiming_at(plan.target_error);
                let job = self.job(plan, settings);
                let mut canvas = Canvas::new(*raster);
                let patches = 0..BeamletPropagation.patches(&job, field);
                let tally =
                    BeamletPropagation.carry(&job, field, patches, &mut canvas, progress)?;
                (canvas.finish(), tally)
            }
            Plan::Planes(plan) => {
                let mut sum = planes()?;
                let tally = PlaneRun::new(hop, plan, settings, field).carry(&mut sum, progress)?;
                (sum.finish(), tally)
            }
            Plan::Paper(plan) => {
                let mut sum = planes()?;
                let address = DrawAddress {
                    seed: settings.seed,
                    hop: self.number as u32,
                };
                let run = PaperRun::new(hop, plan, address, field);
                let tally = run.carry(&mut sum, progress)?;
                (sum.finish(), tally)
            }
        })
    }

    fn carry_to_plane_adjoint(
        &self,
        field: &Field,
        raster: &Raster,
        bar: &Array2<Complex64>,
        back: &mut AdjointSums,
    ) -> Result<(), HopAdjointError> {
        let (hop, settings) = (self.hop, self.settings);
        match self.plan {
            Plan::Free(free, plan) => {
                FreeRun { hop, free, plan }.carry_adjoint(field, raster, bar, back)?;
            }
            Plan::Beamlets(plan) => {
                let settings = &settings.aiming_at(plan.target_error);
                let job = self.job(plan, settings);
                let canvas = Canvas::holding(*raster, bar);
                let patches = 0..BeamletPropagation.patches(&job, field);
                BeamletPropagation.carry_adjoint(&job, field, patches, &canvas, back)?;
            }
            Plan::Planes(_) => return Err(HopAdjointError::NoAdjoint("plane")),
            Plan::Paper(_) => return Err(HopAdjointError::NoAdjoint("paper")),
        }
        Ok(())
    }
}

/// The levels around a curved second screen.
struct ReceivingLevels {
    stack: Stack,
    /// The plane at the middle level, and that of the planned screen if it is another.
    middle: (Screen, Option<Screen>),
    /// How far light lands aside between the middle level and another, along x and y in mm.
    aside: [f64; 2],
}

/// One of the planes on which light is summed around a curved screen.
fn level_of(to: &Screen, level: f64) -> Screen {
    Screen {
        frame: to.frame.moved(Vec3::new(0.0, 0.0, level)),
        shape: Shape::Plane,
        ..to.clone()
    }
}

/// The perturbed hops that lead to other screens.
fn at_level<'a>(
    perturbed: &PerturbedHops<'a>,
    [below, above]: &'a [Screen; 2],
) -> PerturbedHops<'a> {
    PerturbedHops {
        below: Hop {
            to: below,
            ..perturbed.below
        },
        above: Hop {
            to: above,
            ..perturbed.above
        },
        distance: perturbed.distance,
    }
}

/// The levels on which light is summed around a curved screen.
fn stack(to: &Screen, reach: [f64; 2], k: f64) -> Stack {
    let relief = to.relief().unwrap_or(crate::optics::screen::Relief::FLAT);
    let [x, y] = reach;
    let mut cosines = normal_cosines([-x, x, -y, y], to.index).map(|q| to.arrives * q);
    cosines.sort_by(f64::total_cmp);
    Stack::new([relief.low, relief.high], cosines, k)
}

/// A hop without rays, with its plan.
struct FreeRun<'a> {
    hop: Hop<'a>,
    free: &'a FreeHop,
    plan: &'a FreePlan,
}

impl FreeRun<'_> {
    /// The field on a raster, and its tally: what does not arrive goes elsewhere.
    fn carry(&self, field: &Field, raster: &Raster) -> (Array2<Complex64>, Tally) {
        let heights = heights(&self.hop, field);
        let leaves = self.hop.from.leaves();
        let surface = heights.as_ref().map(|heights| (heights, leaves));
        let values = self.free.carry(field, surface, raster, self.plan);
        let landed = raster.power(&values);
        let mut tally = Tally::default();
        tally.add_energy(Fate::Arrived, landed);
        tally.add_energy(Fate::Elsewhere, (field.power() - landed).max(0.0));
        (values, tally)
    }

    /// The conjugate transpose of [`FreeRun::carry`].
    ///
    /// # Errors
    /// When a perturbed hop is not free: a parameter that tilts a screen is planned with rays.
    fn carry_adjoint(
        &self,
        field: &Field,
        raster: &Raster,
        bar: &Array2<Complex64>,
        back: &mut AdjointSums,
    ) -> Result<(), HopAdjointError> {
        let free = |hop: &Hop| {
            let name = |screen: &Screen| screen.name.clone();
            let not_free = || HopAdjointError::NotFree(name(hop.from), name(hop.to));
            along(self.free, hop).ok_or_else(not_free)
        };
        let pair = |n: &PerturbedHops| -> Result<_, HopAdjointError> {
            Ok(PerturbedFreeHops {
                below: free(&n.below)?,
                above: free(&n.above)?,
                distance: n.distance,
            })
        };
        let perturbed = back.perturbed.iter().map(pair);
        let perturbed = perturbed.collect::<Result<Vec<_>, _>>()?;
        let heights = heights(&self.hop, field);
        let leaves = self.hop.from.leaves();
        let emitted = EmittedField {
            field,
            surface: heights.as_ref().map(|heights| (heights, leaves)),
        };
        let (field_bar, pulled) =
            (self.free).carry_adjoint(bar, raster, emitted, self.plan, &perturbed);
        *back.from_bar += &field_bar;
        for (total, part) in back.parameters.iter_mut().zip(pulled) {
            *total += part;
        }
        Ok(())
    }
}

/// The heights of a curved first screen at the nodes of a field; nothing for a plane one.
fn heights(hop: &Hop, field: &Field) -> Option<Heights> {
    (!hop.from.is_plane()).then(|| Heights::on(hop.from, &field.grid))
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use crate::engine::chain::arriving_light::{
        Arriving, arrival_reach, incidence, leaving, receiving_raster,
    };
    use crate::engine::chain::backend::AdjointSums;
    use crate::engine::chain::hop_run::{HopAdjointError, HopRun};
    use crate::engine::plan::direction_spread::LightDirections;
    use crate::engine::plan::downstream::Downstream;
    use crate::engine::plan::hop_plan::plan;
    use crate::engine::plan::settings::{Method, Settings};
    use crate::engine::progress::uncancelled;
    use crate::fixtures::paper_systems::near_hologram;
    use crate::optics::pixels::pixel_grid::PixelForm;
    use crate::wave::grid::field::Field;

    /// Methods without an adjoint once gave a gradient of zero.
    #[test]
    fn methods_without_an_adjoint_are_refused() {
        let system = near_hologram(&Array2::zeros((20, 20)), PixelForm::Point);
        let hop = system.hops().next().unwrap();
        for (method, name) in [(Method::Plane, "plane"), (Method::Paper, "paper")] {
            let settings = Settings {
                method,
                ..Settings::default()
            };
            let (chief, usual) = incidence(&system);
            let light = LightDirections { chief, usual };
            let plan = plan(&hop, light, Downstream::none(), &settings).unwrap();
            let reach = arrival_reach(&hop, &plan);
            let raster = receiving_raster(&hop, reach, &settings).unwrap();
            let light = Arriving::from_source(&system);
            let (_, field) = light
                .pass(&system, hop.from, leaving(&plan), &settings)
                .unwrap();
            let mut bar = Field::zeros(field.grid.clone());
            let mut back = AdjointSums {
                from_bar: &mut bar.values,
                perturbed: &[],
                parameters: &mut [],
                pulse: &uncancelled,
            };
            let [nx, ny] = raster.size;
            let levels_bar = [Array2::zeros((ny, nx))];
            let found = HopRun::new(0, hop, &plan, &settings, Downstream::none()).carry_adjoint(
                &field,
                raster,
                reach,
                &levels_bar,
                &mut back,
            );
            assert_eq!(found, Err(HopAdjointError::NoAdjoint(name)));
        }
    }
}
