//! Square patches of a field with sharp edges, anywhere on it, and their plane waves.
//!
//! The field inside a square about x_c, with zeros around it up to a period P, is expanded as
//! U = Σₘ cₘ e^{ik pₘ·(x−x_c)} on a lattice of optical direction cosines. A node of the field belongs to
//! the patch or does not, so that patches at random positions cover every node by their exact share.

use std::f64::consts::TAU;
use std::ops::Range;

use fearless_simd::{Simd, dispatch};
use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::math::chirp::{Chirp, Comb};
use crate::math::commensurate_dft::CommensurateDft;
use crate::math::lanes::phasors;
use crate::math::simd_level::level;
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

    /// The factor of an input beside its weight.
    fn before(&self, cell: usize) -> Complex64 {
        match self {
            Sums::CommensurateDft(dft) => dft.before()[cell],
            Sums::Chirp(_) => Complex64::ONE,
        }
    }

    /// The factors of outputs, these phases among them.
    fn after(&self, phases: &[Complex64]) -> Vec<Complex64> {
        match self {
            Sums::CommensurateDft(dft) => {
                let factors = dft.after().iter().zip(phases);
                factors.map(|(after, phase)| after * phase).collect()
            }
            Sums::Chirp(_) => phases.to_vec(),
        }
    }

    /// The length of a line: its cells, and zeros behind them.
    fn length(&self, cells: usize) -> usize {
        match self {
            Sums::CommensurateDft(dft) => dft.length(),
            Sums::Chirp(_) => cells,
        }
    }

    /// Adds to `out` the sums over a line, which has its factors already and may be overwritten, times `after`.
    fn apply(
        &self,
        line: &mut [Complex64],
        after: &[Complex64],
        out: &mut [Complex64],
        [sums, work]: &mut [Vec<Complex64>; 2],
    ) {
        match self {
            Sums::CommensurateDft(dft) => dft.apply(line, after, out, work),
            Sums::Chirp(chirp) => {
                sums.clear();
                sums.resize(out.len(), Complex64::ZERO);
                chirp.apply(line, sums, work);
                for ((out, sum), after) in out.iter_mut().zip(sums).zip(after) {
                    *out += *sum * after;
                }
            }
        }
    }
}

/// Lines that are read together: those that share a cache line.
const LINES: usize = 4;

/// Memory for the transform of a few lines.
#[derive(Debug, Default)]
struct LineBuffers {
    lines: Vec<Complex64>,
    work: [Vec<Complex64>; 2],
}

/// Memory for cutting many patches, and the modes of the last one.
#[derive(Debug, Default)]
pub struct CutScratch {
    /// The coefficients cₘ over the bands, m_x fastest.
    pub modes: Vec<Complex64>,
    /// The sums along y of each column of nodes.
    columns: Vec<Complex64>,
    buffers: LineBuffers,
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
    /// Weights of its nodes with the carrier taken out and with the factor before the transform, zero outside.
    weights: Vec<Complex64>,
    /// The factor of each mode after the transform, for each node of a cell.
    after: Vec<Vec<Complex64>>,
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
        let nodes = axis.offsets.len();
        let (range, before) = (self.range(centre), first as i64 * nodes as i64);
        let weights = (0..self.cells * nodes)
            .map(|i| match usize::try_from(before + i as i64) {
                Ok(index) if range.contains(&index) => {
                    let weight = axis.weight(index) * self.window_at(index, centre) / self.period;
                    self.carried(carrier, axis.node(index) - centre)
                        * self.sums[i % nodes].before(i / nodes)
                        * weight
                }
                _ => Complex64::ZERO,
            })
            .collect();
        let turns: Vec<f64> = (0..self.band.count)
            .map(|m| -self.k / TAU * self.band.at(m) * (origin - centre))
            .collect();
        let mut phases = vec![Complex64::ZERO; turns.len()];
        phasors(&turns, &mut phases);
        Placed {
            first: first as i64,
            weights,
            after: self.sums.iter().map(|sums| sums.after(&phases)).collect(),
        }
    }

    /// The factor that takes the carrier out at a distance from the centre.
    fn carried(&self, carrier: f64, distance: f64) -> Complex64 {
        match carrier {
            0.0 => Complex64::ONE,
            _ => Complex64::cis(-self.k * carrier * distance),
        }
    }

    /// The modes of up to four lines of nodes, read together by index within the patch.
    fn transform(
        &self,
        placed: &Placed,
        nodes: impl Fn(usize) -> [Complex64; LINES],
        out: &mut [Complex64],
        buffers: &mut LineBuffers,
    ) {
        let each = self.axis.offsets.len();
        let LineBuffers { lines, work } = buffers;
        out.fill(Complex64::ZERO);
        for (g, sums) in self.sums.iter().enumerate() {
            let length = sums.length(self.cells);
            lines.resize(LINES * length, Complex64::ZERO);
            let weights = placed.weights.iter().skip(g).step_by(each);
            dispatch!(level(), simd => fill(simd, lines, weights, |cell| nodes(cell * each + g)));
            let outs = out.chunks_mut(self.band.count.max(1));
            for (line, out) in lines.chunks_exact_mut(length).zip(outs) {
                sums.apply(line, &placed.after[g], out, work);
            }
        }
    }
}

