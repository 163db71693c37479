//! The coherent sum of beamlets on a uniform grid.
//!
//! Each beamlet is evaluated over its own footprint only. Along a row its exponent is quadratic in x,
//! so neighbouring values have a ratio that itself changes by a constant factor: two complex
//! multiplications per value, eight columns at once. Rows are dealt out in bands of fixed height; a band
//! takes its beamlets in order, so the sum has the same bits for any number of threads.

use fearless_simd::{Level, Simd, dispatch};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::math::lanes::{LANES, Lanes, cis, exp};
use crate::wave::wavelet::Arrival;

/// Rows of a band: the unit of parallel work.
const BAND_ROWS: usize = 32;

/// A uniform grid of sample points: x = start + i·pitch, likewise y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    /// First column and first row, in mm.
    pub start: [f64; 2],
    /// Distance of columns and of rows, in mm.
    pub pitch: [f64; 2],
    /// Number of columns and rows.
    pub size: [usize; 2],
}

/// A field being summed: real and imaginary part in bands of rows.
pub struct Canvas {
    raster: Raster,
    bands: Vec<Band>,
}

struct Band {
    first_row: usize,
    rows: usize,
    /// Row-major, padded so that eight columns may be touched past the last one.
    re: Vec<f64>,
    im: Vec<f64>,
    stride: usize,
}

/// What a footprint costs: how many values the sums so far have evaluated.
pub type Evaluations = u64;

impl Canvas {
    /// An empty sum on a raster.
    pub fn new(raster: Raster) -> Self {
        let [nx, ny] = raster.size;
        let stride = nx + LANES;
        let bands = (0..ny.div_ceil(BAND_ROWS))
            .map(|b| {
                let first_row = b * BAND_ROWS;
                let rows = BAND_ROWS.min(ny - first_row);
                Band {
                    first_row,
                    rows,
                    re: vec![0.0; rows * stride],
                    im: vec![0.0; rows * stride],
                    stride,
                }
            })
            .collect();
        Self { raster, bands }
    }

    /// Adds beamlets, each where it exceeds `threshold` of its own peak; `k` is the vacuum wavenumber.
    pub fn add(&mut self, arrivals: &[Arrival], k: f64, threshold: f64) -> Evaluations {
        let raster = self.raster;
        let level = Level::new();
        self.bands
            .par_iter_mut()
            .map(|band| dispatch!(level, simd => fill(simd, band, &raster, arrivals, k, threshold)))
            .sum()
    }

    /// Whether a beamlet's footprint meets the raster.
    pub fn meets(&self, arrival: &Arrival, k: f64, threshold: f64) -> bool {
        let reach = arrival.footprint(k, threshold);
        (0..2).all(|a| {
            let low = self.raster.start[a];
            let high = low + (self.raster.size[a] as f64 - 1.0) * self.raster.pitch[a];
            arrival.at[a] + reach[a] >= low && arrival.at[a] - reach[a] <= high
        })
    }

    /// Whether a point lies within the raster.
    pub fn contains(&self, point: [f64; 2]) -> bool {
        (0..2).all(|a| {
            let low = self.raster.start[a];
            let high = low + (self.raster.size[a] as f64 - 1.0) * self.raster.pitch[a];
            (low..=high).contains(&point[a])
        })
    }

    /// The sum, indexed [y, x].
    pub fn finish(self) -> ndarray::Array2<Complex64> {
        let [nx, ny] = self.raster.size;
        ndarray::Array2::from_shape_fn((ny, nx), |(j, i)| {
            let band = &self.bands[j / BAND_ROWS];
            let at = (j - band.first_row) * band.stride + i;
            Complex64::new(band.re[at], band.im[at])
        })
    }
}

