//! A search with a coarse set of rays: which directions lead to the target, and what the train does to them.

use crate::engine::ray_block::hop_rays::{HopRays, Jacobian, JacobianScratch};
use crate::engine::trace::bounding_sphere::{BoundingSphere, SeenDirections};
use crate::engine::trace::ray_trace::Landing;
use crate::math::lanes::LANES;
use crate::optics::ray::Loss;
use crate::optics::surface::{Surface, without_edges};
use crate::optics::system::Hop;

/// A ray of the search with its Jacobian ∂(s, p′)/∂(x, p).
#[derive(Clone, Copy, Debug)]
pub(crate) struct SearchRay {
    /// Where it starts, in mm on the first screen.
    pub at: [f64; 2],
    /// Its optical direction cosines there.
    pub p: [f64; 2],
    /// The area of directions that it represents.
    pub area: f64,
    /// Where it lands.
    pub landing: Landing,
    /// Rows (s_x, s_y, p′_x, p′_y), columns (x, y, p_x, p_y).
    pub jacobian: [[f64; 4]; 4],
}

/// What a search is for. Cells that cannot add to it are not divided.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum SearchGoal {
    /// All rays that reach the target.
    #[default]
    Rays,
    /// Those that land beside it, and the bounds of all directions.
    Rim,
    /// The bounds only, where they lie within these.
    Bounds([f64; 4]),
}

/// No limits to the directions.
pub(crate) const ALL: [f64; 4] = [
    f64::NEG_INFINITY,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::INFINITY,
];

/// The rays that reach a target.
#[derive(Clone, Debug, Default)]
pub(crate) struct DirectionSearch {
    /// What it is for.
    goal: SearchGoal,
    /// Rays that land inside the target.
    pub rays: Vec<SearchRay>,
    /// Rays that land beside it, close enough for their footprints to matter.
    pub rim: Vec<SearchRay>,
    /// Bounds of the directions that may reach the target: `[p_x low, p_x high, p_y low, p_y high]`;
    /// low above high when none does.
    pub band: [f64; 4],
    /// Rays traced.
    pub traced: usize,
    /// Lost rays by cause, as found.
    pub lost: Vec<(Loss, usize)>,
    /// Whether a cell may lead to the target that was too small to be divided.
    unresolved: bool,
}

/// Positions of the search along each axis.
const POSITIONS: usize = 5;

/// Cells are accepted when no larger than this share of the index.
const COARSEST: f64 = 0.125;

/// Cells whose ray is lost are divided down to this share of the index.
const FINEST_LOST: f64 = 1.0 / 64.0;

/// From this share of the index on, a ray that an edge stops is traced without edges: its cell is divided where
/// its light would land on the target, and dropped elsewhere.
const CLIPPED: f64 = 1.0 / 32.0;

/// Such cells are divided down to this share of the index: there are the more of them along an edge, the smaller they are.
const FINEST_CLIPPED: f64 = 1.0 / 512.0;

/// Deepest division of the square of directions: 1.2e-4 wide.
const DEPTH: usize = 14;

/// The same where no ray is found and cells of [`DEPTH`] may lead to the target: a sensor of 30 µm in the focus of 0.5 m is seen
/// in fewer directions than one of them has.
const DEEPER: usize = 22;

/// Most rays that a search keeps from one point. Where landings spread without bound all along a curve of directions,
/// the division would keep hundreds of thousands; it is then done again with fewer levels. Usual searches keep hundreds.
const MOST_RAYS: usize = 4096;

/// Directions closer to grazing are left out: their landing spreads without bound.
const STEEPEST: f64 = 0.995;

/// A linear landing estimate is trusted to this factor.
const SAFETY: f64 = 1.5;

/// A square cell of directions.
#[derive(Clone, Copy)]
struct Cell {
    centre: [f64; 2],
    half: f64,
    /// How often it may still be divided.
    left: usize,
}

