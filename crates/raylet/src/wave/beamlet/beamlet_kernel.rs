//! One beamlet on a few rows of a raster.
//!
//! Eight rows go together, one in each lane. Along a row the exponent is quadratic in x, so neighbouring values
//! have a ratio that itself changes by a constant factor: two complex multiplications per value.

use fearless_simd::{Simd, SimdBase, SimdFloat, f64x8};
use num_complex::Complex64;

use crate::math::lanes::{LANES, Lanes, cis, exp};
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::raster::Raster;

/// Rows of a raster being summed. Eight rows are a block; a block has for each column the real parts of its eight
/// values, then their imaginary parts.
pub(crate) struct Rows {
    values: Vec<f64>,
    /// The places of their values, in mm.
    pub raster: Raster,
}

/// Numbers of one column of a block.
const COLUMN: usize = 2 * LANES;

impl Rows {
    /// Dark rows of a raster.
    pub(crate) fn zeros(raster: Raster) -> Self {
        let [nx, ny] = raster.size;
        Self {
            values: vec![0.0; ny.div_ceil(LANES) * nx * COLUMN],
            raster,
        }
    }

    /// The value at a row and a column.
    pub(crate) fn value(&self, [j, i]: [usize; 2]) -> Complex64 {
        let at = self.place([j, i]);
        Complex64::new(self.values[at], self.values[at + LANES])
    }

    /// Sets the value at a row and a column.
    pub(crate) fn set(&mut self, [j, i]: [usize; 2], value: Complex64) {
        let at = self.place([j, i]);
        (self.values[at], self.values[at + LANES]) = (value.re, value.im);
    }

    fn place(&self, [j, i]: [usize; 2]) -> usize {
        (j / LANES * self.raster.size[0] + i) * COLUMN + j % LANES
    }

    /// The numbers of some columns of a block.
    #[inline(always)]
    fn columns(&self, block: usize, [first, last]: [usize; 2]) -> &[f64] {
        let start = block * self.raster.size[0];
        &self.values[(start + first) * COLUMN..(start + last) * COLUMN]
    }

    /// Mutable access to the numbers of some columns of a block.
    #[inline(always)]
    fn columns_mut(&mut self, block: usize, [first, last]: [usize; 2]) -> &mut [f64] {
        let start = block * self.raster.size[0];
        &mut self.values[(start + first) * COLUMN..(start + last) * COLUMN]
    }
}

/// Σ conj(B)·value over the samples that a beamlet B of unit amplitude touches, times 1, u, v, u², uv, v²
/// with (u, v) = x − s.
pub(crate) type Moments = [Complex64; 6];

/// A beamlet about to be added to some rows.
pub(crate) struct BeamletKernel<'a> {
    arrival: &'a Arrival,
    raster: Raster,
    /// First row and the row after the last.
    span: [usize; 2],
    /// The footprint ends where uᵀ(Im G)u reaches this, in mm.
    limit: f64,
    /// Vacuum wavenumber in rad/mm.
    k: f64,
}

/// The parts of eight rows that lie in a footprint.
struct Chords {
    /// First columns of the rows, and those after their last.
    low: Lanes,
    high: Lanes,
}

/// Rows of a block that are computed together.
#[derive(Clone, Copy, Default)]
struct Group {
    /// One for its rows, zero for others.
    lit: Lanes,
    /// First column and the one after the last.
    columns: [usize; 2],
}

/// Values in one column of eight rows, and their ratios to those in the next column.
struct ColumnValues<S: Simd> {
    value: Pair<S>,
    ratio: Pair<S>,
    /// The factor by which the ratio changes from column to column.
    step: Pair<S>,
}

/// Real and imaginary parts of eight numbers.
type Pair<S> = (f64x8<S>, f64x8<S>);

/// Columns after which a value is computed anew: its error grows as the square of their number.
const LONGEST: usize = 256;

/// Where the exponent of a row is below this in the first column of its block, its values cannot be computed from that
/// column on.
const FAINTEST: f64 = -600.0;

