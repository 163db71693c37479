//! Plane wavelets with prefactor: the second way to carry a field by rays.
//!
//! The field is cut by windows that add up to one, each patch is split into plane waves, and each ray
//! brings an infinite plane wave of the ray's direction, with the amplitude √det(D + ikσ²C) that makes
//! the sum over overlapping windows right behind surfaces with power. The sum is a non-uniform FFT, so
//! it is the cheap choice for large screens and nearly unit magnification; beamlets need fewer rays.
//!
//! Two lattices have copies that must not reach the target: windows `step` apart send copies
//! λ/(C·step) beside the target; a patch period P sends copies P/D away when there is no power, and
//! where there is they are damped by the windows' overlap as exp(−P²/2(σ² + (μ/kσ)²)), μ an eigenvalue
//! of C⁻¹D along which the copy lies. The aberration inside one wavelet is not corrected: where a beamlet
//! plan has the correction, beamlets are more accurate.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::beamlet::beamlet_launch::launch_beamlet;
use crate::engine::beamlet::beamlet_plan::{Planner, sample_rays};
use crate::engine::beamlet::starting_width::starting_width;
use crate::engine::error::tally::{Fate, Tally};
use crate::engine::plan::settings::Settings;
use crate::engine::progress::{Cancelled, ShareDone};
use crate::engine::trace::direction_search::{
    DirectionSearch, SearchGoal, SearchRay, search_directions,
};
use crate::optics::ray::Loss;
use crate::optics::system::Hop;
use crate::wave::beamlet::plane::{PlaneSum, PlaneWave};
use crate::wave::grid::field::{Axis, Field};
use crate::wave::patches::patch::{Band, Patches, Spectrum};
use crate::wave::patches::window::Positions;

/// The lattice of a sum of plane wavelets.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanePlan {
    /// Width σ of the windows in mm.
    pub sigma: f64,
    /// Distance of windows along x and y, in mm.
    pub step: [f64; 2],
    /// Period of a patch in mm.
    pub period: f64,
    /// Directions along x and y.
    pub bands: [Band; 2],
    /// Rays that land up to this far beside the target count in full, in mm.
    pub margin: f64,
    /// Over this distance further out they fade to nothing, along x and y, in mm.
    pub fade: [f64; 2],
    /// The target, `[x_min, x_max, y_min, y_max]` in mm.
    pub target: [f64; 4],
    /// Largest optical direction cosines on the receiving screen, along x and y.
    pub arriving: [f64; 2],
    /// Rays that the plan expects.
    pub rays: f64,
}

/// Windows are cut at this many σ: their tails there are below 1e-4.
const REACH: f64 = 4.5;

/// Margin and fade in footprints of a beamlet, behind power. Measured on a hologram and a lens: half a
/// margin costs five times the error, twice the fade twice the rays for no smaller one.
const MARGIN: f64 = 0.8;
const FADE: f64 = 0.3;

/// Rays of a chunk: the unit of the sum.
const CHUNK: usize = 1 << 19;

/// Bytes that a ray of a chunk takes, with its copies and its place in the sum; and the share of the memory that a
/// chunk may have.
const RAY_BYTES: usize = 600;
const CHUNK_SHARE: usize = 2;

/// Memory that chunks do not exceed, whatever the limit: sums over other chunks differ in their last bits.
const CHUNK_MEMORY: usize = 1 << 30;

/// Distance of windows in σ where it is not given.
const STEP: f64 = 1.5;

/// What the train does to the sample rays: the largest entries of the blocks of their Jacobians.
struct Blocks {
    /// |∂s/∂x|.
    a: [[f64; 2]; 2],
    /// |∂p′/∂x|.
    c: [[f64; 2]; 2],
    /// |∂p′/∂p|.
    d: [[f64; 2]; 2],
    /// The largest eigenvalue of C⁻¹D, in mm; infinite when some direction has no power.
    reach: f64,
}

impl Blocks {
    fn new(sample_rays: &[SearchRay]) -> Self {
        let block = |row: usize, column: usize| {
            let entry = |a: usize, b: usize| {
                let size = |ray: &SearchRay| ray.jacobian[row + a][column + b].abs();
                sample_rays.iter().map(size).fold(0.0, f64::max)
            };
            [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
        };
        Self {
            a: block(0, 0),
            c: block(2, 0),
            d: block(2, 2),
            reach: sample_rays.iter().map(reach).fold(0.0, f64::max),
        }
    }
}

/// The largest eigenvalue of C⁻¹D of one ray, by modulus; the matrix is symmetric as J is symplectic.
fn reach(ray: &SearchRay) -> f64 {
    let [_, _, [a, b, p, q], [c, d, r, s]] = ray.jacobian;
    let determinant = a * d - b * c;
    if determinant == 0.0 {
        return f64::INFINITY;
    }
    let (xx, xy, yy) = (d * p - b * r, d * q - b * s, a * s - c * q);
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    (mean.abs() + half.hypot(xy)) / determinant.abs()
}

/// Σ_a m_ab·s_a for both b.
fn columns(m: [[f64; 2]; 2], s: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|b| m[0][b] * s[0] + m[1][b] * s[1])
}

