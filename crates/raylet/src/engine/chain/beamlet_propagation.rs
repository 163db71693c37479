//! The backend of the machine's own cores.
//!
//! Patches are taken in chunks of fixed size: their spectra and rays in parallel, then the sum over the
//! chunk in parallel over rows. Memory is one chunk of arrivals, whatever the number of rays, and the
//! result has the same bits for any number of threads. The adjoint stands beside the forward step;
//! `chain_dot_product_slow` in the crate's tests checks it.

use std::borrow::Cow;
use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::beamlet::aberration_sample::AberrationSamples;
use crate::engine::beamlet::beamlet_cache::PatchBeamlets;
use crate::engine::beamlet::beamlet_target::{DiscardedBeamlet, LaunchPlanes, target_beamlet};
use crate::engine::chain::backend::{AdjointSums, Backend, Job, Kept};
use crate::engine::chain::patch_cutter::{Cutter, positions};
use crate::engine::error::tally::{Fate, Tally};
use crate::engine::monte_carlo::mode_sampling::Drawing;
use crate::engine::progress::{Cancelled, ShareDone};
use crate::engine::trace::ray_sensitivity::{BLOCK, PerturbedHops, VariedHop, pull};
use crate::math::part::part;
use crate::optics::ray::Loss;
use crate::wave::beamlet::beamlet_kernel::Moments;
use crate::wave::beamlet::beamlet_sum::Canvas;
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::field::Field;
use crate::wave::patches::patch::Spectrum;

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
        let own = job.spectra().is_none().then(|| cutter.keep()).flatten();
        let kept = job.spectra().unwrap_or(&own);
        let histogram = cutter.histogram(kept);
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
                .filter_map(|index| cutter.with(kept, index, |s| one(index, s, to)))
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
        let own = (job.adjoint_needs_spectra() && job.spectra().is_none())
            .then(|| cutter.keep())
            .flatten();
        let spectra = job.spectra().unwrap_or(&own);
        let kept_beamlets = KeptBeamlets::new(&cutter, to_bar, spectra);

        let chunk = (CHUNK / cutter.most_modes().max(1)).max(1);
        let mut done = 0;
        while done < patches.len() {
            // The beamlets of the forward pass, traced again unless they are kept.
            let first = patches.start + done;
            let last = (first + chunk).min(patches.end);
            let all: Vec<Cow<_>> = (first..last)
                .into_par_iter()
                .filter_map(|index| kept_beamlets.of(index))
                .collect();

            // canvas += amplitude·coefficient·beamlet
            let bars: Vec<(Array2<Complex64>, Vec<f64>)> = all
                .par_iter()
                .map(|beamlets| give_back(&cutter, spectra, beamlets, &varied_hops, to_bar))
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

/// The beamlets that the forward pass followed, for the adjoint: kept, or traced again.
struct KeptBeamlets<'a> {
    cutter: &'a Cutter<'a>,
    to: &'a Canvas,
    /// The spectra of all patches, if they are needed and fit.
    spectra: &'a Kept,
    /// The energy below which modes are left out; zero where none are, or where they are drawn.
    floor: f64,
    /// The beamlets of all patches, if they fit.
    cached: Option<&'a [Option<PatchBeamlets>]>,
}

impl<'a> KeptBeamlets<'a> {
    fn new(cutter: &'a Cutter<'a>, to: &'a Canvas, spectra: &'a Kept) -> Self {
        let job = cutter.job;
        let floor = match job.draws.is_none() && job.settings.weakest_mode() > 0.0 {
            true => cutter.histogram(spectra).floor(job.settings),
            false => 0.0,
        };
        Self {
            cutter,
            to,
            spectra,
            floor,
            cached: cutter.cached(to),
        }
    }

    /// The beamlets of one patch.
    fn of(&self, index: usize) -> Option<Cow<'a, PatchBeamlets>> {
        let (cutter, to) = (self.cutter, self.to);
        if cutter.job.draws.is_some() {
            return drawn(cutter, self.spectra, index, to).map(Cow::Owned);
        }
        if self.floor > 0.0 {
            let strong = |spectrum: &Spectrum| self.strong(index, spectrum);
            let found = cutter.with(self.spectra, index, strong);
            return found.flatten().map(Cow::Owned);
        }
        match self.cached {
            Some(all) => all[index].as_ref().map(Cow::Borrowed),
            None => beamlets(cutter, index, to, &|_| true).map(Cow::Owned),
        }
    }

    /// The beamlets of one patch whose modes are strong. Its spectrum is computed once, because that may take long.
    fn strong(&self, index: usize, spectrum: &Spectrum) -> Option<PatchBeamlets> {
        let is_strong = |place: [usize; 2]| spectrum.coefficients[place].norm_sqr() >= self.floor;
        match self.cached {
            Some(all) => all[index].as_ref().map(|all| all.only(is_strong)),
            None => beamlets(self.cutter, index, self.to, &is_strong),
        }
    }
}

