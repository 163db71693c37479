//! Integrals of polynomials over the part of a cell that an aperture leaves open.
//!
//! By Green's theorem ∫∫ P(x)·Q(y) over the open part of a box is the integral of P(x)·R(y) along its outline,
//! R(y) being ∫ Q from the bottom of the box, with y cut off at the bottom and the top and x at the sides.
//! Straight sides and arcs are exact to rounding. Where an aperture and its obstruction cut the same box, the
//! box is quartered.

use ndarray::Array2;

use crate::optics::aperture::{Aperture, Outline};
use crate::optics::polygon;

/// A cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Its lowest and highest x, in mm.
    pub x: [f64; 2],
    /// Its lowest and highest y, in mm.
    pub y: [f64; 2],
}

/// A part of the cell along x and y, in units that run from −1 to 1 over the cell.
type Part = [[f64; 2]; 2];

/// Times that a part is quartered where an aperture and its obstruction cut it.
const QUARTERINGS: u32 = 6;

/// The longest arc that one rule of Gauss nodes integrates, in rad.
const LONGEST_ARC: f64 = 0.8;

/// Integrates Legendre polynomials over the open parts of cells. Its memory serves one cell after another.
pub(crate) struct OpenMoments {
    /// Nodes on [−1, 1] and weights of the rule along a piece of an edge.
    rule: Vec<(f64, f64)>,
    /// The moments of a cell while they are added up, indexed [b, a].
    total: Array2<f64>,
    /// Polynomials along x at a point, integrals of those along y up to it, and up to the bottom of a part.
    along_x: Vec<f64>,
    along_y: Vec<f64>,
    bottom: Vec<f64>,
    /// Where an edge crosses the sides of a part.
    breaks: Vec<f64>,
}

impl OpenMoments {
    /// For so many polynomials along x and y.
    pub(crate) fn new([nx, ny]: [usize; 2]) -> Self {
        Self {
            rule: gauss_rule(nx + ny + 2),
            total: Array2::zeros((ny, nx)),
            along_x: vec![0.0; nx],
            along_y: vec![0.0; ny],
            bottom: vec![0.0; ny],
            breaks: Vec::new(),
        }
    }

    /// The integrals of P_a(ξ)·P_b(η) over the open part of a cell, indexed [b, a]: Legendre polynomials of coordinates that
    /// run from −1 to 1 over the cell.
    pub(crate) fn over(&mut self, aperture: &Aperture, cell: &Cell) -> &Array2<f64> {
        self.total.fill(0.0);
        self.add_open(aperture, cell, [[-1.0, 1.0]; 2], 1.0, QUARTERINGS);
        &self.total
    }

    /// Adds the moments of the open part of a part of the cell, times `sign`.
    fn add_open(
        &mut self,
        aperture: &Aperture,
        cell: &Cell,
        part: Part,
        sign: f64,
        quarterings: u32,
    ) {
        let Outline::Blocked { open, by } = &aperture.outline else {
            return for_each_edge(aperture, cell, |edge| self.add_edge(&edge, part, sign));
        };
        // Both in the coordinates of the cell.
        let placed = |part: &Aperture| Aperture {
            centre: [0, 1].map(|i| part.centre[i] + aperture.centre[i]),
            ..part.clone()
        };
        let (open, by) = (&placed(open), &placed(by));
        let (whole, covered) = (share(open, cell, part), share(by, cell, part));
        if whole == 0.0 || covered == 1.0 {
            return;
        }
        if covered == 0.0 {
            return self.add_open(open, cell, part, sign, quarterings);
        }
        if whole == 1.0 {
            self.add_box(part, sign);
            return self.add_open(by, cell, part, -sign, quarterings);
        }
        if quarterings == 0 {
            return self.add_box(part, sign * whole * (1.0 - covered));
        }
        let halves =
            part.map(|[low, high]| [[low, 0.5 * (low + high)], [0.5 * (low + high), high]]);
        for quarter in halves[0].iter().flat_map(|x| halves[1].map(|y| [*x, y])) {
            self.add_open(aperture, cell, quarter, sign, quarterings - 1);
        }
    }

    /// Adds the moments of a part of the cell, all of it open, times `weight`.
    fn add_box(&mut self, [x, y]: Part, weight: f64) {
        let along = |[low, high]: [f64; 2], count: usize| {
            let mut ends = [low, high].map(|_| vec![0.0; count]);
            legendre_integrals(low, &mut ends[0]);
            legendre_integrals(high, &mut ends[1]);
            let both = ends[1].iter().zip(&ends[0]);
            both.map(|(high, low)| high - low).collect::<Vec<f64>>()
        };
        let (along_x, along_y) = (along(x, self.along_x.len()), along(y, self.along_y.len()));
        add_product(&mut self.total, &along_x, along_y.into_iter(), weight);
    }

