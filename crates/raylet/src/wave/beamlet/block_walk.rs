//! The values of a beamlet on the blocks of a raster, from block to block and column to column.
//!
//! The exponent i·k[p·(u, v) + ½(xx u² + 2 xy u v + yy v²)] is quadratic. So the ratio of a value to that one column, or one
//! block, farther on changes by a constant factor with each step. All values follow from those of one column of one block by
//! products: two complex ones a value, and four a block.

use std::ops::Range;

use fearless_simd::{Select, Simd, SimdBase, f64x8};
use num_complex::Complex64;

use crate::math::lanes::LANES;
use crate::wave::beamlet::column_values::{ColumnValues, LONGEST, Pair, polar, times};
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::raster::Raster;

/// Where the exponent reaches this, values are not followed.
const FAINTEST: f64 = 300.0;

/// Footprints with (xy)² up to this part of xx·yy, imaginary parts, meet few columns of a block beside those of its rows.
const ROUND: f64 = 0.5;

/// A footprint whose rows lie closely above one another.
pub(crate) struct RoundFootprint<'a> {
    arrival: &'a Arrival,
    raster: &'a Raster,
    /// First row and the row after the last.
    span: [usize; 2],
    /// The column nearest to the beamlet's ray.
    pub column: usize,
    /// Vacuum wavenumber in rad/mm.
    k: f64,
    /// Half the width of the middle row, and the height of the row in which the footprint ends on its left, in mm.
    half: f64,
    left: f64,
    /// −xy/xx and (xx·yy − xy²)/xx² of the imaginary parts: how the middle of a row, and the square of its half width, change with v.
    shear: f64,
    narrowing: f64,
}

impl<'a> RoundFootprint<'a> {
    /// The footprint on rows of a raster, where uᵀ(Im G)u stays below `limit` in mm; nothing where its values cannot be followed from
    /// one of them to all others.
    #[inline(always)]
    pub(crate) fn new(
        arrival: &'a Arrival,
        raster: &'a Raster,
        span: [usize; 2],
        limit: f64,
        k: f64,
    ) -> Option<Self> {
        let [xx, xy, yy] = arrival.curvature.map(|g| g.im);
        let [hx, hy] = raster.pitch;
        let last = raster.size[0].saturating_sub(1) as f64;
        let place = (arrival.at[0] - raster.start[0]) / hx;
        let column = place.round().clamp(0.0, last);
        let shear = -xy / xx;
        let narrowing = (yy + xy * shear) / xx;
        let half = (limit / xx).sqrt();
        let left = xy / xx * (limit / (yy * narrowing)).sqrt();

        // The row of the first block that is farthest from the ray, in the column nearest to it.
        let u = (column - place) * hx;
        let first = raster.start[1] + (span[0] / LANES * LANES) as f64 * hy - arrival.at[1];
        let v = first.abs().max((first + (LANES - 1) as f64 * hy).abs());
        let faintest = 0.5 * k * (xx * u * u + 2.0 * (xy * u * v).abs() + yy * v * v);
        let steepest = k * xx * hx * hx;
        let widest = (half + (shear * v).abs() + u.abs()) / hx;
        let faint = faintest.max(steepest) >= FAINTEST;
        let followed = xy * xy <= ROUND * xx * yy && !faint && widest < LONGEST as f64;
        followed.then_some(Self {
            arrival,
            raster,
            span,
            column: column as usize,
            k,
            half,
            left,
            shear,
            narrowing,
        })
    }

    /// In the column nearest to the ray and the first row of its block: the value of unit amplitude, its ratio to the next row and
    /// how this changes, its ratios to both next columns and how they change with each row, and how they change with each column.
    #[inline(always)]
    fn factors<S: Simd>(&self, simd: S) -> [Complex64; LANES] {
        let [xx, xy, yy] = self.arrival.curvature;
        let [px, py] = self.arrival.cosines;
        let [hx, hy] = self.raster.pitch;
        let row = (self.span[0] / LANES * LANES) as f64;
        let u = self.raster.start[0] + self.column as f64 * hx - self.arrival.at[0];
        let v = self.raster.start[1] + row * hy - self.arrival.at[1];

        let slope_x = xx * u + xy * v + px;
        let slope_y = xy * u + yy * v + py;
        let (half_x, half_y) = (xx * (0.5 * hx * hx), yy * (0.5 * hy * hy));
        let value = (slope_x + px) * (0.5 * u) + (slope_y + py) * (0.5 * v);
        let exponents = [
            value,
            slope_y * hy + half_y,
            half_y * 2.0,
            slope_x * hx + half_x,
            half_x - slope_x * hx,
            xy * (hx * hy),
            xy * (-hx * hy),
            half_x * 2.0,
        ];
        let (phases, decays) = pair(simd, &exponents.map(|exponent| exponent * self.k));
        let (re, im) = polar(-decays, phases);
        let both = re.as_array().iter().zip(im.as_array());
        let mut factors = [Complex64::ONE; LANES];
        for (factor, (re, im)) in factors.iter_mut().zip(both) {
            *factor = Complex64::new(*re, *im);
        }
        factors
    }

    /// The blocks that it meets.
    pub(crate) fn blocks(&self) -> Range<usize> {
        self.span[0] / LANES..self.span[1].div_ceil(LANES)
    }

