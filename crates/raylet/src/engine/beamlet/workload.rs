//! What a chosen beamlet plan will take, counted on a few of its patches.
//!
//! The choice between plans counts every patch and every direction. The forecast of the chosen one follows the
//! run more closely: each patch follows the directions that lead from it to the target and that its light may
//! have, and a beamlet is summed over the part of its footprint that lies on the target.

use std::f64::consts::PI;

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::beamlet::beamlet_launch::launch_beamlet;
use crate::engine::beamlet::beamlet_plan::{BeamletPlan, MARGIN, Planner};
use crate::engine::plan::cost_model::{as_conics, beamlet_widths, beamlets};
use crate::engine::plan::work::Work;
use crate::engine::trace::direction_search::reach;
use crate::optics::aperture::Aperture;
use crate::optics::pixels::pixel_grid::PixelForm;
use crate::optics::screen::ScreenKind;
use crate::wave::patches::window::Positions;

/// Patches looked at along each axis, and directions of each.
const PATCHES: usize = 8;
const DIRECTIONS: usize = 5;

/// Modes beyond its light's own directions that a smooth patch holds, on each side: where the spectrum of its
/// window falls below the weakest mode that is followed.
const SPREAD: f64 = 4.5;

/// Share of the target error that the modes may cost which a run leaves out for their weakness.
const LEFT_OUT: f64 = 1.0 / 3.0;

/// Any direction.
const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Neighbouring pixels that are compared.
const STEPS: usize = 10_000;

/// What a few patches hold.
#[derive(Default)]
struct Sample {
    /// Patches looked at, and those of them with any light.
    patches: f64,
    lit: f64,
    /// Rays of the lit ones, and the values of these rays.
    rays: f64,
    values: f64,
}

/// Seconds of the correction of a beamlet, if it has one, and of its sum at so many points.
fn seconds_of_sum(correct: bool, values: f64) -> f64 {
    let correction = if correct { beamlets::CORRECTION } else { 0.0 };
    correction + values * beamlets::VALUE
}

