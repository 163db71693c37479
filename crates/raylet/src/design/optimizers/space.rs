//! Bounds and scales of parameters.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::design::exact;
use crate::design::optimizers::reduction;

/// A step that ends within this many units in the last place of a bound ends on it.
const ULPS: f64 = 4.0;

/// The largest parameter of a scene: a length in mm.
const LARGEST_PARAMETER: f64 = 1e12;

/// Bounds and scales of a flat vector of parameters.
///
/// The scale of a parameter is a change that matters about as much as a change of any other parameter by its own scale:
/// 1 rad of a phase, perhaps 1e-4/mm of a curvature. Optimisers measure steps and gradients in scales.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Space {
    #[serde(with = "exact::list")]
    lower: Vec<f64>,
    #[serde(with = "exact::list")]
    upper: Vec<f64>,
    #[serde(with = "exact::list")]
    scale: Vec<f64>,
    bounded: bool,
}

/// Why bounds, scales or values of parameters are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SpaceError {
    /// A range that goes beyond the parameters.
    #[error("parameters {from}..{to} of {count}")]
    Range {
        /// First parameter.
        from: usize,
        /// First parameter behind the range.
        to: usize,
        /// How many there are.
        count: usize,
    },
    /// Bounds with no number between them.
    #[error("no number lies between {lower} and {upper}")]
    Empty {
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A scale that is not a positive number.
    #[error("a scale of {0}; expected a positive number")]
    Scale(f64),
    /// A starting point of another length.
    #[error("{found} starting values for {count} parameters")]
    Length {
        /// Values given.
        found: usize,
        /// Parameters there are.
        count: usize,
    },
    /// A starting value that is no number.
    #[error("parameter {index} starts at {value}")]
    NotFinite {
        /// Which one.
        index: usize,
        /// Its value.
        value: f64,
    },
}

impl Space {
    /// Parameters without bounds, each of scale 1.
    pub fn free(count: usize) -> Self {
        Self {
            lower: vec![f64::NEG_INFINITY; count],
            upper: vec![f64::INFINITY; count],
            scale: vec![1.0; count],
            bounded: false,
        }
    }

    /// With bounds, which may be reached, for a block of parameters; infinite ones bind nothing.
    ///
    /// # Errors
    /// When there are no such parameters or no number lies between the bounds.
    pub(crate) fn with_bounds(
        mut self,
        block: Range<usize>,
        lower: f64,
        upper: f64,
    ) -> Result<Self, SpaceError> {
        self.check(&block)?;
        let none = lower == f64::INFINITY || upper == f64::NEG_INFINITY;
        if none || lower.is_nan() || upper.is_nan() || lower > upper {
            return Err(SpaceError::Empty { lower, upper });
        }
        self.lower[block.clone()].fill(lower);
        self.upper[block].fill(upper);
        self.bounded = self.lower.iter().chain(&self.upper).any(|b| b.is_finite());
        Ok(self)
    }

    /// With a scale for a block of parameters.
    ///
    /// # Errors
    /// When there are no such parameters or the scale is not a positive number.
    pub(crate) fn with_scale(
        mut self,
        block: Range<usize>,
        scale: f64,
    ) -> Result<Self, SpaceError> {
        self.check(&block)?;
        if !(scale.is_finite() && scale > 0.0) {
            return Err(SpaceError::Scale(scale));
        }
        self.scale[block].fill(scale);
        Ok(self)
    }

    fn check(&self, block: &Range<usize>) -> Result<(), SpaceError> {
        let (from, to, count) = (block.start, block.end, self.len());
        if from > to || to > count {
            return Err(SpaceError::Range { from, to, count });
        }
        Ok(())
    }

    /// Number of parameters.
    pub(crate) fn len(&self) -> usize {
        self.scale.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.scale.is_empty()
    }

    /// Whether any bound is finite.
    pub(crate) fn is_bounded(&self) -> bool {
        self.bounded
    }

    /// The scale of each parameter.
    pub(crate) fn scales(&self) -> &[f64] {
        &self.scale
    }

    /// A starting point, moved into the bounds.
    ///
    /// # Errors
    /// When it has another length or holds what is not a number.
    pub(crate) fn start(&self, mut point: Vec<f64>) -> Result<Vec<f64>, SpaceError> {
        let (found, count) = (point.len(), self.len());
        if found != count {
            return Err(SpaceError::Length { found, count });
        }
        if let Some(index) = point.iter().position(|value| !value.is_finite()) {
            let value = point[index];
            return Err(SpaceError::NotFinite { index, value });
        }
        reduction::change(&mut point, |i, x| x.clamp(self.lower[i], self.upper[i]));
        Ok(point)
    }

