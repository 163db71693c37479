//! One beamlet on a few rows of a raster.
//!
//! Along a row its exponent is quadratic in x, so neighbouring values have a ratio that itself changes
//! by a constant factor: two complex multiplications per value, eight columns at once.

use fearless_simd::{Simd, SimdBase, SimdFloat, f64x8};
use num_complex::Complex64;

use crate::math::lanes::{LANES, Lanes, cis, exp};
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::raster::Raster;

/// Rows of a raster being summed: real and imaginary part, row-major, `stride` apart; rows are padded so
/// that eight columns may be touched past the last one.
pub(crate) struct Rows {
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

impl Rows {
    /// Dark rows of a raster.
    pub(crate) fn zeros(raster: Raster) -> Self {
        let [nx, count] = raster.size;
        let stride = nx + LANES;
        Self {
            re: vec![0.0; count * stride],
            im: vec![0.0; count * stride],
            stride,
            count,
            raster,
        }
    }
}

/// Σ conj(B)·value over the samples that a beamlet B of unit amplitude touches, times 1, u, v, u², uv, v²
/// with (u, v) = x − s.
pub(crate) type Moments = [Complex64; 6];

/// A beamlet about to be added to some rows.
pub(crate) struct BeamletKernel<'a> {
    arrival: &'a Arrival,
    /// First row and the row after the last.
    span: [usize; 2],
    /// The footprint ends where uᵀ(Im G)u reaches this, in mm.
    limit: f64,
}

impl<'a> BeamletKernel<'a> {
    /// How far along y a beamlet's footprint reaches, in mm; not finite where it has no end.
    #[inline(always)]
    pub(crate) fn reach(arrival: &Arrival, limit: f64) -> f64 {
        let [xx, xy, yy] = arrival.curvature.map(|g| g.im);
        (limit * xx / (xx * yy - xy * xy)).sqrt()
    }

    /// The beamlet's footprint on the rows; nothing when it does not meet them.
    #[inline(always)]
    pub(crate) fn new(arrival: &'a Arrival, rows: &Rows, limit: f64) -> Option<Self> {
        Self::reaching(arrival, rows, limit, Self::reach(arrival, limit))
    }