impl PlanePlan {
    /// Chooses windows and directions, given the rays that reach the target.
    pub(crate) fn new(planner: &Planner, search: &DirectionSearch) -> Self {
        let (settings, hop) = (planner.settings, planner.hop);
        let sample_rays = sample_rays(search);
        let sigma = settings
            .sigma
            .unwrap_or_else(|| starting_width(planner.hop, planner.from, &sample_rays));
        let blocks = Blocks::new(&sample_rays);
        let [x0, x1, y0, y1] = planner.to;
        let width = [x1 - x0, y1 - y0];

        // With power, copies by the period are damped, least where C⁻¹D is largest.
        let inverse = blocks.reach / (hop.wavenumber() * sigma);
        let damped =
            settings.patch_period() * sigma.hypot(inverse) * std::f64::consts::FRAC_1_SQRT_2;
        let footprint = planner.arrival(&sample_rays, sigma).footprint;

        // Without, they must pass beside the target; directions fade out before they do.
        let spread = blocks.a.map(|row| row[0] + row[1]);
        let window = REACH * sigma * spread[0].max(spread[1]).max(1.0);
        let clear = width.map(|w| 2.0 * w + 4.0 * window);
        let [px, py] = columns(blocks.d, clear);
        let free = px.max(py);

        let (period, margin, fade) = if damped < free {
            (damped, MARGIN * footprint, [FADE * footprint; 2])
        } else {
            (free, window, width.map(|w| w + 2.0 * window))
        };
        let apart = [0, 1].map(|a| width[a] + 2.0 * (margin + fade[a]));
        let alias = columns(blocks.c, apart);
        let step = alias.map(|c| (settings.step.unwrap_or(STEP) * sigma).min(hop.wavelength / c));
        Self {
            sigma,
            step,
            period,
            bands: planner.bands(search, period),
            margin,
            fade,
            target: planner.to,
            arriving: [0.0; 2],
            rays: 0.0,
        }
        .with_directions(planner)
    }

    /// The plan with the directions that lead to the target and its margin.
    fn with_directions(mut self, planner: &Planner) -> Self {
        let margin = self.fade.map(|fade| self.margin + fade);
        let (hop, from, to) = (planner.hop, planner.from, planner.to);
        let wider = search_directions(hop, from, to, margin, SearchGoal::Rays);
        self.bands = planner.bands(&wider, self.period);
        for ray in wider.rays.iter().chain(&wider.rim) {
            for a in 0..2 {
                self.arriving[a] = self.arriving[a].max(ray.landing.cosines[a].abs());
            }
        }
        let [x0, x1, y0, y1] = planner.from;
        let [windows_x, windows_y] = [
            self.positions([x0, x1], self.step[0]),
            self.positions([y0, y1], self.step[1]),
        ];
        let [px, py] = self.bands;
        let counts = [windows_x.count, windows_y.count, px.count, py.count];
        self.rays = counts.map(|count| count as f64).iter().product();
        self
    }

    fn positions(&self, edges: [f64; 2], step: f64) -> Positions {
        Positions::covering(edges, self.sigma, step, REACH * self.sigma).plain()
    }

    /// The weight of a ray that lands at a point: one on the target and its margin, fading beyond.
    fn weight(&self, at: [f64; 2]) -> f64 {
        let along = |a: usize| {
            let (low, high) = (self.target[2 * a], self.target[2 * a + 1]);
            let beside = (low - at[a]).max(at[a] - high) - self.margin;
            let t = (beside / self.fade[a]).clamp(0.0, 1.0);
            1.0 - t * t * t * (10.0 - 15.0 * t + 6.0 * t * t)
        };
        along(0) * along(1)
    }
}

/// A hop by plane wavelets, with its plan.
pub(crate) struct PlaneRun<'a> {
    hop: Hop<'a>,
    plan: &'a PlanePlan,
    field: &'a Field,
    patches: Patches,
    /// Modes weaker than this are not followed.
    floor: f64,
    /// The most rays of a chunk.
    most: usize,
}

