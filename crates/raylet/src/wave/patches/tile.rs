//! Square patches of a field with sharp edges, anywhere on it, and their plane waves.
//!
//! The field inside a square about x_c, with zeros around it up to a period P, is expanded as
//! U = Σₘ cₘ e^{ik pₘ·(x−x_c)} on a lattice of optical direction cosines. A node of the field belongs to
//! the patch or does not, so that patches at random positions cover every node by their exact share.

use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::math::chirp::{Chirp, Comb};
use crate::math::commensurate_dft::CommensurateDft;
use crate::wave::grid::field::{Axis, Field};
use crate::wave::patches::patch::Band;

/// Sums from the same node of every cell to the modes.
enum Sums {
    /// Where the lattice of modes is that of a transform of the cells.
    CommensurateDft(CommensurateDft),
    /// Everywhere else.
    Chirp(Chirp),
}

impl Sums {
    fn new(nodes: Comb, directions: Comb, scale: f64) -> Self {
        match CommensurateDft::new(nodes, directions, scale) {
            Some(dft) => Sums::CommensurateDft(dft),
            None => Sums::Chirp(Chirp::new(nodes, directions, scale)),
        }
    }

    fn apply(&self, input: &[Complex64], out: &mut [Complex64], scratch: &mut Vec<Complex64>) {
        match self {
            Sums::CommensurateDft(dft) => dft.apply(input, out, scratch),
            Sums::Chirp(chirp) => chirp.apply(input, out, scratch),
        }
    }
}

/// What the method `paper` multiplies the field in a patch by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "PatchWindow")]
pub enum TileWindow {
    /// Nothing: sharp edges.
    #[default]
    Rectangle,
    // cos²(πx/D)·cos²(πy/D) on the square of side D.
    /// cos² along each side, zero at the edges.
    Hann,
}

impl TileWindow {
    /// Its factor of one axis at a distance from the middle, in sides.
    pub(crate) fn at(self, distance: f64) -> f64 {
        match self {
            TileWindow::Rectangle => 1.0,
            TileWindow::Hann => (std::f64::consts::PI * distance).cos().powi(2),
        }
    }

    /// Its mean over the square.
    pub(crate) fn mean(self) -> f64 {
        match self {
            TileWindow::Rectangle => 1.0,
            TileWindow::Hann => 0.25,
        }
    }
}

/// A square patch.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    /// Side of the patch, in mm.
    pub side: f64,
    /// Window by which the field in the patch is multiplied.
    pub window: TileWindow,
    /// Period of its plane waves, in mm.
    pub period: f64,
}

/// The transform along one axis, for a fixed number of cells; sums for each node of a cell.
struct AxisTile {
    axis: Axis,
    band: Band,
    cells: usize,
    sums: Vec<Sums>,
    half: f64,
    window: TileWindow,
    k: f64,
    period: f64,
}

/// The plan that cuts square patches out of fields on one grid.
pub struct TileCutter {
    x: AxisTile,
    y: AxisTile,
}

/// Where a patch begins along an axis, and what its nodes weigh.
struct Placed {
    /// Index of its first cell; cells outside of the field are dark.
    first: i64,
    /// Weights of its nodes with the carrier taken out, zero outside.
    weights: Vec<Complex64>,
    /// The factor of each mode after the transform.
    phases: Vec<Complex64>,
}

impl AxisTile {
    fn new(axis: &Axis, band: &Band, k: f64, tile: &Tile) -> Self {
        let Tile {
            side,
            window,
            period,
        } = *tile;
        let cells = (side / axis.pitch).ceil() as usize + 1;
        let directions = Comb {
            start: band.at(0),
            step: band.spacing,
            count: band.count,
        };
        let sums = |offset: &f64| {
            let nodes = Comb {
                start: *offset,
                step: axis.pitch,
                count: cells,
            };
            Sums::new(nodes, directions, -k)
        };
        Self {
            axis: axis.clone(),
            band: *band,
            cells,
            sums: axis.offsets.iter().map(sums).collect(),
            half: 0.5 * side,
            window,
            k,
            period,
        }
    }

