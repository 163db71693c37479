//! What became of the rays and of the energy of a hop.

use ndarray::Array2;

use crate::engine::beamlet::beamlet_aberration::{Aberration, AberrationError};
use crate::optics::ray::Loss;

/// The fate of a ray, or of a share of the energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It reached the target.
    Arrived,
    /// It landed beside the target.
    Outside,
    /// It was lost on the way.
    Lost(Loss),
    /// Its mode was weaker than the threshold and was not followed.
    Weak,
    /// Its aberration inside one beamlet is too large for it to be carried.
    Unresolved,
    /// It was not followed, and the estimate of lost light found no reason why it would be lost.
    Elsewhere,
}

/// All fates, in the order of reports.
pub(crate) const FATES: [Fate; 10] = [
    Fate::Arrived,
    Fate::Outside,
    Fate::Lost(Loss::Clipped),
    Fate::Lost(Loss::Missed),
    Fate::Lost(Loss::TotalReflection),
    Fate::Lost(Loss::Evanescent),
    Fate::Lost(Loss::NotConverged),
    Fate::Weak,
    Fate::Unresolved,
    Fate::Elsewhere,
];

impl Fate {
    /// The name used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Fate::Arrived => "arrived",
            Fate::Outside => "outside",
            Fate::Lost(Loss::Clipped) => "clipped",
            Fate::Lost(Loss::Missed) => "missed",
            Fate::Lost(Loss::TotalReflection) => "total_reflection",
            Fate::Lost(Loss::Evanescent) => "evanescent",
            Fate::Lost(Loss::NotConverged) => "not_converged",
            Fate::Weak => "below_threshold",
            Fate::Unresolved => "unresolved",
            Fate::Elsewhere => "elsewhere",
        }
    }

    /// Its place in [`FATES`].
    pub(crate) fn place(self) -> usize {
        FATES.iter().position(|fate| *fate == self).unwrap_or(0)
    }
}

/// What the aberration about a centre outside the aperture does to the light inside it, as a part. Of two lenses for phones,
/// on axis and off it, with windows of 50 to 80 µm, the error is 0.13 to 1.2 of that aberration; of 16 runs 10 are within a
/// factor of 1.6 of this part.
pub(crate) const OUTSIDE: f64 = 0.3;

/// Sums of squares over beamlets, weighted by energy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Aberrations {
    /// Σ of the weights.
    pub energy: f64,
    /// Σ η².
    pub plain: f64,
    /// Σ of the square of what the correction leaves of η.
    pub left: f64,
    /// Σ ε₃².
    pub cubic: f64,
    /// Σ of the square of what a lattice of windows leaves of ε₃, but for the factor of their distance.
    pub lattice: f64,
    /// Σ of the part of the first orders of that lattice that falls on the target.
    pub orders: f64,
}

impl Aberrations {
    fn merge(&mut self, other: &Self) {
        self.energy += other.energy;
        self.plain += other.plain;
        self.left += other.left;
        self.cubic += other.cubic;
        self.lattice += other.lattice;
        self.orders += other.orders;
    }
}

/// Rays and energy by fate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    rays: [u64; FATES.len()],
    energy: [f64; FATES.len()],
    /// Values evaluated on the receiving screen.
    pub evaluations: u64,
    /// Over the beamlets whose aberration was sampled, by what each brings to the target.
    pub aberration: Aberrations,
    /// Energy of tails that fall on the target and are left out, because the beamlets are too aberrated there.
    pub untrusted: f64,
    /// Share of the light behind the first screen that reaches the sensor; `None` where a screen between changes
    /// directions.
    pub landed: Option<f64>,
    /// The error to expect from rims: from that where the hop begins, if it begins at one, and from those
    /// whose light was cut ray by ray.
    pub edge: f64,
    /// Energy that edges send to the target in directions that their nodes do not resolve.
    pub unresolved_edges: f64,
    /// Energy that falls on the target beyond where the footprints of beamlets end.
    pub beyond_footprints: f64,
    /// Modes below the threshold that were sampled, each for the same energy, and the sum of their shares that fall on the
    /// target.
    pub weak_sample: [f64; 2],
    /// The error of a free hop, measured at a few points, where a direct sum resolves it.
    pub spot_check: Option<f64>,
    /// Σ variance and Σ|U|² over the receiving screen, where rays were drawn at random.
    pub sampling: Option<[f64; 2]>,
    /// Standard error of the field at each sample of the receiving screen, indexed [y, x], where rays were
    /// drawn at random.
    pub noise: Option<Array2<f64>>,
}