/// Seeks the directions that lead from the box `from` on the first screen to the box `to` on the second,
/// dilated by `margin` mm; boxes are `[x_min, x_max, y_min, y_max]` in mm.
///
/// The square of all directions is divided like a quadtree wherever a cell's rays, by their Jacobian,
/// may land on the target, until their landings spread little against it. It ends early where they lead to nothing new.
pub(crate) fn search_directions(
    hop: &Hop,
    from: [f64; 4],
    to: [f64; 4],
    margin: [f64; 2],
    goal: SearchGoal,
) -> DirectionSearch {
    let searched = SearchedHop::new(hop);
    let seek = |depth: usize| {
        let mut search = DirectionSearch::empty(goal);
        for j in 0..POSITIONS {
            for i in 0..POSITIONS {
                let place = |a: usize, i: usize| {
                    let t = i as f64 / (POSITIONS - 1) as f64;
                    from[2 * a] + (from[2 * a + 1] - from[2 * a]) * t
                };
                search.seek(
                    depth,
                    &searched.from([place(0, i), place(1, j)]),
                    to,
                    margin,
                );
            }
        }
        search
    };
    let search = seek(DEPTH);
    match search.is_dark() && search.unresolved {
        true => seek(DEEPER),
        false => search,
    }
}

/// The directions `[p_x low, p_x high, p_y low, p_y high]` that lead from one point to the box `to`,
/// dilated by `margin` mm; nothing when none does. Directions outside of `limits` are not sought.
pub(crate) fn reach(
    hop: &Hop,
    at: [f64; 2],
    to: [f64; 4],
    margin: [f64; 2],
    limits: [f64; 4],
) -> Option<[f64; 4]> {
    let searched = SearchedHop::new(hop);
    let seek = |depth: usize| {
        let mut search = DirectionSearch::empty(SearchGoal::Bounds(limits));
        search.seek(depth, &searched.from(at), to, margin);
        search
    };
    let mut search = seek(DEPTH);
    if search.has_no_band() && search.unresolved {
        search = seek(DEEPER);
    }
    (!search.has_no_band()).then_some(search.band)
}

/// A hop and what its searches share.
struct SearchedHop<'a> {
    hop: &'a Hop<'a>,
    /// The same, made ready for many rays.
    rays: HopRays<'a>,
    /// Its train without the edges of surfaces.
    open: Vec<Surface>,
    /// A sphere about its first surface, which all rays have to meet.
    first: Option<BoundingSphere>,
}

impl<'a> SearchedHop<'a> {
    fn new(hop: &'a Hop<'a>) -> Self {
        Self {
            hop,
            rays: HopRays::new(hop),
            open: without_edges(hop.train),
            first: hop.train.first().and_then(BoundingSphere::of),
        }
    }

    /// From one point.
    fn from(&'a self, at: [f64; 2]) -> SearchedPoint<'a> {
        SearchedPoint {
            hop: self.hop,
            rays: &self.rays,
            open: Hop {
                train: &self.open,
                ..*self.hop
            },
            at,
            seen: (self.first).and_then(|first| first.seen_from(self.hop.from, at)),
        }
    }
}

/// A point from which directions are sought.
struct SearchedPoint<'a> {
    hop: &'a Hop<'a>,
    rays: &'a HopRays<'a>,
    /// The hop without the edges of its surfaces.
    open: Hop<'a>,
    /// Where it is on the first screen.
    at: [f64; 2],
    /// The directions of the first surface, if rays along others miss it.
    seen: Option<SeenDirections>,
}

/// Where the central ray of a cell lands, with its Jacobian, or how it is lost.
type CentralRay = Result<(Landing, Jacobian), Loss>;

impl SearchedPoint<'_> {
    /// Whether all rays of a cell pass beside the first surface.
    fn misses(&self, cell: Cell) -> bool {
        let misses = |seen: &SeenDirections| seen.misses(cell.centre, cell.half);
        self.seen.as_ref().is_some_and(misses)
    }
}

impl Cell {
    /// Whether all its directions are within a band.
    fn is_within(&self, band: &[f64; 4]) -> bool {
        (0..2).all(|a| {
            let (low, high) = (self.centre[a] - self.half, self.centre[a] + self.half);
            low >= band[2 * a] && high <= band[2 * a + 1]
        })
    }

