//! One beamlet of a patch aimed at the target: where it lands, what it looks like there, how far it is to be
//! believed. Nothing of this depends on the field.

use crate::engine::backend::Job;
use crate::engine::beamlets::{TRUSTED_TAIL, launch_from};
use crate::engine::budget::{Aberration, aberration};
use crate::engine::seat::Seat;
use crate::engine::tally::Fate;
use crate::optics::ray::Loss;
use crate::wave::gather::Canvas;
use crate::wave::wavelet::Arrival;

/// A beamlet that reaches the target.
pub struct Aimed {
    /// The beamlet of coefficient one, the correction of its aberration included.
    pub arrival: Arrival,
    /// Whether the aberration inside it was looked at.
    pub looked: bool,
    /// What was found; nothing where its neighbours are lost.
    pub found: Option<Aberration>,
}

/// Where the beamlets of a patch leave.
pub struct Seats {
    /// On the hop that was planned.
    seat: Seat,
    /// On the hop itself, if it is another one.
    moved: Option<Seat>,
}

impl Seats {
    /// The seat above (x, y) of the first screen of a job.
    ///
    /// # Errors
    /// [`Loss::Missed`] where a curved screen does not exist.
    pub fn new(job: &Job, at: [f64; 2]) -> Result<Self, Loss> {
        let moved = job.planned.map(|_| Seat::new(job.hop.from, at));
        Ok(Self {
            seat: Seat::new(job.chooser().from, at)?,
            moved: moved.transpose()?,
        })
    }

    /// The seat on the hop itself.
    pub fn seat(&self) -> &Seat {
        self.moved.as_ref().unwrap_or(&self.seat)
    }
}

/// Aims one beamlet; with `look` its aberration is looked at even if nothing depends on it.
///
/// # Errors
/// Its fate when it does not reach the target, or cannot be believed there.
pub fn aim(
    job: &Job,
    Seats { seat, moved }: &Seats,
    mode: [usize; 2],
    to: &Canvas,
    aberrations: &mut PatchAberration,
    look: bool,
) -> Result<Aimed, Fate> {
    let k = job.hop.wavenumber();
    let [bx, by] = &job.plan.bands;
    let p = [bx.at(mode[0]), by.at(mode[1])];
    let planned = job.chooser();
    let mut arrival = launch_from(seat, planned, p, job.plan.sigma).map_err(Fate::Lost)?;
    if !to.meets(&arrival, k, job.settings.footprint_edge()) {
        return Err(Fate::Outside);
    }

    // The aberration inside the beamlet: made good, or a reason to leave it out, or only looked at for the
    // error budget, which changes nothing.
    let beside = !to.contains(arrival.at);
    let judged = job.plan.correct || (beside && job.plan.doubtful_rim);
    let looked = judged || look;
    let found = if looked { aberrations.at(mode) } else { None };
    if judged && beside && found.is_none_or(|found| found.eta() > TRUSTED_TAIL) {
        return Err(Fate::Unresolved);
    }
    if let Some(moved) = moved {
        arrival = launch_from(moved, &job.hop, p, job.plan.sigma).map_err(Fate::Lost)?;
    }
    if let Some(found) = found
        && job.plan.correct
    {
        arrival.amplitude *= found.correction();
    }
    Ok(Aimed {
        arrival,
        looked,
        found,
    })
}

/// Modes between neighbouring nodes of the aberration's interpolation.
const NODE_SPACING: usize = 4;

/// The aberration of a patch's beamlets, found on a coarse lattice of its modes and interpolated: it is
/// a smooth function of direction.
pub struct PatchAberration<'a> {
    job: &'a Job<'a>,
    centre: [f64; 2],
    nodes: std::collections::HashMap<[usize; 2], Option<Aberration>>,
}

impl<'a> PatchAberration<'a> {
    /// That of the patch about a point of the first screen.
    pub fn new(job: &'a Job<'a>, centre: [f64; 2]) -> Self {
        Self {
            job,
            centre,
            nodes: std::collections::HashMap::new(),
        }
    }

    /// At one mode: bilinear between four nodes, or by its own rays where a node has none.
    pub fn at(&mut self, mode: [usize; 2]) -> Option<Aberration> {
        let low = mode.map(|m| m - m % NODE_SPACING);
        let t = mode.map(|m| (m % NODE_SPACING) as f64 / NODE_SPACING as f64);
        let (mut cubic, mut quartic) = (0.0, 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weight = |d: usize, t: f64| if d == 1 { t } else { 1.0 - t };
            let share = weight(dx, t[0]) * weight(dy, t[1]);
            if share == 0.0 {
                continue;
            }
            let node = [low[0] + dx * NODE_SPACING, low[1] + dy * NODE_SPACING];
            match self.node(node) {
                Some(found) => {
                    cubic += share * found.cubic;
                    quartic += share * found.quartic;
                }
                None => return self.look(mode),
            }
        }
        Some(Aberration { cubic, quartic })
    }

    fn node(&mut self, mode: [usize; 2]) -> Option<Aberration> {
        if let Some(known) = self.nodes.get(&mode) {
            return *known;
        }
        let found = self.look(mode);
        self.nodes.insert(mode, found);
        found
    }

    fn look(&self, mode: [usize; 2]) -> Option<Aberration> {
        let [bx, by] = &self.job.plan.bands;
        let p = [bx.at(mode[0]), by.at(mode[1])];
        let hop = self.job.chooser();
        aberration(hop, self.centre, p, self.job.plan.sigma, hop.wavenumber())
    }
}