    /// Adds −∫ P_a(x)·R_b(y) dx along an edge, as far as it lies between the sides of a part and above its
    /// bottom.
    fn add_edge(&mut self, edge: &Edge, [x, y]: Part, sign: f64) {
        edge.find_breaks([x, y], &mut self.breaks);
        legendre_integrals(y[0], &mut self.bottom);
        for ends in self.breaks.windows(2) {
            let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
            let ([middle_x, middle_y], _) = edge.at(middle);
            if half <= 0.0 || middle_x < x[0] || middle_x > x[1] || middle_y < y[0] {
                continue;
            }
            // A long piece is integrated in parts.
            let pieces = edge.pieces(2.0 * half);
            let half = half / pieces;
            for piece in 0..pieces as usize {
                let middle = ends[0] + (2 * piece + 1) as f64 * half;
                for (node, weight) in &self.rule {
                    let ([px, py], rate) = edge.at(middle + half * node);
                    legendre(px, &mut self.along_x);
                    legendre_integrals(py.clamp(y[0], y[1]), &mut self.along_y);
                    add_product(
                        &mut self.total,
                        &self.along_x,
                        self.along_y
                            .iter()
                            .zip(&self.bottom)
                            .map(|(y, bottom)| y - bottom),
                        -sign * half * weight * rate,
                    );
                }
            }
        }
    }
}

/// Adds the products of numbers along x and y, times `weight`.
fn add_product(
    total: &mut Array2<f64>,
    along_x: &[f64],
    along_y: impl Iterator<Item = f64>,
    weight: f64,
) {
    for (mut row, along_y) in total.rows_mut().into_iter().zip(along_y) {
        let each = row.iter_mut().zip(along_x);
        each.for_each(|(sum, along_x)| *sum += weight * along_x * along_y);
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

/// Visits the edges of an aperture that is no obstructed one; an open aperture has the sides of the cell.
fn for_each_edge(aperture: &Aperture, cell: &Cell, mut visit: impl FnMut(Edge)) {
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
    let box_corners = |x: f64, y: f64| [[-x, -y], [x, -y], [x, y], [-x, y]];
    match &aperture.outline {
        Outline::Disc { radius } => visit(circle(*radius, 1.0)),
        Outline::Annulus { inner, outer } => {
            visit(circle(*outer, 1.0));
            visit(circle(*inner, -1.0));
        }
        Outline::Rectangle { half_x, half_y } => {
            sides_of(&box_corners(*half_x, *half_y), &place).for_each(visit);
        }
        Outline::Polygon { corners } => sides_of(corners, &place).for_each(visit),
        Outline::Open | Outline::Blocked { .. } => {
            sides_of(&box_corners(1.0, 1.0), &|p| p).for_each(visit);
        }
    }
}

/// The sides of a polygon, the open side on the left.
fn sides_of<'a>(
    corners: &'a [[f64; 2]],
    place: &'a dyn Fn([f64; 2]) -> [f64; 2],
) -> impl Iterator<Item = Edge> + 'a {
    let clockwise = polygon::area(corners) < 0.0;
    let oriented = move |[a, b]: [[f64; 2]; 2]| if clockwise { [b, a] } else { [a, b] };
    polygon::sides(corners).map(move |side| Edge::Side(oriented(side).map(place)))
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

    /// Into how many pieces a part of it is divided for one rule of Gauss nodes each; `length` in its parameter.
    fn pieces(&self, length: f64) -> f64 {
        match self {
            Self::Side(_) => 1.0,
            Self::Circle { .. } => (length / LONGEST_ARC).ceil(),
        }
    }

    /// Finds parameters in order, from its beginning to its end, between which it crosses no side of a part.
    fn find_breaks(&self, part: Part, breaks: &mut Vec<f64>) {
        breaks.clear();
        match self {
            Self::Side([a, b]) => {
                let crossing = |i: usize, level: f64| (level - a[i]) / (b[i] - a[i]);
                let all = [(0, 0), (0, 1), (1, 0), (1, 1)];
                let inner = all.map(|(i, end)| crossing(i, part[i][end]));
                breaks.extend(inner.into_iter().filter(|t| 0.0 < *t && *t < 1.0));
                breaks.extend([0.0, 1.0]);
            }
            Self::Circle {
                centre,
                radii,
                turn,
            } => add_circle_breaks(*centre, *radii, *turn, part, breaks),
        };
        breaks.sort_by(f64::total_cmp);
    }
}

