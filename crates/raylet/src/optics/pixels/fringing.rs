//! The phase between the pixels of a liquid-crystal modulator: fly-back where it wraps, and crosstalk of neighbours.
//!
//! The phase of each pixel is that between 0 and 2π. Where neighbours differ by more than π, the phase wraps between them:
//! there it runs from one to the other as a ramp, along rows first, then along columns. The map of phases is then convolved
//! with a Gaussian. Beyond the outer pixels it stays as it is at the edge.

use ndarray::parallel::prelude::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use ndarray::{Array2, ArrayViewMut2, Axis};
use num_complex::Complex64;

use crate::math::erfc::erfc;

/// What lies between the pixels of a modulator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fringing {
    /// Width in mm of the ramp about an edge where the phase wraps; at most the pitch.
    pub fly_back: f64,
    /// Standard deviation in mm of the Gaussian with which the phase is convolved.
    pub crosstalk: f64,
    /// Parts of a pixel along each axis, each with its mean transmission.
    pub sub_pixels: usize,
}

/// Places along each axis of a sub-pixel over which the transmission is averaged.
const PLACES: usize = 4;

/// Standard deviations after which a Gaussian ends: 6e-7 of it lies beyond.
const REACH: f64 = 5.0;

/// What a phase may be below 2π by rounding alone.
const ROUNDING: f64 = 1e-9;

impl Fringing {
    /// The transmission of the sub-pixels of pixels with these values at a pitch [x, y] in mm.
    pub fn transmission(&self, values: &Array2<Complex64>, pitch: [f64; 2]) -> Array2<Complex64> {
        let ((ny, nx), parts) = (values.dim(), self.sub_pixels);
        let phases = values.mapv(wrapped_phase);
        let mut made = Array2::zeros((ny * parts, nx * parts));
        let rows = made.axis_chunks_iter_mut(Axis(0), parts).into_par_iter();
        rows.enumerate().for_each(|(row, mut out)| {
            let lines = self.lines(&phases, row, pitch);
            self.average(&lines, &mut out);
            for ((_, i), value) in out.indexed_iter_mut() {
                *value *= values[[row, i / parts]].norm();
            }
        });
        made
    }

    /// Places along a pixel at which the phase is computed.
    fn places(&self) -> usize {
        self.sub_pixels * PLACES
    }

    /// The phase at the places of one row of pixels, indexed [y, x].
    fn lines(&self, phases: &Array2<f64>, row: usize, pitch: [f64; 2]) -> Array2<f64> {
        let ((ny, nx), places) = (phases.dim(), self.places());
        let [across, up] = pitch.map(|pitch| self.kernel(pitch));
        let reach = up.len() / 2;

        // The rows of pixels that the Gaussian reaches, with the ramps along them, and one more on each side.
        let first = row.saturating_sub(reach.div_ceil(places) + 1);
        let last = (row + reach.div_ceil(places) + 1).min(ny - 1);
        let along: Vec<Vec<f64>> = (first..=last)
            .map(|j| self.ramps_along(phases.row(j).as_slice().unwrap_or(&[]), pitch[0]))
            .collect();
        let line = |at: isize| {
            let at = at.clamp(0, (ny * places) as isize - 1) as usize;
            let (j, share) = (at / places - first, self.share(at));
            let own = &along[j];
            let (before, after) = (j.checked_sub(1).map(|j| &along[j]), along.get(j + 1));
            let width = self.fly_back / pitch[1];
            let value = |i: usize| {
                let neighbours = [before.map(|line| line[i]), after.map(|line| line[i])];
                ramp(own[i], neighbours, share, width)
            };
            (0..nx * places).map(value).collect::<Vec<f64>>()
        };

        // The Gaussian along columns, then along rows.
        let start = (row * places) as isize - reach as isize;
        let lines: Vec<Vec<f64>> = (0..places + 2 * reach)
            .map(|n| line(start + n as isize))
            .collect();
        let mut made = Array2::zeros((places, nx * places));
        for (j, mut out) in made.rows_mut().into_iter().enumerate() {
            let mut sum = vec![0.0; nx * places];
            for (weight, line) in up.iter().zip(&lines[j..]) {
                sum.iter_mut()
                    .zip(line)
                    .for_each(|(sum, value)| *sum += weight * value);
            }
            let convolved = convolved(&sum, &across);
            out.iter_mut()
                .zip(convolved)
                .for_each(|(out, value)| *out = value);
        }
        made
    }

