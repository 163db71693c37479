//! Losses for spots: how bright the light is at given points, and how evenly it is shared among them.

use ndarray::{Array2, ArrayView2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::design::losses::loss::{Loss, LossError, LossValue, check_positive};
use crate::wave::grid::raster::Raster;

/// A point of the sensor between four pixels.
#[derive(Clone, Debug, PartialEq)]
struct Spot {
    /// Row and column of a pixel and its share in the bilinear interpolation.
    corners: [((usize, usize), f64); 4],
    /// The intensity that counts as 1.
    ideal: f64,
}

// Their loss is made small; s are the intensities at the spots over their ideals.
/// How points share the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sharing {
    // Weak spots may starve.
    /// As much light as possible on all of them together: 1 − mean s.
    #[default]
    Linear,
    // Of all ways to share a given sum the even one is best. Infinite while a spot is dark.
    /// None may starve: −mean log s.
    Log,
}

/// The brightness of spots.
///
/// With the intensity of a perfect focus as ideal, sⱼ is a Strehl ratio; with (light sent out)/(area of a
/// pixel), it is the share of the light that falls on the pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Spots {
    shape: (usize, usize),
    spots: Vec<Spot>,
    sharing: Sharing,
    evenness: f64,
}

impl Spots {
    /// The loss for spots at the points (x, y) in mm, each with the intensity that counts as 1.
    ///
    /// `evenness` ≥ 0 multiplies the variance of the sⱼ over their squared mean, which is added.
    ///
    /// # Errors
    /// When there are no points, one is off the sensor's pixel centres, or a number is outside its range.
    pub fn new(
        raster: &Raster,
        points: &[([f64; 2], f64)],
        sharing: Sharing,
        evenness: f64,
    ) -> Result<Self, LossError> {
        if points.is_empty() {
            return Err(LossError::Empty("a list of no spots"));
        }
        if !(evenness >= 0.0 && evenness.is_finite()) {
            return Err(LossError::Number {
                what: "the factor of evenness",
                value: evenness,
                expected: "a number, none below zero",
            });
        }
        let one = |(point, ideal): &([f64; 2], f64)| {
            check_positive("the ideal intensity of a spot", *ideal)?;
            Ok(Spot {
                corners: corners(raster, *point).ok_or(LossError::Outside(*point))?,
                ideal: *ideal,
            })
        };
        Ok(Self {
            shape: (raster.size[1], raster.size[0]),
            spots: points.iter().map(one).collect::<Result<_, LossError>>()?,
            sharing,
            evenness,
        })
    }

    /// sⱼ of each spot.
    pub fn brightness(&self, intensity: ArrayView2<'_, f64>) -> Vec<f64> {
        let one = |spot: &Spot| {
            let parts = spot
                .corners
                .iter()
                .map(|(pixel, share)| share * intensity[*pixel]);
            parts.sum::<f64>() / spot.ideal
        };
        self.spots.iter().map(one).collect()
    }
}

/// The four pixels around a point with their shares; none off the raster.
fn corners(raster: &Raster, point: [f64; 2]) -> Option<[((usize, usize), f64); 4]> {
    let mut first = [0; 2];
    let mut part = [0.0; 2];
    for axis in 0..2 {
        let place = (point[axis] - raster.start[axis]) / raster.pitch[axis];
        let last = raster.size[axis] as f64 - 1.0;
        // A point that is on the rim but for rounding is on it.
        let inside = place.clamp(0.0, last);
        if (place - inside).abs() > 1e-9 || place.is_nan() {
            return None;
        }
        first[axis] = (inside as usize).min(raster.size[axis].saturating_sub(2));
        part[axis] = inside - first[axis] as f64;
    }
    let share = |axis: usize, next: usize| [1.0 - part[axis], part[axis]][next];
    let index = |axis: usize, next: usize| (first[axis] + next).min(raster.size[axis] - 1);
    let corner = |j, i| ((index(1, j), index(0, i)), share(1, j) * share(0, i));
    Some([corner(0, 0), corner(0, 1), corner(1, 0), corner(1, 1)])
}

impl Loss for Spots {
    fn shape(&self) -> (usize, usize) {
        self.shape
    }

