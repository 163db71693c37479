//! How many patches it takes to cover a hologram, by rules of position, and the pictures of it.
//!
//! In free space all modes of all patches of one period add up to the angular spectrum of the field times
//! the number of patches over each place ([`PeriodicHop`]): no ray is needed for their sum.

#![expect(
    clippy::indexing_slicing,
    reason = "systems, windows and rows are made here, with these screens and sizes"
)]

use std::time::Instant;

use ndarray::{Array2, Zip};
use num_complex::Complex64;
use raylet::engine::chain::arriving_light::{Arriving, leaving, receiving_raster};
use raylet::engine::chain::simulate::simulate;
use raylet::engine::chain::simulate_error::SimulateError;
use raylet::engine::monte_carlo::paper::window_coverage;
use raylet::engine::monte_carlo::paper_plan::{DrawAddress, PaperPlan};
use raylet::engine::plan::downstream::Downstream;
use raylet::engine::plan::hop_plan::{Plan, plan};
use raylet::engine::plan::settings::{Method, Paper, Positions, Sampler, Settings};
use raylet::optics::system::System;
use raylet::wave::grid::field::Field;
use raylet::wave::grid::metrics::{field_error, ncc};
use raylet::wave::patches::tile::TileCutter;

use crate::patches::periodic_hop::PeriodicHop;

/// Likeness (NCC) that counts as enough, and the largest number of positions that is tried to reach it.
const ENOUGH: f64 = 0.99;
const MOST: usize = 16_384;

/// Repetitions with other random numbers; their mean judges a number of positions.
const SEEDS: u64 = 2;

/// A rule of position.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Name of the rule in the study.
    pub name: &'static str,
    /// How positions are chosen.
    pub positions: Positions,
    /// Whether the coverage is divided out.
    pub divides: bool,
}

impl Rule {
    /// A rule that does not divide by the coverage.
    const fn plain(name: &'static str, positions: Positions) -> Self {
        Self {
            name,
            positions,
            divides: false,
        }
    }
}

/// The rules compared.
pub const RULES: [Rule; 4] = [
    Rule::plain("inside", Positions::Inside),
    Rule::plain("dilated", Positions::Dilated),
    Rule::plain("jittered", Positions::Jittered),
    Rule {
        divides: true,
        ..Rule::plain("dilated, divided by coverage", Positions::Dilated)
    },
];

/// Likeness and error over the number of positions, for one rule and one size of patches.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name of the rule.
    pub rule: &'static str,
    /// Side of the patches in wavelengths.
    pub side: f64,
    /// For each number of positions: that number, likeness (NCC) of the intensities, and error of the field.
    pub points: Vec<[f64; 3]>,
}

/// Positions that it takes to be alike enough.
#[derive(Clone, Debug)]
pub struct Need {
    /// Name of the rule.
    pub rule: &'static str,
    /// Side of the patches in wavelengths.
    pub side: f64,
    /// Their number; nothing when the most that were tried do not do.
    pub positions: Option<usize>,
    /// Likeness with the most that were tried.
    pub most: f64,
}

/// The study of one hologram.
pub struct Covering {
    /// Likeness over positions.
    pub curves: Vec<Curve>,
    /// Positions needed.
    pub needs: Vec<Need>,
    /// The whole hologram as one patch against free space: period over the width of the hologram, likeness (NCC) and
    /// error of the field.
    pub padding: Vec<[f64; 3]>,
    /// Intensities: the reference; then one patch in the middle, and many, of each size.
    pub images: Vec<(String, Array2<f64>)>,
    /// Width of the hologram in mm.
    pub width: f64,
    /// Sums that were done.
    pub sums: usize,
    /// Seconds it took.
    pub seconds: f64,
}

/// The patches and numbers of positions that a study tries.
#[derive(Clone, Debug)]
pub struct CoveringCase {
    /// Sides of patches in wavelengths that are followed over positions.
    pub sides: Vec<f64>,
    /// Further sides in wavelengths for which only the number of positions needed is found.
    pub between: Vec<f64>,
    /// Numbers of positions.
    pub counts: Vec<usize>,
    /// Periods over the width of the hologram.
    pub periods: Vec<f64>,
}

/// A hologram that fills its frame, and what it brings.
struct Stage<'a> {
    system: &'a System,
    width: f64,
    field: Field,
    hop: PeriodicHop,
    whole: Array2<Complex64>,
    sums: usize,
}

