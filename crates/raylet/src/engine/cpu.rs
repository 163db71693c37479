//! The backend of the machine's own cores.
//!
//! Patches are taken in chunks of fixed size: their spectra and rays in parallel, then the sum over the
//! chunk in parallel over rows. Memory is one chunk of arrivals, whatever the number of rays, and the
//! result has the same bits for any number of threads.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::backend::{Backend, Job};
use crate::engine::beamlets::{MARGIN, TRUSTED_TAIL, launch_from};
use crate::engine::census::Census;
use crate::engine::fan::reach;
use crate::engine::look::Looks;
use crate::engine::seat::Seat;
use crate::engine::tally::{Fate, Tally};
use crate::optics::ray::Loss;
use crate::wave::curved::CurvedPatches;
use crate::wave::field::Field;
use crate::wave::gather::Canvas;
use crate::wave::heights::Heights;
use crate::wave::patch::{Patches, Spectrum};
use crate::wave::wavelet::Arrival;
use crate::wave::window::Positions;

/// This machine's cores, through the current rayon pool.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cpu;

/// Directions of a chunk of patches.
const CHUNK: usize = 1 << 18;

impl Backend for Cpu {
    fn patches(&self, job: &Job, from: &Field) -> usize {
        let [x, y] = positions(job, from);
        x.count * y.count
    }

    fn carry(
        &self,
        job: &Job,
        from: &Field,
        patches: Range<usize>,
        to: &mut Canvas,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Tally {
        let k = job.hop.wavenumber();
        let cutter = Cutter::new(job, from);

        // What all patches hold decides which modes are too weak, also for a part of them.
        let kept = cutter.keep();
        let census = cutter.census(&kept);
        let strength = Strength {
            floor: census.floor(job.settings),
            total: census.total(),
        };

        let chunk = (CHUNK / cutter.most_modes().max(1)).max(1);
        let total = patches.len().max(1);
        let mut tally = Tally::default();
        let mut done = 0;
        while done < patches.len() {
            let first = patches.start + done;
            let last = (first + chunk).min(patches.end);
            let parts: Vec<(Vec<Arrival>, Tally)> = (first..last)
                .into_par_iter()
                .filter_map(|index| {
                    cutter.with(&kept, index, |s| spread(job, (index, s), strength, to))
                })
                .collect();
            let mut arrivals = Vec::new();
            for (part, counts) in parts {
                arrivals.extend(part);
                tally.merge(&counts);
            }
            tally.evaluations += to.add(&arrivals, k, job.settings.footprint_edge());
            done = last - patches.start;
            progress(done as f64 / total as f64);
        }
        tally
    }
}

/// What cuts the field of a job into patches: on a curved screen on its true surface.
struct Cutter<'a> {
    job: &'a Job<'a>,
    field: &'a Field,
    patches: Patches,
    heights: Option<Heights>,
}

/// The spectra of all patches, where they fit into memory.
type Kept = Option<Vec<Option<Spectrum>>>;

impl<'a> Cutter<'a> {
    fn new(job: &'a Job<'a>, field: &'a Field) -> Self {
        let [px, py] = positions(job, field);
        let [bx, by] = &job.plan.bands;
        let axes = [&field.grid.x, &field.grid.y];
        let k = job.hop.wavenumber();
        let from = job.hop.from;
        Self {
            job,
            field,
            patches: Patches::new(axes, [&px, &py], [bx, by], k, job.plan.period),
            heights: (!from.is_plane()).then(|| Heights::on(from, &field.grid)),
        }
    }

    /// Most modes of a patch.
    fn most_modes(&self) -> usize {
        let [bx, by] = &self.job.plan.bands;
        bx.count * by.count
    }

    /// The directions of one patch that may lead to the target, as indices in the bands.
    fn modes(&self, index: usize) -> Option<[Range<usize>; 2]> {
        let hop = &self.job.hop;
        let margin = [MARGIN * self.job.plan.footprint; 2];
        let at = self.patches.place(index).centre;
        let [x0, x1, y0, y1] = reach(hop, at, hop.to.bounds()?, margin)?;
        let [bx, by] = &self.job.plan.bands;
        Some([bx.within(x0, x1), by.within(y0, y1)])
    }

    /// The spectrum of one patch.
    fn cut(&self, index: usize) -> Option<Spectrum> {
        // A patch from which nothing reaches the target has no modes to follow, but its energy counts.
        let modes = self.modes(index).unwrap_or([0..0, 0..0]);
        let dark = modes.iter().any(Range::is_empty);
        let Some(heights) = self.heights.as_ref().filter(|_| !dark) else {
            return self.patches.cut_within(self.field, index, &modes);
        };
        let [bx, by] = &self.job.plan.bands;
        let curved = CurvedPatches {
            patches: &self.patches,
            screen: self.job.hop.from,
            heights,
            origin: [0.0; 2],
            bands: [bx, by],
            k: self.job.hop.wavenumber(),
        };
        curved.cut_within(self.field, index, &modes)
    }

