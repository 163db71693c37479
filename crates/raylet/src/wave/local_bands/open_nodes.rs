//! What an aperture leaves open at the nodes of a tile: a factor for each node.
//!
//! A node that stands alone has the open share of its cell. The two Gauss nodes along each axis of a part of a box pixel stand for
//! light that is linear between them. Where an edge cuts the part, they have the factors with which light that is linear over the
//! part is integrated over what is open (as `wave/grid/aperture_coverage.rs` has them for any number of nodes). They may be
//! somewhat below zero or above one. Open shares of four cells would have the middle of the light in another place.

use ndarray::Array2;

use crate::optics::aperture::Aperture;
use crate::optics::moments::{Cell, OpenMoments};
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::aperture_scan::ApertureScan;
use crate::wave::local_bands::fourier_axis::CellFilter;

/// The two Gauss nodes of a part reaching from −1 to 1.
const PAIR: [f64; 2] = [-INV_SQRT_3, INV_SQRT_3];
const INV_SQRT_3: f64 = 0.577_350_269_189_625_8;

/// The factors of the nodes of a tile, row by row.
pub(crate) struct OpenNodes<'a> {
    aperture: &'a Aperture,
    rows: &'a Axis,
    /// Nodes along an axis of a part: two, or one that stands alone.
    nodes: usize,
    /// The spans along x of the parts.
    spans: Vec<[f64; 2]>,
    /// The open shares of a row of parts, and which row that is.
    shares: Vec<f64>,
    known: Option<usize>,
    moments: OpenMoments,
    /// The factors of the nodes of its rows.
    factors: [Vec<f64>; 2],
}

impl<'a> OpenNodes<'a> {
    /// Those of nodes along x and y that stand for cells of a kind.
    pub(crate) fn new(aperture: &'a Aperture, axes: &'a [Axis; 2], filter: CellFilter) -> Self {
        let [columns, rows] = axes;
        let nodes = match filter {
            CellFilter::Points => 1,
            CellFilter::Pairs => 2,
        };
        let parts = columns.len() / nodes;
        Self {
            aperture,
            rows,
            nodes,
            spans: (0..parts).map(|part| span(columns, part, nodes)).collect(),
            shares: vec![0.0; parts],
            known: None,
            moments: OpenMoments::new([nodes; 2]),
            factors: [0, 1].map(|_| vec![0.0; columns.len()]),
        }
    }

    /// The factors of a row of nodes.
    pub(crate) fn row(&mut self, j: usize) -> &[f64] {
        let part = j / self.nodes;
        if self.known != Some(part) {
            self.known = Some(part);
            self.turn_to(span(self.rows, part, self.nodes));
        }
        match self.nodes {
            1 => &self.shares,
            nodes => &self.factors[j % nodes],
        }
    }

    /// Finds the factors of the nodes of a row of parts.
    fn turn_to(&mut self, row: [f64; 2]) {
        ApertureScan::new(self.aperture, row).fill(&self.spans, &mut self.shares);
        if self.nodes == 1 {
            return;
        }
        for (part, (share, span)) in self.shares.iter().zip(&self.spans).enumerate() {
            let cell = Cell { x: *span, y: row };
            let found = match 0.0 < *share && *share < 1.0 {
                true => of_pairs(self.moments.over(self.aperture, &cell)),
                false => [[*share; 2]; 2],
            };
            for (factors, found) in self.factors.iter_mut().zip(found) {
                factors[2 * part..2 * part + 2].copy_from_slice(&found);
            }
        }
    }
}

/// The span of a part with so many nodes.
fn span(axis: &Axis, part: usize, nodes: usize) -> [f64; 2] {
    let first = part * nodes;
    [axis.span(first)[0], axis.span(first + nodes - 1)[1]]
}

/// The factors [y, x] of the four nodes of a part whose open area has these moments.
fn of_pairs(moments: &Array2<f64>) -> [[f64; 2]; 2] {
    // (a + ½)·P_a for a = 0 and 1.
    let basis = PAIR.map(|node| [0.5, 1.5 * node]);
    basis.map(|along_y| {
        basis.map(|along_x| {
            let terms = moments.indexed_iter();
            terms
                .map(|((b, a), moment)| along_y[b] * along_x[a] * moment)
                .sum()
        })
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use crate::optics::aperture::Aperture;
    use crate::wave::grid::field::Axis;
    use crate::wave::local_bands::fourier_axis::CellFilter;
    use crate::wave::local_bands::open_nodes::OpenNodes;

    /// The integral of a function over an aperture, by the nodes with their factors.
    fn integral(aperture: &Aperture, parts: usize, f: impl Fn(f64, f64) -> f64) -> f64 {
        let axis = Axis::gauss(parts, 3.0 / parts as f64, 0.05, 2);
        let axes = [axis.clone(), axis.clone()];
        let mut open = OpenNodes::new(aperture, &axes, CellFilter::Pairs);
        let mut sum = 0.0;
        for j in 0..axis.len() {
            for (i, factor) in open.row(j).iter().enumerate() {
                sum += factor * axis.weight(i) * axis.weight(j) * f(axis.node(i), axis.node(j));
            }
        }
        sum
    }

    /// Area and second moments of a disc; and a plane wave of 0.6 rad a part, whose integral is that of Airy's pattern.
    #[test]
    fn a_disc_of_pairs_has_its_moments() {
        let disc = Aperture::disc(1.0);
        let found = |f: &dyn Fn(f64, f64) -> f64| integral(&disc, 29, f);
        assert!((found(&|_, _| 1.0) - PI).abs() < 1e-12);
        assert!(found(&|x, _| x).abs() < 1e-12);
        let second = found(&|x, _| x * x);
        assert!((second - 0.25 * PI).abs() < 2e-4, "{second}");

        // 2π·J₁(q)/q with q = 12, J₁(12) = −0.22344710.
        let wave = integral(&disc, 58, |x, y| (7.2 * x - 9.6 * y).cos());
        let exact = -2.0 * PI * 0.223_447_10 / 12.0;
        assert!((wave - exact).abs() < 5e-4 * exact.abs(), "{wave} {exact}");
    }

    /// Light that is linear over parts is integrated over what a rectangle leaves open, wherever its sides cut them.
    #[test]
    fn linear_light_is_integrated_over_what_is_open() {
        for side in [0.31, 0.333, 0.4, 0.47] {
            let rectangle = Aperture::turned_rectangle(side, 0.52, 0.0, [0.1, -0.2]);
            let [area, x, y] = [
                integral(&rectangle, 10, |_, _| 1.0),
                integral(&rectangle, 10, |x, _| x),
                integral(&rectangle, 10, |_, y| y),
            ];
            let whole = 4.0 * side * 0.52;
            assert!((area - whole).abs() < 1e-12, "{area} {whole}");
            assert!((x - 0.1 * whole).abs() < 1e-12, "{x}");
            assert!((y + 0.2 * whole).abs() < 1e-12, "{y}");
        }
    }

    /// A node that stands alone has the open share of its cell.
    #[test]
    fn single_nodes_have_open_shares() {
        let aperture = Aperture::disc(1.0);
        let axes = [Axis::uniform(7, 0.4, 0.1), Axis::uniform(5, 0.5, 0.0)];
        let mut open = OpenNodes::new(&aperture, &axes, CellFilter::Points);
        for j in 0..5 {
            let [y0, y1] = axes[1].span(j);
            for (i, factor) in open.row(j).iter().enumerate() {
                let [x0, x1] = axes[0].span(i);
                assert_eq!(*factor, aperture.coverage(x0, x1, y0, y1));
            }
        }
    }
}
