//! Patches of a field and their plane waves.
//!
//! The field under a window is expanded in plane waves of its period P,
//! ĝⱼ U = Σₘ cₘ e^{ik pₘ·(x−xⱼ)}, on a lattice of optical direction cosines pₘ = chief + m·λ/P.

use std::ops::Range;

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;
use raylet_matrix::{product, product_of_three};
use rayon::prelude::*;

use crate::math::part::part;
use crate::wave::grid::field::{Axis, Field};
use crate::wave::patches::window::Positions;

/// A range of lattice directions along one axis: pₘ = chief + m·spacing for `first ≤ m < first + count`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// The direction cosine of m = 0.
    pub chief: f64,
    /// Lattice spacing λ/P.
    pub spacing: f64,
    /// First index.
    pub first: i64,
    /// Number of directions.
    pub count: usize,
}

impl Band {
    /// The lattice directions within [low, high].
    pub fn between(chief: f64, spacing: f64, low: f64, high: f64) -> Self {
        let first = ((low - chief) / spacing).ceil() as i64;
        let last = ((high - chief) / spacing).floor() as i64;
        Self {
            chief,
            spacing,
            first,
            count: last.saturating_sub(first).saturating_add(1).max(0) as usize,
        }
    }

    /// The indices of this band's directions within [low, high].
    pub(crate) fn within(&self, low: f64, high: f64) -> Range<usize> {
        let part = Self::between(self.chief, self.spacing, low, high);
        let clip = |m: i64| (m - self.first).clamp(0, self.count as i64) as usize;
        let first = clip(part.first);
        first..clip(part.first + part.count as i64).max(first)
    }

    /// The optical direction cosine of the `index`-th direction of the band.
    #[inline]
    pub fn at(&self, index: usize) -> f64 {
        self.chief + (self.first + index as i64) as f64 * self.spacing
    }
}

/// The windowed Fourier sums of every position along one axis: a row per direction, a column per node.
struct AxisSpectra {
    positions: Positions,
    rows: Vec<(Range<usize>, Array2<Complex64>, Vec<f64>)>,
}

impl AxisSpectra {
    fn new(axis: &Axis, positions: &Positions, band: &Band, k: f64, period: f64) -> Self {
        let rows = (0..positions.count)
            .map(|j| {
                let centre = positions.at(j);
                let (range, weights) = positions.analysis(axis, j);
                let start = range.start;
                let matrix = Array2::from_shape_fn((band.count, range.len()), |(m, i)| {
                    let phase = -k * band.at(m) * (axis.node(start + i) - centre);
                    Complex64::from_polar(weights[i] / period, phase)
                });
                (range, matrix, weights)
            })
            .collect();
        Self {
            positions: positions.clone(),
            rows,
        }
    }
}

/// The plan that turns a field into patch spectra.
pub(crate) struct Patches {
    x: AxisSpectra,
    y: AxisSpectra,
    grid: [Axis; 2],
    period: f64,
}

/// Where a patch lies: its centre in mm, and the nodes under its window.
pub(crate) struct PatchPlace {
    /// The centre, on the screen.
    pub centre: [f64; 2],
    /// Nodes along x.
    pub x: Range<usize>,
    /// Nodes along y.
    pub y: Range<usize>,
}

/// One patch: where it is and what plane waves it holds.
pub(crate) struct Spectrum {
    /// Its centre on the screen, in mm.
    pub centre: [f64; 2],
    /// Indices in the bands, along x and y, of the first direction.
    pub first: [usize; 2],
    /// Coefficients cₘ, indexed [m_y, m_x] from there on.
    pub coefficients: Array2<Complex64>,
    /// ∫|ĝⱼU|² dA / P²: what Σₘ|cₘ|² over *all* lattice directions would be.
    pub energy: f64,
}