impl Tally {
    /// Counts one ray with its energy.
    #[inline]
    pub(crate) fn count(&mut self, fate: Fate, energy: f64) {
        self.count_many(fate, 1, energy);
    }

    /// Counts rays with their energy together.
    #[inline]
    pub(crate) fn count_many(&mut self, fate: Fate, rays: u64, energy: f64) {
        let place = fate.place();
        self.rays[place] += rays;
        self.energy[place] += energy;
    }

    /// Counts energy that no ray carried.
    pub(crate) fn add_energy(&mut self, fate: Fate, energy: f64) {
        self.energy[fate.place()] += energy;
    }

    /// Divides the energy of [`Fate::Elsewhere`] by an estimate from all light: each way of being lost gets what
    /// its share of the estimate lacks so far, and the rest landed outside. Without an estimate it stays where it
    /// is.
    pub(crate) fn divide_elsewhere(&mut self, estimate: [f64; FATES.len()]) {
        let estimated: f64 = estimate.iter().sum();
        if estimated <= 0.0 {
            return;
        }
        let total: f64 = self.energy.iter().sum();
        let energy = std::mem::take(&mut self.energy[Fate::Elsewhere.place()]);
        let lacking: [f64; FATES.len()] = std::array::from_fn(|i| match FATES[i] {
            Fate::Lost(_) => (total * estimate[i] / estimated - self.energy[i]).max(0.0),
            _ => 0.0,
        });
        let lost: f64 = lacking.iter().sum();
        let given = lost.min(energy);
        for (sum, part) in self.energy.iter_mut().zip(lacking) {
            *sum += if lost > 0.0 { part * given / lost } else { 0.0 };
        }
        self.energy[Fate::Outside.place()] += energy - given;
    }

    /// Rays of this fate.
    pub fn rays(&self, fate: Fate) -> u64 {
        self.rays[fate.place()]
    }

    /// Rays of every fate.
    pub fn total_rays(&self) -> u64 {
        self.rays.iter().sum()
    }

    /// Takes note of the aberration of a beamlet that brings `energy` to the target; nothing when it is not
    /// known because neighbouring rays are lost.
    #[inline]
    pub(crate) fn add_aberration(&mut self, found: Option<AberrationError>, energy: f64) {
        let found = found.unwrap_or(AberrationError {
            plain: 1.0,
            left: 1.0,
            cubic: 1.0,
            lattice: 1.0,
            orders: 1.0,
        });
        self.aberration.energy += energy;
        self.aberration.plain += energy * found.plain.powi(2);
        self.aberration.left += energy * found.left.powi(2);
        self.aberration.cubic += energy * found.cubic.min(1.0);
        self.aberration.lattice += energy * found.lattice.min(1.0);
        self.aberration.orders += energy * found.orders;
    }

    /// Adds what the aberration about the centre of a window leaves, which is outside the aperture, beyond that where its light
    /// is.
    #[inline]
    pub(crate) fn add_aberration_outside(
        &mut self,
        outside: Option<Aberration>,
        lit: Option<Aberration>,
        energy: f64,
    ) {
        let both = |of: fn(&Aberration) -> f64| {
            let [outside, lit] = [outside, lit].map(|found| found.map_or(1.0, |found| of(&found)));
            energy * (OUTSIDE * (outside - lit).max(0.0)).powi(2)
        };
        self.aberration.plain += both(Aberration::eta);
        self.aberration.left += both(Aberration::left);
    }

    /// Energy of this fate as a share of all.
    pub fn share(&self, fate: Fate) -> f64 {
        let total: f64 = self.energy.iter().sum();
        if total > 0.0 {
            self.energy[fate.place()] / total
        } else {
            0.0
        }
    }

    /// Energy of all fates.
    pub(crate) fn total_energy(&self) -> f64 {
        self.energy.iter().sum()
    }

