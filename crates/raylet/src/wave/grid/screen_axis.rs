//! The nodes of a screen along one axis: cells with enough Gauss nodes each for what arrives, what the element adds and what
//! matters behind it.

use crate::optics::pixels::pixel_grid::{Lattice, PixelForm};
use crate::wave::grid::field::{Axis, CellPart};

/// Accuracy of the integral over a box pixel, relative to its undeviated light.
const PIXEL_TOLERANCE: f64 = 3e-5;

/// Sampling above the Nyquist rate for fields without pixels.
const OVERSAMPLING: f64 = 1.3;

/// Error of a field that cells cut by an edge may bring, of the steepest light.
const CUT_TOLERANCE: f64 = 1e-4;

/// Edges that lie anywhere in the cells of a uniform grid bring errors of the square of the pitch, so where cells
/// are few they are made finer, up to this factor, as long as they stay within this number along an axis.
const EDGE_FINENESS: f64 = 4.0;
const EDGE_CELLS: f64 = 800.0;

/// Samples that an aperture has along an axis at least.
const LEAST_SAMPLES: f64 = 16.0;

/// Uniform samples for which one cell of Gauss nodes stands.
const GAUSS_CELL: f64 = 4.0;

/// Cycles of the steepest light in one cell of Gauss nodes, and nodes in it, at most.
const MOST_CYCLES: f64 = 5.0;
const MOST_NODES: usize = 32;

/// The nodes along one axis of an aperture without pixels, or with pixels on the surface's own coordinates;
/// `frequency` as for [`pixel_axis`].
pub(crate) fn open_axis(
    [low, high]: [f64; 2],
    frequency: f64,
    on_surface: bool,
    cut: bool,
) -> Axis {
    let needed = ((high - low) * OVERSAMPLING * frequency).max(LEAST_SAMPLES);
    let middle = 0.5 * (low + high);
    if on_surface {
        // Cells take the mean over edges that lie anywhere in them: many small ones.
        let cells = (needed * EDGE_FINENESS).min(EDGE_CELLS).max(needed).ceil();
        return Axis::uniform(cells as usize, (high - low) / cells, middle);
    }
    let cells = (needed / GAUSS_CELL).ceil();
    let pitch = (high - low) / cells;
    let nodes = cell_nodes(frequency * pitch, cells as usize, cut);
    Axis::gauss(cells as usize, pitch, middle, nodes)
}

/// The nodes along one axis of a pixel grid, whose active areas have this side over the pitch; `frequency` is the largest
/// spatial frequency in 1/mm that the product of field and plane wave reaches.
pub(crate) fn pixel_axis(
    lattice: &Lattice,
    a: usize,
    side: f64,
    frequency: f64,
    cut: bool,
) -> Axis {
    let (cells, pitch) = ([lattice.shape.1, lattice.shape.0][a], lattice.pitch[a]);
    // Interpolation bends at the centres: half cells, where it is smooth.
    let (least, parts, frequency) = match lattice.form {
        PixelForm::Point => return Axis::uniform(cells, pitch, 0.0),
        PixelForm::Box if side < 1.0 => {
            return gapped_axis([cells as f64, pitch], side, frequency, cut);
        }
        PixelForm::Box => (1, 1.0, frequency),
        PixelForm::Bilinear => (2, 2.0, frequency),
        PixelForm::BandLimited => (1, 1.0, frequency + 0.5 / pitch),
    };
    let cycles = frequency * pitch / parts;
    let parts = parts * (cycles / MOST_CYCLES).ceil().max(1.0);
    let (cells, pitch) = (cells.saturating_mul(parts as usize), pitch / parts);
    let nodes = cell_nodes(frequency * pitch, cells, cut).max(least);
    Axis::gauss(cells, pitch, 0.0, nodes)
}

/// The same for a number of box pixels of a pitch with gaps around their active areas: gap, active area, gap.
fn gapped_axis([cells, pitch]: [f64; 2], side: f64, frequency: f64, cut: bool) -> Axis {
    let (active, gap) = (side * pitch, 0.5 * (1.0 - side) * pitch);
    let parts = |width: f64, count: &dyn Fn(f64) -> usize| {
        let parts = (frequency * width / MOST_CYCLES).ceil().max(1.0);
        let width = width / parts;
        let nodes = count(frequency * width);
        vec![CellPart { width, nodes }; parts as usize]
    };
    let beside = parts(gap, &|cycles| match cut {
        true => cell_nodes(cycles, cells as usize, cut),
        false => gauss_nodes(cycles, PIXEL_TOLERANCE * pitch / gap),
    });
    let middle = parts(active, &|cycles| cell_nodes(cycles, cells as usize, cut));
    let cell = [beside.clone(), middle, beside].concat();
    Axis::of_parts(cells as usize, pitch, 0.0, &cell)
}

/// The number of Gauss nodes in a cell with so many cycles, on an axis of so many cells; `cut` where an edge cuts some
/// of them.
fn cell_nodes(cycles: f64, cells: usize, cut: bool) -> usize {
    let whole = gauss_nodes(cycles, PIXEL_TOLERANCE);
    if !cut {
        return whole;
    }
    // Of a wave's Legendre series (2m+1)·j_m(π·cycles) the terms from the number of nodes on are lost in cut
    // cells, times the moments of their open part, which fall as m^−1.5. There are some 4n cut cells, whose errors
    // add at random, among ¾n².
    let x = std::f64::consts::PI * cycles;
    let share = 2.5 * (cells.max(1) as f64).powf(-1.5);
    let mut bessel = 1.0;
    for m in 1..MOST_NODES {
        let n = m as f64;
        bessel *= x / (2.0 * n + 1.0);
        let lost = (2.0 * n + 1.0) * f64::min(bessel, 1.0) * n.powf(-1.5);
        if m >= whole && share * lost <= CUT_TOLERANCE {
            return m;
        }
    }
    MOST_NODES
}

/// How many Gauss nodes integrate exp(2πi·cycles·t) over a cell of length one to this error.
fn gauss_nodes(cycles: f64, tolerance: f64) -> usize {
    let half = std::f64::consts::PI * cycles;
    let exact = if half > 0.0 { half.sin() / half } else { 1.0 };
    let error = |nodes: usize| {
        let cell = Axis::gauss(1, 2.0, 0.0, nodes);
        let sum: f64 = (0..nodes)
            .map(|i| 0.5 * cell.weight(i) * (half * cell.node(i)).cos())
            .sum();
        (sum - exact).abs()
    };
    let fits = (1..MOST_NODES).find(|&n| error(n) <= tolerance);
    fits.unwrap_or(MOST_NODES)
}

#[cfg(test)]
mod tests {
    use crate::wave::grid::screen_axis::{PIXEL_TOLERANCE, gauss_nodes};

    #[test]
    fn nodes_grow_with_the_frequency() {
        assert_eq!(gauss_nodes(0.0, PIXEL_TOLERANCE), 1);
        assert!(gauss_nodes(0.1, PIXEL_TOLERANCE) <= 3);
        assert_eq!(gauss_nodes(0.5, PIXEL_TOLERANCE), 4);
    }
}