    fn evaluate(&self, intensity: ArrayView2<'_, f64>) -> LossValue {
        let seen = self.brightness(intensity);
        let count = seen.len() as f64;
        let mean = seen.iter().sum::<f64>() / count;
        let square = seen.iter().map(|s| s * s).sum::<f64>() / count;
        let mut value = match self.sharing {
            Sharing::Linear => 1.0 - mean,
            Sharing::Log => -seen.iter().map(|s| s.ln()).sum::<f64>() / count,
        };
        // Variance over squared mean is (mean of squares)/(mean)² − 1.
        let uneven = self.evenness > 0.0 && mean > 0.0;
        if uneven {
            value += self.evenness * (square / (mean * mean) - 1.0);
        }

        let mut bar = Array2::zeros(intensity.dim());
        for (spot, s) in self.spots.iter().zip(&seen) {
            let mut slope = match self.sharing {
                Sharing::Linear => -1.0,
                Sharing::Log if *s > 0.0 => -1.0 / s,
                Sharing::Log => 0.0,
            };
            if uneven {
                slope += 2.0 * self.evenness / (mean * mean) * (s - square / mean);
            }
            for (pixel, share) in spot.corners {
                bar[pixel] += slope / (count * spot.ideal) * share;
            }
        }
        LossValue { value, bar }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use crate::design::losses::discrepancy::discrepancy;
    use crate::fixtures::noise::real_noise;

    use crate::design::losses::loss::{Loss, LossError};
    use crate::design::losses::spots::{Sharing, Spots};
    use crate::wave::grid::raster::Raster;

    const RASTER: Raster = Raster {
        start: [-0.4, -0.2],
        pitch: [0.1, 0.1],
        size: [9, 5],
    };

    const POINTS: [([f64; 2], f64); 3] =
        [([-0.4, 0.2], 2.0), ([0.03, -0.06], 3.0), ([0.2, 0.1], 4.0)];

    #[test]
    fn brightness_between_pixels_is_interpolated() {
        // A plane is interpolated exactly, and a pixel's own place has its own value.
        let plane = Array2::from_shape_fn((5, 9), |(j, i)| 1.0 + 0.2 * i as f64 + 0.5 * j as f64);
        let spots = Spots::new(&RASTER, &POINTS, Sharing::Linear, 0.0).unwrap();
        for (found, (point, ideal)) in spots.brightness(plane.view()).iter().zip(POINTS) {
            let exact = 1.0 + 2.0 * (point[0] + 0.4) + 5.0 * (point[1] + 0.2);
            assert!((found - exact / ideal).abs() < 1e-14);
        }
    }

    #[test]
    fn central_differences() {
        for sharing in [Sharing::Linear, Sharing::Log] {
            for evenness in [0.0, 0.3] {
                let spots = Spots::new(&RASTER, &POINTS, sharing, evenness).unwrap();
                let off = discrepancy(&spots, real_noise((5, 9), 2, [0, 0]).view(), 9);
                assert!(off < 1e-9, "{sharing:?} {off:e}");
            }
        }
    }

    #[test]
    fn what_is_best_for_one_sum_of_light() {
        // Two spots that share the intensity 1: values by hand, and even sharing is best for logarithms.
        let points = [([-0.4, -0.2], 1.0), ([0.4, 0.2], 1.0)];
        let value = |sharing, evenness, first: f64| {
            let mut intensity = Array2::zeros((5, 9));
            intensity[[0, 0]] = first;
            intensity[[4, 8]] = 1.0 - first;
            let spots = Spots::new(&RASTER, &points, sharing, evenness).unwrap();
            spots.evaluate(intensity.view()).value
        };
        for first in [0.1, 0.3, 0.5] {
            assert!((value(Sharing::Linear, 0.0, first) - 0.5).abs() < 1e-15);
            let variance = (2.0 * first - 1.0).powi(2);
            assert!((value(Sharing::Linear, 0.4, first) - 0.5 - 0.4 * variance).abs() < 1e-14);
            let log = -0.5 * (first * (1.0 - first)).ln();
            assert!((value(Sharing::Log, 0.0, first) - log).abs() < 1e-14);
            assert!(log >= f64::ln(2.0) - 1e-15);
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let refused = |points: &[([f64; 2], f64)], evenness| {
            Spots::new(&RASTER, points, Sharing::Log, evenness).unwrap_err()
        };
        assert!(matches!(refused(&[], 0.0), LossError::Empty(_)));
        assert_eq!(
            refused(&[([0.41, 0.0], 1.0)], 0.0),
            LossError::Outside([0.41, 0.0])
        );
        assert!(matches!(
            refused(&[([0.0, f64::NAN], 1.0)], 0.0),
            LossError::Outside(_)
        ));
        assert!(matches!(
            refused(&[([0.0, 0.0], 0.0)], 0.0),
            LossError::Number { .. }
        ));
        assert!(matches!(refused(&POINTS, -1.0), LossError::Number { .. }));
    }
}
