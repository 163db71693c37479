//! Complex fields on the nodes of a plane grid.

use ndarray::Array2;
use num_complex::Complex64;

use crate::math::chirp::Comb;
use crate::optics::screen::Sensor;

/// The nodes of a grid along one axis: equal cells, each with the same few nodes inside.
///
/// Node `cell·q + g` sits at `start + cell·pitch + offsets[g]` and represents a length `weights[g]`;
/// the weights of a cell add up to its pitch. One central node per cell is a uniform grid; Gauss nodes
/// integrate the box pixels of a diffractive element.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Centre of the first cell, in mm.
    pub start: f64,
    /// Width of a cell, in mm.
    pub pitch: f64,
    /// Number of cells.
    pub cells: usize,
    /// Node positions relative to the cell centre, in mm, ascending.
    pub offsets: Vec<f64>,
    /// The length each node represents, in mm.
    pub weights: Vec<f64>,
    /// The parts of a cell, in their order.
    pub(crate) parts: Vec<CellPart>,
}

/// A part of a cell, with Gauss–Legendre nodes of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellPart {
    /// Its width in mm.
    pub width: f64,
    /// Its nodes.
    pub nodes: usize,
}

impl Axis {
    /// One node at the centre of each cell; the axis as a whole is centred on `centre`.
    pub fn uniform(cells: usize, pitch: f64, centre: f64) -> Self {
        Self {
            start: centre - 0.5 * (cells as f64 - 1.0) * pitch,
            pitch,
            cells,
            offsets: vec![0.0],
            weights: vec![pitch],
            parts: vec![CellPart {
                width: pitch,
                nodes: 1,
            }],
        }
    }

    /// The `g`-th node of every cell.
    pub(crate) fn node_comb(&self, g: usize) -> Comb {
        Comb {
            start: self.start + self.offsets[g],
            step: self.pitch,
            count: self.cells,
        }
    }

    /// `nodes` Gauss–Legendre nodes in each cell.
    pub fn gauss(cells: usize, pitch: f64, centre: f64, nodes: usize) -> Self {
        let width = pitch;
        Self::of_parts(cells, pitch, centre, &[CellPart { width, nodes }])
    }

    /// Cells of parts, in their order, each with its own Gauss–Legendre nodes: a pixel and the gap around it.
    pub(crate) fn of_parts(cells: usize, pitch: f64, centre: f64, parts: &[CellPart]) -> Self {
        let (mut offsets, mut weights) = (Vec::new(), Vec::new());
        let mut low = -0.5 * pitch;
        for CellPart { width, nodes } in parts {
            let (points, shares) = gauss_rule(*nodes);
            offsets.extend(points.iter().map(|t| low + 0.5 * width * (1.0 + t)));
            weights.extend(shares.iter().map(|w| 0.5 * width * w));
            low += width;
        }
        Self {
            offsets,
            weights,
            parts: parts.to_vec(),
            ..Self::uniform(cells, pitch, centre)
        }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.cells * self.offsets.len()
    }

    /// Whether there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Position of a node, in mm.
    #[inline]
    pub fn node(&self, index: usize) -> f64 {
        let q = self.offsets.len();
        self.start + (index / q) as f64 * self.pitch + self.offsets[index % q]
    }

    /// The length a node represents, in mm.
    #[inline]
    pub(crate) fn weight(&self, index: usize) -> f64 {
        self.weights[index % self.weights.len()]
    }

    /// Nodes in each cell.
    pub(crate) fn nodes_of_cell(&self) -> usize {
        self.offsets.len()
    }

    /// The interval a node represents: its share of the cell, shares in order of the nodes.
    pub(crate) fn span(&self, index: usize) -> [f64; 2] {
        let (cell, g) = (index / self.offsets.len(), index % self.offsets.len());
        let before: f64 = self.weights[..g].iter().sum();
        let low = self.start + (cell as f64 - 0.5) * self.pitch + before;
        [low, low + self.weights[g]]
    }

    /// The outer edges of the first and last cell, in mm.
    pub fn edges(&self) -> [f64; 2] {
        let low = self.start - 0.5 * self.pitch;
        [low, low + self.cells as f64 * self.pitch]
    }

