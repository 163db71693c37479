//! Interpolation on Chebyshev points, for functions whose oscillation is known.

/// The Chebyshev points of an interval, as many as a function of known oscillation needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// The points, ascending.
    pub at: Vec<f64>,
    /// Their barycentric weights.
    weights: Vec<f64>,
}

/// Most levels: about two hundred radians either way.
const MOST: usize = 400;

impl Levels {
    /// Points between `low` and `high` on which f(z) = exp(iκz), |κ| ≤ `rate`, is interpolated to within
    /// about `tolerance`.
    pub(crate) fn new(low: f64, high: f64, rate: f64, tolerance: f64) -> Self {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let count = count(rate * half, tolerance);
        let angle = |i: usize| std::f64::consts::PI * (i as f64 + 0.5) / count as f64;
        let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        Self {
            at: (0..count).map(|i| middle - half * angle(i).cos()).collect(),
            weights: (0..count).map(|i| sign(i) * angle(i).sin()).collect(),
        }
    }

    /// The share of one level in the value at z.
    pub(crate) fn share(&self, z: f64, number: usize) -> f64 {
        let (mut own, mut total) = (0.0, 0.0);
        for (i, level) in self.at.iter().enumerate() {
            if z == *level {
                return if i == number { 1.0 } else { 0.0 };
            }
            let term = self.weights[i] / (z - level);
            total += term;
            if i == number {
                own = term;
            }
        }
        own / total
    }

    /// The barycentric weight of a level: its share at z is its weight over z − its place, over [`Levels::total`] there.
    pub(crate) fn weight(&self, number: usize) -> f64 {
        self.weights[number]
    }

    /// What the shares of all levels at z are divided by; infinite on a level.
    pub(crate) fn total(&self, z: f64) -> f64 {
        let terms = self.weights.iter().zip(&self.at);
        terms.map(|(weight, level)| weight / (z - level)).sum()
    }

    /// The share of each level in the value at z: barycentric weights (Berrut and Trefethen, SIAM Rev. 46,
    /// 501, 2004). They add up to one.
    pub(crate) fn shares(&self, z: f64, shares: &mut [f64]) {
        if let Some(exact) = self.at.iter().position(|level| *level == z) {
            shares.fill(0.0);
            shares[exact] = 1.0;
            return;
        }
        let mut total = 0.0;
        for (i, (share, level)) in shares.iter_mut().zip(&self.at).enumerate() {
            *share = self.weights[i] / (z - level);
            total += *share;
        }
        shares.iter_mut().for_each(|share| *share /= total);
    }
}

/// Chebyshev points for exp(iφt) on [−1, 1]: the first left-out coefficient 2 J_n(φ) bounds the error, and
/// J_n(φ) ≤ (φ/2)ⁿ/n!.
fn count(phase: f64, tolerance: f64) -> usize {
    let mut bound = 2.0;
    for n in 1..MOST {
        bound *= 0.5 * phase / n as f64;
        if bound < tolerance && n as f64 > 0.5 * phase {
            return n;
        }
    }
    MOST
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::math::chebyshev::Levels;

    #[test]
    fn oscillations_are_interpolated_within_the_tolerance() {
        for (rate, tolerance) in [(1.0, 1e-3), (30.0, 1e-6), (200.0, 1e-9)] {
            let levels = Levels::new(-0.3, 1.1, rate, tolerance);
            let mut shares = vec![0.0; levels.at.len()];
            let mut worst = 0.0f64;
            for i in 0..=200 {
                let z = -0.3 + 1.4 * f64::from(i) / 200.0;
                levels.shares(z, &mut shares);
                let terms = levels.at.iter().zip(&shares);
                let sum: Complex64 = terms.map(|(l, w)| Complex64::cis(rate * l) * w).sum();
                worst = worst.max((sum - Complex64::cis(rate * z)).norm());
            }
            // The Lebesgue constant of a few hundred points is below five.
            assert!(worst < 5.0 * tolerance, "{rate}: {worst:e}");
            assert!(
                levels.at.len() < 20 + (rate * 1.4) as usize,
                "too many points"
            );
        }
    }

    #[test]
    fn a_flat_interval_has_one_level() {
        let levels = Levels::new(2.0, 2.0, 100.0, 1e-6);
        assert_eq!(levels.at, [2.0]);
    }
}
