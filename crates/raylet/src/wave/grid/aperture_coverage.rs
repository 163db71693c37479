//! The open share of the cell of each node of a grid.
//!
//! Gauss nodes integrate a smooth field over their whole cell, or over their part of a cell with a gap. Where an edge cuts it
//! they integrate the field over what is open when each is weighted by the polynomial that comes closest, in the mean square over the
//! cell, to a function that is one on the open part and zero elsewhere: all polynomials of a lower degree than
//! there are nodes are then integrated exactly. With one node a cell the weight is the open share of its area.

use ndarray::{Array2, ArrayViewMut2};

use crate::math::part::part;
use crate::optics::aperture::Aperture;
use crate::optics::moments::{Cell, OpenMoments};
use crate::wave::grid::cell_polynomials::{NodesOfPart, cell_edges, nodes_of_parts};
use crate::wave::grid::field::{Axis, Grid};

/// What an aperture lets through of each node of a grid.
pub(crate) struct ApertureCoverage<'a> {
    aperture: &'a Aperture,
    grid: &'a Grid,
    /// The parts of a cell along x and y.
    parts: [Vec<NodesOfPart>; 2],
}

impl<'a> ApertureCoverage<'a> {
    /// An aperture seen by a grid.
    pub(crate) fn new(aperture: &'a Aperture, grid: &'a Grid) -> Self {
        Self {
            aperture,
            grid,
            parts: [&grid.x, &grid.y].map(nodes_of_parts),
        }
    }

    /// The weights of the nodes in a row of cells, indexed [node in the cell, node along x].
    pub(crate) fn row(&self, row: usize) -> Array2<f64> {
        let nodes = [&self.grid.x, &self.grid.y].map(Axis::nodes_of_cell);
        let mut weights = Array2::ones((nodes[1], self.grid.x.len()));
        let y = cell_edges(&self.grid.y, row);

        // Rows wholly inside or outside, most of them, need no cells.
        let cells = self.grid.x.cells;
        let ends = [0, cells.saturating_sub(1)].map(|column| cell_edges(&self.grid.x, column));
        let whole = self
            .aperture
            .rough_share([ends[0][0], ends[1][1], y[0], y[1]]);
        if whole == 1.0 || whole == 0.0 {
            weights.fill(whole);
            return weights;
        }
        let mut moments = self.moments();
        for column in 0..cells {
            let x = cell_edges(&self.grid.x, column);
            let open = self.aperture.coverage(x[0], x[1], y[0], y[1]);
            if open == 1.0 {
                continue;
            }
            let mut cell = part(
                weights.view_mut(),
                ..,
                column * nodes[0]..(column + 1) * nodes[0],
            );
            if open == 0.0 {
                cell.fill(0.0);
            } else {
                self.fill_cut([x[0], y[0]], cell, &mut moments);
            }
        }
        weights
    }

    /// What integrates over each part of a cell, [y, x] row by row.
    fn moments(&self) -> Vec<OpenMoments> {
        let [along_x, along_y] = &self.parts;
        let row = |y: &NodesOfPart| {
            let each = along_x.iter();
            let new = |x: &NodesOfPart| OpenMoments::new([x.nodes.len(), y.nodes.len()]);
            each.map(new).collect::<Vec<_>>()
        };
        along_y.iter().flat_map(row).collect()
    }

    /// Fills the weights of a cell that an edge cuts, part by part, from its lower ends.
    fn fill_cut(&self, low: [f64; 2], mut cell: ArrayViewMut2<f64>, moments: &mut [OpenMoments]) {
        let [along_x, along_y] = &self.parts;
        let parts = along_y
            .iter()
            .flat_map(|y| along_x.iter().map(move |x| (x, y)));
        for ((x, y), moments) in parts.zip(moments) {
            let ends = Cell {
                x: x.ends.map(|end| low[0] + end),
                y: y.ends.map(|end| low[1] + end),
            };
            let found = moments.over(self.aperture, &ends);
            let weights = y.basis.dot(found).dot(&x.basis.t());
            part(cell.view_mut(), y.nodes.clone(), x.nodes.clone()).assign(&weights);
        }
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::fixtures::parts::{element, pixel_layer, screen};
    use crate::optics::aperture::Aperture;
    use crate::optics::frame::Frame;
    use crate::optics::pixels::pixel_grid::PixelForm;
    use crate::optics::screen::{Screen, ScreenKind};

    use crate::wave::grid::field::{Axis, Field};
    use crate::wave::grid::sampling::{Reach, apply_screen, plan_grid};

    /// A screen on which a disc of a radius opens pixels of a pitch; all of them let everything through.
    fn round_pixels(count: usize, pitch: f64, radius: f64) -> Screen {
        let values = ndarray::Array2::from_elem((count, count), Complex64::ONE);
        let pixels = pixel_layer(values, pitch, PixelForm::Box);
        let doe = element(pixels, Aperture::disc(radius));
        screen(Frame::GLOBAL, ScreenKind::Doe(doe))
    }

    /// The integral of exp(2πi·p·x) over a disc, in rings.
    fn disc_spectrum(radius: f64, [px, py]: [f64; 2]) -> Complex64 {
        let rings = Axis::gauss(40, radius / 40.0, 0.5 * radius, 6);
        let turn = std::f64::consts::TAU;
        let around = 720;
        let ring = |i: usize| {
            let r = rings.node(i);
            let wave = |n: i32| {
                let (s, c) = (turn * f64::from(n) / f64::from(around)).sin_cos();
                Complex64::cis(turn * r * (px * c + py * s))
            };
            (0..around).map(wave).sum::<Complex64>()
                * (rings.weight(i) * r * turn / f64::from(around))
        };
        (0..rings.len()).map(ring).sum()
    }

    /// Spectra of round apertures, of few wide pixels and of none, at λ = 1.
    #[test]
    fn round_apertures_have_their_spectrum() {
        let stop = |radius: f64| Screen {
            kind: ScreenKind::Stop(Aperture::disc(radius)),
            ..round_pixels(1, 1.0, radius)
        };
        let reach = Reach {
            arriving: [0.1; 2],
            leaving: [0.9; 2],
        };
        for (name, radius, screen) in [
            ("8 pixels of 2", 7.3, round_pixels(8, 2.0, 7.3)),
            ("30 pixels of 0.9", 12.1, round_pixels(30, 0.9, 12.1)),
            ("4 pixels of 20", 37.0, round_pixels(4, 20.0, 37.0)),
            ("stop of 5", 5.0, stop(5.0)),
            ("stop of 21", 21.3, stop(21.3)),
        ] {
            let grid = plan_grid(&screen, reach, 1.0, 10_000_000).unwrap();
            let mut field = Field::zeros(grid.clone());
            field.values.fill(Complex64::ONE);
            apply_screen(&screen, &mut field);
            let area = std::f64::consts::PI * radius * radius;
            for p in [
                [0.0, 0.0],
                [0.05, 0.02],
                [0.3, -0.2],
                [0.6, 0.6],
                [0.9, 0.0],
            ] {
                let mut found = Complex64::ZERO;
                for ((j, i), value) in field.values.indexed_iter() {
                    let turns = p[0] * grid.x.node(i) + p[1] * grid.y.node(j);
                    let weight = grid.x.weight(i) * grid.y.weight(j);
                    found += value * weight * Complex64::cis(std::f64::consts::TAU * turns);
                }
                let error = (found - disc_spectrum(radius, p)).norm() / area;
                assert!(
                    error < 1e-4,
                    "{name} {p:?}: {error:e}, nodes {:?}",
                    grid.shape()
                );
            }
        }
    }
}
