//! Numbers of twice the usual precision, for phases. After the whole turns of a phase of many radians are
//! dropped, the rest must still be right to 16 digits.
//!
//! The sums and products without error are those of Dekker, "A floating-point technique for extending the
//! available precision", Numer. Math. 18, 224, 1971.

use std::f64::consts::TAU;

use num_complex::Complex64;

/// A number as the unevaluated sum of two, good for about 31 digits.
#[derive(Clone, Copy)]
pub(crate) struct Double {
    high: f64,
    low: f64,
}

impl Double {
    /// 1/2π.
    pub(crate) const TURNS_PER_RADIAN: Self = Self {
        high: 0.15915494309189535,
        low: -9.839338337591243e-18,
    };

    /// The same number.
    pub(crate) fn from(value: f64) -> Self {
        Self {
            high: value,
            low: 0.0,
        }
    }

    /// a·b without rounding.
    pub(crate) fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        Self {
            high,
            low: a.mul_add(b, -high),
        }
    }

    /// self·other.
    pub(crate) fn times(self, other: Self) -> Self {
        let exact = Self::product(self.high, other.high);
        let low = exact.low + (self.high * other.low + self.low * other.high);
        Self {
            high: exact.high,
            low: 0.0,
        }
        .plus(Self::from(low))
    }

    /// self + other.
    pub(crate) fn plus(self, other: Self) -> Self {
        // What rounding dropped from the sum of the high parts is recovered exactly (Knuth).
        let sum = self.high + other.high;
        let part = sum - self.high;
        let lost = (self.high - (sum - part)) + (other.high - part);
        let low = lost + (self.low + other.low);
        let high = sum + low;
        Self {
            high,
            low: low - (high - sum),
        }
    }

    /// exp(2πi·self).
    pub(crate) fn phasor(self) -> Complex64 {
        let turns = (self.high - self.high.round()) + self.low;
        Complex64::cis(TAU * (turns - turns.round()))
    }
}

#[cfg(test)]
mod tests {
    use crate::math::double::Double;

    #[test]
    fn products_keep_what_one_number_loses() {
        // (1 + ε)(1 − ε) − 1 = −ε², far below the last digit of one.
        let small = 0.5_f64.powi(50);
        let one = Double::from(1.0);
        let difference = Double::product(1.0 + small, 1.0 - small).plus(Double::from(-1.0));
        assert_eq!(difference.high, -small * small);
        let square = one
            .plus(Double::from(small * small))
            .times(one.plus(Double::from(small)));
        let rest = square.plus(Double::from(-1.0)).plus(Double::from(-small));
        assert!((rest.high / (small * small) - 1.0).abs() < 0.01);
    }

    #[test]
    fn phasors_of_many_turns() {
        // 2^40 whole turns and an eighth, from radians: the turns vanish without trace.
        let turns = Double::from(2.0_f64.powi(40)).plus(Double::from(0.125));
        let root = 0.5_f64.sqrt();
        assert!((turns.phasor() - num_complex::Complex64::new(root, root)).norm() < 2e-16);
        // A million radians, against the library's own reduction.
        let million = Double::TURNS_PER_RADIAN.times(Double::from(1e6)).phasor();
        assert!((million - num_complex::Complex64::cis(1e6)).norm() < 2e-16);
    }
}