impl Planner<'_> {
    /// What the run of a plan will take; `spacing` is the distance of the points summed on the target.
    pub(crate) fn workload(&self, plan: &BeamletPlan, spacing: [f64; 2]) -> Work {
        let axis = |a: usize| {
            let edges = [self.from[2 * a], self.from[2 * a + 1]];
            Positions::covering(edges, plan.sigma, plan.step, 0.5 * plan.period)
        };
        let (x, y) = (axis(0), axis(1));
        let (mut sample, held) = (Sample::default(), self.held(plan));
        for j in spread(y.count, PATCHES) {
            for i in spread(x.count, PATCHES) {
                let at = [x.at(i), y.at(j)];
                self.sample_at(plan, at, (&held, spacing), &mut sample);
            }
        }

        // The rest of the patches are like these.
        let scale = (x.count * y.count) as f64 / sample.patches.max(1.0);
        let patches = sample.lit * beamlets::PATCH;
        let values = sample.values / sample.rays.max(1.0);
        let rays = sample.rays * self.seconds_of_beamlet(plan.correct, values);
        Work {
            rays: scale * sample.rays,
            values: scale * sample.values,
            seconds: beamlets::HOP + scale * (patches + rays),
        }
    }

    /// Seconds of one beamlet that is summed at so many points, with the correction of its aberration or without.
    fn seconds_of_beamlet(&self, correct: bool, values: f64) -> f64 {
        let traced = beamlets::BEAMLET + as_conics(self.hop.train) * beamlets::SURFACE;
        traced + seconds_of_sum(correct, values)
    }

    /// What it counts for where a width is chosen.
    pub(crate) fn cost_of_beamlet(&self, correct: bool, values: f64) -> f64 {
        let traced = beamlet_widths::BEAMLET + as_conics(self.hop.train) * beamlet_widths::SURFACE;
        traced + seconds_of_sum(correct, values)
    }

    /// Adds one patch to a sample, for the directions that its light may have and the distance of points on the target.
    fn sample_at(
        &self,
        plan: &BeamletPlan,
        at: [f64; 2],
        (held, spacing): (&[[f64; 2]; 2], [f64; 2]),
        sample: &mut Sample,
    ) {
        sample.patches += 1.0;
        let open = self.open(plan, at);
        if open == 0.0 {
            return;
        }
        sample.lit += 1.0;
        let margin = [MARGIN * plan.footprint; 2];
        let Some(led) = reach(self.hop, at, self.to, margin, plan.limits()) else {
            return;
        };
        // An edge under the window sends light anywhere.
        let held = match open < 1.0 {
            true => [ANY; 2],
            false => *held,
        };
        let [mx, my] = [0, 1].map(|a| {
            let low = led[2 * a].max(held[a][0]);
            plan.bands[a].within(low, led[2 * a + 1].min(held[a][1]))
        });
        let rays = (mx.len() * my.len()) as f64;
        if rays == 0.0 {
            return;
        }

        // A few of its directions represent all.
        let (mut tried, mut values) = (0.0, 0.0);
        for j in spread(my.len(), DIRECTIONS) {
            for i in spread(mx.len(), DIRECTIONS) {
                let p = [
                    plan.bands[0].at(mx.start + i),
                    plan.bands[1].at(my.start + j),
                ];
                tried += 1.0;
                values += self.values(at, p, plan.sigma, spacing);
            }
        }
        sample.rays += rays;
        sample.values += rays * values / tried;
    }

    /// The share of a patch that is open.
    fn open(&self, plan: &BeamletPlan, [x, y]: [f64; 2]) -> f64 {
        let open = &Aperture::OPEN;
        let aperture = match &self.hop.from.kind {
            ScreenKind::Stop(aperture) => aperture,
            ScreenKind::Doe(doe) => &doe.aperture,
            ScreenKind::Sensor(_) => open,
        };
        let half = 0.5 * plan.period;
        aperture.coverage(x - half, x + half, y - half, y + half)
    }

    /// The directions that the light of a patch may have, along x and y. All, where the edges of pixels send more light beside
    /// those of the window than may be left out.
    fn held(&self, plan: &BeamletPlan) -> [[f64; 2]; 2] {
        let left_out = (self.settings.target_error * LEFT_OUT).powi(2);
        [0, 1].map(|a| {
            let window = SPREAD * plan.bands[a].spacing;
            match self.sent_by_pixel_edges(a, window) > left_out {
                true => ANY,
                false => self.envelope.range(a, window),
            }
        })
    }

    /// The share of the light that the edges of pixels send into directions that differ by more than q along an axis.
    ///
    /// A step of the amplitude by Δ sends λ|Δ|²/(4π²q²) dq to either side for each length of edge (`edge_diffraction`), and
    /// there is one edge in each pitch.
    fn sent_by_pixel_edges(&self, axis: usize, q: f64) -> f64 {
        let pixels = match &self.hop.from.kind {
            ScreenKind::Doe(doe) => doe.pixels().filter(|pixels| pixels.form == PixelForm::Box),
            ScreenKind::Stop(_) | ScreenKind::Sensor(_) => None,
        };
        pixels.map_or(0.0, |pixels| {
            let of_edge = self.hop.wavelength / (2.0 * PI * PI * q * pixels.pitch[axis]);
            of_edge * mean_step(&pixels.values, axis)
        })
    }

    /// Values that one beamlet is summed over.
    fn values(&self, at: [f64; 2], p: [f64; 2], sigma: f64, spacing: [f64; 2]) -> f64 {
        let Ok(arrival) = launch_beamlet(self.hop, at, p, sigma) else {
            return 0.0;
        };
        let reach = arrival.footprint(self.hop.wavenumber(), self.settings.footprint_edge());
        let along = |a: usize| {
            let low = (arrival.at[a] - reach[a]).max(self.to[2 * a]);
            let high = (arrival.at[a] + reach[a]).min(self.to[2 * a + 1]);
            (high - low).max(0.0) / spacing[a]
        };
        // An ellipse fills this much of its box.
        std::f64::consts::FRAC_PI_4 * along(0) * along(1)
    }
}

/// The mean of |Δ|² between neighbouring pixels along an axis, x first, over that of their own energy; of at most
/// [`STEPS`] pairs of them about.
fn mean_step(values: &Array2<Complex64>, axis: usize) -> f64 {
    let (rows, columns) = values.dim();
    let next = [[0, 1], [1, 0]][axis];
    let side = STEPS.isqrt();
    let rows = (0..rows).step_by(rows.div_ceil(side).max(1));
    let pairs = rows.flat_map(|j| {
        (0..columns)
            .step_by(columns.div_ceil(side).max(1))
            .map(move |i| [j, i])
    });
    let (mut step, mut energy) = (0.0, 0.0);
    for [j, i] in pairs {
        let here = values[[j, i]];
        if let Some(beside) = values.get([j + next[0], i + next[1]]) {
            step += (here - beside).norm_sqr();
            energy += here.norm_sqr();
        }
    }
    if energy > 0.0 { step / energy } else { 0.0 }
}

/// At most `parts` indices below `count`, evenly spread: the middles of as many equal parts.
fn spread(count: usize, parts: usize) -> impl Iterator<Item = usize> + Clone {
    let parts = count.min(parts);
    (0..parts).map(move |i| (2 * i + 1) * count / (2 * parts))
}
