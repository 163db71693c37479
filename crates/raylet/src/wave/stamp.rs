//! One beamlet on a few rows of a raster.
//!
//! Along a row its exponent is quadratic in x, so neighbouring values have a ratio that itself changes
//! by a constant factor: two complex multiplications per value, eight columns at once.

use fearless_simd::{Simd, SimdBase, SimdFloat, f64x8};
use num_complex::Complex64;

use crate::math::lanes::{LANES, Lanes, cis, exp};
use crate::wave::raster::Raster;
use crate::wave::wavelet::Arrival;

/// Rows of a raster being summed: real and imaginary part, row-major, `stride` apart; rows are padded so
/// that eight columns may be touched past the last one.
pub struct Rows {
    /// Real parts.
    pub re: Vec<f64>,
    /// Imaginary parts.
    pub im: Vec<f64>,
    /// Distance of rows in the arrays.
    pub stride: usize,
    /// Number of rows.
    pub count: usize,
    /// Where they stand.
    pub raster: Raster,
}

/// A beamlet about to be added to some rows.
pub struct Stamp<'a> {
    arrival: &'a Arrival,
    /// First row and the row after the last.
    span: [usize; 2],
    /// The footprint ends where uᵀ(Im G)u reaches this, in mm.
    limit: f64,
}

impl<'a> Stamp<'a> {
    /// The beamlet's footprint on the rows; nothing when it does not meet them.
    #[inline(always)]
    pub fn new(arrival: &'a Arrival, rows: &Rows, limit: f64) -> Option<Self> {
        let [xx, xy, yy] = arrival.curvature.map(|g| g.im);
        let determinant = xx * yy - xy * xy;
        let reach = (limit * xx / determinant).sqrt();
        if !reach.is_finite() {
            return None;
        }
        let row = |y: f64| (y - rows.raster.start[1]) / rows.raster.pitch[1];
        let count = rows.count as f64;
        let from = row(arrival.at[1] - reach).ceil().clamp(0.0, count);
        let to = (row(arrival.at[1] + reach).floor() + 1.0).clamp(0.0, count);
        (from < to).then_some(Self {
            arrival,
            span: [from as usize, to as usize],
            limit,
        })
    }

    /// Adds it; returns the number of values.
    #[inline(always)]
    pub fn press<S: Simd>(&self, simd: S, rows: &mut Rows, k: f64) -> u64 {
        let [xx, _, _] = self.arrival.curvature;
        let hx = rows.raster.pitch[0];
        let bend = Complex64::new(-k * xx.im, k * xx.re) * (hx * hx);
        let chirp = Chirp::new(simd, bend);
        let mut evaluations = 0;
        let mut block = self.span[0];
        while block < self.span[1] {
            let heads = self.heads(simd, &rows.raster, block, k);
            for l in 0..LANES.min(self.span[1] - block) {
                let (low, high) = (heads.low[l] as usize, heads.high[l] as usize);
                if low >= high {
                    continue;
                }
                let value = Complex64::new(heads.value[0][l], heads.value[1][l]);
                let ratio = Complex64::new(heads.ratio[0][l], heads.ratio[1][l]);
                let at = (block + l) * rows.stride + low;
                let end = at + (high - low).next_multiple_of(LANES);
                let row = (&mut rows.re[at..end], &mut rows.im[at..end]);
                chirp.run(simd, row, value * self.arrival.amplitude, ratio);
                evaluations += (high - low) as u64;
            }
            block += LANES;
        }
        evaluations
    }

