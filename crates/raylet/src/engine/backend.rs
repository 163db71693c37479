//! The door between fields and rays: everything that crosses it adds.

use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::beamlets::BeamletPlan;
use crate::engine::beyond::Beyond;
use crate::engine::settings::Settings;
use crate::engine::tally::Tally;
use crate::optics::system::Hop;
use crate::wave::field::Field;
use crate::wave::gather::Canvas;

/// One hop to be carried by beamlets.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// Screens and train.
    pub hop: Hop<'a>,
    /// Lattice of the sum.
    pub plan: &'a BeamletPlan,
    /// Thresholds.
    pub settings: &'a Settings,
    /// Where its light goes next.
    pub beyond: &'a Beyond<'a>,
}

/// Something that carries fields.
pub trait Backend {
    /// Number of patches that a field has.
    fn patches(&self, job: &Job, from: &Field) -> usize;

    /// Adds what a range of patches brings to the receiving screen.
    fn carry(
        &self,
        job: &Job,
        from: &Field,
        patches: Range<usize>,
        to: &mut Canvas,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Tally;

    /// The conjugate transpose of [`Backend::carry`] with respect to the field: adds what a range of patches
    /// gives back to the nodes of `from`, whose values only tell which modes were too weak.
    fn carry_adjoint(
        &self,
        job: &Job,
        from: &Field,
        patches: Range<usize>,
        to_bar: &Canvas,
        from_bar: &mut Array2<Complex64>,
        progress: &(dyn Fn(f64) + Sync),
    );
}