    /// All spectra, if they fit: they are looked at twice.
    fn keep(&self) -> Kept {
        let needed = self.patches.count().saturating_mul(self.most_modes());
        (needed <= self.job.settings.samples_allowed()).then(|| {
            let all = (0..self.patches.count()).into_par_iter();
            all.map(|index| self.cut(index)).collect()
        })
    }

    /// What is made of the spectrum of one patch, kept or cut anew.
    fn with<T>(&self, kept: &Kept, index: usize, then: impl FnOnce(&Spectrum) -> T) -> Option<T> {
        match kept {
            Some(all) => all[index].as_ref().map(then),
            None => self.cut(index).as_ref().map(then),
        }
    }

    fn census(&self, kept: &Kept) -> Census {
        let count = |spectrum: &Spectrum| Census::of(spectrum.coefficients.iter());
        (0..self.patches.count())
            .into_par_iter()
            .filter_map(|index| self.with(kept, index, count))
            .reduce(Census::default, Census::merge)
    }
}

fn positions(job: &Job, from: &Field) -> [Positions; 2] {
    let reach = 0.5 * job.plan.period;
    let axis = |axis: &crate::wave::field::Axis| {
        Positions::cover(axis.edges(), job.plan.sigma, job.plan.step, reach)
    };
    [axis(&from.grid.x), axis(&from.grid.y)]
}

/// What the modes of all patches hold.
#[derive(Clone, Copy)]
struct Strength {
    /// The energy below which modes are left out.
    floor: f64,
    /// The energy of all.
    total: f64,
}

/// The beamlets of one patch, given with its number, that reach the target.
fn spread(
    job: &Job,
    (patch, spectrum): (usize, &Spectrum),
    strength: Strength,
    to: &Canvas,
) -> (Vec<Arrival>, Tally) {
    let mut tally = Tally::default();
    let mut arrivals = Vec::new();
    let mut within = 0.0;
    let Ok(seat) = Seat::new(job.hop.from, spectrum.centre) else {
        tally.add_energy(Fate::Lost(Loss::Missed), spectrum.energy);
        return (arrivals, tally);
    };
    let mut looks = Looks::new(job, patch, spectrum.centre, strength.total);
    for ((my, mx), c) in spectrum.coefficients.indexed_iter() {
        let energy = c.norm_sqr();
        within += energy;
        if energy < strength.floor || energy == 0.0 {
            tally.add_energy(Fate::Weak, energy);
            continue;
        }
        let mode = [spectrum.first[0] + mx, spectrum.first[1] + my];
        let fate = match follow(job, &seat, mode, *c, to, &mut looks, &mut tally) {
            Ok(arrival) => {
                arrivals.push(arrival);
                Fate::Arrived
            }
            Err(fate) => fate,
        };
        tally.count(fate, energy);
    }
    tally.add_energy(Fate::Elsewhere, (spectrum.energy - within).max(0.0));
    (arrivals, tally)
}

/// Follows one beamlet to the target.
fn follow(
    job: &Job,
    seat: &Seat,
    mode: [usize; 2],
    coefficient: Complex64,
    to: &Canvas,
    looks: &mut Looks,
    tally: &mut Tally,
) -> Result<Arrival, Fate> {
    let k = job.hop.wavenumber();
    let [bx, by] = &job.plan.bands;
    let p = [bx.at(mode[0]), by.at(mode[1])];
    let mut arrival = launch_from(seat, &job.hop, p, job.plan.sigma).map_err(Fate::Lost)?;
    let edge = job.settings.footprint_edge();
    if !to.meets(&arrival, k, edge) {
        return Err(Fate::Outside);
    }
    arrival.amplitude *= coefficient;

    // The aberration inside the beamlet: made good, or only looked at for the error budget.
    let beside = !to.contains(arrival.at);
    let energy = coefficient.norm_sqr();
    let needed = job.plan.correct || (beside && job.plan.doubtful_rim);
    let (found, stands_for) = match needed {
        true => (looks.between(mode), 1.0),
        false => match looks.drawn(mode, energy) {
            Some(stands_for) => (looks.at(mode), stands_for),
            None => return Ok(arrival),
        },
    };
    if needed && beside && found.is_none_or(|found| found.eta() > TRUSTED_TAIL) {
        return Err(Fate::Unresolved);
    }
    if job.beyond.is_wanted(arrival.at, arrival.cosines) {
        tally.look(found, stands_for * energy * to.share(&arrival, k, edge));
    }
    if let Some(found) = found
        && job.plan.correct
    {
        arrival.amplitude *= found.correction();
    }
    Ok(arrival)
}
