//! The backend of the machine's own cores.
//!
//! Patches are taken in chunks of fixed size: their spectra and rays in parallel, then the sum over the
//! chunk in parallel over rows. Memory is one chunk of arrivals, whatever the number of rays, and the
//! result has the same bits for any number of threads.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::backend::{Backend, Job};
use crate::engine::beamlets::{TRUSTED_TAIL, launch};
use crate::engine::budget::aberration;
use crate::engine::tally::{Fate, Tally};
use crate::optics::ray::Loss;
use crate::wave::field::Field;
use crate::wave::gather::Canvas;
use crate::wave::patch::{Patches, Spectrum};
use crate::wave::wavelet::Arrival;
use crate::wave::window::Positions;

/// This machine's cores, through the current rayon pool.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cpu;

/// Directions of a chunk of patches.
const CHUNK: usize = 1 << 18;

/// One in this many beamlets has its aberration looked at when it is not corrected.
const ESTIMATE_EVERY: usize = 97;

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
        let [bx, by] = &job.plan.bands;
        let [px, py] = positions(job, from);
        let cutter = Patches::new(
            [&from.grid.x, &from.grid.y],
            [&px, &py],
            [bx, by],
            k,
            job.plan.period,
        );

        // The strongest mode of all patches sets the threshold, also for a part of them.
        let strongest = (0..cutter.count())
            .into_par_iter()
            .filter_map(|index| cutter.cut(from, index))
            .map(|spectrum| peak(&spectrum))
            .reduce(|| 0.0, f64::max);
        let floor = strongest * job.settings.mode_threshold;

        let chunk = (CHUNK / (bx.count * by.count).max(1)).max(1);
        let total = patches.len().max(1);
        let mut tally = Tally::default();
        let mut done = 0;
        while done < patches.len() {
            let first = patches.start + done;
            let last = (first + chunk).min(patches.end);
            let parts: Vec<(Vec<Arrival>, Tally)> = (first..last)
                .into_par_iter()
                .filter_map(|index| cutter.cut(from, index))
                .map(|spectrum| spread(job, &spectrum, floor, to))
                .collect();
            let mut arrivals = Vec::new();
            for (part, counts) in parts {
                arrivals.extend(part);
                tally.merge(&counts);
            }
            tally.evaluations += to.add(&arrivals, k, job.settings.footprint_threshold);
            done = last - patches.start;
            progress(done as f64 / total as f64);
        }
        tally
    }
}

fn positions(job: &Job, from: &Field) -> [Positions; 2] {
    let reach = 0.5 * job.plan.period;
    let axis = |axis: &crate::wave::field::Axis| {
        Positions::cover(axis.edges(), job.plan.sigma, job.plan.step, reach)
    };
    [axis(&from.grid.x), axis(&from.grid.y)]
}

fn peak(spectrum: &Spectrum) -> f64 {
    let square = |c: &Complex64| c.norm_sqr();
    spectrum
        .coefficients
        .iter()
        .map(square)
        .fold(0.0, f64::max)
        .sqrt()
}

/// The beamlets of one patch that reach the target.
fn spread(job: &Job, spectrum: &Spectrum, floor: f64, to: &Canvas) -> (Vec<Arrival>, Tally) {
    let [bx, by] = &job.plan.bands;
    let mut tally = Tally::default();
    let mut arrivals = Vec::new();
    let mut within = 0.0;
    for ((my, mx), c) in spectrum.coefficients.indexed_iter() {
        let energy = c.norm_sqr();
        within += energy;
        if energy < floor * floor || energy == 0.0 {
            tally.add_energy(Fate::Weak, energy);
            continue;
        }
        let p = [bx.at(mx), by.at(my)];
        let number = my * bx.count + mx;
        let fate = match follow(job, spectrum.centre, p, *c, number, to, &mut tally) {
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
    at: [f64; 2],
    p: [f64; 2],
    coefficient: Complex64,
    number: usize,
    to: &Canvas,
    tally: &mut Tally,
) -> Result<Arrival, Fate> {
    let k = job.hop.wavenumber();
    let sigma = job.plan.sigma;
    if p[0].hypot(p[1]) >= job.hop.from.index {
        return Err(Fate::Lost(Loss::Evanescent));
    }
    let mut arrival = launch(&job.hop, at, p, sigma).map_err(Fate::Lost)?;
    if !to.meets(&arrival, k, job.settings.footprint_threshold) {
        return Err(Fate::Outside);
    }
    arrival.amplitude *= coefficient;

    // The aberration inside the beamlet: made good, or only looked at for the error budget.
    let beside = !to.contains(arrival.at);
    let doubtful = beside && job.plan.doubtful_rim;
    if job.plan.correct || doubtful || number.is_multiple_of(ESTIMATE_EVERY) {
        let energy = coefficient.norm_sqr();
        match aberration(&job.hop, at, p, sigma, k) {
            Some(found) => {
                let eta = found.eta();
                if beside && eta > TRUSTED_TAIL {
                    return Err(Fate::Unresolved);
                }
                if job.plan.correct {
                    arrival.amplitude *= found.correction();
                }
                tally.aberration[0] += energy * eta * eta;
                tally.cubic += energy * found.cubic.min(1.0);
            }
            None if beside => return Err(Fate::Unresolved),
            None => {
                tally.aberration[0] += energy;
                tally.cubic += energy;
            }
        }
        tally.aberration[1] += energy;
    }
    Ok(arrival)
}
