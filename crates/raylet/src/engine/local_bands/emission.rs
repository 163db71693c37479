//! The beamlets of one window.

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::local_bands::account::HopAccount;
use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::target::Target;
use crate::optics::system::Hop;
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::local_bands::window_transform::Modes;

/// What all windows of a hop share when they send their beamlets.
pub(crate) struct Emission<'a> {
    /// The hop.
    pub hop: &'a Hop<'a>,
    /// The target of the beamlets.
    pub target: &'a Target,
    /// Plane waves weaker than this are left out.
    pub weakest: f64,
    /// Energy of the plane waves of a window under a unit plane wave.
    pub unit: f64,
    /// Whether the aberration inside beamlets is corrected.
    pub corrected: bool,
}

/// Beamlets that reach the target, with the account of how they came about.
#[derive(Default)]
pub(crate) struct Emitted {
    /// The beamlets.
    pub arrivals: Vec<Arrival>,
    /// The account.
    pub account: HopAccount,
}

impl Emission<'_> {
    /// Sends the plane waves of a window, indexed [m_y, m_x], on their way.
    pub(crate) fn send(
        &self,
        start: &ChirpedStart,
        modes: [&Modes; 2],
        waves: &Array2<Complex64>,
        out: &mut Emitted,
    ) {
        let k = self.hop.wavenumber();
        let first = out.arrivals.len();
        let (mut kept, mut strongest) = (0.0, (0.0, [0.0; 2]));
        for ((my, mx), c) in waves.indexed_iter() {
            let (energy, dp) = (c.norm_sqr(), [modes[0].at(mx), modes[1].at(my)]);
            if energy <= self.weakest * self.weakest {
                out.account.weak += energy / self.unit;
                continue;
            }
            let Ok(mut arrival) = start.launch(self.hop, dp) else {
                out.account.lost += energy / self.unit;
                continue;
            };
            if !self.target.meets(&arrival, k) {
                out.account.beside += energy / self.unit;
                continue;
            }
            arrival.amplitude *= c;
            kept += energy / self.unit;
            if energy > strongest.0 {
                strongest = (energy, dp);
            }
            out.arrivals.push(arrival);
        }
        out.account.modes += waves.len() as u64;
        out.account.beamlets += (out.arrivals.len() - first) as u64;
        out.account.kept += kept;
        if kept > 0.0 {
            self.correct(
                start,
                strongest.1,
                kept,
                &mut out.arrivals[first..],
                &mut out.account,
            );
        }
    }

    /// Corrects the aberration inside the beamlets of a window by that of its strongest beamlet.
    fn correct(
        &self,
        start: &ChirpedStart,
        dp: [f64; 2],
        kept: f64,
        arrivals: &mut [Arrival],
        account: &mut HopAccount,
    ) {
        let Some(found) = start.aberration(self.hop, dp) else {
            account.aberrated += kept;
            account.left += kept;
            return;
        };
        account.aberrated += kept * found.eta().powi(2);
        account.left += kept * found.left().powi(2);
        if self.corrected {
            let factor = found.correction();
            arrivals.iter_mut().for_each(|a| a.amplitude *= factor);
        }
    }
}