impl<'a> BeamletKernel<'a> {
    /// How far along y a beamlet's footprint reaches, in mm; not finite where it has no end.
    #[inline(always)]
    pub(crate) fn reach(arrival: &Arrival, limit: f64) -> f64 {
        let [xx, xy, yy] = arrival.curvature.map(|g| g.im);
        (limit * xx / (xx * yy - xy * xy)).sqrt()
    }

    /// The beamlet's footprint on a raster, where uᵀ(Im G)u stays below `limit` in mm; nothing when it does not meet
    /// it.
    #[inline(always)]
    pub(crate) fn new(arrival: &'a Arrival, raster: &Raster, limit: f64, k: f64) -> Option<Self> {
        Self::reaching(arrival, raster, [limit, Self::reach(arrival, limit)], k)
    }

    /// [`BeamletKernel::new`] for a footprint whose half width `reach` along y is known, in mm.
    #[inline(always)]
    pub(crate) fn reaching(
        arrival: &'a Arrival,
        raster: &Raster,
        [limit, reach]: [f64; 2],
        k: f64,
    ) -> Option<Self> {
        if !reach.is_finite() {
            return None;
        }
        let row = |y: f64| (y - raster.start[1]) / raster.pitch[1];
        let count = raster.size[1] as f64;
        let from = row(arrival.at[1] - reach).ceil().clamp(0.0, count);
        let to = (row(arrival.at[1] + reach).floor() + 1.0).clamp(0.0, count);
        (from < to).then_some(Self {
            arrival,
            raster: *raster,
            span: [from as usize, to as usize],
            limit,
            k,
        })
    }

    /// Adds it; returns the number of values.
    #[inline(always)]
    pub(crate) fn add<S: Simd>(&self, simd: S, rows: &mut Rows) -> u64 {
        let step = self.step(simd);
        let mut evaluations = 0;
        for block in self.span[0] / LANES..self.span[1].div_ceil(LANES) {
            let chords = self.chords(simd, block);
            evaluations += chords.count();
            let (groups, count) = self.groups(simd, block, &chords);
            for group in &groups[..count] {
                let [mut first, end] = group.columns;
                while first < end {
                    let last = end.min(first + LONGEST);
                    let columns = rows.columns_mut(block, [first, last]);
                    let values = self.column_values(simd, block, group, first, step);
                    values
                        .scaled(simd, self.arrival.amplitude)
                        .add(simd, columns);
                    first = last;
                }
            }
        }
        evaluations
    }

    /// The conjugate transpose of [`BeamletKernel::add`] for a beamlet of unit amplitude, and the same of its
    /// values times powers of the distance.
    #[inline(always)]
    pub(crate) fn add_adjoint<S: Simd>(&self, simd: S, rows: &Rows) -> Moments {
        let step = self.step(simd);
        let mut moments = [Complex64::ZERO; 6];
        for block in self.span[0] / LANES..self.span[1].div_ceil(LANES) {
            let chords = self.chords(simd, block);
            let (groups, count) = self.groups(simd, block, &chords);
            for group in &groups[..count] {
                let [mut first, end] = group.columns;
                while first < end {
                    let last = end.min(first + LONGEST);
                    let columns = rows.columns(block, [first, last]);
                    let values = self.column_values(simd, block, group, first, step);
                    let sums =
                        values.add_adjoint(simd, columns, self.u(first), self.raster.pitch[0]);
                    self.add_moments(simd, block, &sums, &mut moments);
                    first = last;
                }
            }
        }
        moments
    }

    /// Adds the sums over a block's rows, times 1, u and u², to all moments.
    #[inline(always)]
    fn add_moments<S: Simd>(
        &self,
        simd: S,
        block: usize,
        [one, first, second]: &[Pair<S>; 3],
        moments: &mut Moments,
    ) {
        let v = self.v(simd, block);
        let times_v = |(re, im): Pair<S>| (re * v, im * v);
        let all = [
            *one,
            *first,
            times_v(*one),
            *second,
            times_v(*first),
            times_v(times_v(*one)),
        ];
        for (moment, (re, im)) in moments.iter_mut().zip(all) {
            let total = |sum: f64x8<S>| sum.as_array().iter().sum::<f64>();
            *moment += Complex64::new(total(re), total(im));
        }
    }