    /// Number of nodes below a point; those closer to it than rounding are not.
    pub(crate) fn below(&self, point: f64) -> usize {
        let limit = point - 1e-9 * self.pitch;
        let (mut low, mut high) = (0, self.len());
        while low < high {
            let middle = (low + high) / 2;
            if self.node(middle) < limit {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }

    /// All node positions, in mm.
    pub fn nodes(&self) -> Vec<f64> {
        (0..self.len()).map(|i| self.node(i)).collect()
    }
}

/// Nodes on [−1, 1] and weights of the Gauss–Legendre rule.
fn gauss_rule(nodes: usize) -> (Vec<f64>, Vec<f64>) {
    let nodes = std::num::NonZero::new(nodes).unwrap_or(std::num::NonZero::<usize>::MIN);
    let rule = gauss_quad::GaussLegendre::new(nodes);
    let mut pairs: Vec<(f64, f64)> = rule.into_iter().collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    pairs.into_iter().unzip()
}

/// The nodes of a plane grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Along x (columns).
    pub x: Axis,
    /// Along y (rows).
    pub y: Axis,
}

impl Grid {
    /// The pixel centres of a sensor.
    pub fn of(sensor: &Sensor) -> Self {
        let axis = |a: usize| Axis::uniform(sensor.pixels[a], sensor.pitch[a], 0.0);
        Self {
            x: axis(0),
            y: axis(1),
        }
    }

    /// Array shape [ny, nx].
    pub fn shape(&self) -> [usize; 2] {
        [self.y.len(), self.x.len()]
    }
}

/// Parts of amplitudes lie below it, so that products of four of them, and sums of these, are finite.
pub(crate) const LARGEST_AMPLITUDE: f64 = 1e60;

/// Whether an amplitude is a number of a size that light has.
pub fn is_amplitude(value: Complex64) -> bool {
    value.re.abs() < LARGEST_AMPLITUDE && value.im.abs() < LARGEST_AMPLITUDE
}

/// Complex amplitude on the nodes of a grid, indexed [y, x].
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Where the values stand.
    pub grid: Grid,
    /// The amplitudes.
    pub values: Array2<Complex64>,
}

impl Field {
    /// A dark field.
    pub fn zeros(grid: Grid) -> Self {
        let values = Array2::zeros(grid.shape());
        Self { grid, values }
    }

    /// Σ|U|² over the nodes times their areas, in mm² for unit amplitude.
    pub fn power(&self) -> f64 {
        self.overlap(self)
    }

    /// Σ Re U*V over the nodes times their areas, V another field on the same nodes.
    pub fn overlap(&self, other: &Self) -> f64 {
        let rows = self.values.outer_iter().zip(other.values.outer_iter());
        rows.enumerate()
            .map(|(j, (row, others))| {
                let pairs = row.iter().zip(others).enumerate();
                let line: f64 = pairs
                    .map(|(i, (u, v))| (u.re * v.re + u.im * v.im) * self.grid.x.weight(i))
                    .sum();
                line * self.grid.y.weight(j)
            })
            .sum()
    }

    /// Whether all its values are numbers of a size that light has.
    pub fn is_sound(&self) -> bool {
        self.values.iter().all(|value| is_amplitude(*value))
    }

    /// |U|² at each node.
    pub fn intensity(&self) -> Array2<f64> {
        self.values.mapv(|u| u.norm_sqr())
    }
}

#[cfg(test)]
mod tests {
    use crate::wave::grid::field::Axis;

    #[test]
    fn gauss_cells_integrate_exactly() {
        let axis = Axis::gauss(7, 0.3, 0.4, 4);
        let [low, high] = axis.edges();
        let sum: f64 = (0..axis.len())
            .map(|i| axis.node(i).powi(7) * axis.weight(i))
            .sum();
        let exact = (high.powi(8) - low.powi(8)) / 8.0;
        assert!((sum - exact).abs() < 1e-14 * exact.abs().max(1.0));
        assert!((axis.span(27)[1] - high).abs() < 1e-14);
        assert!((axis.span(5)[1] - axis.span(6)[0]).abs() < 1e-15);
    }
}
