//! One number in a formula: a plain `f64`, or a number that carries tangents.
//!
//! Every geometric formula of the ray path is written once, generic over [`Real`]. Run with `f64` it
//! gives the ray; run with [`Dual`] it gives the ray and its exact first derivatives (forward-mode
//! differentiation), which is how ray Jacobians and lens gradients are obtained.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number that formulas can be evaluated with.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// A number without tangents.
    fn constant(value: f64) -> Self;
    /// The number itself, without its tangents.
    fn value(self) -> f64;
    /// The positive square root.
    fn sqrt(self) -> Self;
    /// The exponential.
    fn exp(self) -> Self;
    /// This number, with its sign changed where another is negative.
    #[inline(always)]
    fn along(self, other: Self) -> Self {
        if other.value() < 0.0 { -self } else { self }
    }
}

impl Real for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        f64::exp(self)
    }
}

/// A number with `N` tangents: its derivatives with respect to `N` independent inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize> {
    /// The number.
    pub value: f64,
    /// Its derivatives.
    pub tangent: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// The `index`-th independent input: tangent one along itself, zero along the others.
    pub fn variable(value: f64, index: usize) -> Self {
        let mut tangent = [0.0; N];
        tangent[index] = 1.0;
        Self { value, tangent }
    }

    /// Applies a scalar function with known value and slope.
    #[inline(always)]
    fn chain(self, value: f64, slope: f64) -> Self {
        Self {
            value,
            tangent: self.tangent.map(|t| t * slope),
        }
    }
}

impl<const N: usize> Real for Dual<N> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self {
            value,
            tangent: [0.0; N],
        }
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let power = self.value.exp();
        self.chain(power, power)
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            tangent: std::array::from_fn(|i| self.tangent[i] + other.tangent[i]),
        }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            value: self.value - other.value,
            tangent: std::array::from_fn(|i| self.tangent[i] - other.tangent[i]),
        }
    }
}

#[expect(
    clippy::suspicious_arithmetic_impl,
    reason = "the rule of differentiation for this operation"
)]
impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            tangent: std::array::from_fn(|i| {
                self.value * other.tangent[i] + self.tangent[i] * other.value
            }),
        }
    }
}

#[expect(
    clippy::suspicious_arithmetic_impl,
    reason = "the rule of differentiation for this operation"
)]
impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self {
            value,
            tangent: std::array::from_fn(|i| {
                (self.tangent[i] - value * other.tangent[i]) / other.value
            }),
        }
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        self.chain(self.value + other, 1.0)
    }
}

impl<const N: usize> Sub<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        self.chain(self.value - other, 1.0)
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, other)
    }
}

#[cfg(test)]
mod tests {
    use crate::math::real::{Dual, Real};

    fn formula<T: Real>(x: T, y: T) -> T {
        (x * y + (x / y).sqrt() - y * 3.0) / (T::constant(2.0) - -x)
    }

    #[test]
    fn dual_tangents_match_central_differences() {
        let (x, y, h) = (0.7, 1.3, 1e-6);
        let dual = formula(Dual::<2>::variable(x, 0), Dual::<2>::variable(y, 1));
        let dx = (formula(x + h, y) - formula(x - h, y)) / (2.0 * h);
        let dy = (formula(x, y + h) - formula(x, y - h)) / (2.0 * h);
        assert!((dual.value - formula(x, y)).abs() < 1e-15);
        assert!((dual.tangent[0] - dx).abs() < 1e-9);
        assert!((dual.tangent[1] - dy).abs() < 1e-9);
    }
}
