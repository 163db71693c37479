//! Fourier sums from the nodes under one window to its plane waves, as a matrix along one axis.

use ndarray::Array2;
use num_complex::Complex64;

use crate::wave::local_bands::fourier_axis::FourierAxis;

/// The factors of nodes are computed anew after so many plane waves, before rounding adds up.
const RESTART: usize = 64;

/// The sums along one axis: a row per plane wave, a column per node. From one plane wave to the next a node's factor turns by
/// the same phase; what a cell does to a plane wave is the same in each cell.
pub(crate) fn fourier_matrix(along: &FourierAxis) -> Array2<Complex64> {
    let (modes, k) = (along.modes, along.k);
    let strands = along.axis.nodes_of_cell();
    let cells: Vec<Vec<Complex64>> = (0..strands).map(|node| along.cell_factors(node)).collect();
    let mut matrix = Array2::zeros((modes.count, along.nodes()));
    for (i, mut column) in matrix.columns_mut().into_iter().enumerate() {
        let node = along.range.0 + i;
        let (u, weight) = (along.offset(node), along.weight(node));
        let step = Complex64::cis(-k * modes.spacing * u);
        let mut wave = Complex64::ZERO;
        for (m, value) in column.iter_mut().enumerate() {
            wave = match m % RESTART {
                0 => Complex64::cis(-k * (modes.shift + modes.at(m)) * u) * weight,
                _ => wave * step,
            };
            *value = wave * cells[node % strands][m];
        }
    }
    matrix
}
