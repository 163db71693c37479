//! Polynomials over the cells of an axis, as the Gauss nodes of a cell have them.
//!
//! A function over a cell that is not smooth is replaced by the polynomial that comes closest to it in the mean square: its
//! values at the nodes are Σ (a + ½)·P_a(node)·∫ f·P_a, of as many Legendre polynomials as there are nodes. Its product with any
//! polynomial of a lower degree is then integrated exactly.

use std::ops::Range;

use ndarray::Array2;

use crate::optics::moments::legendre;
use crate::wave::grid::field::{Axis, CellPart};

/// The nodes of a part of each cell of an axis.
pub(crate) struct NodesOfPart {
    /// Its ends beside the lower end of the cell, in mm.
    pub ends: [f64; 2],
    /// Its nodes among those of the cell.
    pub nodes: Range<usize>,
    /// (a + ½)·P_a at each of them, indexed [node, a], for as many polynomials as there are nodes.
    pub basis: Array2<f64>,
}

/// The lower and upper end of a cell.
pub(crate) fn cell_edges(axis: &Axis, cell: usize) -> [f64; 2] {
    let low = axis.start + (cell as f64 - 0.5) * axis.pitch;
    [low, low + axis.pitch]
}

/// The parts of the cells of an axis.
pub(crate) fn nodes_of_parts(axis: &Axis) -> Vec<NodesOfPart> {
    let (mut low, mut first) = (0.0, 0);
    let part = |part: &CellPart| {
        let (ends, nodes) = ([low, low + part.width], first..first + part.nodes);
        (low, first) = (ends[1], nodes.end);
        let middle = 0.5 * (ends[0] + ends[1] - axis.pitch);
        let mut values = vec![0.0; part.nodes];
        let mut basis = Array2::zeros((part.nodes, part.nodes));
        for (mut row, offset) in basis
            .rows_mut()
            .into_iter()
            .zip(&axis.offsets[nodes.clone()])
        {
            legendre(2.0 * (offset - middle) / part.width, &mut values);
            for (a, (entry, value)) in row.iter_mut().zip(&values).enumerate() {
                *entry = (a as f64 + 0.5) * value;
            }
        }
        NodesOfPart { ends, nodes, basis }
    };
    axis.parts.iter().map(part).collect()
}
