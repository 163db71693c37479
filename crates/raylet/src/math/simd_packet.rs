//! Several plain numbers in one formula: eight rays at once.
//!
//! Inside `fearless_simd::dispatch!` its loops become the machine's own vectors. No fused multiply-add is used,
//! so that every number has the bits that it would have alone.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::math::real::Real;

/// How many numbers a packet holds.
pub(crate) const PACKET: usize = 8;

/// Eight numbers. Its value is the first of them; decisions are taken for all or not at all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SimdPacket(pub [f64; PACKET]);

impl SimdPacket {
    // Written out: the tracing of eight rays has thousands of these, and as many loops take the compiler minutes.
    #[inline(always)]
    fn each(self, of: impl Fn(f64) -> f64) -> Self {
        let [a, b, c, d, e, f, g, h] = self.0;
        Self([of(a), of(b), of(c), of(d), of(e), of(f), of(g), of(h)])
    }

    #[inline(always)]
    fn with(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let [a, b, c, d, e, f, g, h] = self.0;
        let [i, j, k, l, m, n, o, p] = other.0;
        Self([
            of(a, i),
            of(b, j),
            of(c, k),
            of(d, l),
            of(e, m),
            of(f, n),
            of(g, o),
            of(h, p),
        ])
    }
}

impl Real for SimdPacket {
    const SEVERAL: bool = true;
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value; PACKET])
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.0[0]
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.each(f64::sqrt)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        self.each(f64::exp)
    }
    #[inline(always)]
    fn any_pair(self, other: Self, test: impl Fn(f64, f64) -> bool) -> bool {
        // Without a jump for each number.
        let mut any = false;
        for (number, other) in self.0.iter().zip(&other.0) {
            any |= test(*number, *other);
        }
        any
    }
    #[inline(always)]
    fn where_pair(self, a: Self, b: Self, test: impl Fn(f64, f64) -> bool) -> Self {
        let tested = a.with(b, |a, b| if test(a, b) { 1.0 } else { 0.0 });
        self.with(
            tested,
            |value, holds| if holds != 0.0 { value } else { 0.0 },
        )
    }
    #[inline(always)]
    fn along(self, other: Self) -> Self {
        self.with(other, |a, b| if b < 0.0 { -a } else { a })
    }
}

impl Add for SimdPacket {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }
}

impl Sub for SimdPacket {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, |a, b| a - b)
    }
}

impl Mul for SimdPacket {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, |a, b| a * b)
    }
}

impl Div for SimdPacket {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.with(other, |a, b| a / b)
    }
}

impl Neg for SimdPacket {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|a| -a)
    }
}

impl Add<f64> for SimdPacket {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        self.each(|a| a + other)
    }
}

impl Sub<f64> for SimdPacket {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        self.each(|a| a - other)
    }
}

impl Mul<f64> for SimdPacket {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.each(|a| a * other)
    }
}