    /// Adds another tally.
    pub(crate) fn merge(&mut self, other: &Tally) {
        for i in 0..FATES.len() {
            self.rays[i] += other.rays[i];
            self.energy[i] += other.energy[i];
        }
        self.evaluations += other.evaluations;
        self.untrusted += other.untrusted;
        self.unresolved_edges += other.unresolved_edges;
        self.beyond_footprints += other.beyond_footprints;
        for (sum, part) in self.weak_sample.iter_mut().zip(other.weak_sample) {
            *sum += part;
        }
        self.aberration.merge(&other.aberration);
    }

    /// η: the estimated relative error of the field from aberration inside beamlets, uncorrected.
    pub fn eta(&self) -> f64 {
        ratio(self.aberration.plain, self.aberration.energy).sqrt() * self.darkness()
    }

    /// What is left of it after the correction.
    pub(crate) fn eta_corrected(&self) -> f64 {
        ratio(self.aberration.left, self.aberration.energy).sqrt() * self.darkness()
    }

    /// ε₃: the root mean square cubic phase inside beamlets, in rad.
    pub(crate) fn cubic_phase(&self) -> f64 {
        ratio(self.aberration.cubic, self.aberration.energy).sqrt()
    }

    /// The root mean square of what a lattice of windows leaves of the cubic phase, in rad, but for the factor of their
    /// distance.
    pub(crate) fn lattice_phase(&self) -> f64 {
        ratio(self.aberration.lattice, self.aberration.energy).sqrt()
    }

    /// The energy of the first orders of the lattice of windows that falls on the target, over that of the light itself.
    pub(crate) fn orders(&self) -> f64 {
        match self.aberration.energy > 0.0 {
            true => ratio(self.aberration.orders, self.aberration.energy),
            false => 1.0,
        }
    }

    /// How much stronger the beamlets that meet the target are than the field they add up to there: their tails
    /// cancel where the target is darker than what surrounds it, and their errors do not. At least 1.
    pub(crate) fn darkness(&self) -> f64 {
        let total: f64 = self.energy.iter().sum();
        match self.landed {
            Some(landed) => ratio(self.aberration.energy, ALIKE * landed * total)
                .max(1.0)
                .sqrt(),
            None => 1.0,
        }
    }

    /// √ of what edges send to the target in directions that their nodes do not resolve, over the energy that arrives.
    pub(crate) fn edges_left_out(&self) -> f64 {
        ratio(self.unresolved_edges, self.arrived()).sqrt()
    }

    /// √ of what the ends of footprints cut off on the target, over the energy that arrives.
    pub(crate) fn footprints_left_out(&self) -> f64 {
        ratio(self.beyond_footprints, self.arrived()).sqrt()
    }

    /// The energy that arrives at the target: of the field, where it is known.
    fn arrived(&self) -> f64 {
        match self.landed {
            Some(landed) => landed * self.total_energy(),
            None => self.energy[Fate::Arrived.place()],
        }
    }

    /// Standard error of the field from what was drawn at random, relative to the field as it came out:
    /// near one where that is all noise.
    pub fn standard_error(&self) -> Option<f64> {
        self.sampling
            .map(|[variance, square]| ratio(variance.max(0.0), square).sqrt())
    }

    /// √ of the energy in modes below the threshold that falls on the target, as their sample tells, over that which the
    /// others bring there. Without a sample they reach the target as often as the others.
    pub(crate) fn dropped_of_followed(&self) -> f64 {
        let weak = self.energy[Fate::Weak.place()];
        let [sampled, landing] = self.weak_sample;
        match sampled > 0.0 && self.aberration.energy > 0.0 {
            true => ratio(weak * landing / sampled, self.aberration.energy).sqrt(),
            false => ratio(weak, self.total_energy()).sqrt(),
        }
    }

    /// √ of the share of the energy in modes below the threshold, of which so much shows in the field as a ratio of amplitudes,
    /// and in tails that are not trusted.
    pub(crate) fn dropped(&self, shown: f64) -> f64 {
        let kept = self.energy[Fate::Arrived.place()];
        let weak = self.energy[Fate::Weak.place()];
        let tails = ratio(self.untrusted, self.aberration.energy + self.untrusted);
        (shown * shown * ratio(weak, kept + weak) + tails).sqrt() * self.darkness()
    }
}

/// Incoherent sums over tails agree with the light that lands to about this factor where it is evenly lit.
const ALIKE: f64 = 2.0;

fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}