impl<'a> Cutter<'a> {
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
    let mut follower = Follower {
        job,
        launch_planes: &launch_planes,
        to,
        samples: AberrationSamples::new(job, patch, spectrum.centre, strength.total),
        tally,
    };
    let (mut modes, mut coefficients) = (Vec::new(), Vec::new());
    for ((my, mx), c) in spectrum.coefficients.indexed_iter() {
        let energy = c.norm_sqr();
        within += energy;
        if energy < strength.floor || energy == 0.0 {
            follower.tally.add_energy(Fate::Weak, energy);
            continue;
        }
        modes.push([spectrum.first[0] + mx, spectrum.first[1] + my]);
        coefficients.push(*c);
    }
    let landed = launch_planes.landed(job, &modes);
    for (aimed, c) in modes.into_iter().zip(landed).zip(coefficients) {
        let energy = c.norm_sqr();
        let fate = match follower.follow(aimed, c) {
            Ok(arrival) => {
                arrivals.push(arrival);
                Fate::Arrived
            }
            Err(discarded) => {
                follower.tally.untrusted += energy * discarded.share;
                follower.tally.beyond_footprints += energy * discarded.cut;
                discarded.fate
            }
        };
        follower.tally.count(fate, energy);
    }
    let mut tally = follower.tally;
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
    let drawn = weights.indexed_iter().zip(&spectrum.coefficients);
    let drawn: Vec<_> = drawn.filter(|((_, weight), _)| **weight != 0.0).collect();
    let modes: Vec<[usize; 2]> = { drawn.iter() }
        .map(|(((my, mx), _), _)| [spectrum.first[0] + mx, spectrum.first[1] + my])
        .collect();
    let landed = launch_planes.landed(job, &modes);
    for (((_, weight), c), aimed) in drawn.into_iter().zip(modes.into_iter().zip(landed)) {
        let fate = match target_beamlet(job, &launch_planes, aimed, to, &mut samples) {
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

/// The beamlets of one patch that the adjoint of its draws needs: those drawn, or all where each is compared.
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

/// What follows the beamlets of one patch to the target.
struct Follower<'a> {
    job: &'a Job<'a>,
    launch_planes: &'a LaunchPlanes,
    to: &'a Canvas,
    /// The samples of the aberration inside its beamlets.
    samples: AberrationSamples<'a>,
    /// What became of its beamlets.
    tally: Tally,
}

impl Follower<'_> {
    /// Follows one beamlet, given with its mode and where it lands.
    fn follow(
        &mut self,
        aimed: ([usize; 2], Result<Arrival, Loss>),
        coefficient: Complex64,
    ) -> Result<Arrival, DiscardedBeamlet> {
        let (job, to, samples) = (self.job, self.to, &mut self.samples);
        let mode = aimed.0;
        let beamlet = target_beamlet(job, self.launch_planes, aimed, to, samples)?;
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
            let found = found.map(|found| found.at_distance(tail.distance).error());
            let weight = stands_for * energy * tail.share;
            self.tally.add_aberration(found, weight);
        }
        if job.downstream.ends_here() {
            let (k, edge) = (job.hop.wavenumber(), job.settings.footprint_edge());
            self.tally.beyond_footprints += energy * to.cut(&arrival, k, edge);
        }
        arrival.amplitude *= coefficient;
        Ok(arrival)
    }
}

/// The hop with its parameters, a block at a time.
fn varied_hops<'a>(job: &Job<'a>, perturbed: &[PerturbedHops<'a>]) -> Vec<VariedHop<'a>> {
    let blocks = perturbed.chunks(BLOCK);
    blocks.map(|block| VariedHop::new(job.hop, block)).collect()
}

/// The adjoint of one patch: cotangents of the nodes under its window, [y, x], and derivatives by all parameters.
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

/// The derivatives with respect to all parameters that one patch brings. A varied hop has the values of the hop itself, so
/// what arrived arrives again; only a ray at an edge may end by rounding, and the support of a sum is constant.
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
    let [xs, ys] = beamlets.modes.clone();
    let places = (0..ys.len()).flat_map(|my| (0..xs.len()).map(move |mx| [my, mx]));
    let places: Vec<[usize; 2]> = places.filter(|place| selected(*place)).collect();
    let modes: Vec<[usize; 2]> = { places.iter() }
        .map(|[my, mx]| [xs.start + mx, ys.start + my])
        .collect();
    let landed = launch_planes.landed(job, &modes);
    for (place, aimed) in places.into_iter().zip(modes.into_iter().zip(landed)) {
        if let Ok(beamlet) = target_beamlet(job, &launch_planes, aimed, to, &mut samples) {
            beamlets.places.push(place);
            beamlets.arrivals.push(beamlet.arrival);
        }
    }
    Some(beamlets)
}