fn intensity(field: &Array2<Complex64>) -> Array2<f64> {
    field.mapv(|u| u.norm_sqr())
}

/// Patches of this side by this rule, with a period of `period` mm.
fn settings(side: f64, period: f64, rule: Rule, rays: usize) -> Settings {
    Settings {
        method: Method::Paper,
        paper: Paper {
            rays,
            patch: Some(side),
            padding: period / side,
            positions: rule.positions,
            coverage: rule.divides,
            sampler: Sampler::All,
            ..Paper::default()
        },
        ..Settings::default()
    }
}

/// The whole hologram as one patch.
const WHOLE: Rule = Rule::plain("", Positions::Grid);

/// The plan of the system's only hop.
fn planned(system: &System, settings: &Settings) -> Result<PaperPlan, SimulateError> {
    let light = Arriving::from_source(system).directions;
    let mut hops = system.hops();
    let hop = hops.next().ok_or(SimulateError::NoSensor(String::new()))?;
    match plan(&hop, light, &Downstream::default(), settings)? {
        Plan::Paper(plan) => Ok(plan),
        _ => Err(SimulateError::NoSensor(hop.to.name.clone())),
    }
}

/// The field behind the element, and the hop with this period.
fn frame(system: &System, width: f64, period: f64) -> Result<(Field, PeriodicHop), SimulateError> {
    let settings = settings(width, period, WHOLE, 1);
    let plan = planned(system, &settings)?;
    let bands = plan.bands;
    let light = Arriving::from_source(system);
    let screen = &system.screens[0];
    let (_, field) = light.pass(system, screen, leaving(&Plan::Paper(plan)), &settings)?;
    let distance = system.screens[1].frame.origin.z - screen.frame.origin.z;
    let mut hops = system.hops();
    let hop = hops.next().ok_or(SimulateError::NoSensor(String::new()))?;
    let raster = receiving_raster(&hop, [1.0; 2], &settings)?;
    let hop = PeriodicHop::new(system.wavenumber(), &bands, &field.grid, distance, &raster);
    Ok((field, hop))
}

impl<'a> Stage<'a> {
    fn new(system: &'a System) -> Result<Self, SimulateError> {
        let bounds = system.screens[0].bounds().unwrap_or_default();
        let width = bounds[1] - bounds[0];
        let (field, hop) = frame(system, width, width)?;
        let whole = hop.carry(field.values.view());
        Ok(Self {
            system,
            width,
            field,
            hop,
            whole,
            sums: 0,
        })
    }

    /// What so many patches of a side in wavelengths bring.
    fn sum(
        &mut self,
        side: f64,
        rule: Rule,
        rays: usize,
        seed: u64,
    ) -> Result<Array2<Complex64>, SimulateError> {
        let side = side * self.system.wavelength;
        let plan = planned(self.system, &settings(side, self.width, rule, rays))?;
        let axes = [&self.field.grid.x, &self.field.grid.y];
        let k = self.system.wavenumber();
        let cutter = TileCutter::new(axes, &plan.bands, k, &plan.tile());
        let mut values = self.field.values.clone();
        let address = DrawAddress { seed, hop: 0 };
        for hop in self.system.hops() {
            let coverage = window_coverage(&hop, &plan, address, &cutter, self.field.grid.shape());
            let share = plan.share();
            let weight = |count: f64| match plan.coverage {
                true => count.min(1.0),
                false => count * share,
            };
            Zip::indexed(&mut values).for_each(|node, value| *value *= weight(coverage[node]));
        }
        self.sums += 1;
        Ok(self.hop.carry(values.view()))
    }

    /// Likeness and field error of so many patches against the whole in the same frame.
    fn judge(&mut self, side: f64, rule: Rule, rays: usize) -> Result<[f64; 2], SimulateError> {
        let mut means = [0.0; 2];
        for seed in 1..=SEEDS {
            let field = self.sum(side, rule, rays, seed)?;
            let like = ncc(intensity(&field).view(), intensity(&self.whole).view());
            let error = field_error(field.view(), self.whole.view());
            for (mean, value) in means.iter_mut().zip([like, error]) {
                *mean += value.unwrap_or(f64::NAN) / SEEDS as f64;
            }
        }
        Ok(means)
    }