    /// The phase at the places along a row of pixels, with its ramps along the row.
    fn ramps_along(&self, row: &[f64], pitch: f64) -> Vec<f64> {
        let (places, width) = (self.places(), self.fly_back / pitch);
        let value = |at: usize| {
            let i = at / places;
            let before = i.checked_sub(1).map(|i| row[i]);
            ramp(
                row[i],
                [before, row.get(i + 1).copied()],
                self.share(at),
                width,
            )
        };
        (0..row.len() * places).map(value).collect()
    }

    /// How far a place lies along its pixel, from 0 to 1.
    fn share(&self, at: usize) -> f64 {
        let places = self.places();
        ((at % places) as f64 + 0.5) / places as f64
    }

    /// The weights of neighbouring places: the Gaussian over each place, which stands for all that is about it.
    fn kernel(&self, pitch: f64) -> Vec<f64> {
        let sigma = self.crosstalk / pitch * self.places() as f64;
        if sigma == 0.0 {
            return vec![1.0];
        }
        let reach = (REACH * sigma).ceil() as i32;
        let beyond = |edge: f64| 0.5 * erfc(edge / (sigma * std::f64::consts::SQRT_2));
        let weight = |n: i32| beyond(f64::from(n) - 0.5) - beyond(f64::from(n) + 0.5);
        let weights: Vec<f64> = (-reach..=reach).map(weight).collect();
        let sum: f64 = weights.iter().sum();
        weights.iter().map(|weight| weight / sum).collect()
    }

    /// The mean transmission of each sub-pixel.
    fn average(&self, lines: &Array2<f64>, out: &mut ArrayViewMut2<'_, Complex64>) {
        let share = 1.0 / (PLACES * PLACES) as f64;
        for ((j, i), phase) in lines.indexed_iter() {
            out[[j / PLACES, i / PLACES]] += Complex64::from_polar(share, *phase);
        }
    }
}

/// The phase of a value from 0 to 2π.
fn wrapped_phase(value: Complex64) -> f64 {
    let phase = value.arg().rem_euclid(std::f64::consts::TAU);
    match phase > std::f64::consts::TAU - ROUNDING {
        true => 0.0,
        false => phase,
    }
}

/// The phase at a share of the way along a pixel: its own, or that of the ramp of this width in pixels to the neighbour before
/// or after it, where it wraps on the way.
fn ramp(own: f64, [before, after]: [Option<f64>; 2], share: f64, width: f64) -> f64 {
    let (other, distance) = match share < 0.5 {
        true => (before, share),
        false => (after, 1.0 - share),
    };
    match other {
        Some(other) if distance < 0.5 * width && (other - own).abs() > std::f64::consts::PI => {
            own + (other - own) * (0.5 - distance / width)
        }
        _ => own,
    }
}