    /// Its four quarters.
    fn quarters(&self) -> [Self; 4] {
        let (half, left) = (0.5 * self.half, self.left.saturating_sub(1));
        [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(|[x, y]| Self {
            centre: [self.centre[0] + x * half, self.centre[1] + y * half],
            half,
            left,
        })
    }

    /// Whether some of them are.
    fn meets(&self, band: &[f64; 4]) -> bool {
        (0..2).all(|a| {
            let (low, high) = (self.centre[a] - self.half, self.centre[a] + self.half);
            low <= band[2 * a + 1] && high >= band[2 * a]
        })
    }
}

/// Whether rays of a cell may pass the edge that stops its central ray, and land on the target: where that one would land
/// near it without edges, and the cell's landings spread. Where it is lost without edges too, as other cells are.
fn may_pass(open: &Hop, at: [f64; 2], cell: Cell, to: [f64; 4], margin: [f64; 2]) -> bool {
    let n = open.from.index_behind();
    let large = cell.half > FINEST_LOST * n;
    match open.jacobian(at, cell.centre) {
        Ok((landing, jacobian)) => {
            let landings = CellLanding::of(&landing, &jacobian, cell.half, to, margin);
            landings.reaches && (large || (!landings.fine && cell.half > FINEST_CLIPPED * n))
        }
        Err(_) => large,
    }
}

/// Where the rays of a cell land, to first order about its central ray.
struct CellLanding {
    /// Some may land on the target or its margin.
    reaches: bool,
    /// The central one lands on the target.
    inside: bool,
    /// All of them do.
    all_inside: bool,
    /// The central one lands no farther from the target than that is wide.
    near: bool,
    /// Their landings spread little.
    fine: bool,
}

impl CellLanding {
    fn of(
        landing: &Landing,
        jacobian: &[[f64; 4]; 4],
        half: f64,
        to: [f64; 4],
        margin: [f64; 2],
    ) -> Self {
        let mut landings = Self {
            reaches: true,
            inside: true,
            all_inside: true,
            near: true,
            fine: true,
        };
        for a in 0..2 {
            // How far the cell's rays land from its central ray.
            let slope = jacobian[a][2].abs() + jacobian[a][3].abs();
            let spread = SAFETY * half * slope;
            let (low, high) = (to[2 * a], to[2 * a + 1]);
            let s = landing.at[a];
            landings.reaches &= s + spread >= low - margin[a] && s - spread <= high + margin[a];
            landings.inside &= s >= low && s <= high;
            landings.all_inside &= s - spread >= low && s + spread <= high;
            landings.near &= s + margin[a] >= 2.0 * low - high && s - margin[a] <= 2.0 * high - low;
            landings.fine &= spread <= 0.2 * (high - low) + 0.25 * margin[a];
        }
        landings
    }
}

impl DirectionSearch {
    fn empty(goal: SearchGoal) -> Self {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        Self {
            goal,
            band: [none[0], none[1], none[0], none[1]],
            ..Self::default()
        }
    }

    /// Divides the square of directions from one point, less deeply where too many rays would be kept.
    fn seek(&mut self, deepest: usize, point: &SearchedPoint, to: [f64; 4], margin: [f64; 2]) {
        for depth in (0..=deepest).rev() {
            // What lies within the bounds that are known need not be sought again.
            let mut found = Self {
                band: self.band,
                ..Self::empty(self.goal)
            };
            if found.seek_to(depth, point, to, margin) {
                self.merge(found);
                return;
            }
        }
    }

    /// Divides the square of directions from one point down to a depth; false when too many rays would be kept.
    fn seek_to(
        &mut self,
        depth: usize,
        point: &SearchedPoint,
        to: [f64; 4],
        margin: [f64; 2],
    ) -> bool {
        let whole = Cell {
            centre: [0.0, 0.0],
            half: point.hop.from.index_behind(),
            left: depth,
        };
        let mut stack = vec![(whole, None)];
        let mut scratch = JacobianScratch::new();
        while let Some((cell, ray)) = stack.pop() {
            if !self.is_sought(point, cell) {
                continue;
            }
            self.traced += 1;
            if point.misses(cell) {
                self.count_lost(Loss::Clipped, 1);
                continue;
            }
            let ray = ray.unwrap_or_else(|| self.look_ahead(point, cell, &mut stack, &mut scratch));
            if !self.is_divided(point, cell, ray, (to, margin)) {
                continue;
            }
            if self.rays.len() + self.rim.len() > MOST_RAYS {
                return false;
            }
            stack.extend(cell.quarters().map(|quarter| (quarter, None)));
        }
        true
    }

