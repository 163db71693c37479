//! The backend of the machine's own cores.
//!
//! Patches are taken in chunks of fixed size: their spectra and rays in parallel, then the sum over the
//! chunk in parallel over rows. Memory is one chunk of arrivals, whatever the number of rays, and the
//! result has the same bits for any number of threads. `chain_dot_product_slow` in the crate's tests holds the way back.

use std::borrow::Cow;
use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::beamlet::aberration_sample::AberrationSamples;
use crate::engine::beamlet::beamlet_cache::PatchBeamlets;
use crate::engine::beamlet::beamlet_plan::MARGIN;
use crate::engine::beamlet::beamlet_target::{DiscardedBeamlet, LaunchPlanes, target_beamlet};
use crate::engine::beamlet::mode_histogram::ModeHistogram;
use crate::engine::chain::backend::{AdjointSums, Backend, Job};
use crate::engine::error::tally::{Fate, Tally};
use crate::engine::monte_carlo::mode_sampling::Drawing;
use crate::engine::progress::{Cancelled, ShareDone};
use crate::engine::trace::direction_search::reach;
use crate::engine::trace::ray_sensitivity::{BLOCK, PerturbedHops, VariedHop, pull};
use crate::math::part::part;
use crate::optics::ray::Loss;
use crate::wave::beamlet::beamlet_kernel::Moments;
use crate::wave::beamlet::beamlet_sum::Canvas;
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::field::Field;
use crate::wave::grid::heights::Heights;
use crate::wave::patches::curved::CurvedPatches;
use crate::wave::patches::patch::{Patches, Spectrum};
use crate::wave::patches::window::Positions;

/// This machine's cores, through the current rayon pool.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BeamletPropagation;

/// Directions of a chunk of patches.
const CHUNK: usize = 1 << 18;