    /// The distance of a column from the beamlet's ray along x.
    #[inline(always)]
    fn u(&self, column: usize) -> f64 {
        column as f64 * self.raster.pitch[0] + (self.raster.start[0] - self.arrival.at[0])
    }

    /// The distances of a block's rows from the beamlet's ray along y.
    #[inline(always)]
    fn v<S: Simd>(&self, simd: S, block: usize) -> f64x8<S> {
        let hy = self.raster.pitch[1];
        let first = self.raster.start[1] + (block * LANES) as f64 * hy - self.arrival.at[1];
        let lane = f64x8::from_slice(simd, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        lane * f64x8::splat(simd, hy) + f64x8::splat(simd, first)
    }

    /// The parts of a block's rows that lie in the footprint.
    #[inline(always)]
    fn chords<S: Simd>(&self, simd: S, block: usize) -> Chords {
        let splat = |v: f64| f64x8::splat(simd, v);
        let [xx, xy, yy] = self.arrival.curvature;
        let v = self.v(simd, block);

        // The ellipse xx u² + 2 xy u v + yy v² ≤ limit (imaginary parts), cut at each row's v.
        let middle = v * splat(-xy.im / xx.im);
        let under = splat(self.limit) - v * v * splat(yy.im - xy.im * xy.im / xx.im);
        let half = (under.max(splat(0.0)) * splat(1.0 / xx.im)).sqrt();
        let from = splat(self.arrival.at[0] - self.raster.start[0]);
        let column = |u: f64x8<S>| (u + from) * splat(1.0 / self.raster.pitch[0]);
        let width = splat(self.raster.size[0] as f64);
        let clamp = |c: f64x8<S>| c.max(splat(0.0)).min(width);
        let low = clamp(column(middle - half).ceil());
        let high = clamp(column(middle + half).floor() + splat(1.0));
        let (low, mut high) = (*low.as_array(), *high.as_array());

        // Rows beside the raster or the footprint have none.
        for (l, high) in high.iter_mut().enumerate() {
            let row = block * LANES + l;
            if row < self.span[0] || row >= self.span[1] {
                *high = 0.0;
            }
        }
        Chords { low, high }
    }

    /// The rows of a block that are computed together, and how many groups of them there are. All rows are one group;
    /// each row is one where values cannot be computed from column to column, or where an oblique footprint makes all
    /// columns of the block more than those of its rows one by one.
    #[inline(always)]
    fn groups<S: Simd>(&self, simd: S, block: usize, chords: &Chords) -> ([Group; LANES], usize) {
        let mut groups = [Group::default(); LANES];
        let mut all = Group {
            lit: [0.0; LANES],
            columns: [usize::MAX, 0],
        };
        for l in 0..LANES {
            let columns = [chords.low[l] as usize, chords.high[l] as usize];
            if columns[0] < columns[1] {
                all.lit[l] = 1.0;
                all.columns[0] = all.columns[0].min(columns[0]);
                all.columns[1] = all.columns[1].max(columns[1]);
            }
        }
        let [first, last] = all.columns;
        if first >= last {
            return (groups, 0);
        }
        let decay = *self
            .decay(simd, self.u(first), self.v(simd, block))
            .as_array();
        let lost = (0..LANES).any(|l| all.lit[l] > 0.0 && decay[l] < FAINTEST);
        if !lost && (last - first) as u64 <= chords.count() {
            groups[0] = all;
            return (groups, 1);
        }
        let mut count = 0;
        for l in (0..LANES).filter(|l| all.lit[*l] > 0.0) {
            groups[count].lit[l] = 1.0;
            groups[count].columns = [chords.low[l] as usize, chords.high[l] as usize];
            count += 1;
        }
        (groups, count)
    }

    /// The real part of the exponent of unit amplitude at distances (u, v).
    #[inline(always)]
    fn decay<S: Simd>(&self, simd: S, u: f64, v: f64x8<S>) -> f64x8<S> {
        let [xx, xy, yy] = self.arrival.curvature.map(|g| g.im);
        quadratic(simd, [xx, xy, yy], u, v) * f64x8::splat(simd, -self.k)
    }

    /// The values in a column of a group of rows, of unit amplitude, and how they go on.
    #[inline(always)]
    fn column_values<S: Simd>(
        &self,
        simd: S,
        block: usize,
        group: &Group,
        column: usize,
        step: Pair<S>,
    ) -> ColumnValues<S> {
        let splat = |v: f64| f64x8::splat(simd, v);
        let (a, k, hx) = (self.arrival, self.k, self.raster.pitch[0]);
        let [xx, xy, yy] = a.curvature;
        let (u, v) = (self.u(column), self.v(simd, block));

        // Exponent i·k[p·(u,v) + ½(xx u² + 2 xy u v + yy v²)], and its step to the next column.
        let linear = v * splat(a.cosines[1]) + splat(u * a.cosines[0]);
        let phase = (linear + quadratic(simd, [xx.re, xy.re, yy.re], u, v)) * splat(k);
        let next = u + 0.5 * hx;
        let turn = (v * splat(xy.re) + splat(next * xx.re + a.cosines[0])) * splat(k * hx);
        let growth = (v * splat(xy.im) + splat(next * xx.im)) * splat(-k * hx);

        // Rows that do not belong to the group stay dark.
        let lit = f64x8::from_slice(simd, &group.lit);
        let (value, ratio) = (polar(self.decay(simd, u, v), phase), polar(growth, turn));
        ColumnValues {
            value: (value.0 * lit, value.1 * lit),
            ratio: (ratio.0 * lit, ratio.1 * lit),
            step,
        }
    }

    /// The factor by which the ratio of neighbouring columns changes.
    #[inline(always)]
    fn step<S: Simd>(&self, simd: S) -> Pair<S> {
        let [xx, _, _] = self.arrival.curvature;
        let bend = self.k * self.raster.pitch[0] * self.raster.pitch[0];
        let splat = |v: f64| f64x8::splat(simd, v);
        polar(splat(-bend * xx.im), splat(bend * xx.re))
    }
}

impl Chords {
    /// Values in the footprint.
    #[inline(always)]
    fn count(&self) -> u64 {
        let each = self.low.iter().zip(&self.high);
        each.map(|(low, high)| (high - low).max(0.0)).sum::<f64>() as u64
    }
}

impl<S: Simd> ColumnValues<S> {
    /// The same for a beamlet of this amplitude.
    #[inline(always)]
    fn scaled(mut self, simd: S, amplitude: Complex64) -> Self {
        let splat = |v: f64| f64x8::splat(simd, v);
        self.value = times(self.value, (splat(amplitude.re), splat(amplitude.im)));
        self
    }

