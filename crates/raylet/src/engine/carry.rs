//! One hop being run: a field behind the first screen to the light before the second.

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::backend::{Backend, Job};
use crate::engine::beyond::Beyond;
use crate::engine::cpu::Cpu;
use crate::engine::paper;
use crate::engine::paper_plan::Address;
use crate::engine::plan::Plan;
use crate::engine::plane;
use crate::engine::settings::Settings;
use crate::engine::tally::{Fate, Tally};
use crate::math::nufft::NufftError;
use crate::math::vec3::Vec3;
use crate::optics::screen::Screen;
use crate::optics::shape::Shape;
use crate::optics::system::Hop;
use crate::wave::field::Field;
use crate::wave::gather::Canvas;
use crate::wave::heights::{Heights, Stack, normal_cosines};
use crate::wave::plane::PlaneSum;
use crate::wave::propagate::{FreeHop, FreePlan};
use crate::wave::raster::Raster;
use crate::wave::sheets::Sheets;

/// A hop with its plan.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// Its place in the system.
    pub number: usize,
    /// Screens and train.
    pub hop: Hop<'a>,
    /// How it is carried.
    pub plan: &'a Plan,
    /// Thresholds.
    pub settings: &'a Settings,
    /// Where its light goes next.
    pub beyond: &'a Beyond<'a>,
}

