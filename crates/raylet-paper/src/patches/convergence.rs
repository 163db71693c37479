//! How the paper's method converges with secondary rays at one patch, and the picture of it.

#![expect(
    clippy::indexing_slicing,
    reason = "systems, windows and rows are made here, with these screens and sizes"
)]

use std::time::Instant;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::arriving_light::{Arriving, leaving};
use raylet::engine::chain::simulate::simulate;
use raylet::engine::chain::simulate_error::SimulateError;
use raylet::engine::monte_carlo::paper_plan::PaperPlan;
use raylet::engine::plan::downstream::Downstream;
use raylet::engine::plan::hop_plan::{Plan, plan};
use raylet::engine::plan::settings::{Density, Method, Paper, Positions, Sampler, Settings};
use raylet::optics::system::System;
use raylet::wave::grid::metrics::{field_error, unit_sum_mse};
use raylet::wave::patches::tile::{CutScratch, TileCutter};
use raylet_plot::chart_panel::Series;
use raylet_plot::figure::{Figure, Panel};
use raylet_plot::panel::FigureError;

/// Squared errors below this are rounding: all modes were drawn.
const ROUNDING: f64 = 1e-20;

/// One method to draw modes, and what it gave.
#[derive(Clone, Debug)]
pub struct SamplingMethod {
    /// Its name.
    pub name: &'static str,
    density: Density,
    sampler: Sampler,
    /// Draws N, and the mean of ‖U − V‖²/‖V‖², V the patch with all modes.
    pub errors: Vec<[f64; 2]>,
    /// Draws and mean by the law of independent draws, where they are independent.
    pub law: Option<Vec<[f64; 2]>>,
}

/// The measured convergence on one element.
#[derive(Clone, Debug)]
pub struct Convergence {
    /// The methods to draw, compared.
    pub methods: [SamplingMethod; 3],
    /// Modes of the patch that propagate.
    pub modes: usize,
    /// Field error of the sum of all these modes against the angular spectrum with a wide period.
    pub floor: f64,
    /// Unit-sum mean squared error of the intensities of the same two fields.
    pub floor_mse: f64,
    /// Rays followed altogether, and seconds.
    pub rays: u64,
    /// Seconds for them.
    pub seconds: f64,
    /// Fields on the sensor: the angular spectrum, then the most and the least draws proportional to |c|.
    pub fields: [Array2<Complex64>; 3],
    /// Half width of the sensor in mm.
    half: f64,
}

/// One patch as large as the element, at its middle, padded twice.
fn settings(width: f64, density: Density, sampler: Sampler, secondary: usize) -> Settings {
    Settings {
        method: Method::Paper,
        paper: Paper {
            rays: 1,
            secondary,
            patch: Some(width),
            positions: Positions::Grid,
            density,
            sampler,
            ..Paper::default()
        },
        ..Settings::default()
    }
}

/// What the law of independent draws needs of a patch: Σ|c|, Σ|c|² and the number of modes.
fn sums(system: &System, plan: &PaperPlan) -> Result<[f64; 3], SimulateError> {
    let light = Arriving::from_source(system);
    let screen = &system.screens[0];
    let cosines = leaving(&Plan::Paper(plan.clone()));
    let (_, field) = light.pass(system, screen, cosines, &Settings::default())?;
    let axes = [&field.grid.x, &field.grid.y];
    let cutter = TileCutter::new(axes, &plan.bands, system.wavenumber(), &plan.tile());
    let mut scratch = CutScratch::default();
    cutter.cut(&field, [0.0; 2], &mut scratch);
    let [bx, by] = &plan.bands;
    let mut sums = [0.0; 3];
    for (index, c) in scratch.modes.iter().enumerate() {
        let (mx, my) = (index % bx.count, index / bx.count);
        if bx.at(mx).hypot(by.at(my)) < screen.index {
            sums = [sums[0] + c.norm(), sums[1] + c.norm_sqr(), sums[2] + 1.0];
        }
    }
    Ok(sums)
}

