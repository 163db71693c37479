//! A number that carries first and second derivatives with respect to two inputs.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::math::real::Real;

/// f, its slopes f_x, f_y and its bends f_xx, f_xy, f_yy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// The number.
    pub value: f64,
    /// First derivatives (x, y).
    pub slope: [f64; 2],
    /// Second derivatives (xx, xy, yy).
    pub bend: [f64; 3],
}

impl Jet {
    /// The `index`-th of the two inputs.
    pub fn variable(value: f64, index: usize) -> Self {
        let mut slope = [0.0; 2];
        slope[index] = 1.0;
        Self {
            value,
            slope,
            bend: [0.0; 3],
        }
    }

    /// A scalar function of this number, given its value and first two derivatives there.
    fn chain(self, value: f64, first: f64, second: f64) -> Self {
        let ([x, y], [xx, xy, yy]) = (self.slope, self.bend);
        Self {
            value,
            slope: [first * x, first * y],
            bend: [
                first * xx + second * x * x,
                first * xy + second * x * y,
                first * yy + second * y * y,
            ],
        }
    }
}

impl Real for Jet {
    fn constant(value: f64) -> Self {
        Self {
            value,
            slope: [0.0; 2],
            bend: [0.0; 3],
        }
    }
    fn value(self) -> f64 {
        self.value
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root, -0.25 / (root * self.value))
    }
}

impl Add for Jet {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            slope: std::array::from_fn(|i| self.slope[i] + other.slope[i]),
            bend: std::array::from_fn(|i| self.bend[i] + other.bend[i]),
        }
    }
}

impl Sub for Jet {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Jet {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (f, [fx, fy], [fxx, fxy, fyy]) = (self.value, self.slope, self.bend);
        let (g, [gx, gy], [gxx, gxy, gyy]) = (other.value, other.slope, other.bend);
        Self {
            value: f * g,
            slope: [fx * g + f * gx, fy * g + f * gy],
            bend: [
                fxx * g + 2.0 * fx * gx + f * gxx,
                fxy * g + fx * gy + fy * gx + f * gxy,
                fyy * g + 2.0 * fy * gy + f * gyy,
            ],
        }
    }
}

impl Div for Jet {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let inverse = 1.0 / other.value;
        let square = inverse * inverse;
        self * other.chain(inverse, -square, 2.0 * square * inverse)
    }
}

impl Neg for Jet {
    type Output = Self;
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0, 0.0)
    }
}

impl Add<f64> for Jet {
    type Output = Self;
    fn add(self, other: f64) -> Self {
        self.chain(self.value + other, 1.0, 0.0)
    }
}

impl Sub<f64> for Jet {
    type Output = Self;
    fn sub(self, other: f64) -> Self {
        self.chain(self.value - other, 1.0, 0.0)
    }
}

impl Mul<f64> for Jet {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, other, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use crate::math::jet::Jet;
    use crate::math::real::{Dual, Real};

    fn formula<T: Real>(x: T, y: T) -> T {
        (x * y * y + (x / y).sqrt() - y * 3.0) / (T::constant(2.0) - -x)
    }

    #[test]
    fn bends_match_differences_of_slopes() {
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
        for (ours, theirs) in jet.bend.iter().zip([dx[0], dx[1], dy]) {
            assert!((ours - theirs).abs() < 1e-8, "{ours} {theirs}");
        }
    }
}