    /// Traces the central ray of a cell, and with it those of the cells that come next: as many as go together.
    fn look_ahead(
        &self,
        point: &SearchedPoint,
        cell: Cell,
        stack: &mut [(Cell, Option<CentralRay>)],
        scratch: &mut JacobianScratch,
    ) -> CentralRay {
        let start = |cell: &Cell| [point.at[0], point.at[1], cell.centre[0], cell.centre[1]];
        let next = |(cell, ray): &&mut (Cell, Option<CentralRay>)| {
            ray.is_none() && self.is_sought(point, *cell) && !point.misses(*cell)
        };
        let mut next: Vec<_> = { stack.iter_mut().rev() }
            .filter(next)
            .take(LANES - 1)
            .collect();
        let mut starts = vec![start(&cell)];
        starts.extend(next.iter().map(|(cell, _)| start(cell)));
        let mut found = Vec::new();
        point.rays.jacobians_into(&starts, scratch, &mut found);
        let mut found = found.into_iter();
        let own = found.next().unwrap_or(Err(Loss::Missed));
        for ((_, ray), found) in next.iter_mut().zip(found) {
            *ray = Some(found);
        }
        own
    }

    /// Adds what was found from another point.
    fn merge(&mut self, other: Self) {
        self.rays.extend(other.rays);
        self.rim.extend(other.rim);
        for a in [0, 2] {
            self.band[a] = self.band[a].min(other.band[a]);
            self.band[a + 1] = self.band[a + 1].max(other.band[a + 1]);
        }
        self.traced += other.traced;
        self.unresolved |= other.unresolved;
        for (loss, count) in other.lost {
            self.count_lost(loss, count);
        }
    }

    fn count_lost(&mut self, loss: Loss, count: usize) {
        match self.lost.iter_mut().find(|(cause, _)| *cause == loss) {
            Some((_, known)) => *known += count,
            None => self.lost.push((loss, count)),
        }
    }

    /// Whether a cell may add to what is sought.
    fn is_sought(&self, point: &SearchedPoint, cell: Cell) -> bool {
        // Cells wholly evanescent are dropped, those that cross the rim divided a little.
        let n = point.hop.from.index_behind();
        let nearest = cell.centre.map(|c| (c.abs() - cell.half).max(0.0));
        if nearest[0].hypot(nearest[1]) >= STEEPEST * n {
            return false;
        }
        match self.goal {
            SearchGoal::Bounds(limits) => !cell.is_within(&self.band) && cell.meets(&limits),
            SearchGoal::Rays | SearchGoal::Rim => true,
        }
    }

    /// Looks at one cell with its central ray; true when it must be divided.
    fn is_divided(
        &mut self,
        point: &SearchedPoint,
        cell: Cell,
        ray: CentralRay,
        (to, margin): ([f64; 4], [f64; 2]),
    ) -> bool {
        let (at, n) = (point.at, point.hop.from.index_behind());
        let (landing, jacobian) = match ray {
            Ok(found) => found,
            Err(loss) => {
                self.count_lost(loss, 1);
                return match loss {
                    Loss::Clipped if cell.half <= CLIPPED * n => {
                        may_pass(&point.open, at, cell, to, margin)
                    }
                    _ => cell.half > FINEST_LOST * n,
                };
            }
        };

        let ray = SearchRay {
            at,
            p: cell.centre,
            area: 4.0 * cell.half * cell.half,
            landing,
            jacobian,
        };
        self.sort(ray, cell, n, to, margin)
    }

