//! The transmission of an element in the cells about a singular point of its phase: the core of a vortex, the tip of an axicon.
//!
//! Sampled at the nodes, the transmission there has light that comes back from beyond the band of the nodes: a vortex sends it
//! in all directions, as 1/f². So in these cells it is replaced by the polynomial that comes closest to it
//! (`cell_polynomials.rs`). Squares about the point are halved on the way to it, and each is integrated by Gauss nodes.
//!
//! `act_dot_product` (in `sampling.rs`) tests the transpose as a part of what a screen does.

use ndarray::Array2;
use num_complex::Complex64;

use crate::optics::moments::legendre;
use crate::optics::phase::profile::Profile;
use crate::wave::grid::cell_polynomials::{NodesOfPart, cell_edges, nodes_of_parts};
use crate::wave::grid::field::Axis;

/// Cells on each side of the one with the singular point in which the transmission is replaced.
const BESIDE: usize = 2;

/// Times that the box with the singular point is halved; what is left is this power of 4 of the cell.
const HALVINGS: u32 = 12;

/// Gauss nodes along each axis of a box beyond the polynomials of a cell.
const SPARE_NODES: usize = 8;

/// What nodes about singular points have in place of the transmission there, over that transmission.
pub(crate) struct SingularNodes {
    /// Row and column of each node, and the factor.
    pub factors: Vec<([usize; 2], Complex64)>,
}

/// A box: its lower and upper ends along x and y, in mm.
type Box2 = [[f64; 2]; 2];

impl SingularNodes {
    /// Those of phases that multiply each other, each with its singular point, at the Gauss nodes of cells along x and y.
    pub(crate) fn of_cells(phases: &[(&Profile, [f64; 2])], [x, y]: [&Axis; 2]) -> Self {
        let mut factors = Vec::new();
        if phases.is_empty() {
            return Self { factors };
        }
        let light = SingularLight::new(phases, [x, y].map(Axis::nodes_of_cell));
        let parts = [x, y].map(nodes_of_parts);
        let nodes = [x, y].map(Axis::nodes_of_cell);
        for [column, row] in cells_about(phases, [x, y]) {
            let low = [cell_edges(x, column)[0], cell_edges(y, row)[0]];
            for along_y in &parts[1] {
                for along_x in &parts[0] {
                    let found = light.at_nodes([along_x, along_y], low);
                    for ((j, i), value) in found.indexed_iter() {
                        let node = [
                            row * nodes[1] + along_y.nodes.start + j,
                            column * nodes[0] + along_x.nodes.start + i,
                        ];
                        let at = [x.node(node[1]), y.node(node[0])];
                        factors.push((node, value * light.transmission(at).conj()));
                    }
                }
            }
        }
        Self { factors }
    }

    /// Multiplies what was multiplied by the transmission at the nodes.
    pub(crate) fn apply(&self, values: &mut Array2<Complex64>) {
        for (node, factor) in &self.factors {
            values[*node] *= factor;
        }
    }

    /// The conjugate transpose of [`SingularNodes::apply`].
    pub(crate) fn apply_adjoint(&self, bar: &mut Array2<Complex64>) {
        for (node, factor) in &self.factors {
            bar[*node] *= factor.conj();
        }
    }
}

/// The cells about singular points, by column and row, each once.
fn cells_about(phases: &[(&Profile, [f64; 2])], axes: [&Axis; 2]) -> Vec<[usize; 2]> {
    let about = |at: [f64; 2]| {
        let [columns, rows] = [0, 1].map(|a| {
            let axis = axes[a];
            let place = (at[a] - axis.edges()[0]) / axis.pitch;
            let first = (place.floor() - BESIDE as f64).clamp(0.0, axis.cells as f64);
            let last = (place.floor() + BESIDE as f64 + 1.0).clamp(0.0, axis.cells as f64);
            first as usize..last as usize
        });
        rows.flat_map(move |row| columns.clone().map(move |column| [column, row]))
    };
    let mut cells: Vec<[usize; 2]> = phases.iter().flat_map(|(_, at)| about(*at)).collect();
    cells.sort_unstable();
    cells.dedup();
    cells
}

