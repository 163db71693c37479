//! One beamlet on a few rows of a raster.
//!
//! Eight rows go together, one in each lane. Values of most footprints follow from those of one column (`block_walk`). Where a
//! footprint is long and oblique, or very narrow, values are computed anew for each block, or each row.

use fearless_simd::{Simd, SimdBase, SimdFloat, f64x8};
use num_complex::Complex64;

use crate::math::lanes::{LANES, Lanes};
use crate::wave::beamlet::block_walk::{BlockWalk, RoundFootprint};
use crate::wave::beamlet::column_values::{ColumnValues, LONGEST, Pair, polar};
use crate::wave::beamlet::raster_rows::{COLUMN, Rows};
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::raster::Raster;

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
        let reach = Self::reach(arrival, limit);
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
        match RoundFootprint::new(self.arrival, &self.raster, self.span, self.limit, self.k) {
            Some(round) => self.add_round(simd, &round, rows),
            None => self.add_row_by_row(simd, rows),
        }
    }

    /// Adds one whose values follow from those of one column of one block; returns the number of values.
    #[inline(always)]
    fn add_round<S: Simd>(&self, simd: S, round: &RoundFootprint, rows: &mut Rows) -> u64 {
        let mut walk = BlockWalk::new(simd, round, self.arrival.amplitude);
        let mut evaluations = 0;
        for block in round.blocks() {
            let [first, end] = round.columns(block);
            let middle = round.column;
            let (lit, met) = round.lit(simd, block);
            let right = rows
                .columns_mut(block, [middle, end])
                .chunks_exact_mut(COLUMN);
            walk.rightwards().only(lit).add(simd, right);
            let left = rows
                .columns_mut(block, [first, middle])
                .chunks_exact_mut(COLUMN);
            walk.leftwards().only(lit).add(simd, left.rev());
            evaluations += ((end - first) * met) as u64;
            walk.rise();
        }
        evaluations
    }

    /// Adds one of any shape, with values computed anew for each block; returns the number of values.
    #[inline(always)]
    fn add_row_by_row<S: Simd>(&self, simd: S, rows: &mut Rows) -> u64 {
        let step = self.step(simd);
        let mut evaluations = 0;
        for block in self.span[0] / LANES..self.span[1].div_ceil(LANES) {
            let chords = self.chords(simd, block);
            let (groups, count) = self.groups(simd, block, &chords);
            for group in &groups[..count] {
                let [mut first, end] = group.columns;
                evaluations += (end - first) as u64 * group.rows();
                while first < end {
                    let last = end.min(first + LONGEST);
                    let columns = rows
                        .columns_mut(block, [first, last])
                        .chunks_exact_mut(COLUMN);
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
        match RoundFootprint::new(self.arrival, &self.raster, self.span, self.limit, self.k) {
            Some(round) => self.add_round_adjoint(simd, &round, rows),
            None => self.add_row_by_row_adjoint(simd, rows),
        }
    }

    /// The conjugate transpose of [`BeamletKernel::add_round`] for unit amplitude.
    #[inline(always)]
    fn add_round_adjoint<S: Simd>(&self, simd: S, round: &RoundFootprint, rows: &Rows) -> Moments {
        let mut walk = BlockWalk::new(simd, round, Complex64::ONE);
        let (middle, hx) = (round.column, self.raster.pitch[0]);
        let mut moments = [Complex64::ZERO; 6];
        for block in round.blocks() {
            let [first, end] = round.columns(block);
            let right = rows.columns(block, [middle, end]).chunks_exact(COLUMN);
            let left = rows.columns(block, [first, middle]).chunks_exact(COLUMN);
            let (lit, _) = round.lit(simd, block);
            let values = walk.rightwards().only(lit);
            let right = values.add_adjoint(simd, right, self.u(middle), hx);
            let before = self.u(middle) - hx;
            let values = walk.leftwards().only(lit);
            let left = values.add_adjoint(simd, left.rev(), before, -hx);
            self.add_moments(simd, block, &right, &mut moments);
            self.add_moments(simd, block, &left, &mut moments);
            walk.rise();
        }
        moments
    }

    /// The conjugate transpose of [`BeamletKernel::add_row_by_row`] for unit amplitude.
    #[inline(always)]
    fn add_row_by_row_adjoint<S: Simd>(&self, simd: S, rows: &Rows) -> Moments {
        let step = self.step(simd);
        let mut moments = [Complex64::ZERO; 6];
        for block in self.span[0] / LANES..self.span[1].div_ceil(LANES) {
            let chords = self.chords(simd, block);
            let (groups, count) = self.groups(simd, block, &chords);
            for group in &groups[..count] {
                let [mut first, end] = group.columns;
                while first < end {
                    let last = end.min(first + LONGEST);
                    let columns = rows.columns(block, [first, last]).chunks_exact(COLUMN);
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
        ColumnValues { value, ratio, step }.only(lit)
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

impl Group {
    /// The number of its rows.
    #[inline(always)]
    fn rows(&self) -> u64 {
        self.lit.iter().sum::<f64>() as u64
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

/// ½(xx u² + 2 xy u v + yy v²).
#[inline(always)]
fn quadratic<S: Simd>(simd: S, [xx, xy, yy]: [f64; 3], u: f64, v: f64x8<S>) -> f64x8<S> {
    let splat = |v: f64| f64x8::splat(simd, v);
    (v * splat(0.5 * yy) + splat(xy * u)) * v + splat(0.5 * xx * u * u)
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use num_complex::Complex64;

    use crate::math::simd_level::level;
    use crate::wave::beamlet::beamlet_kernel::BeamletKernel;
    use crate::wave::beamlet::raster_rows::Rows;
    use crate::wave::beamlet::wavelet::Arrival;
    use crate::wave::grid::raster::Raster;

    /// Of a round footprint, and of an oblique one.
    #[test]
    fn add_dot_product() {
        for shear in [0.005, 0.023] {
            dot_product(shear);
        }
    }

    fn dot_product(shear: f64) {
        let arrival = Arrival {
            at: [1.3, -0.4],
            cosines: [0.1, -0.3],
            amplitude: Complex64::new(0.3, -0.8),
            curvature: [
                Complex64::new(0.02, 0.03),
                Complex64::new(-0.01, shear),
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

    /// Every value within a footprint is that of the formula, and so are those beside it that are added: of narrow and wide ones,
    /// and of oblique ones whose rows lie so far apart that the Gaussian of one is too small to be followed where another begins.
    /// The number of values is that of those which are added.
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
                let (mut within, mut added) = (0, 0);
                for (j, i) in (0..93).flat_map(|j| (0..600).map(move |i| (j, i))) {
                    let u = raster.start[0] + i as f64 * raster.pitch[0] - arrival.at[0];
                    let v = raster.start[1] + j as f64 * raster.pitch[1] - arrival.at[1];
                    let [xx, xy, yy] = arrival.curvature;
                    let bend = xx * u * u + xy * 2.0 * u * v + yy * v * v;
                    let found = rows.value([j, i]);
                    added += u64::from(found != Complex64::ZERO);
                    within += u64::from(bend.im <= limit);
                    if bend.im > limit && found == Complex64::ZERO {
                        continue;
                    }
                    let linear = arrival.cosines[0] * u + arrival.cosines[1] * v;
                    let value = (Complex64::i() * k * (0.5 * bend + linear)).exp();
                    let off = (found - arrival.amplitude * value).norm();
                    assert!(off < 1e-11, "{shear} {xx} {tall} {j} {i}: {off:e}");
                }
                assert_eq!(count, added, "{shear} {xx} {tall}");
                assert!(within > 5 && added >= within, "{within} {added}");
            }
        }
    }
    /// Columns that lie far apart beside the width of a beamlet.
    #[test]
    fn a_beamlet_much_narrower_than_a_column_is_finite() {
        let raster = Raster {
            start: [-180.0, -9.0],
            pitch: [90.0, 0.2],
            size: [5, 93],
        };
        let arrival = Arrival {
            at: [1.3, -0.4],
            cosines: [0.1, -0.3],
            amplitude: Complex64::ONE,
            curvature: [
                Complex64::new(0.02, 1.0),
                Complex64::new(-0.01, 1.4),
                Complex64::new(0.01, 4.0),
            ],
        };
        let mut rows = Rows::zeros(raster);
        let kernel = BeamletKernel::new(&arrival, &raster, 4.0, std::f64::consts::TAU).unwrap();
        dispatch!(level(), simd => kernel.add(simd, &mut rows));
        let found = (0..93).flat_map(|j| (0..5).map(move |i| [j, i]));
        assert!(
            found
                .map(|at| rows.value(at))
                .all(|value| value.is_finite())
        );
    }
}
