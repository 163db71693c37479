//! The aberration of a patch's beamlets, and which of them are sampled when it is not corrected.
//!
//! A sample costs tens of rays, so few beamlets get one. They are drawn with a chance in proportion to their
//! energy and count for its inverse, so that sums over them are those over all on average, whatever few modes
//! the light is in.

use std::collections::HashMap;

use crate::engine::beamlet::beamlet_aberration::{Aberration, aberration};
use crate::engine::chain::backend::Job;
use crate::math::random::{Purpose, uniform};

/// Samples among the beamlets of all patches, about.
const SAMPLES: f64 = 5000.0;

/// Modes between neighbouring nodes of the aberration's interpolation.
const NODE_SPACING: usize = 4;

/// The samples of one patch.
pub(crate) struct AberrationSamples<'a> {
    job: &'a Job<'a>,
    patch: usize,
    centre: [f64; 2],
    /// Energy of a beamlet that is surely sampled.
    sure: f64,
    /// The aberration on a coarse lattice of modes.
    nodes: HashMap<[usize; 2], Option<Aberration>>,
}

impl<'a> AberrationSamples<'a> {
    /// Of the patch of this number and centre, where the beamlets of all patches have `total` energy.
    pub(crate) fn new(job: &'a Job<'a>, patch: usize, centre: [f64; 2], total: f64) -> Self {
        Self {
            job,
            patch,
            centre,
            sure: total / SAMPLES,
            nodes: HashMap::new(),
        }
    }

    /// For how many beamlets like it a mode with this energy stands; nothing when it is not sampled.
    pub(crate) fn drawn(&self, mode: [usize; 2], energy: f64) -> Option<f64> {
        let chance = energy / self.sure;
        let address = [
            mode[0] as u32,
            self.patch as u32,
            mode[1] as u32,
            Purpose::AberrationSample as u32,
        ];
        (uniform(self.job.settings.seed, address) < chance).then(|| 1.0 / chance.min(1.0))
    }

    /// The aberration of one mode between those of four nodes, for it is a smooth function of direction; by
    /// its own rays where a node has none.
    pub(crate) fn between(&mut self, mode: [usize; 2]) -> Option<Aberration> {
        let low = mode.map(|m| m - m % NODE_SPACING);
        let t = mode.map(|m| (m % NODE_SPACING) as f64 / NODE_SPACING as f64);
        let mut total = Aberration::default();
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weight = |d: usize, t: f64| if d == 1 { t } else { 1.0 - t };
            let share = weight(dx, t[0]) * weight(dy, t[1]);
            if share == 0.0 {
                continue;
            }
            let node = [low[0] + dx * NODE_SPACING, low[1] + dy * NODE_SPACING];
            match self.node(node) {
                Some(found) => {
                    total.cubic += share * found.cubic;
                    total.quartic += share * found.quartic;
                    total.lattice += share * found.lattice;
                }
                None => return self.at(mode),
            }
        }
        Some(total)
    }

    fn node(&mut self, mode: [usize; 2]) -> Option<Aberration> {
        if let Some(known) = self.nodes.get(&mode) {
            return *known;
        }
        let found = self.at(mode);
        self.nodes.insert(mode, found);
        found
    }

    /// The aberration of one mode by its own rays.
    pub(crate) fn at(&self, mode: [usize; 2]) -> Option<Aberration> {
        let [bx, by] = &self.job.plan.bands;
        let p = [bx.at(mode[0]), by.at(mode[1])];
        let hop = self.job.chooser();
        aberration(hop, self.centre, p, self.job.plan.sigma, hop.wavenumber())
    }
}