    /// Adds the values to columns.
    #[inline(always)]
    fn add(self, simd: S, columns: &mut [f64]) {
        let Self {
            mut value,
            mut ratio,
            step,
        } = self;
        for column in columns.chunks_exact_mut(COLUMN) {
            let (re, im) = column.split_at_mut(LANES);
            (f64x8::from_slice(simd, re) + value.0).store_slice(re);
            (f64x8::from_slice(simd, im) + value.1).store_slice(im);
            value = times(value, ratio);
            ratio = times(ratio, step);
        }
    }

    /// Σ of columns times the conjugates of the values that [`ColumnValues::add`] would add to them, row by row, times
    /// 1, u, u² where u starts here and grows by `pitch`.
    #[inline(always)]
    fn add_adjoint(self, simd: S, columns: &[f64], mut u: f64, pitch: f64) -> [Pair<S>; 3] {
        let Self {
            mut value,
            mut ratio,
            step,
        } = self;
        let zero = f64x8::splat(simd, 0.0);
        let mut sums = [(zero, zero); 3];
        for column in columns.chunks_exact(COLUMN) {
            let (re, im) = column.split_at(LANES);
            let (re, im) = (f64x8::from_slice(simd, re), f64x8::from_slice(simd, im));
            // re + i·im += value
            let mut part = (value.0 * re + value.1 * im, value.0 * im - value.1 * re);
            let far = f64x8::splat(simd, u);
            for sum in &mut sums {
                *sum = (sum.0 + part.0, sum.1 + part.1);
                part = (part.0 * far, part.1 * far);
            }
            u += pitch;
            value = times(value, ratio);
            ratio = times(ratio, step);
        }
        sums
    }
}

/// ½(xx u² + 2 xy u v + yy v²).
#[inline(always)]
fn quadratic<S: Simd>(simd: S, [xx, xy, yy]: [f64; 3], u: f64, v: f64x8<S>) -> f64x8<S> {
    let splat = |v: f64| f64x8::splat(simd, v);
    (v * splat(0.5 * yy) + splat(xy * u)) * v + splat(0.5 * xx * u * u)
}

/// The products of eight pairs of complex numbers.
#[inline(always)]
fn times<S: Simd>(a: Pair<S>, b: Pair<S>) -> Pair<S> {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

/// exp(a + ib) of eight pairs.
#[inline(always)]
fn polar<S: Simd>(a: f64x8<S>, b: f64x8<S>) -> Pair<S> {
    let size = exp(a);
    let (cos, sin) = cis(b);
    (size * cos, size * sin)
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use num_complex::Complex64;

    use crate::math::simd_level::level;
    use crate::wave::beamlet::beamlet_kernel::{BeamletKernel, Rows};
    use crate::wave::beamlet::wavelet::Arrival;
    use crate::wave::grid::raster::Raster;

    #[test]
    fn add_dot_product() {
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
                bar.set([j, i], Complex64::new(t - 0.5, (5.0 * t).sin()));
            }
        }
        let (k, level) = (std::f64::consts::TAU, level());
        let kernel = BeamletKernel::new(&arrival, &raster, 2.0, k).unwrap();
        dispatch!(level, simd => kernel.add(simd, &mut rows));
        let back = dispatch!(level, simd => kernel.add_adjoint(simd, &bar))[0];
        let mut forward = Complex64::ZERO;
        for j in 0..45 {
            for i in 0..50 {
                forward += bar.value([j, i]).conj() * rows.value([j, i]);
            }
        }
        let reverse = back.conj() * arrival.amplitude;
        assert!(
            (forward - reverse).norm() < 1e-14 * 100.0,
            "{forward} {reverse}"
        );
    }

