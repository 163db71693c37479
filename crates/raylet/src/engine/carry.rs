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
use crate::engine::spot_check::Spots;
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
            let (values, mut tally) = self.carry_to_plane(field, &raster, progress)?;
            tally.spots = self.spots(field, &raster, &values);
            return Ok((Sheets::plane(raster, values), tally));
        }

        // One plane at each level, and what they give together.
        let stack = stack(to, reach, self.hop.wavenumber());
        let (mut values, mut tally) = (Vec::new(), Tally::default());
        for (number, level) in stack.levels.at.iter().enumerate() {
            let plane = Screen {
                frame: to.frame.moved(Vec3::new(0.0, 0.0, *level)),
                shape: Shape::Plane,
                ..to.clone()
            };
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
            if number == stack.len() / 2 {
                tally = counts;
                tally.spots = run.spots(field, &raster, &sheet);
            }
            values.push(sheet);
        }
        let sheets = Sheets {
            raster,
            stack: Some(stack),
            values,
        };
        Ok((sheets, tally))
    }

    /// The error of a free hop at a few points of what it brought.
    fn spots(&self, field: &Field, raster: &Raster, values: &Array2<Complex64>) -> Option<f64> {
        let Plan::Free(free, _) = self.plan else {
            return None;
        };
        let spots = Spots {
            hop: &self.hop,
            free,
            field,
            raster,
            values,
        };
        spots.error(self.settings.seed)
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