    /// The same for a footprint that is known to reach so far along y.
    #[inline(always)]
    pub(crate) fn reaching(
        arrival: &'a Arrival,
        rows: &Rows,
        limit: f64,
        reach: f64,
    ) -> Option<Self> {
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
    pub(crate) fn add<S: Simd>(&self, simd: S, rows: &mut Rows, k: f64) -> u64 {
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

    /// The conjugate transpose of [`BeamletKernel::add`] for a beamlet of unit amplitude, and the same of its
    /// values times powers of the distance.
    #[inline(always)]
    pub(crate) fn add_adjoint<S: Simd>(&self, simd: S, rows: &Rows, k: f64) -> Moments {
        let [xx, _, _] = self.arrival.curvature;
        let [hx, hy] = rows.raster.pitch;
        let bend = Complex64::new(-k * xx.im, k * xx.re) * (hx * hx);
        let chirp = Chirp::new(simd, bend);
        let mut moments = [Complex64::ZERO; 6];
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
                // row += amplitude·(value, value·ratio, …)
                let row = (&rows.re[at..end], &rows.im[at..end]);
                let u = rows.raster.start[0] + low as f64 * hx - self.arrival.at[0];
                let [one, first, second] = chirp.read(simd, row, [value, ratio], [u, hx]);
                let v = rows.raster.start[1] + (block + l) as f64 * hy - self.arrival.at[1];
                for (moment, part) in
                    moments
                        .iter_mut()
                        .zip([one, first, one * v, second, first * v, one * (v * v)])
                {
                    *moment += part;
                }
            }
            block += LANES;
        }
        moments
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

/// Real and imaginary parts of eight numbers.
type Pair<S> = (f64x8<S>, f64x8<S>);

/// Powers of the constant ρ by which the ratio of neighbours changes.
struct Chirp<S: Simd> {
    /// ρ^{l(l−1)/2}.
    triangle: Pair<S>,
    /// ρ^{28+8l}: from the first ratio to the ratio over eight columns.
    leap: Pair<S>,
    /// ρ^{64}.
    step: Pair<S>,
}

impl<S: Simd> Chirp<S> {
    #[inline(always)]
    fn new(simd: S, bend: Complex64) -> Self {
        Self {
            triangle: powers(simd, bend, [0.0, 0.0, 1.0, 3.0, 6.0, 10.0, 15.0, 21.0]),
            leap: powers(simd, bend, [28.0, 36.0, 44.0, 52.0, 60.0, 68.0, 76.0, 84.0]),
            step: powers(simd, bend, [64.0; LANES]),
        }
    }

    /// The first eight chirped values, and their ratios over eight columns.
    #[inline(always)]
    fn start(&self, simd: S, value: Complex64, ratio: Complex64) -> (Pair<S>, Pair<S>) {
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
        (
            (pr * tr - pi * ti, pr * ti + pi * tr),
            (er * lr - ei * li, er * li + ei * lr),
        )
    }

    /// Adds the chirped values that start at `value` with first ratio `ratio` to a row.
    #[inline(always)]
    fn run(&self, simd: S, row: (&mut [f64], &mut [f64]), value: Complex64, ratio: Complex64) {
        let ((mut vr, mut vi), (mut rr, mut ri)) = self.start(simd, value, ratio);

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

impl<S: Simd> Chirp<S> {
    /// Σ of a row times the conjugates of the values that [`Chirp::run`] would add to it, times 1, u, u²
    /// where u starts at `place[0]` and grows by `place[1]`.
    #[inline(always)]
    fn read(
        &self,
        simd: S,
        row: (&[f64], &[f64]),
        [value, ratio]: [Complex64; 2],
        [start, pitch]: [f64; 2],
    ) -> [Complex64; 3] {
        let ((mut vr, mut vi), (mut rr, mut ri)) = self.start(simd, value, ratio);
        let (sr, si) = self.step;
        let lane = f64x8::from_slice(simd, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let mut u = lane * f64x8::splat(simd, pitch) + f64x8::splat(simd, start);
        let leap = f64x8::splat(simd, LANES as f64 * pitch);
        let zero = f64x8::splat(simd, 0.0);
        let mut sums = [(zero, zero); 3];
        for (re, im) in row.0.chunks_exact(LANES).zip(row.1.chunks_exact(LANES)) {
            let (re, im) = (f64x8::from_slice(simd, re), f64x8::from_slice(simd, im));
            // re + i·im += v
            let mut part = (vr * re + vi * im, vr * im - vi * re);
            for sum in &mut sums {
                *sum = (sum.0 + part.0, sum.1 + part.1);
                part = (part.0 * u, part.1 * u);
            }
            u += leap;
            (vr, vi) = (vr * rr - vi * ri, vr * ri + vi * rr);
            (rr, ri) = (rr * sr - ri * si, rr * si + ri * sr);
        }
        let total = |sum: f64x8<S>| sum.as_array().iter().sum::<f64>();
        sums.map(|(re, im)| Complex64::new(total(re), total(im)))
    }
}

/// exp(n·bend) of eight n. A function of its own: a closure would not be compiled for the machine's vectors.
#[inline(always)]
fn powers<S: Simd>(simd: S, bend: Complex64, n: Lanes) -> Pair<S> {
    let n = f64x8::from_slice(simd, &n);
    polar(
        n * f64x8::splat(simd, bend.re),
        n * f64x8::splat(simd, bend.im),
    )
}

/// exp(a + ib) of eight pairs.
#[inline(always)]
fn polar<S: Simd>(a: f64x8<S>, b: f64x8<S>) -> (f64x8<S>, f64x8<S>) {
    let size = exp(a);
    let (cos, sin) = cis(b);
    (size * cos, size * sin)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use num_complex::Complex64;

    use crate::wave::beamlet::beamlet_kernel::{BeamletKernel, Rows};
    use crate::wave::beamlet::wavelet::Arrival;
    use crate::wave::grid::raster::Raster;

    #[test]
    fn press_dot_product() {
        let arrival = Arrival {
            at: [1.3, -0.4],
            cosines: [0.1, -0.3],
            amplitude: Complex64::new(0.3, -0.8),
            curvature: [
                Complex64::new(0.02, 0.03),
                Complex64::new(-0.01, 0.005),
                Complex64::new(0.01, 0.02),
            ],
        };
        let raster = Raster {
            start: [-9.0, -11.0],
            pitch: [0.4, 0.5],
            size: [50, 45],
        };
        let (mut rows, mut bar) = (Rows::zeros(raster), Rows::zeros(raster));
        for j in 0..45 {
            for i in 0..50 {
                let t = ((j * 50 + i) as f64 * 0.618_033_988_7).fract();
                (bar.re[j * bar.stride + i], bar.im[j * bar.stride + i]) =
                    (t - 0.5, (5.0 * t).sin());
            }
        }
        let (k, level) = (std::f64::consts::TAU, Level::new());
        let kernel = BeamletKernel::new(&arrival, &rows, 2.0).unwrap();
        dispatch!(level, simd => kernel.add(simd, &mut rows, k));
        let back = dispatch!(level, simd => kernel.add_adjoint(simd, &bar, k))[0];
        let mut forward = Complex64::ZERO;
        for at in 0..rows.re.len() {
            let value = Complex64::new(rows.re[at], rows.im[at]);
            forward += Complex64::new(bar.re[at], -bar.im[at]) * value;
        }
        let reverse = back.conj() * arrival.amplitude;
        assert!(
            (forward - reverse).norm() < 1e-14 * 100.0,
            "{forward} {reverse}"
        );
    }
}