/// The transmission of singular phases, and what integrates it over boxes.
struct SingularLight<'a> {
    phases: &'a [(&'a Profile, [f64; 2])],
    /// Gauss nodes of a box.
    rule: Axis,
}

impl<'a> SingularLight<'a> {
    /// For so many polynomials along x and y.
    fn new(phases: &'a [(&'a Profile, [f64; 2])], polynomials: [usize; 2]) -> Self {
        let nodes = polynomials[0].max(polynomials[1]) + SPARE_NODES;
        Self {
            phases,
            rule: Axis::gauss(1, 2.0, 0.0, nodes),
        }
    }

    /// The transmission at a point.
    fn transmission(&self, [x, y]: [f64; 2]) -> Complex64 {
        Complex64::cis(self.phases.iter().map(|(own, _)| own.phase(x, y)).sum())
    }

    /// The closest polynomial at the nodes of a part of a cell whose lower ends are `low`, [y, x].
    fn at_nodes(&self, [x, y]: [&NodesOfPart; 2], low: [f64; 2]) -> Array2<Complex64> {
        let cell = [
            x.ends.map(|end| low[0] + end),
            y.ends.map(|end| low[1] + end),
        ];
        let mut moments = Array2::zeros((y.nodes.len(), x.nodes.len()));
        self.add_box(cell, cell, HALVINGS, &mut moments);
        let complex = |basis: &Array2<f64>| basis.mapv(Complex64::from);
        complex(&y.basis).dot(&moments).dot(&complex(&x.basis).t())
    }

    /// Adds ∫ t·P_a(ξ)·P_b(η) over a part of a cell, [b, a], with ξ and η from −1 to 1 over the cell.
    fn add_box(&self, part: Box2, cell: Box2, halvings: u32, moments: &mut Array2<Complex64>) {
        // Halve a box along its longer sides as long as a singular point is closer than half its size.
        let size = part.map(|[low, high]| high - low);
        let longest = size[0].max(size[1]);
        let near = |at: &[f64; 2]| {
            (0..2).all(|a| part[a][0] - 0.5 * longest < at[a] && at[a] < part[a][1] + 0.5 * longest)
        };
        if halvings > 0 && self.phases.iter().any(|(_, at)| near(at)) {
            let halves = [0, 1].map(|a| {
                let [low, high] = part[a];
                let middle = 0.5 * (low + high);
                match size[a] > 0.6 * longest {
                    true => vec![[low, middle], [middle, high]],
                    false => vec![[low, high]],
                }
            });
            for y in &halves[1] {
                for x in &halves[0] {
                    self.add_box([*x, *y], cell, halvings - 1, moments);
                }
            }
            return;
        }
        self.add_smooth_box(part, cell, moments);
    }

    /// The same where the transmission is smooth, by one rule.
    fn add_smooth_box(&self, part: Box2, cell: Box2, moments: &mut Array2<Complex64>) {
        let (rows, columns) = moments.dim();
        let place = |a: usize, i: usize| {
            let [low, high] = part[a];
            low + 0.5 * (high - low) * (1.0 + self.rule.node(i))
        };
        let polynomials = |a: usize, count: usize| {
            let mut values = Array2::zeros((self.rule.len(), count));
            let [low, high] = cell[a];
            let share = (part[a][1] - part[a][0]) / (high - low);
            for (i, mut row) in values.rows_mut().into_iter().enumerate() {
                let mut own = vec![0.0; count];
                legendre(2.0 * (place(a, i) - low) / (high - low) - 1.0, &mut own);
                let weight = share * self.rule.weight(i);
                row.iter_mut()
                    .zip(&own)
                    .for_each(|(value, own)| *value = Complex64::from(weight * own));
            }
            values
        };
        let values = Array2::from_shape_fn([self.rule.len(); 2], |(j, i)| {
            self.transmission([place(0, i), place(1, j)])
        });
        *moments += &polynomials(1, rows)
            .t()
            .dot(&values)
            .dot(&polynomials(0, columns));
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use num_complex::Complex64;

    use crate::fixtures::parts::{element, pixel_layer, screen};
    use crate::math::bessel::bessel_j;
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::{Doe, Layer};
    use crate::optics::frame::Frame;
    use crate::optics::phase::placement::Placement;
    use crate::optics::phase::profile::Profile;
    use crate::optics::pixels::pixel_grid::PixelForm;
    use crate::optics::screen::ScreenKind;
    use crate::wave::grid::field::{Axis, Field};
    use crate::wave::grid::sampling::{Reach, apply_screen, plan_grid};

    const RADIUS: f64 = 9.3;

    /// The integral of exp(ilφ + 2πi·p·x) over a disc about the core: 2π·i^l·exp(ilθ)·∫J_l(2πpr)·r dr.
    fn vortex_spectrum(charge: i32, [px, py]: [f64; 2]) -> Complex64 {
        let rings = Axis::gauss(40, RADIUS / 40.0, 0.5 * RADIUS, 8);
        let order = charge.unsigned_abs();
        let ring = |i: usize| {
            let r = rings.node(i);
            rings.weight(i) * r * bessel_j(order, TAU * px.hypot(py) * r)
        };
        let sum: f64 = (0..rings.len()).map(ring).sum();
        TAU * sum * Complex64::I.powu(order) * Complex64::cis(f64::from(charge) * py.atan2(px))
    }

    /// A disc with a vortex whose core is its centre, and other layers.
    fn vortex(charge: i32, centre: [f64; 2], others: Vec<Layer>) -> Doe {
        let own = Profile::Vortex { charge }.placed(Placement {
            centre,
            rotation: 0.0,
        });
        let aperture = Aperture {
            centre,
            ..Aperture::disc(RADIUS)
        };
        let mut doe = element(Layer::Phase(own), aperture);
        doe.layers.extend(others);
        doe
    }

    /// The light of a core in every direction, wherever in a cell it lies, with and without pixels.
    #[test]
    fn vortices_have_their_spectrum() {
        let pixels = || {
            let even = ndarray::Array2::from_elem((14, 14), Complex64::ONE);
            pixel_layer(even, 1.5, PixelForm::Box)
        };
        let cases = [
            (1, [0.0, 0.0], vec![]),
            (2, [0.31, -0.12], vec![]),
            (-3, [0.02, 0.3], vec![]),
            (2, [0.31, -0.12], vec![pixels()]),
        ];
        for (charge, centre, others) in cases {
            let doe = vortex(charge, centre, others);
            let screen = screen(Frame::GLOBAL, ScreenKind::Doe(doe));
            let reach = Reach {
                arriving: [0.05; 2],
                leaving: [0.6; 2],
            };
            let grid = plan_grid(&screen, reach, 1.0, 10_000_000).unwrap();
            let mut field = Field::zeros(grid.clone());
            field.values.fill(Complex64::ONE);
            apply_screen(&screen, &mut field);
            for p in [[0.02, 0.01], [0.1, -0.2], [0.4, 0.1], [0.6, 0.0]] {
                let mut found = Complex64::ZERO;
                for ((j, i), value) in field.values.indexed_iter() {
                    let at = [grid.x.node(i) - centre[0], grid.y.node(j) - centre[1]];
                    let weight = grid.x.weight(i) * grid.y.weight(j);
                    found += value * weight * Complex64::cis(TAU * (p[0] * at[0] + p[1] * at[1]));
                }
                let exact = vortex_spectrum(charge, p);
                assert!(
                    (found - exact).norm() < 1e-6,
                    "{charge} {p:?}: {found} {exact}"
                );
            }
        }
    }
}
