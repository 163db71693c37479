//! How the energy of all modes is spread over their strengths: what a threshold would leave out.

use num_complex::Complex64;

use crate::engine::plan::settings::Settings;

/// Exponents of a double, each a class of strength.
const CLASSES: usize = 2048;

/// Modes counted by the binary exponent of their energy |c|². Counts are whole numbers, so histograms can
/// be merged in any order with the same result.
#[derive(Clone)]
pub(crate) struct ModeHistogram {
    counts: Vec<u64>,
    strongest: f64,
}

impl Default for ModeHistogram {
    fn default() -> Self {
        Self {
            counts: vec![0; CLASSES],
            strongest: 0.0,
        }
    }
}

impl ModeHistogram {
    /// Counts some coefficients.
    pub(crate) fn of<'a>(coefficients: impl Iterator<Item = &'a Complex64>) -> Self {
        let mut histogram = Self::default();
        for c in coefficients {
            let energy = c.norm_sqr();
            histogram.counts[(energy.to_bits() >> 52) as usize % CLASSES] += 1;
            histogram.strongest = histogram.strongest.max(energy);
        }
        histogram
    }

    /// Both together.
    pub(crate) fn merge(mut self, other: Self) -> Self {
        for (a, b) in self.counts.iter_mut().zip(&other.counts) {
            *a += b;
        }
        self.strongest = self.strongest.max(other.strongest);
        self
    }

    /// The energy of all modes, to the width of a class.
    pub(crate) fn total(&self) -> f64 {
        (0..CLASSES - 1).map(|class| self.energy(class)).sum()
    }

    /// The energy of a class: the middle of [2ᵉ, 2ᵉ⁺¹) represents its modes.
    fn energy(&self, class: usize) -> f64 {
        self.counts[class] as f64 * 1.5 * lower(class)
    }

    /// The energy below which modes are left out: the threshold's share of the strongest, or less, so
    /// that what is left out stays within a third of the target error.
    pub(crate) fn floor(&self, settings: &Settings) -> f64 {
        let ceiling = self.strongest * settings.weakest_mode().powi(2);
        self.floor_below(ceiling, (settings.target_error / 3.0).powi(2))
    }

    /// The energy below which modes hold this share of the energy of all.
    pub(crate) fn floor_of_share(&self, share: f64) -> f64 {
        self.floor_below(self.strongest, share)
    }

    /// The share of all modes that are at least this strong, to the width of a class.
    pub(crate) fn share_from(&self, floor: f64) -> f64 {
        let all: u64 = self.counts.iter().sum();
        let class = (floor.to_bits() >> 52) as usize % CLASSES;
        let strong: u64 = self.counts[class..].iter().sum();
        strong as f64 / all.max(1) as f64
    }

    /// The energy of the strongest mode.
    pub(crate) fn strongest(&self) -> f64 {
        self.strongest
    }

    /// A ceiling, or the energy below which modes hold a share of the energy of all, whichever is lower.
    fn floor_below(&self, ceiling: f64, share: f64) -> f64 {
        let budget = self.total() * share;
        let mut left_out = 0.0;
        for class in 1..CLASSES - 1 {
            left_out += self.energy(class);
            if left_out > budget || lower(class) >= ceiling {
                return lower(class).min(ceiling);
            }
        }
        ceiling
    }
}

/// The lowest energy of a class.
fn lower(class: usize) -> f64 {
    f64::from_bits((class as u64) << 52)
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::engine::beamlet::mode_histogram::ModeHistogram;
    use crate::engine::plan::settings::Settings;

    #[test]
    fn what_is_left_out_stays_in_the_budget() {
        // One strong mode and many weak ones that together matter.
        let mut modes = vec![Complex64::new(1.0, 0.0)];
        modes.extend((0..20_000).map(|i| Complex64::new(1e-5 * (1.0 + f64::from(i % 60)), 0.0)));
        let settings = Settings::default();
        let floor = ModeHistogram::of(modes.iter()).floor(&settings);
        let energy = |keep: &dyn Fn(f64) -> bool| -> f64 {
            modes
                .iter()
                .map(|c| c.norm_sqr())
                .filter(|e| keep(*e))
                .sum()
        };
        let share = (energy(&|e| e < floor) / energy(&|_| true)).sqrt();
        assert!(share < settings.target_error / 2.0, "{share:e}");
        assert!(floor <= 1e-6, "{floor:e}");
        assert!(floor > 1e-10, "{floor:e}");
        let strong = modes.iter().filter(|c| c.norm_sqr() >= floor).count();
        let share = strong as f64 / modes.len() as f64;
        let found = ModeHistogram::of(modes.iter()).share_from(floor);
        assert!((found / share - 1.0).abs() < 0.1, "{found} {share}");
    }
}