    /// The least number of positions that does, within three per cent.
    fn need(&mut self, side: f64, rule: Rule) -> Result<Need, SimulateError> {
        let [most, _] = self.judge(side, rule, MOST)?;
        let mut need = Need {
            rule: rule.name,
            side,
            positions: None,
            most,
        };
        if most < ENOUGH {
            return Ok(need);
        }
        let (mut low, mut high) = (1.0, MOST as f64);
        while high / low > 1.03 && high - low > 1.0 {
            let middle = f64::sqrt(low * high).round();
            let [like, _] = self.judge(side, rule, middle as usize)?;
            if like < ENOUGH {
                low = middle;
            } else {
                high = middle;
            }
        }
        need.positions = Some(high as usize);
        Ok(need)
    }

    /// Intensities of one patch in the middle and of many.
    fn images(&mut self, case: &CoveringCase) -> Result<Vec<(String, Array2<f64>)>, SimulateError> {
        let mut images = vec![(String::from("Angular spectrum"), intensity(&self.whole))];
        for &side in &case.sides {
            let one = self.sum(side, WHOLE, 1, 1)?;
            images.push((format!("One patch of {side:.0} λ"), intensity(&one)));
        }
        let many = case.counts.last().copied().unwrap_or(1);
        for &side in &case.sides {
            let field = self.sum(side, RULES[1], many, 1)?;
            images.push((format!("{many} patches of {side:.0} λ"), intensity(&field)));
        }
        Ok(images)
    }
}

/// The whole hologram with several periods against free space.
fn padding(system: &System, periods: &[f64]) -> Result<Vec<[f64; 3]>, SimulateError> {
    let truth = simulate(system, &Settings::default(), &|_| {})?;
    let truth = truth.field.values;
    let bounds = system.screens[0].bounds().unwrap_or_default();
    let width = bounds[1] - bounds[0];
    let mut found = Vec::new();
    for &ratio in periods {
        let (field, hop) = frame(system, width, ratio * width)?;
        let sum = hop.carry(field.values.view());
        let like = ncc(intensity(&sum).view(), intensity(&truth).view());
        let error = field_error(sum.view(), truth.view());
        found.push([ratio, like.unwrap_or(f64::NAN), error.unwrap_or(f64::NAN)]);
    }
    Ok(found)
}

impl Covering {
    /// Measures on a hologram in free space with one sample a pixel.
    ///
    /// # Errors
    /// As [`simulate`].
    pub fn measure(system: &System, case: &CoveringCase) -> Result<Self, SimulateError> {
        let clock = Instant::now();
        let mut stage = Stage::new(system)?;
        let (mut curves, mut needs) = (Vec::new(), Vec::new());
        for rule in RULES {
            for &side in &case.sides {
                let mut points = Vec::new();
                for &count in &case.counts {
                    let [like, error] = stage.judge(side, rule, count)?;
                    points.push([count as f64, like, error]);
                }
                let rule = rule.name;
                curves.push(Curve { rule, side, points });
            }
            let mut sides = [&case.sides[..], &case.between].concat();
            sides.sort_by(f64::total_cmp);
            for side in sides {
                needs.push(stage.need(side, rule)?);
            }
        }
        Ok(Self {
            curves,
            needs,
            padding: padding(system, &case.periods)?,
            images: stage.images(case)?,
            width: stage.width,
            sums: stage.sums,
            seconds: clock.elapsed().as_secs_f64(),
        })
    }
}

#[cfg(test)]
mod tests {
    use raylet::engine::chain::simulate::simulate;
    use raylet::wave::grid::metrics::field_error;
    use raylet_testkit::patterns::star_hologram;

    use crate::patches::covering::{RULES, Stage, settings};

    /// The sum without rays is the sum of all rays, for every rule.
    #[test]
    fn sums_of_patches_are_what_their_rays_bring_slow() {
        let system = star_hologram(24, 0.7, 1e-3);
        let mut stage = Stage::new(&system).unwrap();
        for rule in RULES {
            let settings = settings(7e-3, stage.width, rule, 20);
            let rays = simulate(&system, &settings, &|_| {}).unwrap().field.values;
            let sum = stage.sum(7.0, rule, 20, settings.seed).unwrap();
            let error = field_error(sum.view(), rays.view()).unwrap();
            assert!(error < 1e-5, "{}: {error:e}", rule.name);
        }
    }
}
