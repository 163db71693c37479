//! Integrals of polynomials over the part of a cell that an aperture leaves open.
//!
//! By Green's theorem ∫∫ P(x)·Q(y) over the open part of a box is the integral of P(x)·R(y) along its outline,
//! R(y) being ∫ Q from the bottom of the box, with y cut off at the bottom and the top and x at the sides.
//! Straight sides and arcs are exact to rounding. Where an aperture and its obstruction cut the same box, the
//! box is quartered.

use ndarray::Array2;

use crate::optics::aperture::{Aperture, Outline};
use crate::optics::polygon;

/// A cell, and how many Legendre polynomials are integrated along each axis of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Its lowest and highest x, in mm.
    pub x: [f64; 2],
    /// Its lowest and highest y, in mm.
    pub y: [f64; 2],
    /// Polynomials along x and y.
    pub counts: [usize; 2],
}

/// A part of the cell along x and y, in units that run from −1 to 1 over the cell.
type Part = [[f64; 2]; 2];

/// Times that a part is quartered where an aperture and its obstruction cut it.
const QUARTERINGS: u32 = 6;

/// The longest arc that one rule of Gauss nodes integrates, in rad.
const LONGEST_ARC: f64 = 0.8;

/// The integrals of P_a(ξ)·P_b(η) over the open part of a cell, indexed [b, a]: Legendre polynomials of
/// coordinates that run from −1 to 1 over the cell.
pub(crate) fn open_moments(aperture: &Aperture, cell: &Cell) -> Array2<f64> {
    let mut sum = Sum {
        cell,
        rule: gauss_rule(cell.counts[0] + cell.counts[1] + 2),
        total: Array2::zeros((cell.counts[1], cell.counts[0])),
    };
    sum.add_open(aperture, [[-1.0, 1.0]; 2], 1.0, QUARTERINGS);
    sum.total
}

/// The moments of a cell while they are added up.
struct Sum<'a> {
    cell: &'a Cell,
    /// Nodes on [−1, 1] and weights of the rule along a piece of an edge.
    rule: Vec<(f64, f64)>,
    total: Array2<f64>,
}

impl Sum<'_> {
    /// Adds the moments of the open part of a part of the cell, times `sign`.
    fn add_open(&mut self, aperture: &Aperture, part: Part, sign: f64, quarterings: u32) {
        let Outline::Blocked { open, by } = &aperture.outline else {
            for edge in edges(aperture, self.cell) {
                self.add_edge(&edge, part, sign);
            }
            return;
        };
        // Both in the coordinates of the cell.
        let placed = |part: &Aperture| Aperture {
            centre: [0, 1].map(|i| part.centre[i] + aperture.centre[i]),
            ..part.clone()
        };
        let (open, by) = (&placed(open), &placed(by));
        let (whole, covered) = (share(open, self.cell, part), share(by, self.cell, part));
        if whole == 0.0 || covered == 1.0 {
            return;
        }
        if covered == 0.0 {
            return self.add_open(open, part, sign, quarterings);
        }
        if whole == 1.0 {
            self.add_box(part, sign);
            return self.add_open(by, part, -sign, quarterings);
        }
        if quarterings == 0 {
            return self.add_box(part, sign * whole * (1.0 - covered));
        }
        let halves =
            part.map(|[low, high]| [[low, 0.5 * (low + high)], [0.5 * (low + high), high]]);
        for quarter in halves[0].iter().flat_map(|x| halves[1].map(|y| [*x, y])) {
            self.add_open(aperture, quarter, sign, quarterings - 1);
        }
    }

    /// Adds the moments of a part of the cell, all of it open, times `weight`.
    fn add_box(&mut self, [x, y]: Part, weight: f64) {
        let along = |[low, high]: [f64; 2], count: usize| {
            let ends = [low, high].map(|t| legendre_integrals(t, count));
            let both = ends[1].iter().zip(&ends[0]);
            both.map(|(high, low)| high - low).collect::<Vec<f64>>()
        };
        let [nx, ny] = self.cell.counts;
        let (along_x, along_y) = (along(x, nx), along(y, ny));
        for ((b, a), sum) in self.total.indexed_iter_mut() {
            *sum += weight * along_x[a] * along_y[b];
        }
    }

    /// Adds −∫ P_a(x)·R_b(y) dx along an edge, as far as it lies between the sides of a part and above its
    /// bottom.
    fn add_edge(&mut self, edge: &Edge, [x, y]: Part, sign: f64) {
        let [nx, ny] = self.cell.counts;
        let bottom = legendre_integrals(y[0], ny);
        for ends in edge.breaks([x, y]).windows(2) {
            let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
            let ([middle_x, middle_y], _) = edge.at(middle);
            if half <= 0.0 || middle_x < x[0] || middle_x > x[1] || middle_y < y[0] {
                continue;
            }
            for (node, weight) in &self.rule {
                let ([px, py], rate) = edge.at(middle + half * node);
                let along_x = legendre(px, nx);
                let along_y = legendre_integrals(py.clamp(y[0], y[1]), ny);
                let weight = -sign * half * weight * rate;
                for ((b, a), sum) in self.total.indexed_iter_mut() {
                    *sum += weight * along_x[a] * (along_y[b] - bottom[b]);
                }
            }
        }
    }
}

