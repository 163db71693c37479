//! The aperture of an element at the nodes of a tile, with a limited band.
//!
//! The spectrum of a hard edge falls off slowly, so that samples of the edge itself alias at every pitch. Here the shares of
//! fine cells that are open pass a low-pass filter before they are taken at the nodes. Light in a narrower band than the
//! filter's passband, times this mask, has the plane waves that it has behind the edge, in the directions that the passband
//! leaves.

use ndarray::Array2;

use crate::optics::aperture::Aperture;
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::aperture_scan::ApertureScan;

/// Frequencies of the mask up to this one are right, in turns from node to node; those from 1 less this one on are gone.
pub(crate) const PASSBAND: f64 = 0.25;

/// The filter reaches this many nodes to both sides.
pub(crate) const REACH: usize = 7;

/// Cells from node to node. Their own means attenuate the edge of the passband by 2e-3.
const FINE: usize = 7;

/// Shape of the filter's window exp(β(√(1 − z²) − 1)): within the passband the filter is one within 2e-5, and
/// frequencies that must go are below 2e-5.
const SHAPE: f64 = 11.0;

/// The filter at fine cells, from one end to the other; the sum is one.
fn kernel() -> Vec<f64> {
    let ends = (FINE * REACH) as i32;
    let weight = |d: i32| {
        let (u, z) = (f64::from(d) / FINE as f64, f64::from(d) / f64::from(ends));
        let turn = std::f64::consts::PI * u;
        let sinc = if d == 0 { 1.0 } else { turn.sin() / turn };
        sinc * (SHAPE * ((1.0 - z * z).sqrt() - 1.0)).exp()
    };
    let weights: Vec<f64> = (-ends..=ends).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

/// The filter's sum from each fine cell to its end: what a step from zero to one there leaves at the node.
fn steps(kernel: &[f64]) -> Vec<f64> {
    let sums = kernel.iter().rev().scan(0.0, |sum, weight| {
        *sum += weight;
        Some(*sum)
    });
    let mut steps: Vec<f64> = sums.collect();
    steps.reverse();
    steps
}

/// Filters the open shares of a row of fine cells to its nodes. Shares are equal over most of a row, so that only the few
/// steps between unequal cells are filtered.
fn filter_row(mut scan: ApertureScan, spans: &[[f64; 2]], steps: &[f64], filtered: &mut [f64]) {
    let (mut place, mut before) = (0, 0.0);
    while let Some(span) = spans.get(place) {
        let share = scan.open(*span);
        let next = place.saturating_add(scan.equal_cells(*span));

        // Nodes whose filters begin before this cell and reach it.
        let (step, begun) = (share - before, place.div_ceil(FINE));
        let first = (place + 1).saturating_sub(steps.len()).div_ceil(FINE);
        let reached = filtered.iter_mut().enumerate().take(begun).skip(first);
        for (i, value) in reached {
            *value += step * steps.get(place - i * FINE).copied().unwrap_or(0.0);
        }

        // Nodes whose filters begin here.
        let begin = filtered.iter_mut().take(next.div_ceil(FINE)).skip(begun);
        begin.for_each(|value| *value = share);
        (place, before) = (next, share);
    }
}

/// The mask at equally spaced nodes along x and y, [y, x]: one far inside the aperture, zero far outside, and with ripples
/// about its edge.
pub(crate) fn edge_mask(aperture: &Aperture, [columns, rows]: &[Axis; 2]) -> Array2<f64> {
    let mut mask = Array2::zeros((rows.len(), columns.len()));
    if mask.is_empty() {
        return mask;
    }
    let kernel = kernel();
    let steps = steps(&kernel);
    let fine = |axis: &Axis| (axis.len() - 1) * FINE + kernel.len();
    let span = |axis: &Axis, place: usize| {
        let cell = axis.pitch / FINE as f64;
        let middle = axis.node(0) + (place as f64 - (FINE * REACH) as f64) * cell;
        [middle - 0.5 * cell, middle + 0.5 * cell]
    };
    let spans: Vec<[f64; 2]> = (0..fine(columns)).map(|i| span(columns, i)).collect();
    let mut filtered = vec![0.0; columns.len()];
    for place in 0..fine(rows) {
        // Along x first.
        let scan = ApertureScan::new(aperture, span(rows, place));
        filter_row(scan, &spans, &steps, &mut filtered);
        if filtered.iter().all(|value| *value == 0.0) {
            continue;
        }

        // Then to the rows that the filter reaches from here.
        let last = (place / FINE).min(rows.len() - 1);
        let first = place.saturating_sub(kernel.len() - 1).div_ceil(FINE);
        for j in first..=last {
            let weight = kernel.get(place - j * FINE).copied().unwrap_or(0.0);
            let sums = mask.row_mut(j).into_slice().unwrap_or_default();
            for (sum, value) in sums.iter_mut().zip(&filtered) {
                *sum += weight * value;
            }
        }
    }
    mask
}

#[cfg(test)]
mod tests {
    use crate::optics::aperture::{Aperture, Outline};
    use crate::wave::grid::field::Axis;
    use crate::wave::local_bands::edge_mask::{FINE, PASSBAND, REACH, edge_mask, kernel};

    /// The spectrum of a slit, and of a disc, is that of the closed form within the passband.
    #[test]
    fn the_passband_has_the_spectrum_of_the_edge() {
        let axis = || Axis::uniform(80, 0.5, 0.13);
        let slit = Aperture {
            outline: Outline::Rectangle {
                half_x: 11.3,
                half_y: 9.1,
            },
            centre: [0.2, -0.3],
        };
        let mask = edge_mask(&slit, &[axis(), axis()]);
        let turn = |frequency: f64| std::f64::consts::TAU * frequency / 0.5;
        for part in [0.0, 0.31, 0.77, 1.0] {
            let [p, q] = [part * PASSBAND, 0.6 * part * PASSBAND].map(turn);
            let sum: f64 = mask
                .indexed_iter()
                .map(|((j, i), value)| {
                    let (x, y) = (axis().node(i) - 0.2, axis().node(j) + 0.3);
                    0.25 * value * (p * x).cos() * (q * y).cos()
                })
                .sum();
            let side = |half: f64, p: f64| {
                if p == 0.0 {
                    2.0 * half
                } else {
                    2.0 * (p * half).sin() / p
                }
            };
            let exact = side(11.3, p) * side(9.1, q);
            // What a single edge sends there.
            let edge = if p == 0.0 { 400.0 } else { 2.0 / (p * q) };
            assert!((sum - exact).abs() < 8e-3 * edge, "{part}: {sum} {exact}");
        }
    }

    #[test]
    fn far_from_the_edge_it_is_open_or_not() {
        let mask = edge_mask(
            &Aperture::disc(12.0),
            &[Axis::uniform(60, 0.5, 0.0), Axis::uniform(60, 0.5, 0.0)],
        );
        assert!((mask[[30, 30]] - 1.0).abs() < 1e-12);
        assert!(mask[[0, 0]].abs() < 1e-12);
    }

    /// Steps between runs of equal cells give what the sum over all cells under the filter gives.
    #[test]
    fn it_is_the_filtered_share_of_every_cell() {
        let ring = Aperture {
            outline: Outline::Annulus {
                inner: 0.6,
                outer: 2.3,
            },
            centre: [0.2, -0.1],
        };
        let apertures = [
            ring,
            Aperture::regular_polygon(5, 2.1, 0.3, [0.0, 0.1]),
            Aperture::disc(2.2).blocked(Aperture::turned_rectangle(2.6, 0.1, 0.3, [0.0; 2])),
            Aperture::disc(0.01),
        ];
        let axes = [Axis::uniform(9, 0.5, 0.1), Axis::uniform(11, 0.4, -0.2)];
        let kernel = kernel();
        for aperture in &apertures {
            let mask = edge_mask(aperture, &axes);
            for ((j, i), value) in mask.indexed_iter() {
                let span = |axis: &Axis, n: usize, m: usize| {
                    let cell = axis.pitch / FINE as f64;
                    let low = axis.node(n) + (m as f64 - (FINE * REACH) as f64 - 0.5) * cell;
                    [low, low + cell]
                };
                let mut sum = 0.0;
                for (n, across) in kernel.iter().enumerate() {
                    let [y0, y1] = span(&axes[1], j, n);
                    for (m, along) in kernel.iter().enumerate() {
                        let [x0, x1] = span(&axes[0], i, m);
                        sum += across * along * aperture.coverage(x0, x1, y0, y1);
                    }
                }
                assert!((value - sum).abs() < 1e-12, "{aperture:?}: {value} {sum}");
            }
        }
    }
}