/// A strip of patches, one above the other, transformed along x: what they share of their spectra.
pub(crate) struct Strip {
    /// Index of the position along x.
    index: usize,
    /// A row per node along y, a column per direction along x.
    waves: Array2<Complex64>,
    /// Parseval's sum along x of each node along y, without the period.
    energy: Vec<f64>,
}

/// Rows that are transformed together: the unit of parallel work on a strip.
const STRIP_ROWS: usize = 64;

impl Patches {
    /// Plans the spectra of fields on the grid (x, y), for windows on the given positions and
    /// directions in the given bands; `k` is the vacuum wavenumber, `period` the patch period P in mm.
    pub(crate) fn new(
        [x, y]: [&Axis; 2],
        positions: [&Positions; 2],
        bands: [&Band; 2],
        k: f64,
        period: f64,
    ) -> Self {
        Self {
            x: AxisSpectra::new(x, positions[0], bands[0], k, period),
            y: AxisSpectra::new(y, positions[1], bands[1], k, period),
            grid: [x.clone(), y.clone()],
            period,
        }
    }

    /// Where the patch with this index lies.
    pub(crate) fn place(&self, index: usize) -> PatchPlace {
        let (jx, jy) = (index % self.x.rows.len(), index / self.x.rows.len());
        PatchPlace {
            centre: [self.x.positions.at(jx), self.y.positions.at(jy)],
            x: self.x.rows[jx].0.clone(),
            y: self.y.rows[jy].0.clone(),
        }
    }

    /// The windowed Fourier sums of values at the nodes of a patch, for some directions.
    pub(crate) fn transform(
        &self,
        view: ArrayView2<Complex64>,
        index: usize,
        [mx, my]: &[Range<usize>; 2],
    ) -> Array2<Complex64> {
        let (jx, jy) = (index % self.x.rows.len(), index / self.x.rows.len());
        let ex = part(self.x.rows[jx].1.view(), mx.clone(), ..);
        let ey = part(self.y.rows[jy].1.view(), my.clone(), ..);
        // c = Ey · U · Exᵀ
        product_of_three(ey, view, ex)
    }

    /// The conjugate transpose of [`Patches::transform`]: from some directions of a patch to its nodes.
    pub(crate) fn transform_adjoint(
        &self,
        waves_bar: ArrayView2<Complex64>,
        index: usize,
        [mx, my]: &[Range<usize>; 2],
    ) -> Array2<Complex64> {
        let (jx, jy) = (index % self.x.rows.len(), index / self.x.rows.len());
        let ex = part(self.x.rows[jx].1.view(), mx.clone(), ..);
        let ey = part(self.y.rows[jy].1.view(), my.clone(), ..);
        // c = Ey · U · Exᵀ: Ū = Eyᴴ · c̄ · Ex*, as the conjugate of what needs no conjugate matrices.
        let bar = waves_bar.mapv(|c| c.conj());
        let mut values_bar = product_of_three(ey.t(), bar.view(), ex.t());
        values_bar.par_mapv_inplace(|u| u.conj());
        values_bar
    }

    /// Parseval's sum of the values at the nodes of a patch: [`Spectrum::energy`].
    pub(crate) fn energy_of(&self, view: ArrayView2<Complex64>, index: usize) -> f64 {
        let (jx, jy) = (index % self.x.rows.len(), index / self.x.rows.len());
        let ((x, _, wx), (y, _, wy)) = (&self.x.rows[jx], &self.y.rows[jy]);
        let [grid_x, grid_y] = &self.grid;
        let along_x = node_shares(grid_x, x.start, wx);
        let along_y = node_shares(grid_y, y.start, wy);
        let mut total = 0.0;
        for (row, b) in view.outer_iter().zip(&along_y) {
            let line: f64 = row
                .iter()
                .zip(&along_x)
                .map(|(u, a)| u.norm_sqr() * a)
                .sum();
            total += line * b;
        }
        total / (self.period * self.period)
    }

    /// Number of patches.
    pub(crate) fn count(&self) -> usize {
        self.x.rows.len() * self.y.rows.len()
    }