/// The share of a part of the cell that is open; roughly, where it is neither 0 nor 1.
fn share(aperture: &Aperture, cell: &Cell, [x, y]: Part) -> f64 {
    let place = |[low, high]: [f64; 2], t: f64| 0.5 * (low + high + t * (high - low));
    let [x0, x1] = x.map(|t| place(cell.x, t));
    let [y0, y1] = y.map(|t| place(cell.y, t));
    aperture.rough_share([x0, x1, y0, y1])
}

/// A piece of an outline, with the open side on its left; coordinates of the cell.
enum Edge {
    /// A straight side between two points.
    Side([[f64; 2]; 2]),
    /// A whole circle: an ellipse where the cell is no square. `turn` is −1 for a circle that is followed
    /// clockwise.
    Circle {
        centre: [f64; 2],
        radii: [f64; 2],
        turn: f64,
    },
}

/// The edges of an aperture that is no obstructed one; an open aperture has the sides of the cell.
fn edges(aperture: &Aperture, cell: &Cell) -> Vec<Edge> {
    let (middle, half) = (
        [cell.x, cell.y].map(|[low, high]| 0.5 * (low + high)),
        [cell.x, cell.y].map(|[low, high]| 0.5 * (high - low)),
    );
    let place = |p: [f64; 2]| -> [f64; 2] {
        std::array::from_fn(|i| (p[i] + aperture.centre[i] - middle[i]) / half[i])
    };
    let circle = |radius: f64, turn: f64| Edge::Circle {
        centre: place([0.0; 2]),
        radii: half.map(|half| radius / half),
        turn,
    };
    let box_sides = |x: f64, y: f64| polygon_edges(&[[-x, -y], [x, -y], [x, y], [-x, y]], &place);
    match &aperture.outline {
        Outline::Disc { radius } => vec![circle(*radius, 1.0)],
        Outline::Annulus { inner, outer } => vec![circle(*outer, 1.0), circle(*inner, -1.0)],
        Outline::Rectangle { half_x, half_y } => box_sides(*half_x, *half_y),
        Outline::Polygon { corners } => polygon_edges(corners, &place),
        Outline::Open | Outline::Blocked { .. } => {
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            polygon_edges(&corners, &|p| p)
        }
    }
}

/// The sides of a polygon, the open side on the left.
fn polygon_edges(corners: &[[f64; 2]], place: &dyn Fn([f64; 2]) -> [f64; 2]) -> Vec<Edge> {
    let clockwise = polygon::area(corners) < 0.0;
    let oriented = |[a, b]: [[f64; 2]; 2]| if clockwise { [b, a] } else { [a, b] };
    let sides = polygon::sides(corners);
    sides
        .map(|side| Edge::Side(oriented(side).map(place)))
        .collect()
}

impl Edge {
    /// The point at a parameter, and the derivative of its x.
    fn at(&self, t: f64) -> ([f64; 2], f64) {
        match self {
            Self::Side([a, b]) => {
                let step = [b[0] - a[0], b[1] - a[1]];
                ([a[0] + t * step[0], a[1] + t * step[1]], step[0])
            }
            Self::Circle {
                centre,
                radii,
                turn,
            } => {
                let (s, c) = (turn * t).sin_cos();
                let point = [centre[0] + radii[0] * c, centre[1] + radii[1] * s];
                (point, -turn * radii[0] * s)
            }
        }
    }

    /// Parameters in order, from its beginning to its end, between which it crosses no side of a part and no
    /// piece is long.
    fn breaks(&self, part: Part) -> Vec<f64> {
        let mut breaks = match self {
            Self::Side([a, b]) => {
                let crossing = |i: usize, level: f64| (level - a[i]) / (b[i] - a[i]);
                let all = [(0, 0), (0, 1), (1, 0), (1, 1)];
                let inner = all.map(|(i, end)| crossing(i, part[i][end]));
                let within = inner.into_iter().filter(|t| 0.0 < *t && *t < 1.0);
                within.chain([0.0, 1.0]).collect()
            }
            Self::Circle {
                centre,
                radii,
                turn,
            } => circle_breaks(*centre, *radii, *turn, part),
        };
        breaks.sort_by(f64::total_cmp);
        breaks
    }
}

/// Where a circle crosses the sides of a part, as parameters between 0 and 2π, and points between them.
fn circle_breaks(centre: [f64; 2], radii: [f64; 2], turn: f64, part: Part) -> Vec<f64> {
    let level = |i: usize, end: usize| ((part[i][end] - centre[i]) / radii[i]).clamp(-1.0, 1.0);
    let upright = [level(0, 0).acos(), level(0, 1).acos()];
    let level_ones = [level(1, 0).asin(), level(1, 1).asin()];
    let both = upright.into_iter().flat_map(|t| [t, -t]);
    let others = level_ones
        .into_iter()
        .flat_map(|t| [t, std::f64::consts::PI - t]);
    let crossings = both
        .chain(others)
        .map(|t| (turn * t).rem_euclid(std::f64::consts::TAU));
    let parts = (std::f64::consts::TAU / LONGEST_ARC).ceil();
    let regular = (0..=parts as usize).map(|i| i as f64 * std::f64::consts::TAU / parts);
    crossings.chain(regular).collect()
}