    /// Whether a point has the right length, lies between the bounds, and has no number beyond those that a scene may
    /// have.
    pub(crate) fn holds(&self, point: &[f64]) -> bool {
        let bounds = self.lower.iter().zip(&self.upper);
        let inside = |(x, (lower, upper)): (&f64, (&f64, &f64))| {
            x.abs() <= LARGEST_PARAMETER && lower <= x && x <= upper
        };
        point.len() == self.len() && point.iter().zip(bounds).all(inside)
    }

    /// The value of parameter `i` after a step from `from`. It stays within its bounds. If it misses a bound by
    /// rounding alone, it is that bound.
    #[inline]
    pub(crate) fn moved(&self, i: usize, from: f64, step: f64) -> f64 {
        let (lower, upper) = (self.lower[i], self.upper[i]);
        let to = (from + step).clamp(lower, upper);
        let near = ULPS * f64::EPSILON * (from.abs() + step.abs());
        match to {
            to if to - lower <= near => lower,
            to if upper - to <= near => upper,
            to => to,
        }
    }

    /// Whether parameter `i` is at a bound and going downhill would leave it.
    #[inline]
    pub(crate) fn binds(&self, i: usize, at: f64, slope: f64) -> bool {
        (at <= self.lower[i] && slope >= 0.0) || (at >= self.upper[i] && slope <= 0.0)
    }

    /// The distance of parameter `i` from the bound ahead, divided by the step; infinite without a bound.
    #[inline]
    pub(crate) fn room(&self, i: usize, at: f64, step: f64) -> f64 {
        match step {
            step if step > 0.0 => (self.upper[i] - at) / step,
            step if step < 0.0 => (self.lower[i] - at) / step,
            _ => f64::INFINITY,
        }
    }

    /// The largest downhill step, in scales, that the bounds allow against the gradient: zero at
    /// a minimum.
    pub(crate) fn slope(&self, point: &[f64], gradient: &[f64]) -> f64 {
        let one = |i: usize| {
            let scale = self.scale[i];
            let to = point[i] - scale * scale * gradient[i];
            if self.lower[i] <= to && to <= self.upper[i] {
                return (scale * gradient[i]).abs();
            }
            (to.clamp(self.lower[i], self.upper[i]) - point[i]).abs() / scale
        };
        reduction::extreme(point.len(), 0.0, one, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use crate::design::optimizers::space::{Space, SpaceError};

    #[test]
    fn blocks_have_their_own_bounds_and_scales() {
        let space = Space::free(5).with_bounds(1..3, -1.0, 2.0).unwrap();
        let space = space.with_scale(2..4, 0.1).unwrap();
        let start = space.start(vec![9.0, 9.0, -9.0, 9.0, 9.0]).unwrap();
        assert_eq!(start, [9.0, 2.0, -1.0, 9.0, 9.0]);
        assert_eq!(space.scales(), [1.0, 1.0, 0.1, 0.1, 1.0]);
        assert!(space.holds(&start) && !space.holds(&start[1..]));
        for outside in [2.1, f64::NAN, f64::INFINITY] {
            assert!(!space.holds(&[0.0, outside, 0.0, 0.0, 0.0]));
        }

        // Rounding leaves nothing between a step's end and the bound it was to reach.
        let from = 0.1 + 0.2;
        assert_eq!(space.moved(1, from, 2.0 - from - 2e-16), 2.0);
        assert_eq!(space.moved(1, from, 1.0), from + 1.0);
        assert_eq!(space.room(1, 0.0, -0.5), 2.0);
        assert_eq!(space.room(0, 0.0, -0.5), f64::INFINITY);
        assert!(space.binds(1, 2.0, -0.1) && !space.binds(1, 2.0, 0.1));

        // At a bound only the way back in counts; near it no more than the way to it.
        let gradient = [0.3, -0.5, 8.0, 0.5, 0.0];
        let slope = |at| space.slope(&[0.0, 2.0, at, 0.0, 0.0], &gradient);
        assert_eq!(slope(-1.0), 0.3);
        assert!((slope(-0.95) - 0.5).abs() < 1e-12, "{}", slope(-0.95));
        assert!((slope(0.0) - 0.8).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let space = || Space::free(3);
        assert!(matches!(
            space().with_bounds(2..4, 0.0, 1.0),
            Err(SpaceError::Range { count: 3, .. })
        ));
        let empty = [(1.0, 0.0), (f64::NAN, 0.0), (f64::INFINITY, f64::INFINITY)];
        for (lower, upper) in empty {
            let found = space().with_bounds(0..1, lower, upper);
            assert!(matches!(found, Err(SpaceError::Empty { .. })));
        }
        for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let found = space().with_scale(0..1, scale);
            assert!(matches!(found, Err(SpaceError::Scale(_))));
        }
        assert!(matches!(
            space().start(vec![0.0]),
            Err(SpaceError::Length { .. })
        ));
        let found = space().start(vec![0.0, f64::NAN, 0.0]);
        assert!(matches!(found, Err(SpaceError::NotFinite { index: 1, .. })));
    }
}