    /// Keeps, divides or drops a cell whose central ray has landed.
    fn sort(&mut self, ray: SearchRay, cell: Cell, n: f64, to: [f64; 4], margin: [f64; 2]) -> bool {
        let CellLanding {
            reaches,
            inside,
            all_inside,
            near,
            fine,
        } = CellLanding::of(&ray.landing, &ray.jacobian, cell.half, to, margin);
        let fine = fine && cell.half <= COARSEST * n;
        if !reaches {
            return cell.half > COARSEST * n;
        }
        if all_inside && self.goal == SearchGoal::Rim && cell.is_within(&self.band) {
            return false;
        }
        if !fine && cell.left > 0 {
            return true;
        }
        self.unresolved |= !fine;
        if !fine && !near {
            return false;
        }

        // A cell of its own: its directions belong to the band.
        for a in 0..2 {
            self.band[2 * a] = self.band[2 * a].min(cell.centre[a] - cell.half);
            self.band[2 * a + 1] = self.band[2 * a + 1].max(cell.centre[a] + cell.half);
        }
        if inside {
            self.rays.push(ray);
        } else {
            self.rim.push(ray);
        }
        false
    }

    /// Whether no direction may lead to the target.
    fn has_no_band(&self) -> bool {
        self.band[0] > self.band[1]
    }

    /// Whether no ray of the search reaches the target.
    pub(crate) fn is_dark(&self) -> bool {
        self.rays.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use crate::engine::trace::direction_search::{ALL, SearchGoal, reach, search_directions};
    use crate::fixtures::parts::{on_axis, open_screen};
    use crate::optics::aperture::Aperture;
    use crate::optics::refraction::{Coating, Interface};
    use crate::optics::shape::Shape;
    use crate::optics::surface::Surface;
    use crate::optics::system::Hop;

    /// In free space, with an aperture of 25.3 mm radius half-way to a target of 2 mm straight ahead of a point 0.3 mm inside
    /// its edge. Rays of slope up to 0.003 pass, and the target is seen up to 0.005.
    #[test]
    fn directions_beside_an_edge_are_found() {
        let aperture = Surface {
            frame: on_axis(100.0),
            shape: Shape::Plane,
            aperture: Aperture::disc(25.3),
            interface: Interface::Refract,
            coating: Coating::Unit,
            index: [1.0, 1.0],
        };
        let (from, to) = (open_screen(on_axis(0.0)), open_screen(on_axis(200.0)));
        let hop = Hop {
            wavelength: 0.5e-3,
            from: &from,
            train: &[aperture],
            to: &to,
        };
        let target = [24.0, 26.0, -1.0, 1.0];
        let [x0, x1, y0, y1] = reach(&hop, [25.0, 0.0], target, [0.0; 2], ALL).unwrap();
        assert!((-0.007..=-0.005).contains(&x0), "{x0}");
        assert!((0.0029..=0.005).contains(&x1), "{x1}");
        assert!((-0.007..=-0.005).contains(&y0) && (0.005..=0.007).contains(&y1));
    }

    /// A target of 10 µm at 0.5 m is seen within 2e-5, far less than the smallest cells of a usual search.
    #[test]
    fn a_small_target_far_away_is_found() {
        let (from, to) = (open_screen(on_axis(0.0)), open_screen(on_axis(500.0)));
        let hop = Hop {
            wavelength: 0.5e-3,
            from: &from,
            train: &[],
            to: &to,
        };
        let target = [19.995, 20.005, -0.005, 0.005];
        let [x0, x1, y0, y1] = reach(&hop, [3.0, 0.0], target, [0.0; 2], ALL).unwrap();
        // The sine of the direction to either edge.
        let sine = |edge: f64| (edge - 3.0) / f64::hypot(edge - 3.0, 500.0);
        let [low, high] = [sine(target[0]), sine(target[1])];
        assert!(
            x0 <= low && x1 >= high && x1 - x0 < 2.0 * (high - low),
            "{x0} {x1}"
        );
        assert!(y0 <= -1e-5 && y1 >= 1e-5 && y1 - y0 < 4e-5, "{y0} {y1}");
        let found = search_directions(
            &hop,
            [2.9, 3.1, -0.1, 0.1],
            target,
            [0.0; 2],
            SearchGoal::Rays,
        );
        assert!(!found.is_dark());
    }
}