impl<'a> PlaneRun<'a> {
    /// Of the field behind the first screen.
    pub(crate) fn new(
        hop: Hop<'a>,
        plan: &'a PlanePlan,
        settings: &Settings,
        field: &'a Field,
    ) -> Self {
        let positions = |axis: &Axis, a: usize| plan.positions(axis.edges(), plan.step[a]);
        let (px, py) = (positions(&field.grid.x, 0), positions(&field.grid.y, 1));
        let [bx, by] = &plan.bands;
        let patches = Patches::new(
            [&field.grid.x, &field.grid.y],
            [&px, &py],
            [bx, by],
            hop.wavenumber(),
            plan.period,
        );
        let mut run = Self {
            hop,
            plan,
            field,
            patches,
            floor: 0.0,
            most: (settings.memory_limit.min(CHUNK_MEMORY) / (CHUNK_SHARE * RAY_BYTES)).max(1),
        };
        run.floor = run.strongest() * settings.weakest_mode();
        run
    }

    /// The strongest mode, from patches about one σ apart: neighbours are nearly alike.
    fn strongest(&self) -> f64 {
        let [nx, ny] = self.patches.shape();
        let stride = self
            .plan
            .step
            .map(|step| (self.plan.sigma / step).floor().max(1.0) as usize);
        let peak = |spectrum: Spectrum| {
            let square = |c: &Complex64| c.norm_sqr();
            let all = spectrum.coefficients.iter().map(square);
            all.fold(0.0, f64::max)
        };
        let columns: Vec<usize> = (0..nx).step_by(stride[0]).collect();
        let strongest = |&jx: &usize| {
            let strip = self.patches.strip(self.field, jx);
            (0..ny)
                .step_by(stride[1])
                .filter_map(|jy| self.patches.cut_strip(&strip, jy))
                .map(peak)
                .fold(0.0, f64::max)
        };
        columns
            .par_iter()
            .map(strongest)
            .reduce(|| 0.0, f64::max)
            .sqrt()
    }

    /// Adds what the field brings to the receiving screen. Runs in chunks of about [`CHUNK`] rays on the current rayon
    /// pool; the sum has the same bits for any number of threads.
    ///
    /// # Errors
    /// When `progress` cancels the work.
    pub(crate) fn carry(
        &self,
        to: &mut PlaneSum,
        progress: &ShareDone,
    ) -> Result<Tally, Cancelled> {
        let [nx, ny] = self.patches.shape();
        let directions = self.plan.bands[0].count * self.plan.bands[1].count;
        let rays = CHUNK.max(to.samples()).min(self.most);
        let chunk = (rays / directions.max(1)).max(1);
        let strips = (chunk / ny.max(1)).max(1);
        let mut tally = Tally::default();
        for first in (0..nx).step_by(strips) {
            let strips: Vec<_> = (first..nx.min(first + strips))
                .into_par_iter()
                .map(|jx| self.patches.strip(self.field, jx))
                .collect();
            let total = strips.len() * ny;
            for start in (0..total).step_by(chunk) {
                let parts: Vec<(Vec<PlaneWave>, Tally)> = (start..total.min(start + chunk))
                    .into_par_iter()
                    .filter_map(|i| self.patches.cut_strip(&strips[i / ny], i % ny))
                    .map(|spectrum| self.spread(&spectrum))
                    .collect();
                let mut waves = Vec::new();
                for (part, counts) in parts {
                    waves.extend(part);
                    tally.merge(&counts);
                }
                to.add(&waves);
            }
            Cancelled::check(progress((first + strips.len()) as f64 / nx as f64))?;
        }
        Ok(tally)
    }

    /// The plane waves that one patch brings to the target.
    fn spread(&self, spectrum: &Spectrum) -> (Vec<PlaneWave>, Tally) {
        let [bx, by] = &self.plan.bands;
        let mut tally = Tally::default();
        let mut waves = Vec::new();
        let mut within = 0.0;
        for ((my, mx), c) in spectrum.coefficients.indexed_iter() {
            let energy = c.norm_sqr();
            within += energy;
            if energy < self.floor * self.floor || energy == 0.0 {
                tally.add_energy(Fate::Weak, energy);
                continue;
            }
            let fate = match self.follow(spectrum.centre, [bx.at(mx), by.at(my)]) {
                Ok(mut wave) => {
                    wave.amplitude *= c;
                    waves.push(wave);
                    Fate::Arrived
                }
                Err(fate) => fate,
            };
            tally.count(fate, energy);
        }
        tally.add_energy(Fate::Elsewhere, (spectrum.energy - within).max(0.0));
        (waves, tally)
    }

    /// Follows one ray to the target.
    fn follow(&self, at: [f64; 2], p: [f64; 2]) -> Result<PlaneWave, Fate> {
        if p[0].hypot(p[1]) >= self.hop.from.index_behind() {
            return Err(Fate::Lost(Loss::Evanescent));
        }
        let beamlet = launch_beamlet(&self.hop, at, p, self.plan.sigma).map_err(Fate::Lost)?;
        let weight = self.plan.weight(beamlet.at);
        if weight == 0.0 {
            return Err(Fate::Outside);
        }
        let mut wave = PlaneWave::from_beamlet(&beamlet);
        wave.amplitude *= weight;
        Ok(wave)
    }
}