    /// Every value within a footprint is that of the formula: of narrow and wide ones, and of oblique ones whose rows lie
    /// so far apart that the Gaussian of one is too small to be followed where another begins.
    #[test]
    fn oblique_and_wide_footprints_match_the_formula() {
        let raster = Raster {
            start: [-30.0, -9.0],
            pitch: [0.1, 0.2],
            size: [600, 93],
        };
        let (k, limit) = (std::f64::consts::TAU, 2.2);
        for shear in [-0.9999, 0.3, 0.999999] {
            for [xx, tall] in [[0.1, 0.001], [0.1, 0.1], [0.1, 4.0], [10.0, 1000.0]] {
                let yy = xx * tall;
                let arrival = Arrival {
                    at: [1.3, -0.4],
                    cosines: [0.1, -0.3],
                    amplitude: Complex64::new(0.3, -0.8),
                    curvature: [
                        Complex64::new(0.02, xx),
                        Complex64::new(-0.01, shear * (xx * yy).sqrt()),
                        Complex64::new(0.01, yy),
                    ],
                };
                let mut rows = Rows::zeros(raster);
                let kernel = BeamletKernel::new(&arrival, &raster, limit, k).unwrap();
                let count = dispatch!(level(), simd => kernel.add(simd, &mut rows));
                let mut within = 0;
                for (j, i) in (0..93).flat_map(|j| (0..600).map(move |i| (j, i))) {
                    let u = raster.start[0] + i as f64 * raster.pitch[0] - arrival.at[0];
                    let v = raster.start[1] + j as f64 * raster.pitch[1] - arrival.at[1];
                    let [xx, xy, yy] = arrival.curvature;
                    let bend = xx * u * u + xy * 2.0 * u * v + yy * v * v;
                    if bend.im > limit {
                        continue;
                    }
                    within += 1;
                    let linear = arrival.cosines[0] * u + arrival.cosines[1] * v;
                    let value = (Complex64::i() * k * (0.5 * bend + linear)).exp();
                    let off = (rows.value([j, i]) - arrival.amplitude * value).norm();
                    assert!(off < 1e-11, "{shear} {xx} {tall} {j} {i}: {off:e}");
                }
                assert_eq!(count, within, "{shear} {xx} {tall}");
                assert!(within > 5, "{within}");
            }
        }
    }
}
