//! Analytic phase profiles of diffractive elements.
//!
//! A profile φ multiplies the field by exp(+iφ) and bends a ray by ∇φ/k in optical direction cosines.

use crate::math::jet::Jet;
use crate::math::real::{Dual, Real};

/// A smooth phase φ(x, y) in radians over the element's own plane, x and y in mm.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    /// φ = gx·x + gy·y: a blazed grating of one order.
    Linear {
        /// Phase gradient in rad/mm.
        gradient: [f64; 2],
    },
    /// The ideal diffractive lens, φ = −k(√(r² + f²) − |f|)·sign f: equal optical path to its focus.
    Lens {
        /// Focal length in mm in the medium around the element; negative diverges.
        focal_length: f64,
        /// Wavenumber k = 2πn/λ it is made for, in rad/mm.
        wavenumber: f64,
    },
    /// φ = slope·r.
    Axicon {
        /// Radial phase gradient in rad/mm; negative bends towards the axis.
        slope: f64,
    },
    /// φ = charge·θ.
    Vortex {
        /// Topological charge.
        charge: i32,
    },
    /// φ = Σ aᵢ (r/ρ)^{2i+2}.
    Radial {
        /// Normalising radius ρ in mm.
        radius: f64,
        /// Coefficients in rad of (r/ρ)², (r/ρ)⁴, …
        coefficients: Vec<f64>,
    },
    /// φ = Σ aⱼ Zⱼ(x/ρ, y/ρ), Noll's order and normalisation (Noll, J. Opt. Soc. Am. 66, 207, 1976).
    Zernike {
        /// Normalising radius ρ in mm.
        radius: f64,
        /// Coefficients in rad of Z₁, Z₂, …
        coefficients: Vec<f64>,
    },
}

impl Profile {
    /// The phase in radians.
    pub(crate) fn phase(&self, x: f64, y: f64) -> f64 {
        match self {
            Profile::Vortex { charge } => f64::from(*charge) * y.atan2(x),
            _ => self.smooth(x, y),
        }
    }

    /// The phase gradient in rad/mm; zero at the singular centre of a vortex or axicon.
    pub(crate) fn gradient(&self, x: f64, y: f64) -> [f64; 2] {
        match self {
            Profile::Vortex { charge } => {
                let square = x * x + y * y;
                let rate = if square > 0.0 {
                    f64::from(*charge) / square
                } else {
                    0.0
                };
                [-y * rate, x * rate]
            }
            Profile::Axicon { .. } if x == 0.0 && y == 0.0 => [0.0, 0.0],
            _ => {
                let phase = self.smooth(Dual::<2>::variable(x, 0), Dual::variable(y, 1));
                phase.tangent
            }
        }
    }

    /// The second derivatives (xx, xy, yy) of the phase in rad/mm²; zero at the singular centre of a
    /// vortex or axicon.
    pub(crate) fn hessian(&self, x: f64, y: f64) -> [f64; 3] {
        let square = x * x + y * y;
        match self {
            Profile::Vortex { .. } | Profile::Axicon { .. } if square == 0.0 => [0.0; 3],
            Profile::Vortex { charge } => {
                let rate = f64::from(*charge) / (square * square);
                [
                    2.0 * x * y * rate,
                    (y * y - x * x) * rate,
                    -2.0 * x * y * rate,
                ]
            }
            _ => self.smooth(Jet::variable(x, 0), Jet::variable(y, 1)).bend,
        }
    }

    /// Every profile but the vortex, whose phase is no algebraic function.
    fn smooth<T: Real>(&self, x: T, y: T) -> T {
        match self {
            Profile::Linear { gradient: [gx, gy] } => x * *gx + y * *gy,
            Profile::Lens {
                focal_length: f,
                wavenumber,
            } => {
                // √(r²+f²) − |f| without cancellation.
                let square = x * x + y * y;
                let path = square / ((square + f * f).sqrt() + f.abs());
                path * (-wavenumber * f.signum())
            }
            Profile::Axicon { slope } => (x * x + y * y).sqrt() * *slope,
            Profile::Vortex { .. } => T::constant(0.0),
            Profile::Radial {
                radius,
                coefficients,
            } => {
                let u = (x * x + y * y) * (1.0 / (radius * radius));
                let horner = |sum: T, a: &f64| sum * u + *a;
                coefficients.iter().rev().fold(T::constant(0.0), horner) * u
            }
            Profile::Zernike {
                radius,
                coefficients,
            } => zernikes(coefficients, x * (1.0 / radius), y * (1.0 / radius)),
        }
    }
}

/// Radial order n and signed azimuthal order m of Noll's index (from 1); negative m for sines.
pub(crate) fn noll(index: usize) -> (u32, i32) {
    let mut n = 0;
    let mut first = 1;
    while first + n < index {
        first += n + 1;
        n += 1;
    }
    // Within an order |m| grows by two, starting from the parity of n; even indices are cosines.
    let place = index - first;
    let m = if n % 2 == 0 {
        2 * place.div_ceil(2)
    } else {
        2 * (place / 2) + 1
    };
    let sign = if index.is_multiple_of(2) { 1 } else { -1 };
    (n as u32, sign * m as i32)
}

/// Σ aⱼ Zⱼ(x, y) with the coefficients of Z₁, Z₂, … in Noll's order and normalisation.
pub(crate) fn zernikes<T: Real>(coefficients: &[f64], x: T, y: T) -> T {
    let mut sum = T::constant(0.0);
    for (index, a) in coefficients.iter().enumerate() {
        if *a != 0.0 {
            sum = sum + zernike(index + 1, x, y) * *a;
        }
    }
    sum
}