    /// The nodes of the patch about a point; patches side by side share none.
    fn range(&self, centre: f64) -> Range<usize> {
        self.axis.below(centre - self.half)..self.axis.below(centre + self.half)
    }

    /// The window of the patch about a point at a node.
    fn window_at(&self, node: usize, centre: f64) -> f64 {
        let distance = (self.axis.node(node) - centre) / (2.0 * self.half);
        self.window.at(distance)
    }

    fn place(&self, centre: f64, carrier: f64) -> Placed {
        let axis = &self.axis;
        let edge = axis.start - 0.5 * axis.pitch;
        let first = ((centre - self.half - edge) / axis.pitch).floor();
        let origin = axis.start + first * axis.pitch;
        let (range, before) = (self.range(centre), first as i64 * axis.offsets.len() as i64);
        let weights = (0..self.cells * axis.offsets.len())
            .map(|i| match usize::try_from(before + i as i64) {
                Ok(index) if range.contains(&index) => Complex64::from_polar(
                    axis.weight(index) * self.window_at(index, centre) / self.period,
                    -self.k * carrier * (axis.node(index) - centre),
                ),
                _ => Complex64::ZERO,
            })
            .collect();
        let phases = (0..self.band.count)
            .map(|m| Complex64::cis(-self.k * self.band.at(m) * (origin - centre)))
            .collect();
        Placed {
            first: first as i64,
            weights,
            phases,
        }
    }

    /// Adds to `out` the modes of one line of nodes, read by index within the patch.
    fn transform(
        &self,
        placed: &Placed,
        node: impl Fn(usize) -> Complex64,
        out: &mut [Complex64],
        buffers: &mut [Vec<Complex64>; 2],
    ) {
        let nodes = self.axis.offsets.len();
        let [line, scratch] = buffers;
        for (g, sums) in self.sums.iter().enumerate() {
            line.clear();
            line.extend((0..self.cells).map(|cell| {
                let i = cell * nodes + g;
                let weight = placed.weights[i];
                if weight == Complex64::ZERO {
                    return weight;
                }
                node(i) * weight
            }));
            sums.apply(line, out, scratch);
        }
        for (out, phase) in out.iter_mut().zip(&placed.phases) {
            *out *= phase;
        }
    }
}

impl TileCutter {
    /// Plans patches out of fields on the grid (x, y), onto directions in the given bands; `k` is the
    /// vacuum wavenumber.
    pub fn new([x, y]: [&Axis; 2], bands: &[Band; 2], k: f64, tile: &Tile) -> TileCutter {
        TileCutter {
            x: AxisTile::new(x, &bands[0], k, tile),
            y: AxisTile::new(y, &bands[1], k, tile),
        }
    }

    /// The nodes along x and along y that the patch about a point has.
    pub(crate) fn nodes(&self, centre: [f64; 2]) -> [Range<usize>; 2] {
        [self.x.range(centre[0]), self.y.range(centre[1])]
    }

    /// The window along x and along y of the patch about a point, at nodes that it has.
    pub(crate) fn window(&self, centre: [f64; 2], [i, j]: [usize; 2]) -> [f64; 2] {
        [
            self.x.window_at(i, centre[0]),
            self.y.window_at(j, centre[1]),
        ]
    }

    /// The coefficients cₘ of the patch about a point, indexed [m_y, m_x] over the bands.
    pub fn cut(&self, field: &Field, centre: [f64; 2]) -> Array2<Complex64> {
        self.cut_nodes(centre, [0.0; 2], |node| field.values[node])
    }

