//! The Kaiser–Bessel bump, by which non-uniform Fourier sums pass through a uniform grid.
//!
//! φ(t) = I₀(β√(1 − (2t/w)²))/I₀(β) for |t| ≤ w/2 and zero beyond, t in grid steps. Inside its support
//! it is entire, so that between neighbouring grid points each tap is a polynomial of low degree. On a
//! twice oversampled grid β ≈ 3πw/4 makes the aliased energy least, and it falls tenfold with every tap
//! (as for the related kernel of Barnett, Magland and af Klinteberg, SIAM J. Sci. Comput. 41, C479, 2019).

use std::f64::consts::PI;

/// The most taps along one axis; coefficients are stored in lines of this length, zero beyond the width.
pub(crate) const LANES: usize = 16;

/// Aliases summed on either side to predict the error; the rest would add one percent.
const ALIASES: usize = 20;

/// A kernel: its width, and the polynomial of each tap.
#[derive(Clone, Debug)]
pub(crate) struct Kaiser {
    /// Number of grid points that a source touches along an axis.
    pub(crate) width: usize,
    beta: f64,
    /// Coefficients, highest power first: tap j of a source at fraction d after its grid point is
    /// Σ coefficients\[k\]\[j\]·(2d − 1)^(degree − k). The source's bump is centred w/2 − 1 later.
    pub(crate) coefficients: Vec<[f64; LANES]>,
}

impl Kaiser {
    /// The narrowest kernel whose error is within `tolerance`; none if 16 taps are not enough.
    ///
    /// `axes` are the numbers of modes and of grid points along each axis. The error is relative, root
    /// mean square over the modes, for strengths and positions without order.
    pub(crate) fn within(tolerance: f64, axes: [[usize; 2]; 2]) -> Option<Self> {
        let edge = |[modes, grid]: [usize; 2]| (modes / 2) as f64 / grid as f64;
        let band = edge(axes[0]).max(edge(axes[1]));
        let fits = |kernel: &Self| {
            axes.into_iter()
                .map(|axis| kernel.aliased(axis))
                .sum::<f64>()
                <= tolerance * tolerance
        };
        let bump = |width: usize| {
            // The bump's transform ends where the first alias begins; the last term is fitted.
            let beta = PI * width as f64 * (1.0 - band) - 1.28 / width as f64;
            Self {
                width,
                beta,
                coefficients: Vec::new(),
            }
        };
        // Each tap gains about a digit, so the search begins not far from its end.
        let least = (-tolerance.log10() - 2.0).max(2.0) as usize;
        let mut kernel = (least..=LANES).map(bump).find(fits)?;

        // The lowest degree at which the series has converged well below the error of the kernel.
        let mut degree = kernel.width;
        while !kernel.fit(degree, (0.01 * tolerance).max(5e-16)) {
            degree += 1;
        }
        Some(kernel)
    }

    /// Mean over the modes of an axis of aliased over true energy, by the closed form of the transform.
    fn aliased(&self, [modes, grid]: [usize; 2]) -> f64 {
        // Some of the modes, evenly chosen, represent all.
        let chosen = modes.min(64);
        let mode = |i: usize| {
            let j = (i * modes + modes / 2) / chosen;
            let cycles = (j as f64 - (modes / 2) as f64) / grid as f64;
            let alias = |m: usize| {
                let m = m as f64;
                self.transform_above_cut(m + cycles).powi(2)
                    + self.transform_above_cut(m - cycles).powi(2)
            };
            (1..=ALIASES).map(alias).sum::<f64>() / self.transform(cycles).powi(2)
        };
        (0..chosen).map(mode).sum::<f64>() / chosen as f64
    }

    /// By how much the bump of a source lies after the source itself, in grid steps.
    pub(crate) fn delay(&self) -> f64 {
        0.5 * self.width as f64 - 1.0
    }

    /// φ at distance `t` in grid steps.
    fn value(&self, t: f64) -> f64 {
        let z = 2.0 * t / self.width as f64;
        bessel_i0(self.beta * (1.0 - z * z).max(0.0).sqrt()) / bessel_i0(self.beta)
    }

    /// ∫φ(t)·exp(−2πi·cycles·t)dt, for less than half a cycle per grid step.
    pub(crate) fn transform(&self, cycles: f64) -> f64 {
        let width = self.width as f64;
        let across = PI * width * cycles;
        let root = (self.beta * self.beta - across * across).sqrt();
        width * root.sinh() / (root * bessel_i0(self.beta))
    }

    /// The same integral for frequencies above the cut, where it oscillates.
    fn transform_above_cut(&self, cycles: f64) -> f64 {
        let width = self.width as f64;
        let across = PI * width * cycles;
        let root = (across * across - self.beta * self.beta).sqrt();
        width * root.sin() / (root * bessel_i0(self.beta))
    }