impl Run<'_> {
    /// Carries a field to a raster of the second screen; to levels around it when it is curved, as many as
    /// light with direction cosines up to `reach` asks for. The tally is that of the middle level.
    ///
    /// # Errors
    /// When a sum of plane waves cannot be planned.
    pub fn carry(
        &self,
        field: &Field,
        raster: Raster,
        reach: [f64; 2],
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<(Sheets, Tally), NufftError> {
        let to = self.hop.to;
        if to.is_plane() {
            let (values, tally) = self.carry_to_plane(field, &raster, progress)?;
            return Ok((Sheets::plane(raster, values), tally));
        }

        // One plane at each level, and what they give together.
        let stack = stack(to, reach, self.hop.wavenumber());
        let (mut values, mut tally) = (Vec::new(), Tally::default());
        for (number, level) in stack.levels.at.iter().enumerate() {
            let plane = level_of(to, *level);
            let plan = self.plan.moved(*level);
            let run = Run {
                hop: Hop {
                    to: &plane,
                    ..self.hop
                },
                plan: &plan,
                ..*self
            };
            let before = number as f64 / stack.len() as f64;
            let part = |done: f64| progress(before + done / stack.len() as f64);
            let (sheet, counts) = run.carry_to_plane(field, &raster, &part)?;
            values.push(sheet);
            if number == stack.len() / 2 {
                tally = counts;
            }
        }
        let sheets = Sheets {
            raster,
            stack: Some(stack),
            values,
        };
        Ok((sheets, tally))
    }

    /// The levels around the second screen on which [`Run::carry`] sums light; nothing for a plane one.
    pub fn stack(&self, reach: [f64; 2]) -> Option<Stack> {
        let to = self.hop.to;
        (!to.is_plane()).then(|| stack(to, reach, self.hop.wavenumber()))
    }

    /// The conjugate transpose of [`Run::carry`]: from the levels of the second screen, one array each, to the
    /// nodes of `field`. Plane wavelets and the source paper's method have none yet.
    pub fn carry_adjoint(
        &self,
        field: &Field,
        raster: Raster,
        reach: [f64; 2],
        sheets_bar: &[Array2<Complex64>],
        progress: &(dyn Fn(f64) + Sync),
    ) -> Array2<Complex64> {
        let to = self.hop.to;
        let mut total: Array2<Complex64> = Array2::zeros(field.values.dim());
        if to.is_plane() {
            self.carry_to_plane_adjoint(field, &raster, &sheets_bar[0], &mut total, progress);
            return total;
        }
        let stack = stack(to, reach, self.hop.wavenumber());
        for (level, bar) in stack.levels.at.iter().zip(sheets_bar) {
            let plane = level_of(to, *level);
            let plan = self.plan.moved(*level);
            let run = Run {
                hop: Hop {
                    to: &plane,
                    ..self.hop
                },
                plan: &plan,
                ..*self
            };
            run.carry_to_plane_adjoint(field, &raster, bar, &mut total, progress);
        }
        total
    }

    fn carry_to_plane_adjoint(
        &self,
        field: &Field,
        raster: &Raster,
        bar: &Array2<Complex64>,
        total: &mut Array2<Complex64>,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let (hop, settings) = (self.hop, self.settings);
        match self.plan {
            Plan::Free(free, waves) => {
                *total += &carry_free_adjoint(&hop, (free, waves), field, raster, bar);
            }
            Plan::Beamlets(plan) => {
                let job = Job {
                    hop,
                    plan,
                    settings,
                    beyond: self.beyond,
                };
                let canvas = Canvas::holding(*raster, bar);
                let patches = 0..Cpu.patches(&job, field);
                Cpu.carry_adjoint(&job, field, patches, &canvas, total, progress);
            }
            Plan::Planes(_) | Plan::Paper(_) => {}
        }
    }

    fn carry_to_plane(
        &self,
        field: &Field,
        raster: &Raster,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<(Array2<Complex64>, Tally), NufftError> {
        let (hop, settings) = (self.hop, self.settings);
        let planes = || PlaneSum::new(*raster, hop.wavenumber(), settings.nufft_tolerance);
        Ok(match self.plan {
            Plan::Free(free, waves) => carry_free(&hop, (free, waves), field, raster),
            Plan::Beamlets(plan) => {
                let job = Job {
                    hop,
                    plan,
                    settings,
                    beyond: self.beyond,
                };
                let mut canvas = Canvas::new(*raster);
                let patches = 0..Cpu.patches(&job, field);
                let tally = Cpu.carry(&job, field, patches, &mut canvas, progress);
                (canvas.finish(), tally)
            }
            Plan::Planes(plan) => {
                let mut sum = planes()?;
                let tally = plane::carry(hop, plan, settings, field, &mut sum, progress);
                (sum.finish(), tally)
            }
            Plan::Paper(plan) => {
                let mut sum = planes()?;
                let address = Address {
                    seed: settings.seed,
                    hop: self.number as u32,
                };
                let tally = paper::carry(hop, plan, address, field, &mut sum, progress);
                (sum.finish(), tally)
            }
        })
    }
}

/// One of the planes on which light is summed around a curved screen.
fn level_of(to: &Screen, level: f64) -> Screen {
    Screen {
        frame: to.frame.moved(Vec3::new(0.0, 0.0, level)),
        shape: Shape::Plane,
        ..to.clone()
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

/// A free hop, and its tally: what does not arrive goes elsewhere.
fn carry_free(
    hop: &Hop,
    (free, plan): (&FreeHop, &FreePlan),
    field: &Field,
    raster: &Raster,
) -> (Array2<Complex64>, Tally) {
    let values = match hop.from.is_plane() {
        true => free.carry(field, raster, plan),
        false => {
            let heights = Heights::on(hop.from, &field.grid);
            free.carry_curved(field, &heights, hop.from.leaves(), raster, plan)
        }
    };
    let landed = raster.power(&values);
    let mut tally = Tally::default();
    tally.add_energy(Fate::Arrived, landed);
    tally.add_energy(Fate::Elsewhere, (field.power() - landed).max(0.0));
    (values, tally)
}

/// The conjugate transpose of [`carry_free`].
fn carry_free_adjoint(
    hop: &Hop,
    (free, plan): (&FreeHop, &FreePlan),
    field: &Field,
    raster: &Raster,
    bar: &Array2<Complex64>,
) -> Array2<Complex64> {
    match hop.from.is_plane() {
        true => free.carry_adjoint(bar, raster, &field.grid, plan),
        false => {
            let heights = Heights::on(hop.from, &field.grid);
            let surface = (field, &heights, hop.from.leaves());
            free.carry_curved_adjoint(bar, raster, surface, plan)
        }
    }
}