    /// The same of the values that `node` gives by index [y, x], on the bands moved by `carrier`.
    pub(crate) fn cut_nodes(
        &self,
        centre: [f64; 2],
        carrier: [f64; 2],
        node: impl Fn([usize; 2]) -> Complex64,
    ) -> Array2<Complex64> {
        let (px, py) = (
            self.x.place(centre[0], carrier[0]),
            self.y.place(centre[1], carrier[1]),
        );
        let nodes = [&self.x, &self.y].map(|axis| axis.axis.offsets.len());
        let start = [px.first * nodes[0] as i64, py.first * nodes[1] as i64];
        let mut buffers = [Vec::new(), Vec::new()];

        // Along x on the rows that the patch has, then along y.
        let mut rows: Array2<Complex64> = Array2::zeros((py.weights.len(), self.x.band.count));
        for (j, mut out) in rows.outer_iter_mut().enumerate() {
            if py.weights[j] == Complex64::ZERO {
                continue;
            }
            let row = (start[1] + j as i64) as usize;
            let along = |i: usize| node([row, (start[0] + i as i64) as usize]);
            if let Some(out) = out.as_slice_mut() {
                self.x.transform(&px, along, out, &mut buffers);
            }
        }
        let mut modes = Array2::zeros((self.y.band.count, self.x.band.count));
        let mut column = vec![Complex64::ZERO; self.y.band.count];
        for m in 0..self.x.band.count {
            column.fill(Complex64::ZERO);
            self.y
                .transform(&py, |i| rows[[i, m]], &mut column, &mut buffers);
            for (mode, value) in modes.column_mut(m).iter_mut().zip(&column) {
                *mode = *value;
            }
        }
        modes
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::wave::grid::field::{Axis, Field, Grid};
    use crate::wave::patches::patch::Band;
    use crate::wave::patches::tile::{Tile, TileCutter, TileWindow};

    /// Patches inside, across an edge and around a corner, against the sum as written.
    #[test]
    fn coefficients_match_the_direct_sum() {
        for window in [TileWindow::Rectangle, TileWindow::Hann] {
            against_the_sum(&Tile {
                side: 3.3,
                window,
                period: 8.0,
            });
        }
    }

    fn against_the_sum(tile: &Tile) {
        let k = std::f64::consts::TAU;
        let (x, y) = (Axis::gauss(20, 0.5, 0.3, 2), Axis::gauss(16, 0.6, -0.2, 3));
        let mut field = Field::zeros(Grid {
            x: x.clone(),
            y: y.clone(),
        });
        for ((j, i), value) in field.values.indexed_iter_mut() {
            *value = Complex64::cis((7 * i * i + 3 * j * i + j) as f64);
        }
        let Tile { side, period, .. } = *tile;
        let bands = [
            Band::between(0.1, 1.0 / period, -0.9, 0.8),
            Band::between(0.0, 1.0 / period, -0.7, 0.95),
        ];
        let cutter = TileCutter::new([&x, &y], &bands, k, tile);
        for centre in [[0.37, -0.81], [5.2, 1.0], [-5.9, -6.0]] {
            let modes = cutter.cut(&field, centre);
            let (mut error, mut norm) = (0.0, 0.0);
            for ((my, mx), mode) in modes.indexed_iter() {
                let p = [bands[0].at(mx), bands[1].at(my)];
                let mut exact = Complex64::ZERO;
                for ((j, i), u) in field.values.indexed_iter() {
                    let (dx, dy) = (x.node(i) - centre[0], y.node(j) - centre[1]);
                    if dx.abs() <= 0.5 * side && dy.abs() <= 0.5 * side {
                        let window = tile.window.at(dx / side) * tile.window.at(dy / side);
                        let weight = window * x.weight(i) * y.weight(j) / (period * period);
                        exact += u * Complex64::from_polar(weight, -k * (p[0] * dx + p[1] * dy));
                    }
                }
                error += (mode - exact).norm_sqr();
                norm += exact.norm_sqr();
            }
            assert!((error / norm).sqrt() < 1e-12, "{:e}", (error / norm).sqrt());
        }
    }
}
