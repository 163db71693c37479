//! The coherent sum of beamlets on a uniform grid.
//!
//! Each beamlet is evaluated over its own footprint only. Rows are dealt out in bands of fixed height; a
//! band takes its beamlets in order, so the sum has the same bits for any number of threads.

use std::f64::consts::TAU;
use std::ops::Range;

use fearless_simd::{Simd, dispatch};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::math::simd_level::level;
use crate::wave::beamlet::beamlet_kernel::{BeamletKernel, Moments};
use crate::wave::beamlet::raster_rows::Rows;
use crate::wave::beamlet::wavelet::{Arrival, Tail};
use crate::wave::grid::raster::Raster;

/// Rows of a band: the unit of parallel work.
const BAND_ROWS: usize = 32;

/// A field being summed: real and imaginary part in bands of rows.
pub struct Canvas {
    raster: Raster,
    bands: Vec<Band>,
}

struct Band {
    first_row: usize,
    rows: Rows,
}

/// What a footprint costs: how many values the sums so far have evaluated.
pub(crate) type Evaluations = u64;

impl Canvas {
    /// An empty sum on a raster.
    pub fn new(raster: Raster) -> Self {
        let [nx, ny] = raster.size;
        let bands = (0..ny.div_ceil(BAND_ROWS))
            .map(|b| {
                let first_row = b * BAND_ROWS;
                let above = first_row as f64 * raster.pitch[1];
                let rows = Rows::zeros(Raster {
                    start: [raster.start[0], raster.start[1] + above],
                    size: [nx, BAND_ROWS.min(ny - first_row)],
                    ..raster
                });
                Band { first_row, rows }
            })
            .collect();
        Self { raster, bands }
    }

    /// Adds beamlets, each where it exceeds `threshold` of its own peak; `k` is the vacuum wavenumber.
    pub fn add(&mut self, arrivals: &[Arrival], k: f64, threshold: f64) -> Evaluations {
        let level = level();
        let limit = -2.0 * threshold.ln() / k;
        let (first, met) = self.met_by(arrivals, limit);
        let bands = self.bands.par_iter_mut().zip(first.par_windows(2));
        bands
            .map(|(band, part)| {
                let met = met.get(part[0]..part[1]).unwrap_or_default();
                dispatch!(level, simd => fill(simd, &mut band.rows, (arrivals, met), k, limit))
            })
            .sum()
    }

    /// The conjugate transpose of [`Canvas::add`]: for each beamlet, with its amplitude taken for one, what
    /// the canvas holds times its conjugate, summed over its footprint; the first of the moments is the
    /// cotangent of the amplitude when the canvas holds the cotangent of the sum.
    pub(crate) fn add_adjoint(&self, arrivals: &[Arrival], k: f64, threshold: f64) -> Vec<Moments> {
        let moments = |arrival| self.moments(arrival, k, threshold);
        arrivals.par_iter().map(moments).collect()
    }

    /// [`Canvas::add_adjoint`] for one beamlet.
    pub(crate) fn moments(&self, arrival: &Arrival, k: f64, threshold: f64) -> Moments {
        let level = level();
        let limit = -2.0 * threshold.ln() / k;
        let mut total = [Complex64::ZERO; 6];
        for band in &self.bands[self.bands_of(arrival, limit)] {
            let part = dispatch!(level, simd => read(simd, &band.rows, arrival, k, limit));
            total.iter_mut().zip(part).for_each(|(t, p)| *t += p);
        }
        total
    }

    /// The bands that a beamlet's footprint meets, or a band beside them.
    fn bands_of(&self, arrival: &Arrival, limit: f64) -> Range<usize> {
        let reach = BeamletKernel::reach(arrival, limit);
        if !reach.is_finite() {
            return 0..0;
        }
        let height = BAND_ROWS as f64 * self.raster.pitch[1];
        let count = self.bands.len();
        let band = |y: f64| (y - self.raster.start[1]) / height;
        let first = band(arrival.at[1] - reach).floor().max(0.0) as usize;
        let end = (band(arrival.at[1] + reach).floor() + 1.0).max(0.0) as usize;
        first.min(count)..end.min(count)
    }

    /// The numbers of the beamlets that meet each band, in their order: where the bands' parts begin, and all parts one
    /// after the other.
    fn met_by(&self, arrivals: &[Arrival], limit: f64) -> (Vec<usize>, Vec<usize>) {
        let ranges = arrivals.iter().map(|arrival| self.bands_of(arrival, limit));
        let ranges: Vec<Range<usize>> = ranges.collect();
        let mut first = vec![0; self.bands.len() + 1];
        for band in ranges.iter().cloned().flatten() {
            first[band + 1] += 1;
        }
        for band in 1..first.len() {
            first[band] += first[band - 1];
        }
        let mut next = first.clone();
        let mut met = vec![0; first.last().copied().unwrap_or_default()];
        for (number, range) in ranges.into_iter().enumerate() {
            for band in range {
                met[next[band]] = number;
                next[band] += 1;
            }
        }
        (first, met)
    }

