//! The plan of the source paper's method: where patches stand, and which modes they have.

use crate::engine::beamlet::beamlet_plan::Planner;
use crate::engine::monte_carlo::tangent_patch::TangentPatch;
use crate::engine::plan::settings::{Density, Positions, Sag, Sampler};
use crate::engine::trace::direction_search::{ALL, SearchGoal, search_directions};
use crate::math::random::{Purpose, pair};
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::Hop;
use crate::wave::patches::patch::Band;
use crate::wave::patches::tile::{Tile, TileWindow};

/// The plan of a hop by the method of the source paper: positions of patches, and modes to draw at each.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperPlan {
    /// Number of positions.
    pub positions: usize,
    /// Rule by which positions are chosen.
    pub rule: Positions,
    /// Columns and rows of the rules that have a grid.
    pub cells: [usize; 2],
    /// Box of the positions, `[x_min, x_max, y_min, y_max]` in mm.
    pub area: [f64; 4],
    /// Whether the field is divided by the sum of the windows over it.
    pub coverage: bool,
    /// Number of modes drawn at each position.
    pub secondary: usize,
    /// Probability of a mode.
    pub density: Density,
    /// Rule by which modes are drawn: all, with or without replacement.
    pub sampler: Sampler,
    /// Side of the square patch, in mm.
    pub side: f64,
    /// Window by which the field in a patch is multiplied.
    pub window: TileWindow,
    /// Period of the modes of a patch, in mm.
    pub period: f64,
    /// Lattice of modes along x and y, as rates on the screen's local plane; those that do not propagate
    /// are never drawn.
    pub bands: [Band; 2],
    /// Use of the height of a curved screen over its tangent plane.
    pub sag: Sag,
    /// Normal cosine of the incident light, with its sign.
    pub along: f64,
    /// Whether each wave is multiplied by the cosine of its direction on the receiving screen.
    pub obliquity: bool,
    /// Largest optical direction cosines on the receiving screen, along x and y.
    pub arriving: [f64; 2],
}

/// The address of the random numbers of a hop.
#[derive(Clone, Copy, Debug)]
pub struct DrawAddress {
    /// Seed of the run.
    pub seed: u64,
    /// Number of the hop.
    pub hop: u32,
}

impl PaperPlan {
    /// The plan that follows from the settings.
    pub(crate) fn new(planner: &Planner) -> Self {
        let (hop, settings) = (planner.hop, &planner.settings.paper);
        let [x0, x1, y0, y1] = planner.from;
        let side = settings.patch.unwrap_or(0.25 * (x1 - x0).min(y1 - y0));
        let period = side * settings.padding.max(1.0);
        let beside = match settings.positions {
            Positions::Inside | Positions::Grid => 0.0,
            Positions::Dilated | Positions::Jittered => 0.5 * side,
        };
        let area = [x0 - beside, x1 + beside, y0 - beside, y1 + beside];
        let (positions, cells) = match settings.positions {
            Positions::Inside | Positions::Dilated => (settings.rays, [settings.rays, 1]),
            Positions::Jittered | Positions::Grid => {
                let cells = grid(area, settings.rays);
                (cells[0] * cells[1], cells)
            }
        };
        let [px, py] = planner.light.chief;
        let n = hop.from.index_behind();
        let plan = Self {
            positions,
            rule: settings.positions,
            cells,
            area,
            coverage: settings.coverage,
            secondary: settings.secondary,
            density: settings.density,
            sampler: settings.sampler,
            side,
            window: settings.window,
            period,
            bands: lattice(planner, side, period),
            sag: settings.sag,
            along: hop.from.arrives * (n * n - px * px - py * py).max(0.0).sqrt(),
            obliquity: settings.obliquity,
            arriving: [0.0; 2],
        };
        Self {
            arriving: plan.reach(hop),
            ..plan
        }
    }

    /// The square patch at each position: side, window and period.
    pub fn tile(&self) -> Tile {
        Tile {
            side: self.side,
            window: self.window,
            period: self.period,
        }
    }

    /// The position of a patch.
    pub(crate) fn place(&self, patch: u32, DrawAddress { seed, hop }: DrawAddress) -> [f64; 2] {
        let [x0, x1, y0, y1] = self.area;
        let within = match self.rule {
            Positions::Grid => [0.5; 2],
            _ => pair(seed, [hop, patch, 0, Purpose::PatchPosition as u32]),
        };
        let (cell, cells) = match self.rule {
            Positions::Inside | Positions::Dilated => ([0; 2], [1; 2]),
            Positions::Jittered | Positions::Grid => {
                let columns = self.cells[0] as u32;
                ([patch % columns, patch / columns], self.cells)
            }
        };
        let share = [0, 1].map(|a| (f64::from(cell[a]) + within[a]) / cells[a] as f64);
        [x0 + (x1 - x0) * share[0], y0 + (y1 - y0) * share[1]]
    }

