//! What a hop takes: rays and values, counted as a run counts them, and seconds.

use std::iter::Sum;
use std::ops::{Add, Mul};

/// The work of a hop, or of a part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Rays followed.
    pub rays: f64,
    /// Values summed on the second screen.
    pub values: f64,
    /// Seconds of one core, about.
    pub seconds: f64,
}

impl Add for Work {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            values: self.values + other.values,
            seconds: self.seconds + other.seconds,
        }
    }
}

impl Mul<f64> for Work {
    type Output = Self;
    fn mul(self, times: f64) -> Self {
        Self {
            rays: self.rays * times,
            values: self.values * times,
            seconds: self.seconds * times,
        }
    }
}

impl Sum for Work {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), Add::add)
    }
}