impl Backend for BeamletPropagation {
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
        progress: &ShareDone,
    ) -> Result<Tally, Cancelled> {
        let k = job.hop.wavenumber();
        let cutter = Cutter::new(job, from);

        // What all patches hold decides which modes are too weak, also for a part of them.
        let kept = cutter.keep();
        let histogram = cutter.histogram(&kept);
        let strength = Strength {
            floor: histogram.floor(job.settings),
            total: histogram.total(),
        };

        let cached = cutter.cached(to);
        let one = |index: usize, spectrum: &Spectrum, to: &Canvas| match cached {
            _ if job.draws.is_some() => draw(job, index, spectrum, to),
            Some(all) => {
                let beamlets = all[index].as_ref();
                let lit = beamlets.map(|beamlets| lit(beamlets, spectrum, strength.floor));
                (lit.unwrap_or_default(), Tally::default())
            }
            None => spread(job, index, spectrum, strength, to),
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
                .filter_map(|index| cutter.with(&kept, index, |s| one(index, s, to)))
                .collect();
            let mut arrivals = Vec::new();
            for (part, counts) in parts {
                arrivals.extend(part);
                tally.merge(&counts);
            }
            tally.evaluations += to.add(&arrivals, k, job.settings.footprint_edge());
            done = last - patches.start;
            Cancelled::check(progress(done as f64 / total as f64))?;
        }
        Ok(tally)
    }

    fn carry_adjoint(
        &self,
        job: &Job,
        from: &Field,
        patches: Range<usize>,
        to_bar: &Canvas,
        back: &mut AdjointSums,
    ) -> Result<(), Cancelled> {
        let cutter = Cutter::new(job, from);
        let varied_hops = varied_hops(job, back.perturbed);
        let (mut kept, mut floor) = (None, 0.0);
        if job.draws.is_some() {
            kept = cutter.keep();
        } else if job.settings.weakest_mode() > 0.0 {
            kept = cutter.keep();
            floor = cutter.histogram(&kept).floor(job.settings);
        }

        // A patch's spectrum, which may have to be computed again, shows which of its beamlets are strong.
        let cached = cutter.cached(to_bar);
        let strong = |index: usize, spectrum: &Spectrum| {
            let is_strong = |place: [usize; 2]| spectrum.coefficients[place].norm_sqr() >= floor;
            match cached {
                Some(all) => all[index].as_ref().map(|all| all.only(is_strong)),
                None => beamlets(&cutter, index, to_bar, &is_strong),
            }
        };
        let one = |index: usize| match cached {
            _ if job.draws.is_some() => drawn(&cutter, &kept, index, to_bar).map(Cow::Owned),
            _ if floor > 0.0 => {
                let found = cutter.with(&kept, index, |spectrum| strong(index, spectrum));
                found.flatten().map(Cow::Owned)
            }
            Some(all) => all[index].as_ref().map(Cow::Borrowed),
            None => beamlets(&cutter, index, to_bar, &|_| true).map(Cow::Owned),
        };

        let chunk = (CHUNK / cutter.most_modes().max(1)).max(1);
        let mut done = 0;
        while done < patches.len() {
            // The beamlets of the way there, traced again unless they are kept.
            let first = patches.start + done;
            let last = (first + chunk).min(patches.end);
            let all: Vec<Cow<_>> = (first..last).into_par_iter().filter_map(one).collect();

            // canvas += amplitude·coefficient·beamlet
            let bars: Vec<(Array2<Complex64>, Vec<f64>)> = all
                .par_iter()
                .map(|beamlets| give_back(&cutter, &kept, beamlets, &varied_hops, to_bar))
                .collect();

            // Patches overlap: one after the other.
            for (beamlets, (bar, pulled)) in all.iter().zip(&bars) {
                let place = cutter.patches.place(beamlets.index);
                let mut part = part(back.from_bar.view_mut(), place.y, place.x);
                part += bar;
                for (total, part) in back.parameters.iter_mut().zip(pulled) {
                    *total += part;
                }
            }
            done = last - patches.start;
            Cancelled::check((back.pulse)())?;
        }
        Ok(())
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
        let hop = self.job.chooser();
        let margin = [MARGIN * self.job.plan.footprint; 2];
        let at = self.patches.place(index).centre;
        let plan = self.job.plan;
        let [x0, x1, y0, y1] = reach(hop, at, hop.to.bounds()?, margin, plan.limits())?;
        let [bx, by] = &plan.bands;
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
        self.curved(heights).cut_within(self.field, index, &modes)
    }

    /// The conjugate transpose of [`Cutter::cut`]: from some modes of a patch to the nodes under its window.
    fn cut_adjoint(
        &self,
        index: usize,
        modes: &[Range<usize>; 2],
        bar: &Array2<Complex64>,
    ) -> Array2<Complex64> {
        let place = self.patches.place(index);
        let nowhere = || Array2::zeros([place.y.len(), place.x.len()]);
        match &self.heights {
            None => self.patches.transform_adjoint(bar.view(), index, modes),
            Some(heights) => self
                .curved(heights)
                .cut_adjoint(self.field, index, modes, bar)
                .unwrap_or_else(nowhere),
        }
    }

    fn curved<'b>(&'b self, heights: &'b Heights) -> CurvedPatches<'b> {
        let [bx, by] = &self.job.plan.bands;
        CurvedPatches {
            patches: &self.patches,
            screen: self.job.hop.from,
            heights,
            origin: [0.0; 2],
            bands: [bx, by],
            k: self.job.hop.wavenumber(),
        }
    }

    /// All spectra, if they fit: they are looked at twice.
    fn keep(&self) -> Kept {
        let needed = self.patches.count().saturating_mul(self.most_modes());
        (needed <= self.job.settings.samples_allowed()).then(|| {
            let all = (0..self.patches.count()).into_par_iter();
            all.map(|index| self.cut(index)).collect()
        })
    }

    /// The result of the spectrum of one patch, which is kept or computed again.
    fn with<T>(&self, kept: &Kept, index: usize, then: impl FnOnce(&Spectrum) -> T) -> Option<T> {
        match kept {
            Some(all) => all[index].as_ref().map(then),
            None => self.cut(index).as_ref().map(then),
        }
    }

    /// The beamlets of all patches to a canvas, if they may be kept from run to run and fit.
    fn cached(&self, to: &Canvas) -> Option<&'a [Option<PatchBeamlets>]> {
        let cache = self.job.cache.filter(|_| self.job.draws.is_none())?;
        let (grid, raster) = (&self.field.grid, to.raster());
        if cache.is_new() {
            let all = 0..self.patches.count();
            let modes = |index: usize| self.modes(index).map_or(0, |[x, y]| x.len() * y.len());
            let most = all.clone().into_par_iter().map(modes).sum::<usize>();
            let fits =
                most.saturating_mul(PatchBeamlets::BYTES) <= self.job.settings.memory_limit / 8;
            let one = |index: usize| beamlets(self, index, to, &|_| true);
            let found = fits.then(|| all.into_par_iter().map(one).collect());
            cache.fill(grid, raster, found);
        }
        cache.of(grid, raster)
    }

    fn histogram(&self, kept: &Kept) -> ModeHistogram {
        let count = |spectrum: &Spectrum| ModeHistogram::of(spectrum.coefficients.iter());
        (0..self.patches.count())
            .into_par_iter()
            .filter_map(|index| self.with(kept, index, count))
            .reduce(ModeHistogram::default, ModeHistogram::merge)
    }
}