/// All beamlets on one band.
#[inline(always)]
fn fill<S: Simd>(
    _simd: S,
    band: &mut Band,
    raster: &Raster,
    arrivals: &[Arrival],
    k: f64,
    threshold: f64,
) -> Evaluations {
    let low = raster.start[1] + band.first_row as f64 * raster.pitch[1];
    let high = low + (band.rows as f64 - 1.0) * raster.pitch[1];
    let mut evaluations = 0;
    for arrival in arrivals {
        let reach = arrival.footprint(k, threshold)[1];
        if arrival.at[1] + reach < low || arrival.at[1] - reach > high {
            continue;
        }
        evaluations += stamp(band, raster, arrival, k, threshold);
    }
    evaluations
}

/// One beamlet on one band.
#[inline(always)]
fn stamp(band: &mut Band, raster: &Raster, a: &Arrival, k: f64, threshold: f64) -> Evaluations {
    let [hx, hy] = raster.pitch;
    let first_y = raster.start[1] + band.first_row as f64 * hy;

    // The rows that the footprint meets.
    let reach = a.footprint(k, threshold)[1];
    let row_of = |y: f64| (y - first_y) / hy;
    let from = row_of(a.at[1] - reach).ceil().max(0.0) as usize;
    let to = (row_of(a.at[1] + reach).floor() + 1.0).clamp(0.0, band.rows as f64) as usize;

    // Exponent of the value at (u, v): i·k[p·(u,v) + ½(xx u² + 2 xy u v + yy v²)].
    let [xx, xy, yy] = a.curvature;
    let bend = Complex64::new(-k * xx.im, k * xx.re) * (hx * hx);
    let chirp = Chirp::new(bend);
    let mut evaluations = 0;
    for block in (from..to.max(from)).step_by(LANES) {
        let spans = Spans::new(block, to, first_y, raster, a, k, threshold);

        // First value and first ratio of eight rows at once.
        let (mut exponent, mut phase) = ([0.0; LANES], [0.0; LANES]);
        let (mut growth, mut turn) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            let (u, v) = (spans.u[l], spans.v[l]);
            let quadratic =
                |xx: f64, xy: f64, yy: f64| 0.5 * (xx * u + 2.0 * xy * v) * u + 0.5 * yy * v * v;
            phase[l] = k * (a.cosines[0] * u + a.cosines[1] * v + quadratic(xx.re, xy.re, yy.re));
            exponent[l] = -k * quadratic(xx.im, xy.im, yy.im);
            turn[l] = k * hx * (a.cosines[0] + xx.re * (u + 0.5 * hx) + xy.re * v);
            growth[l] = -k * hx * (xx.im * (u + 0.5 * hx) + xy.im * v);
        }
        let first = polar(exponent, phase);
        let ratio = polar(growth, turn);

        // Along each row.
        for l in 0..LANES.min(to - block) {
            let [i0, i1] = spans.columns[l];
            if i0 >= i1 {
                continue;
            }
            let value = Complex64::new(first.0[l], first.1[l]) * a.amplitude;
            let at = (block + l) * band.stride + i0;
            let end = at + (i1 - i0).next_multiple_of(LANES);
            let row = (&mut band.re[at..end], &mut band.im[at..end]);
            chirp.run(row, value, Complex64::new(ratio.0[l], ratio.1[l]));
            evaluations += (i1 - i0) as u64;
        }
    }
    evaluations
}

/// The column ranges of eight rows, and the offsets of their first values from the chief ray.
struct Spans {
    columns: [[usize; 2]; LANES],
    u: Lanes,
    v: Lanes,
}