    /// The spectrum of the patch with this index (x fastest); nothing when the field is dark there.
    pub(crate) fn cut(&self, field: &Field, index: usize) -> Option<Spectrum> {
        self.cut_within(field, index, &self.modes())
    }

    /// All directions, as indices along x and y.
    pub(crate) fn modes(&self) -> [Range<usize>; 2] {
        let count = |axis: &AxisSpectra| axis.rows.first().map_or(0, |row| row.1.nrows());
        [0..count(&self.x), 0..count(&self.y)]
    }

    /// The same, of some directions only, given by their indices along x and y.
    pub(crate) fn cut_within(
        &self,
        field: &Field,
        index: usize,
        modes: &[Range<usize>; 2],
    ) -> Option<Spectrum> {
        let place = self.place(index);
        let view = part(field.values.view(), place.y.clone(), place.x.clone());
        let energy = self.energy_of(view, index);
        if energy == 0.0 {
            return None;
        }
        Some(Spectrum {
            centre: place.centre,
            first: [modes[0].start, modes[1].start],
            coefficients: self.transform(view, index, modes),
            energy,
        })
    }

    /// The numbers of patches along x and y.
    pub(crate) fn shape(&self) -> [usize; 2] {
        [self.x.rows.len(), self.y.rows.len()]
    }

    /// The strip of patches with this index along x. With many overlapping patches above each other,
    /// their spectra cost less this way than one by one.
    pub(crate) fn strip(&self, field: &Field, index: usize) -> Strip {
        let (range, matrix, weights) = &self.x.rows[index];
        let view = part(field.values.view(), .., range.clone());
        let mut waves = Array2::zeros((view.nrows(), matrix.nrows()));
        let mut energy = vec![0.0; view.nrows()];
        let shares = node_shares(&self.grid[0], range.start, weights);
        waves
            .axis_chunks_iter_mut(ndarray::Axis(0), STRIP_ROWS)
            .into_par_iter()
            .zip(energy.par_chunks_mut(STRIP_ROWS))
            .zip(view.axis_chunks_iter(ndarray::Axis(0), STRIP_ROWS))
            .for_each(|((mut waves, energy), rows)| {
                waves.assign(&product(rows, matrix.t()));
                for (total, row) in energy.iter_mut().zip(rows.outer_iter()) {
                    *total = row.iter().zip(&shares).map(|(u, a)| u.norm_sqr() * a).sum();
                }
            });
        Strip {
            index,
            waves,
            energy,
        }
    }

    /// The spectrum of the patch of a strip with this index along y; nothing when the field is dark
    /// there.
    pub(crate) fn cut_strip(&self, strip: &Strip, index: usize) -> Option<Spectrum> {
        let (range, matrix, weights) = &self.y.rows[index];
        let shares = node_shares(&self.grid[1], range.start, weights);
        let lines = &strip.energy[range.clone()];
        let energy: f64 = lines.iter().zip(&shares).map(|(line, b)| line * b).sum();
        if energy == 0.0 {
            return None;
        }
        let waves = part(strip.waves.view(), range.clone(), ..);
        Some(Spectrum {
            centre: [self.x.positions.at(strip.index), self.y.positions.at(index)],
            first: [0; 2],
            coefficients: product(matrix.view(), waves),
            energy: energy / (self.period * self.period),
        })
    }
}

/// The factor of the intensity at each node of a window in Parseval's sum: weight²/length. |ĝU|²·length has the node's
/// length once, and the square of the analysis weight ĝ·length has it twice.
fn node_shares(axis: &Axis, start: usize, weights: &[f64]) -> Vec<f64> {
    let node = |(i, w): (usize, &f64)| w * w / axis.weight(start + i);
    weights.iter().enumerate().map(node).collect()
}

#[cfg(test)]
mod tests {
    use crate::fixtures::dot_product::assert_transposed;
    use crate::fixtures::noise::noise;
    use num_complex::Complex64;