/// Nodes on [−1, 1] and weights of the Gauss–Legendre rule.
fn gauss_rule(count: usize) -> Vec<(f64, f64)> {
    let count = std::num::NonZero::new(count).unwrap_or(std::num::NonZero::<usize>::MIN);
    gauss_quad::GaussLegendre::new(count).into_iter().collect()
}

/// The first Legendre polynomials at a point.
pub(crate) fn legendre(t: f64, count: usize) -> Vec<f64> {
    let mut values = vec![1.0, t];
    for n in 1..count.saturating_sub(1) {
        let n_real = n as f64;
        let next = (2.0 * n_real + 1.0) * t * values[n] - n_real * values[n - 1];
        values.push(next / (n_real + 1.0));
    }
    values.truncate(count);
    values
}

/// The integrals of the first Legendre polynomials from −1 to a point.
fn legendre_integrals(t: f64, count: usize) -> Vec<f64> {
    let values = legendre(t, count + 1);
    let integral = |n: usize| match n {
        0 => t + 1.0,
        n => (values[n + 1] - values[n - 1]) / (2 * n + 1) as f64,
    };
    (0..count).map(integral).collect()
}

#[cfg(test)]
mod tests {
    use crate::optics::aperture::{Aperture, Outline};
    use crate::optics::moments::{Cell, legendre, open_moments};

    /// Every kind of outline, off centre where that can be.
    fn apertures() -> Vec<Aperture> {
        let centre = [0.21, -0.13];
        let at = |outline: Outline| Aperture { outline, centre };
        let (inner, outer) = (0.41, 1.2);
        let bar = Aperture::turned_rectangle(1.6, 0.1, 0.3, [0.1, 0.0]);
        let arrow = vec![[0.8, -1.0], [0.1, -0.3], [-1.0, -0.9], [0.0, 1.2]];
        vec![
            at(Outline::Disc { radius: outer }),
            at(Outline::Annulus { inner, outer }),
            Aperture::turned_rectangle(0.9, 0.5, 0.0, centre),
            Aperture::turned_rectangle(0.9, 0.5, 0.4, centre),
            at(Outline::Polygon { corners: arrow }),
            Aperture::disc(1.2).blocked(Aperture::disc(0.4)),
            at(Outline::Disc { radius: outer }).blocked(bar),
        ]
    }

    /// Cells of a grid over all of the aperture, cut or not, with sides of two lengths.
    fn cells(n: usize) -> impl Iterator<Item = Cell> {
        let (hx, hy) = (3.2 / n as f64, 3.0 / n as f64);
        (0..n * n).map(move |k| {
            let (x, y) = (-1.6 + (k % n) as f64 * hx, -1.5 + (k / n) as f64 * hy);
            Cell {
                x: [x, x + hx],
                y: [y, y + hy],
                counts: [4, 5],
            }
        })
    }

    /// The lowest moment is the open area, which [`Aperture::coverage`] knows by other formulas.
    #[test]
    fn lowest_moment_is_the_open_area() {
        for (aperture, n) in apertures().iter().flat_map(|a| [1, 7, 16].map(|n| (a, n))) {
            for cell in cells(n) {
                let share = aperture.coverage(cell.x[0], cell.x[1], cell.y[0], cell.y[1]);
                let found = 0.25 * open_moments(aperture, &cell)[[0, 0]];
                assert!(
                    (found - share).abs() < 2e-5,
                    "{aperture:?} {cell:?}: {found} {share}"
                );
            }
        }
    }

    /// All moments against a fine midpoint sum over the points inside.
    #[test]
    fn moments_match_counted_points_slow() {
        let fine = 400;
        let place = |k: usize| (2 * k + 1) as f64 / fine as f64 - 1.0;
        for (aperture, cell) in apertures()
            .iter()
            .flat_map(|a| cells(5).map(move |c| (a, c)))
        {
            let found = open_moments(aperture, &cell);
            let mut counted = ndarray::Array2::<f64>::zeros(found.dim());
            for (j, i) in (0..fine * fine).map(|k| (k / fine, k % fine)) {
                let t = [place(i), place(j)];
                let at = |[low, high]: [f64; 2], t: f64| 0.5 * (low + high + t * (high - low));
                if aperture.contains(at(cell.x, t[0]), at(cell.y, t[1])) {
                    let (px, py) = (legendre(t[0], 4), legendre(t[1], 5));
                    for ((b, a), sum) in counted.indexed_iter_mut() {
                        *sum += px[a] * py[b] * 4.0 / (fine * fine) as f64;
                    }
                }
            }
            let worst = (&found - &counted)
                .iter()
                .fold(0.0, |w: f64, d| w.max(d.abs()));
            assert!(worst < 6e-3, "{aperture:?} {cell:?}: {worst:e}");
        }
    }
}