    /// Column range, first value and first ratio of eight rows.
    #[inline(always)]
    fn heads<S: Simd>(&self, simd: S, raster: &Raster, block: usize, k: f64) -> Heads {
        let splat = |v: f64| f64x8::splat(simd, v);
        let a = self.arrival;
        let [hx, hy] = raster.pitch;
        let [xx, xy, yy] = a.curvature;
        let lane = f64x8::from_slice(simd, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);

        // The ellipse xx u² + 2 xy u v + yy v² ≤ limit (imaginary parts), cut at each row's v.
        let v = lane * splat(hy) + splat(raster.start[1] + block as f64 * hy - a.at[1]);
        let middle = v * splat(-xy.im / xx.im);
        let under = splat(self.limit) - v * v * splat(yy.im - xy.im * xy.im / xx.im);
        let half = (under.max(splat(0.0)) * splat(1.0 / xx.im)).sqrt();
        let column = |u: f64x8<S>| (u + splat(a.at[0] - raster.start[0])) * splat(1.0 / hx);
        let width = splat(raster.size[0] as f64);
        let clamp = |c: f64x8<S>| c.max(splat(0.0)).min(width);
        let low = clamp(column(middle - half).ceil());
        let high = clamp(column(middle + half).floor() + splat(1.0));
        let u = low * splat(hx) + splat(raster.start[0] - a.at[0]);

        // Exponent i·k[p·(u,v) + ½(xx u² + 2 xy u v + yy v²)], and its step to the next column.
        let quadratic = |xx: f64, xy: f64, yy: f64| {
            (u * splat(0.5 * xx) + v * splat(xy)) * u + v * v * splat(0.5 * yy)
        };
        let linear = u * splat(a.cosines[0]) + v * splat(a.cosines[1]);
        let phase = (linear + quadratic(xx.re, xy.re, yy.re)) * splat(k);
        let decay = quadratic(xx.im, xy.im, yy.im) * splat(-k);
        let next = u + splat(0.5 * hx);
        let turn = (next * splat(xx.re) + v * splat(xy.re) + splat(a.cosines[0])) * splat(k * hx);
        let growth = (next * splat(xx.im) + v * splat(xy.im)) * splat(-k * hx);
        let (value, ratio) = (polar(decay, phase), polar(growth, turn));
        Heads {
            low: *low.as_array(),
            high: *high.as_array(),
            value: [*value.0.as_array(), *value.1.as_array()],
            ratio: [*ratio.0.as_array(), *ratio.1.as_array()],
        }
    }
}

/// Where eight rows start and end, with their first values and ratios (real and imaginary parts).
struct Heads {
    low: Lanes,
    high: Lanes,
    value: [Lanes; 2],
    ratio: [Lanes; 2],
}

/// Powers of the constant ρ by which the ratio of neighbours changes.
struct Chirp<S: Simd> {
    /// ρ^{l(l−1)/2}.
    triangle: (f64x8<S>, f64x8<S>),
    /// ρ^{28+8l}: from the first ratio to the ratio over eight columns.
    leap: (f64x8<S>, f64x8<S>),
    /// ρ^{64}.
    step: (f64x8<S>, f64x8<S>),
}

impl<S: Simd> Chirp<S> {
    #[inline(always)]
    fn new(simd: S, bend: Complex64) -> Self {
        let power = |n: Lanes| {
            let n = f64x8::from_slice(simd, &n);
            polar(
                n * f64x8::splat(simd, bend.re),
                n * f64x8::splat(simd, bend.im),
            )
        };
        Self {
            triangle: power([0.0, 0.0, 1.0, 3.0, 6.0, 10.0, 15.0, 21.0]),
            leap: power([28.0, 36.0, 44.0, 52.0, 60.0, 68.0, 76.0, 84.0]),
            step: power([64.0; LANES]),
        }
    }

    /// Adds the chirped values that start at `value` with first ratio `ratio` to a row.
    #[inline(always)]
    fn run(&self, simd: S, row: (&mut [f64], &mut [f64]), value: Complex64, ratio: Complex64) {
        // Eight neighbours value·ratioˡ·ρ^{l(l−1)/2}, and their ratios over eight columns,
        // ratio⁸·ρ^{28+8l}.
        let squared = ratio * ratio;
        let fourth = squared * squared;
        let eighth = fourth * fourth;
        let low = [
            value,
            value * ratio,
            value * squared,
            value * squared * ratio,
        ];
        let high = low.map(|v| v * fourth);
        let real = [low.map(|v| v.re), high.map(|v| v.re)];
        let imaginary = [low.map(|v| v.im), high.map(|v| v.im)];
        let pr = f64x8::from_slice(simd, real.as_flattened());
        let pi = f64x8::from_slice(simd, imaginary.as_flattened());
        let (tr, ti) = self.triangle;
        let (lr, li) = self.leap;
        let er = f64x8::splat(simd, eighth.re);
        let ei = f64x8::splat(simd, eighth.im);
        let (mut vr, mut vi) = (pr * tr - pi * ti, pr * ti + pi * tr);
        let (mut rr, mut ri) = (er * lr - ei * li, er * li + ei * lr);

        // Two complex multiplications per value.
        let (sr, si) = self.step;
        let (re, im) = row;
        for (re, im) in re.chunks_exact_mut(LANES).zip(im.chunks_exact_mut(LANES)) {
            (f64x8::from_slice(simd, re) + vr).store_slice(re);
            (f64x8::from_slice(simd, im) + vi).store_slice(im);
            (vr, vi) = (vr * rr - vi * ri, vr * ri + vi * rr);
            (rr, ri) = (rr * sr - ri * si, rr * si + ri * sr);
        }
    }
}

/// exp(a + ib) of eight pairs.
#[inline(always)]
fn polar<S: Simd>(a: f64x8<S>, b: f64x8<S>) -> (f64x8<S>, f64x8<S>) {
    let size = exp(a);
    let (cos, sin) = cis(b);
    (size * cos, size * sin)
}
