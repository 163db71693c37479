//! The interface between fields and rays: everything that crosses it adds.

use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::beamlet::beamlet_cache::BeamletCache;
use crate::engine::beamlet::beamlet_plan::BeamletPlan;
use crate::engine::error::tally::Tally;
use crate::engine::monte_carlo::mode_sampling::{Draws, PatchDraws};
use crate::engine::plan::downstream::Downstream;
use crate::engine::plan::settings::Settings;
use crate::engine::progress::{Cancelled, Pulse, ShareDone};
use crate::engine::trace::ray_sensitivity::PerturbedHops;
use crate::optics::system::Hop;
use crate::wave::beamlet::beamlet_sum::Canvas;
use crate::wave::grid::field::Field;
use crate::wave::patches::patch::Spectrum;

/// The spectra of all patches of a field, where they fit into memory.
pub(crate) type Kept = Option<Vec<Option<Spectrum>>>;

/// What the hops to the levels around a curved second screen share.
#[derive(Clone, Copy)]
pub(crate) struct SharedByLevels<'a> {
    /// The hop to the middle level, as it was planned: by it the directions of each patch are chosen.
    pub middle: Hop<'a>,
    /// How far light lands aside on the other levels, along x and y in mm.
    pub aside: [f64; 2],
    /// The spectra of all patches in these directions; nothing where they are not known.
    pub spectra: Option<&'a Kept>,
}

/// One hop to be carried by beamlets.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    /// Screens and train.
    pub hop: Hop<'a>,
    /// The hop that was planned, if `hop` is a slightly changed one: by it beamlets are chosen and corrected,
    /// so that what is differentiated is smooth.
    pub planned: Option<Hop<'a>>,
    /// Lattice of the sum.
    pub plan: &'a BeamletPlan,
    /// Thresholds.
    pub settings: &'a Settings,
    /// The hops behind this one, as far as its directions are kept.
    pub downstream: &'a Downstream<'a>,
    /// Memory that may keep its beamlets for the next run of the hop.
    pub cache: Option<&'a BeamletCache>,
    /// How beamlets are drawn, with the number of the hop; `None` where all are followed.
    pub draws: Option<(Draws, u32)>,
    /// What it shares with the hops to other levels of a curved second screen.
    pub shared: Option<SharedByLevels<'a>>,
}

impl<'a> Job<'a> {
    /// The hop by which beamlets are chosen.
    pub(crate) fn chooser(&self) -> &Hop<'a> {
        self.planned.as_ref().unwrap_or(&self.hop)
    }

    /// Whether the adjoint looks at the spectra of patches: for modes that were too weak, or drawn.
    pub(crate) fn adjoint_needs_spectra(&self) -> bool {
        self.draws.is_some() || self.settings.weakest_mode() > 0.0
    }

    /// The spectra of all patches, if they are known.
    pub(crate) fn spectra(&self) -> Option<&'a Kept> {
        self.shared.and_then(|shared| shared.spectra)
    }

    /// The draws of one patch.
    pub(crate) fn draws_of(&self, patch: usize) -> Option<PatchDraws> {
        self.draws.map(|(draws, hop)| PatchDraws {
            draws,
            at: [hop, patch as u32],
        })
    }
}

/// The sums to which the adjoint of a hop adds.
pub(crate) struct AdjointSums<'a> {
    /// Cotangent of the field at the nodes of the first screen, [y, x].
    pub from_bar: &'a mut Array2<Complex64>,
    /// How the hop changes with each parameter.
    pub perturbed: &'a [PerturbedHops<'a>],
    /// Derivative with respect to each of them.
    pub parameters: &'a mut [f64],
    /// Called after each chunk of work.
    pub pulse: &'a Pulse<'a>,
}

/// Something that carries fields.
pub(crate) trait Backend {
    /// Number of patches that a field has.
    fn patches(&self, job: &Job, from: &Field) -> usize;

    /// Adds what a range of patches brings to the receiving screen.
    ///
    /// # Errors
    /// When `progress` cancels the work.
    fn carry(
        &self,
        job: &Job,
        from: &Field,
        patches: Range<usize>,
        to: &mut Canvas,
        progress: &ShareDone,
    ) -> Result<Tally, Cancelled>;

    /// The conjugate transpose of [`Backend::carry`], held by `chain_dot_product_slow` in the crate's tests: adds what
    /// a range of patches gives back. The values of `from` only show which modes were too weak, and on what the
    /// parameters act.
    ///
    /// # Errors
    /// When the pulse of `back` cancels the work.
    fn carry_adjoint(
        &self,
        job: &Job,
        from: &Field,
        patches: Range<usize>,
        to_bar: &Canvas,
        back: &mut AdjointSums,
    ) -> Result<(), Cancelled>;
}