    /// One for rows of a block that it meets and zero for others, and how many it meets.
    #[inline(always)]
    pub(crate) fn lit<S: Simd>(&self, simd: S, block: usize) -> (f64x8<S>, usize) {
        let [low, high] = self.span.map(|row| row as f64 - (block * LANES) as f64);
        let met = high.min(LANES as f64) - low.max(0.0);
        let lane = f64x8::from_slice(simd, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let within = lane.simd_ge(f64x8::splat(simd, low)) & lane.simd_lt(f64x8::splat(simd, high));
        let (one, zero) = (f64x8::splat(simd, 1.0), f64x8::splat(simd, 0.0));
        (within.select(one, zero), met as usize)
    }

    /// The first column of a block that it meets, and the one after the last; the column nearest to the ray is among them. Where it
    /// meets no column both are that one.
    #[inline(always)]
    pub(crate) fn columns(&self, block: usize) -> [usize; 2] {
        let hy = self.raster.pitch[1];
        let height = |row: usize| self.raster.start[1] + row as f64 * hy - self.arrival.at[1];
        let low = height(self.span[0].max(block * LANES));
        let high = height(self.span[1].min((block + 1) * LANES) - 1);
        let half = |v: f64| {
            (self.half * self.half - self.narrowing * v * v)
                .max(0.0)
                .sqrt()
        };
        let (left, right) = (self.left.clamp(low, high), (-self.left).clamp(low, high));
        let column =
            |u: f64| (u + self.arrival.at[0] - self.raster.start[0]) / self.raster.pitch[0];
        let first = column(self.shear * left - half(left)).ceil().max(0.0) as usize;
        let end = (column(self.shear * right + half(right)).floor() + 1.0).max(0.0) as usize;
        let end = end.min(self.raster.size[0]);
        match first < end {
            true => [first.min(self.column), end.max(self.column + 1)],
            false => [self.column; 2],
        }
    }
}

/// Values of a block in the column nearest to the ray, and the ratios of their neighbours to them.
pub(crate) struct BlockWalk<S: Simd> {
    value: Pair<S>,
    /// To the next column on each side.
    right: Pair<S>,
    left: Pair<S>,
    /// To the next block, and how this ratio and those to the columns change with each block.
    up: Pair<S>,
    up_step: Pair<S>,
    right_step: Pair<S>,
    left_step: Pair<S>,
    /// How the ratios to the columns change with each column.
    step: Pair<S>,
}

impl<S: Simd> BlockWalk<S> {
    /// The values in the first block of a footprint, for a beamlet of this amplitude.
    #[inline(always)]
    pub(crate) fn new(simd: S, of: &RoundFootprint, amplitude: Complex64) -> Self {
        let [first, row, bend, right, left, shear, back, step] = of.factors(simd);
        let values = powers(amplitude * first, row, bend);
        let rows = powers(row, bend, Complex64::ONE);
        let rights = powers(right, shear, Complex64::ONE);
        let lefts = powers(left, back, Complex64::ONE);

        // The ratio to the next block is the product of the eight ratios to the next row.
        let [bend4, shear4, back4] = [bend, shear, back].map(|z| square(square(z)));
        let bend16 = square(square(bend4));
        let rows = pair(simd, &rows);
        let row2 = times(rows, rows);
        let row4 = times(row2, row2);
        let up = times(row4, row4);
        Self {
            value: pair(simd, &values),
            right: pair(simd, &rights),
            left: pair(simd, &lefts),
            up: times(up, splat(simd, bend16 * square(bend4) * bend4)),
            up_step: splat(simd, square(square(bend16))),
            right_step: splat(simd, square(shear4)),
            left_step: splat(simd, square(back4)),
            step: splat(simd, step),
        }
    }

    /// Goes on to the next block.
    #[inline(always)]
    pub(crate) fn rise(&mut self) {
        self.value = times(self.value, self.up);
        self.up = times(self.up, self.up_step);
        self.right = times(self.right, self.right_step);
        self.left = times(self.left, self.left_step);
    }

    /// The values from the column nearest to the ray on, to the right.
    #[inline(always)]
    pub(crate) fn rightwards(&self) -> ColumnValues<S> {
        ColumnValues {
            value: self.value,
            ratio: self.right,
            step: self.step,
        }
    }

    /// The values from the column before that one on, to the left.
    #[inline(always)]
    pub(crate) fn leftwards(&self) -> ColumnValues<S> {
        ColumnValues {
            value: times(self.value, self.left),
            ratio: times(self.left, self.step),
            step: self.step,
        }
    }
}

/// Eight numbers, the ratio of the second to the first, and the factor by which it changes from one to the next.
#[inline(always)]
fn powers(first: Complex64, mut ratio: Complex64, step: Complex64) -> [Complex64; LANES] {
    let mut all = [first; LANES];
    let mut next = first;
    for value in &mut all[1..] {
        next *= ratio;
        ratio *= step;
        *value = next;
    }
    all
}

/// z².
#[inline(always)]
fn square(z: Complex64) -> Complex64 {
    z * z
}

/// Eight numbers, one in each lane.
#[inline(always)]
fn pair<S: Simd>(simd: S, of: &[Complex64; LANES]) -> Pair<S> {
    let (re, im) = (of.map(|z| z.re), of.map(|z| z.im));
    (f64x8::from_slice(simd, &re), f64x8::from_slice(simd, &im))
}

/// A number in all lanes.
#[inline(always)]
fn splat<S: Simd>(simd: S, z: Complex64) -> Pair<S> {
    (f64x8::splat(simd, z.re), f64x8::splat(simd, z.im))
}