fn square(a: &Array2<Complex64>) -> f64 {
    a.iter().map(|u| u.norm_sqr()).sum()
}

/// One element, and its patch with all modes.
struct Element<'a> {
    system: &'a System,
    width: f64,
    whole: Array2<Complex64>,
    /// Σ|c|, Σ|c|² and the number of modes.
    sums: [f64; 3],
}

impl<'a> Element<'a> {
    fn new(system: &'a System) -> Result<Self, SimulateError> {
        let bounds = system.screens[0].bounds().unwrap_or_default();
        let width = bounds[1] - bounds[0];
        let all = settings(width, Density::Amplitude, Sampler::All, 1);
        let mut sums = [0.0; 3];
        for hop in system.hops() {
            let light = Arriving::from_source(system).directions;
            if let Plan::Paper(planned) = plan(&hop, light, &Downstream::default(), &all)? {
                sums = self::sums(system, &planned)?;
            }
        }
        Ok(Self {
            system,
            width,
            whole: simulate(system, &all, &|_| {})?.field.values,
            sums,
        })
    }

    /// Fills in the errors of one method with so many draws, and its law; the last field, and all rays.
    fn follow(
        &self,
        method: &mut SamplingMethod,
        count: usize,
        seeds: u64,
    ) -> Result<(Array2<Complex64>, u64), SimulateError> {
        let norm = square(&self.whole);
        let (mut sum, mut rays, mut last) = (0.0, 0, self.whole.clone());
        for seed in 0..seeds {
            let settings = Settings {
                seed,
                ..settings(self.width, method.density, method.sampler, count)
            };
            let outcome = simulate(self.system, &settings, &|_| {})?;
            rays += outcome.hops[0].tally.total_rays();
            last = outcome.field.values;
            sum += square(&(&last - &self.whole)) / norm;
        }
        method.errors.push([count as f64, sum / seeds as f64]);

        // (Σ|c|²/π − |V|²)/N at every point, over the mean of |V|².
        let [sizes, squares, modes] = self.sums;
        let spread = match method.density {
            Density::Amplitude => sizes * sizes,
            Density::Uniform => modes * squares,
        };
        let points = self.whole.len() as f64;
        if let Some(law) = &mut method.law {
            law.push([count as f64, (spread * points / norm - 1.0) / count as f64]);
        }
        Ok((last, rays))
    }
}

impl Convergence {
    /// Measures with each of `draws`, the mean of `seeds` repetitions each.
    ///
    /// # Errors
    /// As [`simulate`].
    pub fn measure(system: &System, draws: &[usize], seeds: u64) -> Result<Self, SimulateError> {
        let clock = Instant::now();
        let element = Element::new(system)?;
        let truth = simulate(system, &Settings::default(), &|_| {})?
            .field
            .values;

        // Each method with each number of draws; the paper's own method is shown.
        let mut rays = 0;
        let mut shown = [truth.clone(), truth.clone(), truth.clone()];
        let mut methods = methods();
        for (number, method) in methods.iter_mut().enumerate() {
            for (place, count) in draws.iter().enumerate() {
                let (field, followed) = element.follow(method, *count, seeds)?;
                rays += followed;
                if number == PAPER {
                    shown[if place == 0 { 2 } else { 1 }] = field;
                }
            }
        }
        let whole = element.whole;
        let bright = |u: &Array2<Complex64>| u.mapv(|u| u.norm_sqr());
        Ok(Self {
            methods,
            modes: element.sums[2] as usize,
            floor: field_error(whole.view(), truth.view()).unwrap_or(f64::NAN),
            floor_mse: unit_sum_mse(bright(&whole).view(), bright(&truth).view())
                .unwrap_or(f64::NAN),
            rays,
            seconds: clock.elapsed().as_secs_f64(),
            fields: shown,
            half: 0.5 * element.width,
        })
    }

