//! The diffraction orders of a blazed or stepped profile.
//!
//! A kinoform is a smooth phase φ folded into heights of one wavelength of its design. At another wavelength its phase is
//! α (φ mod 2π), with α the ratio of the phases that one height makes at the two wavelengths. So its transmission is
//! Σ cₘ exp(imφ): each order m is a smooth element of its own.

use num_complex::Complex64;

use crate::math::sinc::sinc;

/// The profile of a period, from φ = 0 to 2π.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Blaze {
    /// A ramp.
    Continuous,
    /// So many equal steps.
    Levels(u32),
}

impl Blaze {
    /// cₘ = (1/2π) ∫ exp(iα profile(φ) − imφ) dφ over a period.
    pub fn amplitude(self, alpha: f64, order: i32) -> Complex64 {
        let m = f64::from(order);
        let beside = alpha - m;
        match self {
            Self::Continuous => Complex64::from_polar(sinc(beside), std::f64::consts::PI * beside),
            Self::Levels(levels) => {
                let count = f64::from(levels);
                // Step number l has the phase 2πl/L, and its middle stands half a step behind its start.
                let step =
                    |l: u32| Complex64::cis(std::f64::consts::TAU * beside * f64::from(l) / count);
                let sum: Complex64 = (0..levels).map(step).sum();
                let half = Complex64::cis(-std::f64::consts::PI * m / count);
                sum / count * half * sinc(m / count)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::optics::phase::blaze::Blaze;

    /// The integral by midpoints.
    fn integral(profile: Blaze, alpha: f64, order: i32) -> Complex64 {
        const NODES: u32 = 48_000;
        let value = |n: u32| {
            let phi = std::f64::consts::TAU * (f64::from(n) + 0.5) / f64::from(NODES);
            let height = match profile {
                Blaze::Continuous => phi,
                Blaze::Levels(levels) => {
                    let step = std::f64::consts::TAU / f64::from(levels);
                    (phi / step).floor() * step
                }
            };
            Complex64::cis(alpha * height - f64::from(order) * phi)
        };
        (0..NODES).map(value).sum::<Complex64>() / f64::from(NODES)
    }

    #[test]
    fn amplitudes_are_the_fourier_coefficients_of_the_profile() {
        for profile in [Blaze::Continuous, Blaze::Levels(2), Blaze::Levels(8)] {
            for alpha in [1.0, 0.83, 1.3] {
                for order in -2..=3 {
                    let (found, exact) = (
                        profile.amplitude(alpha, order),
                        integral(profile, alpha, order),
                    );
                    assert!((found - exact).norm() < 1e-7, "{profile:?} {alpha} {order}");
                }
            }
        }
    }

    /// Efficiencies in textbooks: 40.5 % for two levels, 81.1 % for four, 95 % for eight.
    #[test]
    fn levels_have_their_known_efficiency() {
        for (levels, share) in [(2, 0.405), (4, 0.811), (8, 0.950)] {
            let found = Blaze::Levels(levels).amplitude(1.0, 1).norm_sqr();
            assert!((found - share).abs() < 5e-4, "{levels}: {found}");
        }
    }
}