/// Adds where a circle crosses the sides of a part, as parameters between 0 and 2π, and these ends.
fn add_circle_breaks(
    centre: [f64; 2],
    radii: [f64; 2],
    turn: f64,
    part: Part,
    breaks: &mut Vec<f64>,
) {
    let level = |i: usize, end: usize| ((part[i][end] - centre[i]) / radii[i]).clamp(-1.0, 1.0);
    let upright = [level(0, 0).acos(), level(0, 1).acos()];
    let level_ones = [level(1, 0).asin(), level(1, 1).asin()];
    let both = upright.into_iter().flat_map(|t| [t, -t]);
    let others = level_ones
        .into_iter()
        .flat_map(|t| [t, std::f64::consts::PI - t]);
    let crossings = both.chain(others);
    breaks.extend(crossings.map(|t| (turn * t).rem_euclid(std::f64::consts::TAU)));
    breaks.extend([0.0, std::f64::consts::TAU]);
}

/// Nodes on [−1, 1] and weights of the Gauss–Legendre rule.
fn gauss_rule(count: usize) -> Vec<(f64, f64)> {
    let count = std::num::NonZero::new(count).unwrap_or(std::num::NonZero::<usize>::MIN);
    gauss_quad::GaussLegendre::new(count).into_iter().collect()
}

/// Writes the first Legendre polynomials at a point.
pub(crate) fn legendre(t: f64, values: &mut [f64]) {
    for n in 0..values.len() {
        let n_real = n as f64;
        values[n] = match n {
            0 => 1.0,
            1 => t,
            _ => {
                ((2.0 * n_real - 1.0) * t * values[n - 1] - (n_real - 1.0) * values[n - 2]) / n_real
            }
        };
    }
}

/// Writes the integrals of the first Legendre polynomials from −1 to a point.
fn legendre_integrals(t: f64, integrals: &mut [f64]) {
    // (2n + 1)·∫Pₙ = Pₙ₊₁ − Pₙ₋₁
    let (mut before, mut here) = (0.0, 1.0);
    for (n, integral) in integrals.iter_mut().enumerate() {
        let n = n as f64;
        let next = ((2.0 * n + 1.0) * t * here - n * before) / (n + 1.0);
        *integral = match n {
            0.0 => t + 1.0,
            _ => (next - before) / (2.0 * n + 1.0),
        };
        (before, here) = (here, next);
    }
}

#[cfg(test)]
mod tests {
    use crate::optics::aperture::{Aperture, Outline};
    use crate::optics::moments::{Cell, OpenMoments, legendre};

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
            }
        })
    }

    /// The lowest moment is the open area, which [`Aperture::coverage`] knows by other formulas.
    #[test]
    fn lowest_moment_is_the_open_area() {
        let mut moments = OpenMoments::new([4, 5]);
        for (aperture, n) in apertures().iter().flat_map(|a| [1, 7, 16].map(|n| (a, n))) {
            for cell in cells(n) {
                let share = aperture.coverage(cell.x[0], cell.x[1], cell.y[0], cell.y[1]);
                let found = 0.25 * moments.over(aperture, &cell)[[0, 0]];
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
        let mut moments = OpenMoments::new([4, 5]);
        let place = |k: usize| (2 * k + 1) as f64 / fine as f64 - 1.0;
        for (aperture, cell) in apertures()
            .iter()
            .flat_map(|a| cells(5).map(move |c| (a, c)))
        {
            let found = moments.over(aperture, &cell);
            let mut counted = ndarray::Array2::<f64>::zeros(found.dim());
            for (j, i) in (0..fine * fine).map(|k| (k / fine, k % fine)) {
                let t = [place(i), place(j)];
                let at = |[low, high]: [f64; 2], t: f64| 0.5 * (low + high + t * (high - low));
                if aperture.contains(at(cell.x, t[0]), at(cell.y, t[1])) {
                    let (mut px, mut py) = ([0.0; 4], [0.0; 5]);
                    legendre(t[0], &mut px);
                    legendre(t[1], &mut py);
                    for ((b, a), sum) in counted.indexed_iter_mut() {
                        *sum += px[a] * py[b] * 4.0 / (fine * fine) as f64;
                    }
                }
            }
            let worst = (found - &counted)
                .iter()
                .fold(0.0, |w: f64, d| w.max(d.abs()));
            assert!(worst < 6e-3, "{aperture:?} {cell:?}: {worst:e}");
        }
    }
}