impl Spans {
    #[inline(always)]
    fn new(
        block: usize,
        to: usize,
        first_y: f64,
        raster: &Raster,
        a: &Arrival,
        k: f64,
        threshold: f64,
    ) -> Self {
        let [xx, xy, yy] = a.curvature.map(|g| g.im);
        let limit = -2.0 * threshold.ln() / k;
        let mut spans = Spans {
            columns: [[0, 0]; LANES],
            u: [0.0; LANES],
            v: [0.0; LANES],
        };
        let width = raster.size[0] as f64;
        for l in 0..LANES {
            // The ellipse xx u² + 2 xy u v + yy v² ≤ limit, cut at this row's v.
            let v = first_y + (block + l) as f64 * raster.pitch[1] - a.at[1];
            let middle = -xy * v / xx;
            let under = (limit - v * v * (yy - xy * xy / xx)).max(0.0) / xx;
            let half = under.sqrt();
            let column = |u: f64| (a.at[0] + u - raster.start[0]) / raster.pitch[0];
            let low = column(middle - half).ceil().clamp(0.0, width);
            let high = (column(middle + half).floor() + 1.0).clamp(0.0, width);
            spans.u[l] = raster.start[0] + low * raster.pitch[0] - a.at[0];
            spans.v[l] = v;
            if block + l < to && low < high {
                spans.columns[l] = [low as usize, high as usize];
            }
        }
        spans
    }
}

/// Powers of the constant ρ by which the ratio of neighbours changes.
struct Chirp {
    /// ρ^{l(l−1)/2}.
    triangle: (Lanes, Lanes),
    /// ρ^{28+8l}: from the first ratio to the ratio over eight columns.
    leap: (Lanes, Lanes),
    /// ρ^{64}.
    step: Complex64,
}

impl Chirp {
    #[inline(always)]
    fn new(bend: Complex64) -> Self {
        let power = |n: Lanes| polar(n.map(|n| n * bend.re), n.map(|n| n * bend.im));
        let triangle = power([0.0, 0.0, 1.0, 3.0, 6.0, 10.0, 15.0, 21.0]);
        let leap = power([28.0, 36.0, 44.0, 52.0, 60.0, 68.0, 76.0, 84.0]);
        let far = power([64.0; LANES]);
        Self {
            triangle,
            leap,
            step: Complex64::new(far.0[0], far.1[0]),
        }
    }

    /// Adds the chirped values that start at `value` with first ratio `ratio` to a row.
    #[inline(always)]
    fn run(&self, row: (&mut [f64], &mut [f64]), value: Complex64, ratio: Complex64) {
        // Eight neighbours: value·ratioˡ·ρ^{l(l−1)/2}; their ratios over eight columns: ratio⁸·ρ^{28+8l}.
        let (mut vr, mut vi) = ([0.0; LANES], [0.0; LANES]);
        let mut power = value;
        for l in 0..LANES {
            vr[l] = power.re;
            vi[l] = power.im;
            power *= ratio;
        }
        let (tr, ti) = self.triangle;
        let squared = ratio * ratio;
        let fourth = squared * squared;
        let eighth = fourth * fourth;
        let (lr, li) = self.leap;
        let (mut rr, mut ri) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            (vr[l], vi[l]) = (vr[l] * tr[l] - vi[l] * ti[l], vr[l] * ti[l] + vi[l] * tr[l]);
            rr[l] = eighth.re * lr[l] - eighth.im * li[l];
            ri[l] = eighth.re * li[l] + eighth.im * lr[l];
        }

        // Two complex multiplications per value.
        let (sr, si) = (self.step.re, self.step.im);
        let (re, im) = row;
        for (re, im) in re.chunks_exact_mut(LANES).zip(im.chunks_exact_mut(LANES)) {
            for l in 0..LANES {
                re[l] += vr[l];
                im[l] += vi[l];
                let v = (vr[l] * rr[l] - vi[l] * ri[l], vr[l] * ri[l] + vi[l] * rr[l]);
                let r = (rr[l] * sr - ri[l] * si, rr[l] * si + ri[l] * sr);
                (vr[l], vi[l]) = v;
                (rr[l], ri[l]) = r;
            }
        }
    }
}

/// exp(a + ib) of eight pairs.
#[inline(always)]
fn polar(a: Lanes, b: Lanes) -> (Lanes, Lanes) {
    let size = exp(a);
    let (cos, sin) = cis(b);
    let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
    for l in 0..LANES {
        re[l] = size[l] * cos[l];
        im[l] = size[l] * sin[l];
    }
    (re, im)
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::wave::gather::{Canvas, Raster};
    use crate::wave::wavelet::Arrival;

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