    /// A canvas that holds these values, indexed [y, x].
    pub(crate) fn holding(raster: Raster, values: &ndarray::Array2<Complex64>) -> Self {
        let mut canvas = Self::new(raster);
        for ((j, i), value) in values.indexed_iter() {
            let band = &mut canvas.bands[j / BAND_ROWS];
            band.rows.set([j - band.first_row, i], *value);
        }
        canvas
    }

    /// Its sample points.
    pub(crate) fn raster(&self) -> &Raster {
        &self.raster
    }

    /// Whether a beamlet's footprint meets the raster.
    pub(crate) fn meets(&self, arrival: &Arrival, k: f64, threshold: f64) -> bool {
        let reach = arrival.footprint(k, threshold);
        (0..2).all(|a| {
            let low = self.raster.start[a];
            let high = low + (self.raster.size[a] as f64 - 1.0) * self.raster.pitch[a];
            arrival.at[a] + reach[a] >= low && arrival.at[a] - reach[a] <= high
        })
    }

    /// The box of its points, `[x_min, x_max, y_min, y_max]` in mm.
    pub(crate) fn bounds(&self) -> [f64; 4] {
        let [x, y] = self.raster.size;
        let [px, py] = self.raster.pitch;
        let [low_x, low_y] = self.raster.start;
        let high = [low_x + (x as f64 - 1.0) * px, low_y + (y as f64 - 1.0) * py];
        [low_x, high[0], low_y, high[1]]
    }

    /// How a beamlet lies to the raster.
    pub(crate) fn tail(&self, arrival: &Arrival, k: f64) -> Tail {
        Tail::of(arrival, self.bounds(), k)
    }

    /// About this share of the energy of a beamlet that lands beside the raster falls on it beyond the end of its footprint: of what lies
    /// beyond it all around, the part in the sector that the raster fills; none where the footprint covers the raster.
    pub(crate) fn cut(&self, arrival: &Arrival, k: f64, threshold: f64) -> f64 {
        let beyond = threshold * threshold;
        if self.contains(arrival.at) || !self.meets(arrival, k, beyond) {
            return 0.0;
        }
        let [x0, x1, y0, y1] = self.bounds();
        let corners = [[x0, y0], [x1, y0], [x0, y1], [x1, y1]];
        if corners.iter().all(|at| arrival.decay(*at, k) >= threshold) {
            return 0.0;
        }
        let width = arrival.footprint(k, threshold);
        let seen = corners.map(|at| [0, 1].map(|a| (at[a] - arrival.at[a]) / width[a]));
        let between = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2]| {
            (ax * by - ay * bx).abs().atan2(ax * bx + ay * by)
        };
        let sector = (seen
            .iter()
            .flat_map(|a| seen.iter().map(move |b| between(*a, *b))))
        .fold(0.0, f64::max);
        self.tail(arrival, k).share.min(beyond * sector / TAU)
    }

    /// Whether a point lies within the raster.
    pub(crate) fn contains(&self, point: [f64; 2]) -> bool {
        (0..2).all(|a| {
            let low = self.raster.start[a];
            let high = low + (self.raster.size[a] as f64 - 1.0) * self.raster.pitch[a];
            (low..=high).contains(&point[a])
        })
    }

    /// The sum, indexed [y, x].
    pub(crate) fn finish(self) -> ndarray::Array2<Complex64> {
        let [nx, ny] = self.raster.size;
        ndarray::Array2::from_shape_fn((ny, nx), |(j, i)| {
            let band = &self.bands[j / BAND_ROWS];
            band.rows.value([j - band.first_row, i])
        })
    }
}

/// The beamlets that meet a band, by their numbers.
#[inline(always)]
fn fill<S: Simd>(
    simd: S,
    rows: &mut Rows,
    (arrivals, met): (&[Arrival], &[usize]),
    k: f64,
    limit: f64,
) -> Evaluations {
    let mut evaluations = 0;
    for number in met {
        if let Some(kernel) = BeamletKernel::new(&arrivals[*number], &rows.raster, limit, k) {
            evaluations += kernel.add(simd, rows);
        }
    }
    evaluations
}