/// The Noll-normalised Zernike polynomial at (x, y) in units of the normalising radius.
fn zernike<T: Real>(index: usize, x: T, y: T) -> T {
    let (n, m) = noll(index);
    let order = m.unsigned_abs();
    // The angular part with its power of r: (x + iy)^|m|.
    let (mut re, mut im) = (T::constant(1.0), T::constant(0.0));
    for _ in 0..order {
        (re, im) = (re * x - im * y, re * y + im * x);
    }
    let angular = if m < 0 { im } else { re };
    // The rest of the radial part is a polynomial in u = r², highest power first.
    let u = x * x + y * y;
    let half = (n - order) / 2;
    let mut radial = T::constant(0.0);
    for s in 0..=half {
        radial = radial * u + radial_coefficient(n, order, s);
    }
    let norm = f64::from(n + 1) * if m == 0 { 1.0 } else { 2.0 };
    angular * radial * norm.sqrt()
}

/// k! for all k for which it is a number.
const FACTORIALS: [f64; 171] = {
    let mut list = [1.0; 171];
    let mut k = 1;
    while k < list.len() {
        list[k] = list[k - 1] * k as f64;
        k += 1;
    }
    list
};

/// (−1)^s (n−s)! / (s! ((n+m)/2−s)! ((n−m)/2−s)!).
fn radial_coefficient(n: u32, m: u32, s: u32) -> f64 {
    let factorial = |k: u32| FACTORIALS.get(k as usize).map_or(f64::INFINITY, |&k| k);
    let sign = if s.is_multiple_of(2) { 1.0 } else { -1.0 };
    sign * factorial(n - s)
        / (factorial(s) * factorial((n + m) / 2 - s) * factorial((n - m) / 2 - s))
}

#[cfg(test)]
mod tests {
    use crate::optics::profile::{Profile, noll};

    #[test]
    fn gradients_match_differences() {
        let profiles = [
            Profile::Linear {
                gradient: [3.0, -2.0],
            },
            Profile::Lens {
                focal_length: -7.0,
                wavenumber: 900.0,
            },
            Profile::Axicon { slope: -4.0 },
            Profile::Vortex { charge: 3 },
            Profile::Radial {
                radius: 2.0,
                coefficients: vec![1.0, -0.5, 0.2],
            },
            Profile::Zernike {
                radius: 1.5,
                coefficients: (1..=15).map(|j| 1.0 / f64::from(j)).collect(),
            },
        ];
        let (x, y, h) = (0.4, -0.9, 1e-5);
        for profile in profiles {
            let [gx, gy] = profile.gradient(x, y);
            let dx = (profile.phase(x + h, y) - profile.phase(x - h, y)) / (2.0 * h);
            let dy = (profile.phase(x, y + h) - profile.phase(x, y - h)) / (2.0 * h);
            let scale = 1.0 + gx.hypot(gy);
            assert!((gx - dx).abs() < 1e-7 * scale, "{profile:?}");
            assert!((gy - dy).abs() < 1e-7 * scale, "{profile:?}");

            // Second derivatives against differences of the first.
            let along_x = (profile.gradient(x + h, y), profile.gradient(x - h, y));
            let along_y = (profile.gradient(x, y + h), profile.gradient(x, y - h));
            let expected = [
                (along_x.0[0] - along_x.1[0]) / (2.0 * h),
                (along_x.0[1] - along_x.1[1]) / (2.0 * h),
                (along_y.0[1] - along_y.1[1]) / (2.0 * h),
            ];
            for (ours, theirs) in profile.hessian(x, y).iter().zip(expected) {
                assert!((ours - theirs).abs() < 1e-7 * scale, "{profile:?}");
            }
        }
    }

    #[test]
    fn noll_order_is_the_published_one() {
        let published = [
            (0, 0),
            (1, 1),
            (1, -1),
            (2, 0),
            (2, -2),
            (2, 2),
            (3, -1),
            (3, 1),
            (3, -3),
            (3, 3),
            (4, 0),
            (4, 2),
            (4, -2),
            (4, 4),
            (4, -4),
        ];
        for (i, expected) in published.iter().enumerate() {
            assert_eq!(noll(i + 1), *expected, "Z{}", i + 1);
        }
    }

    #[test]
    fn zernikes_are_orthonormal_on_the_unit_disc() {
        // Midpoint rule in polar coordinates; Noll: mean of Zi·Zj over the disc is δij.
        let term = |j: usize| {
            let mut coefficients = vec![0.0; j];
            coefficients[j - 1] = 1.0;
            Profile::Zernike {
                radius: 1.0,
                coefficients,
            }
        };
        let mean = |i: usize, j: usize| {
            let (a, b) = (term(i), term(j));
            let (rings, spokes) = (400, 64);
            let mut sum = 0.0;
            for ring in 0..rings {
                let r = ((f64::from(ring) + 0.5) / f64::from(rings)).sqrt();
                for spoke in 0..spokes {
                    let t = f64::from(spoke) * std::f64::consts::TAU / f64::from(spokes);
                    let (x, y) = (r * t.cos(), r * t.sin());
                    sum += a.phase(x, y) * b.phase(x, y);
                }
            }
            sum / f64::from(rings * spokes)
        };
        for i in 1..=11 {
            for j in 1..=11 {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((mean(i, j) - expected).abs() < 1e-4, "Z{i} Z{j}");
            }
        }
    }
}