/// Fills lines of equal length with values of nodes times their weights; zeros behind them.
#[inline(always)]
fn fill<'a, S: Simd>(
    _: S,
    lines: &mut [Complex64],
    weights: impl ExactSizeIterator<Item = &'a Complex64>,
    nodes: impl Fn(usize) -> [Complex64; LINES],
) {
    let (length, cells) = (lines.len() / LINES, weights.len());
    for (cell, weight) in weights.enumerate() {
        let values = match *weight == Complex64::ZERO {
            true => [Complex64::ZERO; LINES],
            false => nodes(cell).map(|value| value * weight),
        };
        for (line, value) in values.into_iter().enumerate() {
            lines[line * length + cell] = value;
        }
    }
    for line in lines.chunks_exact_mut(length.max(1)) {
        line[cells..].fill(Complex64::ZERO);
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

    /// The coefficients cₘ of the patch about a point.
    pub fn cut(&self, field: &Field, centre: [f64; 2], scratch: &mut CutScratch) {
        self.cut_nodes(centre, [0.0; 2], |node| field.values[node], scratch);
    }

    /// The same of the values that `node` gives by index [y, x], on the bands moved by `carrier`.
    pub(crate) fn cut_nodes(
        &self,
        centre: [f64; 2],
        carrier: [f64; 2],
        node: impl Fn([usize; 2]) -> Complex64,
        scratch: &mut CutScratch,
    ) {
        let (px, py) = (
            self.x.place(centre[0], carrier[0]),
            self.y.place(centre[1], carrier[1]),
        );
        let nodes = [&self.x, &self.y].map(|axis| axis.axis.offsets.len());
        let start = [px.first * nodes[0] as i64, py.first * nodes[1] as i64];
        let [nx, ny] = [&self.x, &self.y].map(|axis| axis.band.count);
        let CutScratch {
            modes,
            columns,
            buffers,
        } = scratch;

        // Along y on the columns that the patch has, then along x.
        let lit = |i: usize| {
            px.weights
                .get(i)
                .is_some_and(|weight| *weight != Complex64::ZERO)
        };
        columns.resize(px.weights.len() * ny, Complex64::ZERO);
        for (group, out) in columns.chunks_mut(LINES * ny.max(1)).enumerate() {
            let first = group * LINES;
            let lit: [bool; LINES] = std::array::from_fn(|line| lit(first + line));
            let along = |j: usize| {
                let row = (start[1] + j as i64) as usize;
                std::array::from_fn(|line| match lit[line] {
                    true => node([row, (start[0] + (first + line) as i64) as usize]),
                    false => Complex64::ZERO,
                })
            };
            self.y.transform(&py, along, out, buffers);
        }
        modes.resize(nx * ny, Complex64::ZERO);
        for (group, out) in modes.chunks_mut(LINES * nx.max(1)).enumerate() {
            let first = group * LINES;
            let along = |i: usize| match columns[i * ny + first..(i + 1) * ny].first_chunk() {
                Some(lines) => *lines,
                None => std::array::from_fn(|line| match first + line < ny {
                    true => columns[i * ny + first + line],
                    false => Complex64::ZERO,
                }),
            };
            self.x.transform(&px, along, out, buffers);
        }
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::wave::grid::field::{Axis, Field, Grid};
    use crate::wave::patches::patch::Band;
    use crate::wave::patches::tile::{CutScratch, Tile, TileCutter, TileWindow};

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
        let mut scratch = CutScratch::default();
        for centre in [[0.37, -0.81], [5.2, 1.0], [-5.9, -6.0]] {
            cutter.cut(&field, centre, &mut scratch);
            let modes = &scratch.modes;
            let (mut error, mut norm) = (0.0, 0.0);
            for (index, mode) in modes.iter().enumerate() {
                let (mx, my) = (index % bands[0].count, index / bands[0].count);
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