/// What one band gives back to a beamlet.
#[inline(always)]
fn read<S: Simd>(simd: S, rows: &Rows, arrival: &Arrival, k: f64, limit: f64) -> Moments {
    match BeamletKernel::new(arrival, &rows.raster, limit, k) {
        Some(kernel) => kernel.add_adjoint(simd, rows),
        None => [Complex64::ZERO; 6],
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::wave::beamlet::beamlet_sum::Canvas;
    use crate::wave::beamlet::wavelet::Arrival;
    use crate::wave::grid::raster::Raster;

    fn arrivals() -> Vec<Arrival> {
        let random =
            |i: usize, j: usize| (((i * 37 + j * 101) as f64) * 0.618_033_988_7).fract() - 0.5;
        (0..40)
            .map(|i| {
                let (a, b) = (0.02 + 0.01 * random(i, 1), 0.03 + 0.02 * random(i, 2));
                let shear = (a * b).sqrt() * 1.6 * random(i, 3);
                Arrival {
                    at: [60.0 * random(i, 4), 50.0 * random(i, 5)],
                    cosines: [0.4 * random(i, 6), 0.4 * random(i, 7)],
                    amplitude: Complex64::new(random(i, 8), random(i, 9)),
                    curvature: [
                        Complex64::new(0.05 * random(i, 10), a),
                        Complex64::new(0.05 * random(i, 11), shear),
                        Complex64::new(0.05 * random(i, 12), b),
                    ],
                }
            })
            .collect()
    }

    #[test]
    fn sum_matches_the_formula() {
        let k = std::f64::consts::TAU;
        let raster = Raster {
            start: [-20.0, -21.0],
            pitch: [0.31, 0.43],
            size: [131, 97],
        };
        let mut canvas = Canvas::new(raster);
        canvas.add(&arrivals(), k, 1e-9);
        let sum = canvas.finish();
        let (mut error, mut norm) = (0.0, 0.0);
        for ((j, i), value) in sum.indexed_iter() {
            let (x, y) = (-20.0 + 0.31 * i as f64, -21.0 + 0.43 * j as f64);
            let mut exact = Complex64::ZERO;
            for a in arrivals() {
                let (u, v) = (x - a.at[0], y - a.at[1]);
                let [xx, xy, yy] = a.curvature;
                let bend = 0.5 * (xx * u * u + xy * 2.0 * u * v + yy * v * v);
                let linear = a.cosines[0] * u + a.cosines[1] * v;
                exact += a.amplitude * (Complex64::i() * k * (bend + linear)).exp();
            }
            error += (value - exact).norm_sqr();
            norm += exact.norm_sqr();
        }
        assert!((error / norm).sqrt() < 2e-9, "{:e}", (error / norm).sqrt());
    }

    /// Σ conj(ȳ)·y is the same as Σ conj(amplitudē)·amplitude, and moments match their formulas.
    #[test]
    fn add_dot_product() {
        let k = std::f64::consts::TAU;
        let raster = Raster {
            start: [-20.0, -21.0],
            pitch: [0.31, 0.43],
            size: [131, 97],
        };
        let bar = ndarray::Array2::from_shape_fn((97, 131), |(j, i)| {
            let t = (j * 131 + i) as f64 * 0.618_033_988_7;
            Complex64::new(t.fract() - 0.5, (3.7 * t).fract() - 0.5)
        });
        let mut canvas = Canvas::new(raster);
        canvas.add(&arrivals(), k, 1e-3);
        let sum = canvas.finish();
        let moments = Canvas::holding(raster, &bar).add_adjoint(&arrivals(), k, 1e-3);
        let forward: Complex64 = bar.iter().zip(&sum).map(|(a, b)| a.conj() * b).sum();
        let back: Complex64 = moments
            .iter()
            .zip(&arrivals())
            .map(|(m, arrival)| m[0].conj() * arrival.amplitude)
            .sum();
        let size = (bar.iter().map(|v| v.norm_sqr()).sum::<f64>()
            * sum.iter().map(|v| v.norm_sqr()).sum::<f64>())
        .sqrt();
        assert!((forward - back).norm() < 1e-14 * size, "{forward} {back}");

        // The moments as written, over footprints wide enough.
        let moments = Canvas::holding(raster, &bar).add_adjoint(&arrivals(), k, 1e-12);
        for (found, a) in moments.iter().zip(&arrivals()) {
            let mut exact = [Complex64::ZERO; 6];
            for ((j, i), bar) in bar.indexed_iter() {
                let u = -20.0 + 0.31 * i as f64 - a.at[0];
                let v = -21.0 + 0.43 * j as f64 - a.at[1];
                let [xx, xy, yy] = a.curvature;
                let bend = 0.5 * (xx * u * u + xy * 2.0 * u * v + yy * v * v);
                let linear = a.cosines[0] * u + a.cosines[1] * v;
                let part = (Complex64::i() * k * (bend + linear)).exp().conj() * bar;
                for (e, power) in exact.iter_mut().zip([1.0, u, v, u * u, u * v, v * v]) {
                    *e += part * power;
                }
            }
            for (found, exact) in found.iter().zip(exact) {
                assert!((found - exact).norm() < 1e-8, "{found} {exact}");
            }
        }
    }

    #[test]
    fn bits_do_not_depend_on_threads() {
        let raster = Raster {
            start: [-20.0, -21.0],
            pitch: [0.31, 0.43],
            size: [131, 97],
        };
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let mut canvas = Canvas::new(raster);
                canvas.add(&arrivals(), std::f64::consts::TAU, 1e-3);
                canvas.finish()
            })
        };
        assert_eq!(run(1), run(3));
    }
}