fn positions(job: &Job, from: &Field) -> [Positions; 2] {
    let reach = 0.5 * job.plan.period;
    let axis = |axis: &crate::wave::grid::field::Axis| {
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
    patch: usize,
    spectrum: &Spectrum,
    strength: Strength,
    to: &Canvas,
) -> (Vec<Arrival>, Tally) {
    let mut tally = Tally::default();
    let mut arrivals = Vec::new();
    let mut within = 0.0;
    let Ok(launch_planes) = LaunchPlanes::new(job, spectrum.centre) else {
        tally.add_energy(Fate::Lost(Loss::Missed), spectrum.energy);
        return (arrivals, tally);
    };
    let mut samples = AberrationSamples::new(job, patch, spectrum.centre, strength.total);
    for ((my, mx), c) in spectrum.coefficients.indexed_iter() {
        let energy = c.norm_sqr();
        within += energy;
        if energy < strength.floor || energy == 0.0 {
            tally.add_energy(Fate::Weak, energy);
            continue;
        }
        let mode = [spectrum.first[0] + mx, spectrum.first[1] + my];
        let fate = match follow(job, &launch_planes, mode, *c, to, &mut samples, &mut tally) {
            Ok(arrival) => {
                arrivals.push(arrival);
                Fate::Arrived
            }
            Err(discarded) => {
                tally.untrusted += energy * discarded.share;
                discarded.fate
            }
        };
        tally.count(fate, energy);
    }
    tally.add_energy(Fate::Elsewhere, (spectrum.energy - within).max(0.0));
    (arrivals, tally)
}

/// The drawn beamlets of one patch, given with its number, that reach the target.
fn draw(job: &Job, patch: usize, spectrum: &Spectrum, to: &Canvas) -> (Vec<Arrival>, Tally) {
    let mut tally = Tally::default();
    let mut arrivals = Vec::new();
    let (Some(draws), Ok(launch_planes)) =
        (job.draws_of(patch), LaunchPlanes::new(job, spectrum.centre))
    else {
        tally.add_energy(Fate::Lost(Loss::Missed), spectrum.energy);
        return (arrivals, tally);
    };
    let mut samples = AberrationSamples::new(job, patch, spectrum.centre, f64::INFINITY);
    let weights = draws.weights(&spectrum.coefficients);
    for ((place, weight), c) in weights.indexed_iter().zip(&spectrum.coefficients) {
        if *weight == 0.0 {
            continue;
        }
        let mode = [spectrum.first[0] + place.1, spectrum.first[1] + place.0];
        let fate = match target_beamlet(job, &launch_planes, mode, to, &mut samples) {
            Ok(beamlet) => {
                let mut arrival = beamlet.arrival;
                arrival.amplitude *= c * *weight;
                arrivals.push(arrival);
                Fate::Arrived
            }
            Err(discarded) => discarded.fate,
        };
        tally.count(fate, c.norm_sqr() * weight);
    }
    (arrivals, tally)
}

/// The beamlets of one patch that its draws need on the way back: those drawn, or all where each is compared.
fn drawn(cutter: &Cutter, kept: &Kept, index: usize, to: &Canvas) -> Option<PatchBeamlets> {
    let draws = cutter.job.draws_of(index)?;
    if let Drawing::Gumbel { .. } = draws.draws.drawing {
        return beamlets(cutter, index, to, &|_| true);
    }
    let weights = cutter.with(kept, index, |spectrum| {
        draws.weights(&spectrum.coefficients)
    })?;
    beamlets(cutter, index, to, &|place| weights[place] != 0.0)
}

/// Follows one beamlet to the target.
fn follow(
    job: &Job,
    launch_planes: &LaunchPlanes,
    mode: [usize; 2],
    coefficient: Complex64,
    to: &Canvas,
    samples: &mut AberrationSamples,
    tally: &mut Tally,
) -> Result<Arrival, DiscardedBeamlet> {
    let beamlet = target_beamlet(job, launch_planes, mode, to, samples)?;
    let mut arrival = beamlet.arrival;
    let energy = coefficient.norm_sqr();
    let seen = match beamlet.needed {
        true => Some((beamlet.found, 1.0)),
        false => {
            let drawn = samples.drawn(mode, energy);
            drawn.map(|stands_for| (samples.at(mode), stands_for))
        }
    };
    if let Some((found, stands_for)) = seen
        && job.downstream.is_relevant(arrival.at, arrival.cosines)
    {
        // The tail that falls on the target is more aberrated than the beamlet's middle.
        let tail = to.tail(&arrival, job.hop.wavenumber());
        let found = found.map(|found| found.at_distance(tail.distance));
        tally.add_aberration(found, stands_for * energy * tail.share);
    }
    arrival.amplitude *= coefficient;
    Ok(arrival)
}

/// The hop with its parameters, a block at a time.
fn varied_hops<'a>(job: &Job<'a>, perturbed: &[PerturbedHops<'a>]) -> Vec<VariedHop<'a>> {
    let blocks = perturbed.chunks(BLOCK);
    blocks.map(|block| VariedHop::new(job.hop, block)).collect()
}

/// What one patch gives back: to the nodes under its window, and to all parameters.
fn give_back(
    cutter: &Cutter,
    kept: &Kept,
    beamlets: &PatchBeamlets,
    varied_hops: &[VariedHop],
    to_bar: &Canvas,
) -> (Array2<Complex64>, Vec<f64>) {
    let (k, edge) = (
        cutter.job.hop.wavenumber(),
        cutter.job.settings.footprint_edge(),
    );
    let moments = to_bar.add_adjoint(&beamlets.arrivals, k, edge);
    let mut bar = Array2::zeros([beamlets.modes[1].len(), beamlets.modes[0].len()]);
    for ((place, arrival), moments) in beamlets.places.iter().zip(&beamlets.arrivals).zip(&moments)
    {
        bar[*place] = arrival.amplitude.conj() * moments[0];
    }
    if let Some(draws) = cutter.job.draws_of(beamlets.index) {
        let weigh = |spectrum: &Spectrum| draws.weights_adjoint(&spectrum.coefficients, &bar);
        bar = cutter.with(kept, beamlets.index, weigh).unwrap_or(bar);
    }
    let pulled = pulled(cutter, kept, beamlets, varied_hops, &moments);
    (
        cutter.cut_adjoint(beamlets.index, &beamlets.modes, &bar),
        pulled,
    )
}

/// The derivatives with respect to all parameters that one patch brings.
fn pulled(
    cutter: &Cutter,
    kept: &Kept,
    beamlets: &PatchBeamlets,
    varied_hops: &[VariedHop],
    moments: &[Moments],
) -> Vec<f64> {
    let mut total = vec![0.0; BLOCK * varied_hops.len()];
    let (plan, k) = (cutter.job.plan, cutter.job.hop.wavenumber());
    let [bx, by] = &plan.bands;
    let centre = cutter.patches.place(beamlets.index).centre;
    let mut add = |spectrum: &Spectrum| {
        let Ok(launch_planes) = LaunchPlanes::new(cutter.job, centre) else {
            return;
        };
        for ((place, arrival), moments) in
            beamlets.places.iter().zip(&beamlets.arrivals).zip(moments)
        {
            let amplitude = arrival.amplitude * spectrum.coefficients[*place];
            if amplitude == Complex64::ZERO {
                continue;
            }
            let [x, y] = [0, 1].map(|a| beamlets.modes[a].start + place[1 - a]);
            let p = [bx.at(x), by.at(y)];
            for (varied_hop, total) in varied_hops.iter().zip(total.chunks_mut(BLOCK)) {
                if let Ok(carried) = varied_hop.carry(launch_planes.launch_plane(), p, plan.sigma) {
                    let parts = pull(&carried, amplitude, moments, k);
                    total.iter_mut().zip(parts).for_each(|(t, part)| *t += part);
                }
            }
        }
    };
    if !varied_hops.is_empty() {
        cutter.with(kept, beamlets.index, &mut add);
    }
    total
}

/// The beamlets of a patch times the coefficients of a spectrum, without those that are too weak.
fn lit(beamlets: &PatchBeamlets, spectrum: &Spectrum, floor: f64) -> Vec<Arrival> {
    let mut list = Vec::new();
    for (place, arrival) in beamlets.places.iter().zip(&beamlets.arrivals) {
        let coefficient = spectrum.coefficients[*place];
        let energy = coefficient.norm_sqr();
        if energy < floor || energy == 0.0 {
            continue;
        }
        let mut arrival = *arrival;
        arrival.amplitude *= coefficient;
        list.push(arrival);
    }
    list
}

/// The beamlets of one patch of coefficient one that reach the target, of those that are selected by their place among
/// its modes.
fn beamlets(
    cutter: &Cutter,
    index: usize,
    to: &Canvas,
    selected: &dyn Fn([usize; 2]) -> bool,
) -> Option<PatchBeamlets> {
    let job = cutter.job;
    let modes = cutter.modes(index)?;
    let centre = cutter.patches.place(index).centre;
    let launch_planes = LaunchPlanes::new(job, centre).ok()?;
    let mut samples = AberrationSamples::new(job, index, centre, f64::INFINITY);
    let mut beamlets = PatchBeamlets {
        index,
        places: Vec::new(),
        arrivals: Vec::new(),
        modes,
    };
    for my in 0..beamlets.modes[1].len() {
        for mx in 0..beamlets.modes[0].len() {
            let mode = [beamlets.modes[0].start + mx, beamlets.modes[1].start + my];
            if !selected([my, mx]) {
                continue;
            }
            if let Ok(beamlet) = target_beamlet(job, &launch_planes, mode, to, &mut samples) {
                beamlets.places.push([my, mx]);
                beamlets.arrivals.push(beamlet.arrival);
            }
        }
    }
    Some(beamlets)
}