    /// One over the sum of windows that is expected at a point.
    pub fn share(&self) -> f64 {
        let [x0, x1, y0, y1] = self.area;
        (x1 - x0) * (y1 - y0) / (self.positions as f64 * self.side * self.side * self.window.mean())
    }

    /// Whether every position is drawn for itself, and the field not divided by what they cover together.
    pub(crate) fn is_independent(&self) -> bool {
        matches!(self.rule, Positions::Inside | Positions::Dilated) && !self.coverage
    }

    /// Rays of a patch, at most.
    pub(crate) fn rays_each(&self) -> usize {
        let modes = self.bands[0].count.saturating_mul(self.bands[1].count);
        match self.sampler {
            Sampler::All => modes,
            Sampler::Multinomial | Sampler::Systematic => self.secondary.min(modes),
        }
    }

    /// Rays that it expects; equal draws counted as often as they are drawn.
    pub(crate) fn rays(&self) -> f64 {
        let each = match self.sampler {
            Sampler::Multinomial => self.secondary,
            Sampler::Systematic | Sampler::All => self.rays_each(),
        };
        self.positions as f64 * each as f64
    }

    /// The largest direction cosines on arrival, from a coarse set of positions and modes.
    fn reach(&self, hop: &Hop) -> [f64; 2] {
        let [x0, x1, y0, y1] = self.area;
        let between = |low: f64, high: f64, i: usize, n: usize| {
            low + (high - low) * i as f64 / (n - 1) as f64
        };
        let ends = |a: usize| {
            let band = &self.bands[a];
            [band.at(0), band.at(band.count.max(1) - 1)]
        };
        let ([px0, px1], [py0, py1]) = (ends(0), ends(1));
        let mut reach = [0.0f64; 2];
        for place in 0..25 {
            let at = [between(x0, x1, place % 5, 5), between(y0, y1, place / 5, 5)];
            let Some(tangent_patch) = TangentPatch::new(hop.from, at, self.along) else {
                continue;
            };
            let (start, at) = tangent_patch.start(hop);
            for mode in 0..225 {
                let rates = [
                    between(px0, px1, mode % 15, 15),
                    between(py0, py1, mode / 15, 15),
                ];
                if let Some(p) = tangent_patch.cosines(rates)
                    && let Ok(landing) = start.trace(at, p, &mut ())
                {
                    reach = [0, 1].map(|a| reach[a].max(landing.cosines[a].abs()));
                }
            }
        }
        reach
    }
}

/// Columns and rows of about `count` cells, as square as they can be.
fn grid([x0, x1, y0, y1]: [f64; 4], count: usize) -> [usize; 2] {
    let columns = (count as f64 * (x1 - x0) / (y1 - y0))
        .sqrt()
        .round()
        .max(1.0);
    let rows = (count as f64 / columns).round().max(1.0);
    [columns as usize, rows as usize]
}

/// The modes of a patch: those of the FFT of its pixels, in the given number of bands; without
/// pixels those that lead to the target. Never beyond what propagates.
fn lattice(planner: &Planner, side: f64, period: f64) -> [Band; 2] {
    let hop = planner.hop;
    let spare = spare(hop.from);
    let pixels = match &hop.from.kind {
        ScreenKind::Doe(doe) => doe.pixels(),
        ScreenKind::Stop(_) | ScreenKind::Sensor(_) => None,
    };
    let Some(pixels) = pixels else {
        let (from, to, wanted) = (planner.from, planner.to, SearchGoal::Bounds(ALL));
        let mut search = search_directions(hop, from, to, [side; 2], wanted);
        for (a, spare) in spare.iter().enumerate() {
            search.band[2 * a] -= spare;
            search.band[2 * a + 1] += spare;
        }
        return planner.bands(&search, period);
    };
    [0, 1].map(|a| {
        let n = hop.from.index_behind() + spare[a];
        let orders = planner.settings.paper.orders.max(1) as f64;
        let half = 0.5 * orders * hop.wavelength / pixels.pitch[a];
        let centre = planner.light.chief[a];
        let (low, high) = ((centre - half).max(-n), (centre + half).min(n));
        // Like an FFT's, the band holds one of its two ends, whichever way rounding goes.
        let spacing = hop.wavelength / period;
        let [low, high] = [low, high].map(|p| p - 1e-9 * spacing);
        Band::between(centre, spacing, low, high)
    })
}

/// How much the rates on a screen may differ from direction cosines: its slope times the change of the
/// normal cosine there.
fn spare(screen: &Screen) -> [f64; 2] {
    let change = if screen.leaves() == screen.arrives {
        1.0
    } else {
        2.0
    };
    let slope = screen.relief().map_or([0.0; 2], |relief| relief.slope);
    slope.map(|s| s * change * screen.index)
}