    use crate::wave::grid::field::{Axis, Field, Grid};
    use crate::wave::patches::patch::{Band, Patches};
    use crate::wave::patches::window::Positions;

    /// Smooth speckle on a fine grid, cut into patches and put together again with Gaussian windows.
    #[test]
    fn patches_rebuild_the_field() {
        let (wavelength, sigma) = (1.0, 6.0);
        let k = std::f64::consts::TAU / wavelength;
        let axis = Axis::uniform(160, 0.25, 0.0);
        let mut field = Field::zeros(Grid {
            x: axis.clone(),
            y: axis.clone(),
        });
        for ((j, i), value) in field.values.indexed_iter_mut() {
            let (x, y) = (axis.node(i), axis.node(j));
            *value =
                Complex64::cis(k * (0.3 * x - 0.2 * y) + (0.7 * x).sin() + (0.4 * y * x).cos());
        }
        let period = 6.0 * sigma;
        let positions = Positions::covering(axis.edges(), sigma, 1.5 * sigma, 0.5 * period);
        let band = Band::between(0.0, wavelength / period, -2.0 - 1e-9, 1.99);
        let patches = Patches::new([&axis, &axis], [&positions; 2], [&band; 2], k, period);

        let mut worst = 0.0f64;
        for (i, j) in [(80, 80), (20, 100), (2, 3), (159, 80)] {
            let (x, y) = (axis.node(i), axis.node(j));
            let mut sum = Complex64::ZERO;
            for index in 0..patches.count() {
                let Some(patch) = patches.cut(&field, index) else {
                    continue;
                };
                let [u, v] = [x - patch.centre[0], y - patch.centre[1]];
                let window = (-0.5 * (u * u + v * v) / (sigma * sigma)).exp();
                for ((my, mx), c) in patch.coefficients.indexed_iter() {
                    sum +=
                        c * Complex64::from_polar(window, k * (band.at(mx) * u + band.at(my) * v));
                }
            }
            worst = worst.max((sum - field.values[[j, i]]).norm());
        }
        assert!(worst < 3e-4, "{worst:e}");

        // Strips give the same spectra.
        let [nx, ny] = patches.shape();
        for (jx, jy) in [(0, 0), (2, 5), (nx - 1, ny - 2)] {
            let one = patches.cut(&field, jy * nx + jx).unwrap();
            let other = patches.cut_strip(&patches.strip(&field, jx), jy).unwrap();
            let off = (&one.coefficients - &other.coefficients).mapv(|c| c.norm_sqr());
            assert!(off.sum() < 1e-28 * one.energy, "{:e}", off.sum());
            assert!((one.energy - other.energy).abs() < 1e-14 * one.energy);
            assert_eq!(one.centre, other.centre);
        }
    }

    #[test]
    fn transform_dot_product() {
        let (x, y) = (Axis::gauss(15, 0.8, 0.3, 3), Axis::uniform(30, 0.5, 0.0));
        let k = std::f64::consts::TAU;
        let positions = [&x, &y].map(|axis| Positions::covering(axis.edges(), 3.0, 4.0, 9.0));
        let band = Band::between(0.1, 1.0 / 18.0, -0.5, 0.6);
        let [px, py] = &positions;
        let patches = Patches::new([&x, &y], [px, py], [&band; 2], k, 18.0);
        // Tall and wide selections, which are multiplied in different orders.
        for modes in [[1..4, 2..19], [0..17, 5..8]] {
            for index in [0, patches.count() / 2] {
                let place = patches.place(index);
                let values = noise((place.y.len(), place.x.len()), 0);
                let bar = noise((modes[1].len(), modes[0].len()), 1);
                let there = patches.transform(values.view(), index, &modes);
                let back = patches.transform_adjoint(bar.view(), index, &modes);
                assert_transposed(&[(&bar, &there)], &[(&back, &values)]);
            }
        }
    }
}
