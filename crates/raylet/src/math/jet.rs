//! A number that carries first and second derivatives with respect to two inputs.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::math::real::Real;

/// f, its slopes f_x, f_y and its second derivatives f_xx, f_xy, f_yy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jet<T = f64> {
    /// The number.
    pub value: T,
    /// First derivatives (x, y).
    pub slope: [T; 2],
    /// Second derivatives (xx, xy, yy).
    pub hessian: [T; 3],
}

impl<T: Real> Jet<T> {
    /// The `index`-th of the two inputs.
    #[inline(always)]
    pub(crate) fn variable(value: T, index: usize) -> Self {
        let zero = T::constant(0.0);
        let mut slope = [zero; 2];
        slope[index] = T::constant(1.0);
        Self {
            value,
            slope,
            hessian: [zero; 3],
        }
    }

    /// A scalar function of this number, given its value and first two derivatives there.
    #[inline(always)]
    fn chain(self, value: T, first: T, second: T) -> Self {
        let ([x, y], [xx, xy, yy]) = (self.slope, self.hessian);
        Self {
            value,
            slope: [first * x, first * y],
            hessian: [
                first * xx + second * x * x,
                first * xy + second * x * y,
                first * yy + second * y * y,
            ],
        }
    }
}

impl<T: Real> Real for Jet<T> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self {
            value: T::constant(value),
            slope: [T::constant(0.0); 2],
            hessian: [T::constant(0.0); 3],
        }
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.value.value()
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let half = T::constant(0.5) / root;
        self.chain(root, half, half * -0.5 / self.value)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let power = self.value.exp();
        self.chain(power, power, power)
    }
}

impl<T: Real> Add for Jet<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (f, [fx, fy], [fxx, fxy, fyy]) = (self.value, self.slope, self.hessian);
        let (g, [gx, gy], [gxx, gxy, gyy]) = (other.value, other.slope, other.hessian);
        Self {
            value: f + g,
            slope: [fx + gx, fy + gy],
            hessian: [fxx + gxx, fxy + gxy, fyy + gyy],
        }
    }
}

impl<T: Real> Sub for Jet<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<T: Real> Mul for Jet<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (f, [fx, fy], [fxx, fxy, fyy]) = (self.value, self.slope, self.hessian);
        let (g, [gx, gy], [gxx, gxy, gyy]) = (other.value, other.slope, other.hessian);
        Self {
            value: f * g,
            slope: [fx * g + f * gx, fy * g + f * gy],
            hessian: [
                fxx * g + fx * gx * 2.0 + f * gxx,
                fxy * g + fx * gy + fy * gx + f * gxy,
                fyy * g + fy * gy * 2.0 + f * gyy,
            ],
        }
    }
}

impl<T: Real> Div for Jet<T> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = T::constant(1.0) / other.value;
        let square = inverse * inverse;
        self * other.chain(inverse, -square, square * inverse * 2.0)
    }
}

impl<T: Real> Neg for Jet<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.value, T::constant(-1.0), T::constant(0.0))
    }
}

impl<T: Real> Add<f64> for Jet<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        self.chain(self.value + other, T::constant(1.0), T::constant(0.0))
    }
}

impl<T: Real> Sub<f64> for Jet<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        self.chain(self.value - other, T::constant(1.0), T::constant(0.0))
    }
}

impl<T: Real> Mul<f64> for Jet<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, T::constant(other), T::constant(0.0))
    }
}

#[cfg(test)]
mod tests {
    use crate::math::jet::Jet;
    use crate::math::real::{Dual, Real};

    fn formula<T: Real>(x: T, y: T) -> T {
        (x * y * y + (x / y).sqrt() - y * 3.0 + (x * y).exp()) / (T::constant(2.0) - -x)
    }

    #[test]
    fn second_derivatives_match_differences_of_slopes() {
        let (x, y, h) = (0.7, 1.3, 1e-5);
        let slope =
            |x: f64, y: f64| formula(Dual::<2>::variable(x, 0), Dual::variable(y, 1)).tangent;
        let jet = formula(Jet::variable(x, 0), Jet::variable(y, 1));
        let dx: [f64; 2] =
            std::array::from_fn(|i| (slope(x + h, y)[i] - slope(x - h, y)[i]) / (2.0 * h));
        let dy = (slope(x, y + h)[1] - slope(x, y - h)[1]) / (2.0 * h);
        assert!((jet.value - formula(x, y)).abs() < 1e-15);
        for (ours, theirs) in jet.slope.iter().zip(slope(x, y)) {
            assert!((ours - theirs).abs() < 1e-14);
        }
        for (ours, theirs) in jet.hessian.iter().zip([dx[0], dx[1], dy]) {
            assert!((ours - theirs).abs() < 1e-8, "{ours} {theirs}");
        }
    }
}
