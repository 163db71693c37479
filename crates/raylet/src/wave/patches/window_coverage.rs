//! The sum of windows about scattered points.

use ndarray::{Array2, Axis};
use rayon::prelude::*;

use crate::wave::grid::field::Grid;
use crate::wave::patches::local_spectrum::Window;

/// Rows of a band: the unit of parallel work.
const ROWS: usize = 32;

/// Σ gⱼ^`power` over windows about `centres`, cut at `period`, at each node of a grid, indexed [y, x].
pub(crate) fn window_coverage(
    centres: &[[f64; 2]],
    grid: &Grid,
    window: Window,
    period: f64,
    power: i32,
) -> Array2<f64> {
    let mut cover = Array2::zeros(grid.shape());
    let bands = cover.axis_chunks_iter_mut(Axis(0), ROWS);
    bands.into_par_iter().enumerate().for_each(|(b, mut band)| {
        let first = b * ROWS;
        for centre in centres {
            let (rows, gy) = window.on(&grid.y, centre[1], period);
            let within = rows.start.max(first)..rows.end.min(first + band.nrows());
            if within.is_empty() {
                continue;
            }
            let (columns, gx) = window.on(&grid.x, centre[0], period);
            for row in within {
                let along_y = gy[row - rows.start];
                for (i, g) in columns.clone().zip(&gx) {
                    band[[row - first, i]] += (along_y * g).powi(power);
                }
            }
        }
    });
    cover
}

#[cfg(test)]
mod tests {
    use crate::wave::grid::field::{Axis, Grid};
    use crate::wave::patches::local_spectrum::Window;
    use crate::wave::patches::window_coverage::window_coverage;

    #[test]
    fn windows_add_up_at_every_node() {
        let grid = Grid {
            x: Axis::uniform(50, 0.1, 0.3),
            y: Axis::gauss(30, 0.2, -0.1, 2),
        };
        let centres: Vec<[f64; 2]> = (0..40)
            .map(|i| {
                [
                    (0.37 * f64::from(i)).sin() * 3.0,
                    (0.91 * f64::from(i)).cos() * 4.0,
                ]
            })
            .collect();
        let gaussian = window_coverage(&centres, &grid, Window::Gaussian { sigma: 0.5 }, 3.0, 2);
        let square = window_coverage(&centres, &grid, Window::Square { side: 1.3 }, 3.0, 1);
        for ((j, i), found) in gaussian.indexed_iter() {
            let (mut sum, mut count) = (0.0, 0.0);
            for [x, y] in &centres {
                let (u, v) = (grid.x.node(i) - x, grid.y.node(j) - y);
                if u.abs() < 1.5 && v.abs() < 1.5 {
                    sum += (-(u * u + v * v) / 0.25).exp();
                }
                if u.abs() < 0.65 && v.abs() < 0.65 {
                    count += 1.0;
                }
            }
            assert!((found - sum).abs() < 1e-14);
            assert_eq!(square[[j, i]], count);
        }
    }
}
