//! Expected errors of beamlets of one width, from real rays: aberration inside them, and tails that are
//! discarded.

use crate::engine::beamlet::beamlet_aberration::{Aberration, aberration};
use crate::engine::beamlet::beamlet_launch::launch_beamlet;
use crate::engine::beamlet::discarded_tail::{LeavingBeamlet, discarded_tail_share};
use crate::engine::trace::direction_search::SearchRay;
use crate::engine::trace::launch_plane::LaunchPlane;
use crate::optics::system::Hop;
use crate::wave::beamlet::wavelet::Tail;

/// Share of the light that the errors of a width are averaged over.
const TRUSTED_SHARE: f64 = 0.98;

/// Tails count up to this distance r, where the amplitude is exp(−r²/2).
pub(crate) const FARTHEST: f64 = 4.0;

/// Largest η that a beamlet beside the target may have for its tail on the target to be accurate.
pub(crate) const TRUSTED_TAIL: f64 = 0.1;

/// Errors that a width of beamlets is expected to have, relative to the field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExpectedErrors {
    /// From aberration inside beamlets, uncorrected.
    pub eta: f64,
    /// After the correction.
    pub eta_corrected: f64,
    /// Mean cubic phase ε₃, in rad.
    pub cubic: f64,
    /// From tails that are discarded.
    pub dropped: f64,
}

/// A beamlet along a ray of the search.
struct SampledBeamlet {
    /// Its aberration; none where its neighbours are lost.
    aberration: Option<Aberration>,
    /// How much light it brings to the target.
    weight: f64,
    /// How it lies to the target.
    tail: Tail,
}

impl SampledBeamlet {
    /// η² uncorrected and corrected and ε₃² of what falls on the target, with their weight.
    fn squares(&self) -> ([f64; 3], f64) {
        let squares = self.aberration.map_or([1.0; 3], |found| {
            let found = found.at_distance(self.tail.distance);
            [
                found.eta().powi(2),
                found.left().powi(2),
                found.cubic.min(1.0),
            ]
        });
        (squares, self.weight)
    }

    /// Whether a run discards its tail, if it lands beside the target.
    fn is_discarded(&self) -> bool {
        self.aberration
            .is_none_or(|found| found.eta() > TRUSTED_TAIL)
    }
}

/// What the errors of a width are computed for.
pub(crate) struct WidthErrors<'a, W> {
    /// The hop.
    pub hop: &'a Hop<'a>,
    /// The target box of the second screen, `[x_min, x_max, y_min, y_max]` in mm.
    pub to: [f64; 4],
    /// How much light goes a ray's way.
    pub weight: W,
}

impl<W: Fn(&SearchRay) -> f64> WidthErrors<'_, W> {
    /// The errors that beamlets of width σ are expected to have: root mean squares over the sample rays and the tails
    /// of those beside the target, weighted by the light that goes their way and falls on it. The worst few are left
    /// out: grazing rays or rays whose neighbours are lost, to which the envelope may give more light than they
    /// have; what they do carry is in the tally of the run. Tails that a run discards count as lost light instead.
    pub(crate) fn at(
        &self,
        sample_rays: &[SearchRay],
        beside: &[SearchRay],
        sigma: f64,
    ) -> ExpectedErrors {
        let mut found = Vec::new();
        let mut discarded = 0.0;
        for ray in sample_rays {
            found.extend(self.sampled(ray, sigma).map(|sampled| sampled.squares()));
        }
        for ray in beside {
            let Some(sampled) = self.sampled(ray, sigma) else {
                continue;
            };
            if sampled.is_discarded() {
                discarded += self.discarded(ray, sigma, sampled.tail);
            } else {
                found.push(sampled.squares());
            }
        }
        found.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        let all = found.iter().map(|f| f.1).sum::<f64>();
        let (mut total, mut sums) = (0.0, [0.0; 3]);
        for (squares, weight) in found {
            total += weight;
            for (sum, square) in sums.iter_mut().zip(squares) {
                *sum += weight * square;
            }
            if total >= TRUSTED_SHARE * all {
                break;
            }
        }
        let [eta, eta_corrected, cubic] = sums.map(|sum| (sum / total).sqrt());
        let dropped = (discarded / (all + discarded)).sqrt();
        ExpectedErrors {
            eta,
            eta_corrected,
            cubic,
            dropped,
        }
    }

    /// The beamlet of width σ along a ray, if any of it falls on the target.
    fn sampled(&self, ray: &SearchRay, sigma: f64) -> Option<SampledBeamlet> {
        let k = self.hop.wavenumber();
        let arrival = launch_beamlet(self.hop, ray.at, ray.p, sigma);
        let tail = arrival.map_or(Tail::WHOLE, |arrival| Tail::of(&arrival, self.to, k));
        (tail.distance < FARTHEST).then(|| SampledBeamlet {
            aberration: aberration(self.hop, ray.at, ray.p, sigma, k),
            weight: (self.weight)(ray) * tail.share,
            tail,
        })
    }

    /// The light that the discarded tail of a beamlet beside the target would bring there.
    fn discarded(&self, ray: &SearchRay, sigma: f64, tail: Tail) -> f64 {
        let Ok(launch_plane) = LaunchPlane::new(self.hop.from, ray.at) else {
            return 0.0;
        };
        let leaving = LeavingBeamlet {
            launch_plane: &launch_plane,
            p: ray.p,
            sigma,
        };
        (self.weight)(ray) * discarded_tail_share(self.hop, &leaving, self.to, tail)
    }
}