    /// Fits polynomials of the given degree, and returns whether their last terms are below `bound`.
    fn fit(&mut self, degree: usize, bound: f64) -> bool {
        self.coefficients = vec![[0.0; LANES]; degree + 1];
        let mut last = 0.0_f64;
        for tap in 0..self.width {
            let distance = |s: f64| tap as f64 - self.delay() - 0.5 * (s + 1.0);
            let series = chebyshev(degree, |s| self.value(distance(s)));
            last = last.max(series[degree].abs()).max(series[degree - 1].abs());
            for (power, value) in monomials(&series).into_iter().enumerate() {
                self.coefficients[degree - power][tap] = value;
            }
        }
        last <= bound
    }
}

/// The modified Bessel function I₀ for moderate x, by its power series of positive terms.
pub(crate) fn bessel_i0(x: f64) -> f64 {
    let square = 0.25 * x * x;
    let (mut term, mut sum, mut k) = (1.0, 1.0, 0.0);
    while term > f64::EPSILON * 1e-2 * sum {
        k += 1.0;
        term *= square / (k * k);
        sum += term;
    }
    sum
}

/// Coefficients of the Chebyshev series through `f` at the Chebyshev points of \[−1, 1\].
fn chebyshev(degree: usize, f: impl Fn(f64) -> f64) -> Vec<f64> {
    let count = degree + 1;
    let angle = |k: usize| PI * (k as f64 + 0.5) / count as f64;
    let values: Vec<f64> = (0..count).map(|k| f(angle(k).cos())).collect();
    let coefficient = |n: usize| {
        let weight = if n == 0 { 1.0 } else { 2.0 } / count as f64;
        weight
            * (0..count)
                .map(|k| values[k] * (n as f64 * angle(k)).cos())
                .sum::<f64>()
    };
    (0..count).map(coefficient).collect()
}

/// Coefficients of 1, s, s², … of a Chebyshev series, by T₍ₙ₊₁₎ = 2s·Tₙ − T₍ₙ₋₁₎.
fn monomials(series: &[f64]) -> Vec<f64> {
    let count = series.len();
    let mut sum = vec![0.0; count];
    let (mut before, mut now) = (vec![0.0; count], vec![0.0; count]);
    now[0] = 1.0;
    for (n, &coefficient) in series.iter().enumerate() {
        sum.iter_mut()
            .zip(&now)
            .for_each(|(sum, power)| *sum += coefficient * power);
        let factor = if n == 0 { 1.0 } else { 2.0 };
        let shifted = |k: usize| if k == 0 { 0.0 } else { factor * now[k - 1] };
        let next = (0..count).map(|k| shifted(k) - before[k]).collect();
        before = std::mem::replace(&mut now, next);
    }
    sum
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use crate::math::kaiser::{Kaiser, bessel_i0};

    #[test]
    fn bessel_values() {
        // Abramowitz and Stegun, tables 9.8 and 9.11.
        assert!((bessel_i0(1.0) / 1.266065877752008 - 1.0).abs() < 1e-15);
        assert!((bessel_i0(10.0) / 2815.716628466254 - 1.0).abs() < 1e-14);
    }

    /// A kernel for 100 × 100 modes on a twice finer grid.
    fn kernel(tolerance: f64) -> Kaiser {
        Kaiser::within(tolerance, [[100, 200]; 2]).unwrap()
    }

    #[test]
    fn polynomials_follow_the_bump() {
        for digits in 1..=13 {
            let tolerance = 0.1_f64.powi(digits);
            let kernel = kernel(tolerance);
            for i in 0..100 {
                let d = f64::from(i) / 100.0;
                for tap in 0..kernel.width {
                    let s = 2.0 * d - 1.0;
                    let value = kernel
                        .coefficients
                        .iter()
                        .fold(0.0, |sum, c| sum * s + c[tap]);
                    let expected = kernel.value(tap as f64 - kernel.delay() - d);
                    assert!((value - expected).abs() < 0.01 * tolerance + 1e-14);
                }
            }
        }
    }

    #[test]
    fn transform_is_the_integral() {
        let kernel = kernel(1e-9);
        for cycles in [0.0, 0.1, 0.25, 0.75, 1.3] {
            // Midpoint rule: the bump is smooth but for a jump of 1/I₀(β) at its ends.
            let count = 20_000;
            let step = kernel.width as f64 / f64::from(count);
            let term = |i: i32| {
                let t = (f64::from(i) + 0.5) * step - 0.5 * kernel.width as f64;
                kernel.value(t) * (2.0 * PI * cycles * t).cos() * step
            };
            let integral: f64 = (0..count).map(term).sum();
            let inside = cycles < 0.5;
            let closed = if inside {
                kernel.transform(cycles)
            } else {
                kernel.transform_above_cut(cycles)
            };
            assert!(
                (closed - integral).abs() < 1e-13,
                "{cycles} {closed:e} {integral:e}"
            );
        }
    }

    #[test]
    fn a_digit_for_each_tap() {
        let widths = [2, 6, 9, 12].map(|digits| kernel(0.1_f64.powi(digits)).width);
        assert_eq!(widths, [3, 7, 10, 14]);
        assert!(Kaiser::within(1e-17, [[100, 200]; 2]).is_none());
        // A finer grid needs fewer taps.
        assert_eq!(Kaiser::within(1e-6, [[100, 400]; 2]).unwrap().width, 6);
    }
}