    /// Errors over draws with their laws, and what the sensor shows with few, many and no draws.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn png(&self, title: &str) -> Result<Vec<u8>, FigureError> {
        let mut series: Vec<Series> = Vec::new();
        for method in &self.methods {
            let shown = method.errors.iter().filter(|error| error[1] > ROUNDING);
            series.push(Series::line(method.name, shown.copied()));
        }
        for (method, name) in self
            .methods
            .iter()
            .zip(["law, uniform", "law, proportional to |c|"])
        {
            if let Some(law) = &method.law {
                series.push(Series::dashed(name, law.clone()));
            }
        }
        let chart = Panel::lines(series)
            .title(format!("Against all {} modes of the patch", self.modes))
            .x_axis("secondary rays", "")
            .y_axis("relative mean squared error of the field", "")
            .log_x()
            .log_y();
        let least = self.methods[1].errors.first().map_or(0.0, |e| e[0]);
        let most = self.methods[1].errors.last().map_or(0.0, |e| e[0]);
        let names = [
            String::from("Angular spectrum"),
            format!("{most} draws proportional to |c|"),
            format!("{least} draws proportional to |c|"),
        ];
        let range = [-self.half, self.half];
        let images = self.fields.iter().zip(names).map(|(field, name)| {
            let panel = Panel::image(field.mapv(|u| u.norm_sqr()), range, range);
            Panel::from(panel.title(name).quantity("|U|²", ""))
        });
        Figure::new(vec![vec![chart.into()], images.collect()], title).to_png(1.5)
    }
}

/// The place of the paper's method among them.
const PAPER: usize = 1;

/// The methods that are compared.
fn methods() -> [SamplingMethod; 3] {
    let method = |name, density, sampler, law| SamplingMethod {
        name,
        density,
        sampler,
        errors: Vec::new(),
        law,
    };
    let independent = || Some(Vec::new());
    [
        method(
            "uniform",
            Density::Uniform,
            Sampler::Multinomial,
            independent(),
        ),
        method(
            "proportional to |c|",
            Density::Amplitude,
            Sampler::Multinomial,
            independent(),
        ),
        method(
            "proportional to |c|, systematic",
            Density::Amplitude,
            Sampler::Systematic,
            None,
        ),
    ]
}

#[cfg(test)]
mod tests {
    use raylet::engine::chain::simulate::simulate;
    use raylet::engine::plan::settings::{Density, Sampler};
    use raylet::wave::grid::metrics::field_error;
    use raylet_testkit::patterns::metalens;

    use crate::patches::convergence::{Convergence, settings};

    /// The error of independent draws is their law, once rare strong modes are drawn at all; without
    /// replacement it is less.
    #[test]
    fn errors_follow_their_laws_slow() {
        let system = metalens(30, 0.1, 1e-3);
        let found = Convergence::measure(&system, &[30, 300, 3000], 8).unwrap();
        let lawful = found.methods.each_ref().map(|method| method.law.is_some());
        assert_eq!(lawful, [true, true, false]);
        for method in &found.methods {
            if let Some(law) = &method.law {
                let ratio = method.errors[2][1] / law[2][1];
                assert!((ratio - 1.0).abs() < 0.2, "{}: {ratio}", method.name);
            }
        }
        for (with, without) in found.methods[1].errors.iter().zip(&found.methods[2].errors) {
            assert!(without[1] < with[1], "{without:?} {with:?}");
        }

        // What all modes lack are the copies of a period of twice the patch; wider ones lack less.
        let width = 0.03;
        let mut wide = settings(width, Density::Amplitude, Sampler::All, 1);
        wide.paper.padding = 8.0;
        let wide = simulate(&system, &wide, &|_| {}).unwrap().field.values;
        let floor = field_error(wide.view(), found.fields[0].view()).unwrap();
        assert!(floor < 0.3 * found.floor, "{floor:e} {:e}", found.floor);
        assert!(found.png("Metalens").unwrap().starts_with(b"\x89PNG"));
    }
}
