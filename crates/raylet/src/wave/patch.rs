//! Patches of a field and their plane waves.
//!
//! The field under a window is expanded in plane waves of its period P,
//! ĝⱼ U = Σₘ cₘ e^{ik pₘ·(x−xⱼ)}, on a lattice of optical direction cosines pₘ = anchor + m·λ/P.

use ndarray::{Array2, ArrayView2, s};
use num_complex::Complex64;

use crate::wave::field::{Axis, Field};
use crate::wave::window::Positions;

/// A range of lattice directions along one axis: pₘ = anchor + m·spacing for `first ≤ m < first + count`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// The direction cosine of m = 0.
    pub anchor: f64,
    /// Lattice spacing λ/P.
    pub spacing: f64,
    /// First index.
    pub first: i64,
    /// Number of directions.
    pub count: usize,
}

impl Band {
    /// The lattice directions within [low, high].
    pub fn between(anchor: f64, spacing: f64, low: f64, high: f64) -> Self {
        let first = ((low - anchor) / spacing).ceil() as i64;
        let last = ((high - anchor) / spacing).floor() as i64;
        Self {
            anchor,
            spacing,
            first,
            count: (last - first + 1).max(0) as usize,
        }
    }

    /// The optical direction cosine of the `index`-th direction of the band.
    #[inline]
    pub fn at(&self, index: usize) -> f64 {
        self.anchor + (self.first + index as i64) as f64 * self.spacing
    }
}

/// The windowed Fourier sums of every position along one axis: a row per direction, a column per node.
struct AxisSpectra {
    positions: Positions,
    rows: Vec<(std::ops::Range<usize>, Array2<Complex64>, Vec<f64>)>,
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
pub struct Patches {
    x: AxisSpectra,
    y: AxisSpectra,
    grid: [Axis; 2],
    period: f64,
}

/// One patch: where it is and what plane waves it holds.
pub struct Spectrum {
    /// Its centre on the screen, in mm.
    pub centre: [f64; 2],
    /// Coefficients cₘ, indexed [m_y, m_x] over the bands.
    pub coefficients: Array2<Complex64>,
    /// ∫|ĝⱼU|² dA / P²: what Σₘ|cₘ|² over *all* lattice directions would be.
    pub energy: f64,
}

impl Patches {
    /// Plans the spectra of fields on the grid (x, y), for windows on the given positions and
    /// directions in the given bands; `k` is the vacuum wavenumber, `period` the patch period P in mm.
    pub fn new(
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

    /// Number of patches.
    pub fn count(&self) -> usize {
        self.x.rows.len() * self.y.rows.len()
    }

    /// The spectrum of the patch with this index (x fastest); nothing when the field is dark there.
    pub fn cut(&self, field: &Field, index: usize) -> Option<Spectrum> {
        let (jx, jy) = (index % self.x.rows.len(), index / self.x.rows.len());
        let (range_x, ex, wx) = &self.x.rows[jx];
        let (range_y, ey, wy) = &self.y.rows[jy];
        let view = field
            .values
            .slice(s![range_y.start..range_y.end, range_x.start..range_x.end]);
        let energy = self.energy(view, (range_x.start, wx), (range_y.start, wy));
        if energy == 0.0 {
            return None;
        }
        // c = Ey · U · Exᵀ, the smaller side first.
        let coefficients = if ey.nrows() * range_x.len() < ex.nrows() * range_y.len() {
            ey.dot(&view).dot(&ex.t())
        } else {
            ey.dot(&view.dot(&ex.t()))
        };
        Some(Spectrum {
            centre: [self.x.positions.at(jx), self.y.positions.at(jy)],
            coefficients,
            energy,
        })
    }

    /// Parseval's sum of the windowed patch.
    fn energy(
        &self,
        view: ArrayView2<Complex64>,
        (x0, wx): (usize, &[f64]),
        (y0, wy): (usize, &[f64]),
    ) -> f64 {
        // The analysis weights hold the node's length once; |ĝU|²·length needs weight²/length.
        let [x, y] = &self.grid;
        let share = |axis: &Axis, start: usize, w: &[f64]| -> Vec<f64> {
            let node = |(i, w): (usize, &f64)| w * w / axis.weight(start + i);
            w.iter().enumerate().map(node).collect()
        };
        let (along_x, along_y) = (share(x, x0, wx), share(y, y0, wy));
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
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::wave::field::{Axis, Field, Grid};
    use crate::wave::patch::{Band, Patches};
    use crate::wave::window::Positions;

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
        let positions = Positions::cover(axis.edges(), sigma, 1.5 * sigma, 0.5 * period);
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
    }
}
