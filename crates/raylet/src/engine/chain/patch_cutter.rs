//! The patches of a field that beamlets carry: their places, spectra and modes. The adjoint stands beside the forward
//! step; `chain_dot_product_slow` in the crate's tests checks it.

use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::engine::beamlet::beamlet_plan::MARGIN;
use crate::engine::beamlet::mode_histogram::ModeHistogram;
use crate::engine::chain::backend::{Job, Kept};
use crate::engine::trace::direction_search::reach;
use crate::wave::grid::field::{Axis, Field};
use crate::wave::grid::heights::Heights;
use crate::wave::patches::curved::CurvedPatches;
use crate::wave::patches::patch::{Patches, Spectrum};
use crate::wave::patches::window::Positions;

/// What cuts the field of a job into patches: on a curved screen on its true surface.
pub(crate) struct Cutter<'a> {
    /// The hop and its plan.
    pub job: &'a Job<'a>,
    /// The field on its first screen.
    pub field: &'a Field,
    /// The patches.
    pub patches: Patches,
    heights: Option<Heights>,
}

impl<'a> Cutter<'a> {
    pub(crate) fn new(job: &'a Job<'a>, field: &'a Field) -> Self {
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
    pub(crate) fn most_modes(&self) -> usize {
        let [bx, by] = &self.job.plan.bands;
        bx.count * by.count
    }

    /// The directions of one patch that may lead to the target, as indices in the bands.
    pub(crate) fn modes(&self, index: usize) -> Option<[Range<usize>; 2]> {
        let margin = MARGIN * self.job.plan.footprint;
        let (hop, margin) = match &self.job.shared {
            Some(shared) => (&shared.middle, shared.aside.map(|aside| margin + aside)),
            None => (self.job.chooser(), [margin; 2]),
        };
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
    pub(crate) fn cut_adjoint(
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
    pub(crate) fn keep(&self) -> Kept {
        let needed = self.patches.count().saturating_mul(self.most_modes());
        (needed <= self.job.settings.samples_allowed()).then(|| {
            let all = (0..self.patches.count()).into_par_iter();
            all.map(|index| self.cut(index)).collect()
        })
    }

    /// The result of the spectrum of one patch, which is kept or computed again.
    pub(crate) fn with<T>(
        &self,
        kept: &Kept,
        index: usize,
        then: impl FnOnce(&Spectrum) -> T,
    ) -> Option<T> {
        match kept {
            Some(all) => all[index].as_ref().map(then),
            None => self.cut(index).as_ref().map(then),
        }
    }

    pub(crate) fn histogram(&self, kept: &Kept) -> ModeHistogram {
        let count = |spectrum: &Spectrum| ModeHistogram::of(spectrum.coefficients.iter());
        (0..self.patches.count())
            .into_par_iter()
            .filter_map(|index| self.with(kept, index, count))
            .reduce(ModeHistogram::default, ModeHistogram::merge)
    }
}

/// The places of the patches along x and y.
pub(crate) fn positions(job: &Job, from: &Field) -> [Positions; 2] {
    let reach = 0.5 * job.plan.period;
    let axis =
        |axis: &Axis| Positions::covering(axis.edges(), job.plan.sigma, job.plan.step, reach);
    [axis(&from.grid.x), axis(&from.grid.y)]
}