/// A line convolved with weights; beyond its ends it stays as it is there.
fn convolved(line: &[f64], weights: &[f64]) -> Vec<f64> {
    let (reach, last) = (weights.len() / 2, line.len() - 1);
    if reach == 0 {
        return line.to_vec();
    }
    let padded: Vec<f64> = (0..line.len() + 2 * reach)
        .map(|n| line[n.saturating_sub(reach).min(last)])
        .collect();
    let sum = |around: &[f64]| around.iter().zip(weights).map(|(v, w)| v * w).sum();
    padded.windows(weights.len()).map(sum).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::math::sinc::sinc;
    use crate::optics::pixels::fringing::Fringing;

    const PERIOD: usize = 6;

    /// A blazed grating of 5 periods of pixels of 1 mm along x or y.
    fn blazed(along_y: bool) -> Array2<Complex64> {
        let value = |n: usize| Complex64::cis(TAU * (n % PERIOD) as f64 / PERIOD as f64);
        match along_y {
            true => Array2::from_shape_fn((5 * PERIOD, 1), |(j, _)| value(j)),
            false => Array2::from_shape_fn((2, 5 * PERIOD), |(_, i)| value(i)),
        }
    }

    /// The amplitude of the first order of the middle period of sub-pixels.
    fn first_order(fringing: Fringing, along_y: bool) -> Complex64 {
        let made = fringing.transmission(&blazed(along_y), [1.0; 2]);
        let line: Vec<Complex64> = match along_y {
            true => made.column(0).to_vec(),
            false => made.row(0).to_vec(),
        };
        let count = PERIOD * fringing.sub_pixels;
        let part = |n: usize| {
            let turn = TAU * (n as f64 + 0.5) / count as f64;
            line[2 * count + n] * Complex64::cis(-turn)
        };
        (0..count).map(part).sum::<Complex64>() / count as f64 * sinc(1.0 / count as f64)
    }

    /// The same of a phase over x from 0 to the period, by a sum over many points.
    fn brute_force(phase: impl Fn(f64) -> f64) -> Complex64 {
        let points = 60_000;
        let part = |n: u32| {
            let x = PERIOD as f64 * (f64::from(n) + 0.5) / f64::from(points);
            Complex64::cis(phase(x) - TAU * x / PERIOD as f64)
        };
        (0..points).map(part).sum::<Complex64>() / f64::from(points)
    }

    fn staircase(x: f64) -> f64 {
        TAU * x.rem_euclid(PERIOD as f64).floor() / PERIOD as f64
    }

    /// Each step has the amplitude sinc(1/N)/N; half a ramp of width w takes its place at each end of the period. On the ramp the
    /// phase falls from 2π(N − 1)/N to 0, so its first order has the closed form (w/N) sinc((N − 1 + w)/N) at the phase in its
    /// middle.
    #[test]
    fn fly_back_takes_light_from_the_first_order_as_its_closed_form_says() {
        let (n, width) = (PERIOD as f64, 0.7);
        let step = |low: f64, high: f64, level: f64| {
            let middle = 0.5 * (low + high);
            Complex64::from_polar(
                (high - low) / n * sinc((high - low) / n),
                TAU * (level - middle) / n,
            )
        };
        let mut exact: Complex64 = (1..PERIOD - 1)
            .map(|k| step(k as f64, k as f64 + 1.0, k as f64))
            .sum();
        exact += step(0.5 * width, 1.0, 0.0) + step(n - 1.0, n - 0.5 * width, n - 1.0);
        exact += Complex64::from_polar(width / n * sinc((n - 1.0 + width) / n), PI * (n - 1.0) / n);
        let direct = brute_force(|x| {
            let edge = (x + 0.5 * n).rem_euclid(n) - 0.5 * n;
            match edge.abs() < 0.5 * width {
                true => TAU * (n - 1.0) / n * (0.5 - edge / width),
                false => staircase(x),
            }
        });
        assert!((direct - exact).norm() < 1e-4, "{direct} {exact}");
        for along_y in [false, true] {
            for (sub_pixels, most) in [(4, 5e-4), (16, 2e-5)] {
                let fringing = Fringing {
                    fly_back: width,
                    crosstalk: 0.0,
                    sub_pixels,
                };
                let error = (first_order(fringing, along_y) - exact).norm() / exact.norm();
                assert!(error < most, "{sub_pixels}: {error:e}");
            }
        }
    }

    /// The staircase convolved by a sum over many points, for a narrow and a wide Gaussian. Where the phase is smooth, the mean
    /// over d parts of a period and their boxes weaken the order by sinc²(1/d): by 5.7e-3 for 4 parts of a pixel, by 3.6e-4 for 16.
    /// The direct sum is itself off by some 3e-5, because steps fall between its nodes.
    #[test]
    fn crosstalk_takes_light_from_the_first_order_as_a_direct_sum_says() {
        for sigma in [0.15, 0.5] {
            let phase = |x: f64| {
                let nodes = 4800;
                let at = |n: i32| 6.0 * sigma * f64::from(n) / f64::from(nodes);
                let weight = |n: i32| (-0.5 * (at(n) / sigma).powi(2)).exp();
                let sum: f64 = (-nodes..=nodes)
                    .map(|n| weight(n) * staircase(x - at(n)))
                    .sum();
                sum / (-nodes..=nodes).map(weight).sum::<f64>()
            };
            let points = 1500;
            let part = |n: u32| {
                let x = PERIOD as f64 * (f64::from(n) + 0.5) / f64::from(points);
                Complex64::cis(phase(x) - TAU * x / PERIOD as f64)
            };
            let exact = (0..points).map(part).sum::<Complex64>() / f64::from(points);
            for along_y in [false, true] {
                for (sub_pixels, most) in [(4, 6e-3), (16, 4e-4)] {
                    let fringing = Fringing {
                        fly_back: 0.0,
                        crosstalk: sigma,
                        sub_pixels,
                    };
                    let error = (first_order(fringing, along_y) - exact).norm() / exact.norm();
                    assert!(error < most, "{sigma} {sub_pixels}: {error:e}");
                }
            }
        }
    }

    /// Rounding below 2π is no wrap, and amplitudes stay as they are.
    #[test]
    fn an_even_phase_stays_even() {
        let fringing = Fringing {
            fly_back: 0.5,
            crosstalk: 0.3,
            sub_pixels: 2,
        };
        let flat = Array2::from_shape_fn((3, 4), |(j, i)| {
            Complex64::from_polar(0.5 + i as f64, TAU * (j + i) as f64)
        });
        let made = fringing.transmission(&flat, [1.0, 2.0]);
        assert_eq!(made.dim(), (6, 8));
        for ((_, i), value) in made.indexed_iter() {
            assert!((value - (0.5 + (i / 2) as f64)).norm() < 1e-12);
        }
    }
}
