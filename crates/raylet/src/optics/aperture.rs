//! Clear apertures and the share of a small cell that lies inside them.

use crate::optics::phase::placement::Placement;
use crate::optics::polygon;

/// The open part of a surface or screen, in its local x, y plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Aperture {
    /// Its outline.
    pub outline: Outline,
    /// Its centre, in mm.
    pub centre: [f64; 2],
}

/// The outline of an aperture; lengths in mm.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// No edge at all.
    Open,
    /// Within a circle.
    Disc {
        /// Radius of the circle.
        radius: f64,
    },
    /// Between two circles.
    Annulus {
        /// Radius of the obstruction.
        inner: f64,
        /// Radius of the aperture.
        outer: f64,
    },
    /// Within a rectangle along x and y.
    Rectangle {
        /// Half the width along x.
        half_x: f64,
        /// Half the height along y.
        half_y: f64,
    },
    /// Within a polygon whose sides do not cross.
    Polygon {
        /// Its corners in order, seen from the centre.
        corners: Vec<[f64; 2]>,
    },
    /// What one aperture leaves open of another.
    Blocked {
        /// The aperture.
        open: Box<Aperture>,
        /// The obstruction; only its part inside the aperture matters.
        by: Box<Aperture>,
    },
}

/// Points along the edge of an aperture, and intervals along each axis of the lattice inside.
const RIM: usize = 256;
const LATTICE: usize = 64;

/// Slopes of the depth are differences over this part of a width.
const SLOPE_STEP: f64 = 0.01;

/// Times a cell that both an aperture and its obstruction cut is divided into quarters.
const QUARTERINGS: u32 = 8;

impl Aperture {
    /// An aperture without edge.
    pub const OPEN: Aperture = Aperture {
        outline: Outline::Open,
        centre: [0.0, 0.0],
    };

    /// A centred disc.
    pub fn disc(radius: f64) -> Self {
        Self {
            outline: Outline::Disc { radius },
            centre: [0.0, 0.0],
        }
    }

    /// A rectangle turned by `angle` rad from x towards y.
    pub fn turned_rectangle(half_x: f64, half_y: f64, angle: f64, centre: [f64; 2]) -> Self {
        if angle == 0.0 {
            let outline = Outline::Rectangle { half_x, half_y };
            return Self { outline, centre };
        }
        let (s, c) = angle.sin_cos();
        let signs = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
        let corner = |[i, j]: [f64; 2]| {
            let (x, y) = (i * half_x, j * half_y);
            [x * c - y * s, x * s + y * c]
        };
        let corners = signs.map(corner).to_vec();
        let outline = Outline::Polygon { corners };
        Self { outline, centre }
    }

    /// A regular polygon with corners on a circle, the first of them at `angle` rad from x towards y.
    pub fn regular_polygon(sides: usize, radius: f64, angle: f64, centre: [f64; 2]) -> Self {
        let corner = |i: usize| {
            let (s, c) = (angle + std::f64::consts::TAU * i as f64 / sides as f64).sin_cos();
            [radius * c, radius * s]
        };
        let corners = (0..sides).map(corner).collect();
        let outline = Outline::Polygon { corners };
        Self { outline, centre }
    }

    /// This aperture without what `by` covers.
    pub fn blocked(self, by: Aperture) -> Self {
        Self {
            outline: Outline::Blocked {
                open: Box::new(self),
                by: Box::new(by),
            },
            centre: [0.0, 0.0],
        }
    }

    /// The same opening on other axes of its plane.
    pub(crate) fn seen_from(&self, axes: Placement) -> Self {
        let [x, y] = self.centre;
        let centre = axes.inwards(x, y);
        match &self.outline {
            Outline::Open | Outline::Disc { .. } | Outline::Annulus { .. } => Self {
                outline: self.outline.clone(),
                centre,
            },
            Outline::Rectangle { half_x, half_y } => {
                Self::turned_rectangle(*half_x, *half_y, -axes.rotation, centre)
            }
            Outline::Polygon { corners } => {
                let turned = Placement {
                    centre: [0.0; 2],
                    ..axes
                };
                let corners = corners
                    .iter()
                    .map(|[x, y]| turned.inwards(*x, *y))
                    .collect();
                let outline = Outline::Polygon { corners };
                Self { outline, centre }
            }
            // Both parts are given from the centre of the whole.
            Outline::Blocked { open, by } => {
                let [open, by] = [open, by].map(|part| {
                    let centre = [0, 1].map(|a| part.centre[a] + self.centre[a]);
                    Self {
                        centre,
                        ..(**part).clone()
                    }
                    .seen_from(axes)
                });
                open.blocked(by)
            }
        }
    }

    /// Whether a point is inside.
    #[inline(always)]
    pub fn contains(&self, x: f64, y: f64) -> bool {
        let (x, y) = (x - self.centre[0], y - self.centre[1]);
        match &self.outline {
            Outline::Open => true,
            Outline::Disc { radius } => x * x + y * y <= radius * radius,
            Outline::Annulus { inner, outer } => {
                let square = x * x + y * y;
                inner * inner <= square && square <= outer * outer
            }
            Outline::Rectangle { half_x, half_y } => x.abs() <= *half_x && y.abs() <= *half_y,
            Outline::Polygon { corners } => polygon::contains(corners, x, y),
            Outline::Blocked { open, by } => open.contains(x, y) && !by.contains(x, y),
        }
    }

    /// How far inside the edge a point lies, in mm; negative outside, infinite without an edge. Beyond the
    /// corners of a rectangle, and where an obstruction meets the edge of its aperture, it is the larger of the
    /// distances to their sides.
    pub fn depth(&self, x: f64, y: f64) -> f64 {
        let (x, y) = (x - self.centre[0], y - self.centre[1]);
        match &self.outline {
            Outline::Open => f64::INFINITY,
            Outline::Disc { radius } => radius - x.hypot(y),
            Outline::Annulus { inner, outer } => (outer - x.hypot(y)).min(x.hypot(y) - inner),
            Outline::Rectangle { half_x, half_y } => (half_x - x.abs()).min(half_y - y.abs()),
            Outline::Polygon { corners } => {
                let sign = if polygon::contains(corners, x, y) {
                    1.0
                } else {
                    -1.0
                };
                sign * polygon::distance(corners, x, y)
            }
            Outline::Blocked { open, by } => open.depth(x, y).min(-by.depth(x, y)),
        }
    }

    /// The bounding box `[x_min, x_max, y_min, y_max]`, or nothing when there is no edge.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        let [x0, x1, y0, y1] = match &self.outline {
            Outline::Open => return None,
            Outline::Disc { radius } => around(*radius, *radius),
            Outline::Annulus { outer, .. } => around(*outer, *outer),
            Outline::Rectangle { half_x, half_y } => around(*half_x, *half_y),
            Outline::Polygon { corners } => {
                let nothing = [f64::INFINITY, -f64::INFINITY, f64::INFINITY, -f64::INFINITY];
                corners.iter().fold(nothing, |[x0, x1, y0, y1], [x, y]| {
                    [x0.min(*x), x1.max(*x), y0.min(*y), y1.max(*y)]
                })
            }
            Outline::Blocked { open, .. } => open.bounds()?,
        };
        let [x, y] = self.centre;
        Some([x + x0, x + x1, y + y0, y + y1])
    }

    /// A circle about everything inside: its centre and radius in mm, or nothing when there is no edge.
    pub(crate) fn circumcircle(&self) -> Option<([f64; 2], f64)> {
        let [x, y] = self.centre;
        match &self.outline {
            Outline::Disc { radius } | Outline::Annulus { outer: radius, .. } => {
                Some(([x, y], *radius))
            }
            Outline::Blocked { open, .. } => {
                let ([cx, cy], radius) = open.circumcircle()?;
                Some(([x + cx, y + cy], radius))
            }
            Outline::Open | Outline::Rectangle { .. } | Outline::Polygon { .. } => {
                let [x0, x1, y0, y1] = self.bounds()?;
                let centre = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
                Some((centre, 0.5 * (x1 - x0).hypot(y1 - y0)))
            }
        }
    }

    /// The slope of the depth inside the edge along x and y, from differences over a small part of a `width` in mm. It leads away
    /// from the edge.
    pub(crate) fn depth_slope(&self, [x, y]: [f64; 2], width: f64) -> [f64; 2] {
        let step = SLOPE_STEP * width;
        let rise = [
            self.depth(x + step, y) - self.depth(x - step, y),
            self.depth(x, y + step) - self.depth(x, y - step),
        ];
        rise.map(|rise| rise / (2.0 * step))
    }

    /// Points along the outer edge; none without an edge.
    pub(crate) fn rim(&self) -> Vec<[f64; 2]> {
        let circle = |radius: f64| Self::regular_polygon(RIM, radius, 0.0, self.centre).rim();
        let [cx, cy] = self.centre;
        match &self.outline {
            Outline::Open => Vec::new(),
            Outline::Disc { radius } | Outline::Annulus { outer: radius, .. } => circle(*radius),
            Outline::Rectangle { half_x, half_y } => {
                let (x, y) = (*half_x, *half_y);
                let corners = vec![[-x, -y], [x, -y], [x, y], [-x, y]];
                let outline = Outline::Polygon { corners };
                let centre = self.centre;
                Self { outline, centre }.rim()
            }
            Outline::Polygon { corners } => {
                // Its corners and points along its sides.
                let parts = RIM.div_ceil(corners.len());
                let next = corners.iter().cycle().skip(1);
                let side = |([ax, ay], [bx, by]): (&[f64; 2], &[f64; 2])| {
                    let (from, to) = ([cx + ax, cy + ay], [cx + bx, cy + by]);
                    (0..parts).map(move |i| {
                        let t = i as f64 / parts as f64;
                        [
                            from[0] + t * (to[0] - from[0]),
                            from[1] + t * (to[1] - from[1]),
                        ]
                    })
                };
                corners.iter().zip(next).flat_map(side).collect()
            }
            Outline::Blocked { open, .. } => open.rim(),
        }
    }

    /// A lattice of points inside; none without an edge.
    pub(crate) fn inside(&self) -> Vec<[f64; 2]> {
        let Some([x0, x1, y0, y1]) = self.bounds() else {
            return Vec::new();
        };
        let place = |low: f64, high: f64, i: usize| low + (high - low) * i as f64 / LATTICE as f64;
        let all = (0..=LATTICE).flat_map(|j| (0..=LATTICE).map(move |i| (i, j)));
        all.map(|(i, j)| [place(x0, x1, i), place(y0, y1, j)])
            .filter(|[x, y]| self.contains(*x, *y))
            .collect()
    }

    /// The share of the cell `[x0, x1] × [y0, y1]` that is open, between 0 and 1, by exact areas. In a
    /// cell that both an aperture and its obstruction cut it is good to some 1e-5.
    pub fn coverage(&self, x0: f64, x1: f64, y0: f64, y1: f64) -> f64 {
        self.share([x0, x1, y0, y1], QUARTERINGS)
    }

    /// The same with so many quarterings left, which obstructions of what is obstructed already share.
    fn share(&self, [x0, x1, y0, y1]: [f64; 4], quarterings: u32) -> f64 {
        let area = (x1 - x0) * (y1 - y0);
        let (x0, x1) = (x0 - self.centre[0], x1 - self.centre[0]);
        let (y0, y1) = (y0 - self.centre[1], y1 - self.centre[1]);
        let open = match &self.outline {
            Outline::Open => area,
            Outline::Disc { radius } => disc_area(*radius, x0, x1, y0, y1),
            Outline::Annulus { inner, outer } => {
                disc_area(*outer, x0, x1, y0, y1) - disc_area(*inner, x0, x1, y0, y1)
            }
            Outline::Rectangle { half_x, half_y } => {
                let span = |a: f64, b: f64, half: f64| (b.min(half) - a.max(-half)).max(0.0);
                span(x0, x1, *half_x) * span(y0, y1, *half_y)
            }
            Outline::Polygon { corners } => polygon::area_within(corners, x0, x1, y0, y1),
            Outline::Blocked { open, by } => {
                return left_open(open, by, [x0, x1, y0, y1], quarterings);
            }
        };
        (open / area).clamp(0.0, 1.0)
    }

    /// 0 and 1 as the share of a cell `[x0, x1, y0, y1]` that is open, and otherwise something between: without
    /// quarterings.
    pub(crate) fn rough_share(&self, cell: [f64; 4]) -> f64 {
        match &self.outline {
            Outline::Blocked { open, by } => {
                let ([x0, x1, y0, y1], [x, y]) = (cell, self.centre);
                let seen = [x0 - x, x1 - x, y0 - y, y1 - y];
                match (open.rough_share(seen), by.rough_share(seen)) {
                    (0.0, _) | (_, 1.0) => 0.0,
                    (open, 0.0) => open,
                    (1.0, by) => 1.0 - by,
                    _ => 0.5,
                }
            }
            _ => self.share(cell, 0),
        }
    }
}

/// The box of these half sizes about the origin.
fn around(half_x: f64, half_y: f64) -> [f64; 4] {
    [-half_x, half_x, -half_y, half_y]
}

/// The share of a cell that is open and not blocked: exact wherever at most one of the two has an edge,
/// and found by quartering the cell elsewhere.
fn left_open(open: &Aperture, by: &Aperture, cell: [f64; 4], quarterings: u32) -> f64 {
    // Rough shares are enough to decide whether to divide the cell: finding them by quartering at each quartering
    // took five hundred times as long for every obstruction more.
    let mixed = |part: &Aperture| {
        let share = part.rough_share(cell);
        0.0 < share && share < 1.0
    };
    if quarterings == 0 || !mixed(open) || !mixed(by) {
        return open.share(cell, quarterings) * (1.0 - by.share(cell, quarterings));
    }
    let [x0, x1, y0, y1] = cell;
    let (x, y) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
    let quarters = [
        [x0, x, y0, y],
        [x, x1, y0, y],
        [x0, x, y, y1],
        [x, x1, y, y1],
    ];
    let share = |quarter: [f64; 4]| left_open(open, by, quarter, quarterings - 1);
    0.25 * quarters.map(share).iter().sum::<f64>()
}

/// Area common to the disc of this radius about the origin and a rectangle.
fn disc_area(radius: f64, x0: f64, x1: f64, y0: f64, y1: f64) -> f64 {
    // Cells wholly inside or outside, nearly all of them, need no arcs.
    let square = |x: f64, y: f64| x * x + y * y;
    if square(x0.abs().max(x1.abs()), y0.abs().max(y1.abs())) <= radius * radius {
        return (x1 - x0) * (y1 - y0);
    }
    let gap = |a: f64, b: f64| {
        if a > 0.0 {
            a
        } else if b < 0.0 {
            -b
        } else {
            0.0
        }
    };
    if square(gap(x0, x1), gap(y0, y1)) >= radius * radius {
        return 0.0;
    }
    // Any rectangle is a signed sum of four that have a corner in the origin.
    corner_area(radius, x1, y1) - corner_area(radius, x0, y1) - corner_area(radius, x1, y0)
        + corner_area(radius, x0, y0)
}

/// Signed area common to the disc and the rectangle between the origin and (x, y).
fn corner_area(radius: f64, x: f64, y: f64) -> f64 {
    let sign = x.signum() * y.signum();
    let (x, y) = (x.abs().min(radius), y.abs().min(radius));
    if x.hypot(y) <= radius {
        return sign * x * y;
    }
    // The arc cuts the top edge at x = a and the right edge at x; under the arc lies a circular segment.
    let a = (radius * radius - y * y).max(0.0).sqrt();
    let under = |t: f64| {
        let t = t.min(radius);
        0.5 * (t * (radius * radius - t * t).max(0.0).sqrt()
            + radius * radius * (t / radius).asin())
    };
    sign * (a * y + under(x) - under(a))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::time::{Duration, Instant};

    use crate::optics::aperture::{Aperture, Outline};

    /// The depth changes sign where `contains` does, and a step of that length outward reaches the edge.
    #[test]
    fn depth_is_the_distance_to_the_edge() {
        let ring = Outline::Annulus {
            inner: 0.4,
            outer: 1.4,
        };
        let oblong = Outline::Rectangle {
            half_x: 1.2,
            half_y: 0.7,
        };
        let shapes = [
            Aperture::disc(1.3),
            Aperture {
                outline: ring,
                centre: [0.2, -0.1],
            },
            Aperture {
                outline: oblong,
                centre: [-0.1, 0.0],
            },
            Aperture::regular_polygon(5, 1.4, 0.3, [0.0, 0.1]),
            Aperture::disc(1.3).blocked(Aperture::disc(0.3)),
        ];
        for shape in &shapes {
            for n in 0..400 {
                let (x, y) = (
                    f64::from(n % 20) * 0.17 - 1.6,
                    f64::from(n / 20) * 0.17 - 1.6,
                );
                let depth = shape.depth(x, y);
                assert_eq!(depth >= 0.0, shape.contains(x, y), "{shape:?} {x} {y}");
                if depth <= 0.0 {
                    continue;
                }
                // All of a disc of that radius is inside, and some of one a little larger is not.
                let around = |r: f64| {
                    let turn = |i: i32| f64::from(i) * PI / 500.0;
                    (0..1000).all(|i| shape.contains(x + r * turn(i).cos(), y + r * turn(i).sin()))
                };
                assert!(
                    around(0.999 * depth) && !around(1.01 * depth),
                    "{shape:?} {x} {y}"
                );
            }
        }
    }

    #[test]
    fn coverage_adds_up_to_the_area() {
        let radius = 1.37;
        let aperture = Aperture {
            outline: Outline::Annulus {
                inner: 0.41,
                outer: radius,
            },
            centre: [0.21, -0.13],
        };
        for n in [3, 17, 50] {
            let h = 4.0 / n as f64;
            let edge = |i: usize| -2.0 + i as f64 * h;
            let mut sum = 0.0;
            for j in 0..n {
                for i in 0..n {
                    sum += aperture.coverage(edge(i), edge(i + 1), edge(j), edge(j + 1)) * h * h;
                }
            }
            assert!((sum - PI * (radius * radius - 0.41 * 0.41)).abs() < 1e-12);
        }
    }

    #[test]
    fn rectangle_edges_are_weighted() {
        let aperture = Aperture {
            outline: Outline::Rectangle {
                half_x: 1.0,
                half_y: 1.0,
            },
            centre: [0.0, 0.0],
        };
        assert!((aperture.coverage(0.75, 1.25, -0.5, 0.5) - 0.5).abs() < 1e-15);
        assert_eq!(aperture.coverage(1.5, 2.0, 0.0, 1.0), 0.0);
    }

    /// Every kind of outline, off centre where that can be.
    fn apertures() -> Vec<Aperture> {
        let centre = [0.21, -0.13];
        let disc = Aperture {
            outline: Outline::Disc { radius: 1.2 },
            centre,
        };
        let bar = Aperture::turned_rectangle(1.6, 0.1, 0.3, [0.1, 0.0]);
        let corners = vec![[0.0, 1.2], [-1.0, -0.9], [0.1, -0.3], [0.8, -1.0]];
        vec![
            Aperture::turned_rectangle(0.9, 0.5, 0.4, centre),
            Aperture::regular_polygon(6, 1.3, 0.1, centre),
            Aperture {
                outline: Outline::Polygon { corners },
                centre,
            },
            disc.clone().blocked(Aperture::disc(0.4)),
            disc.clone().blocked(bar.clone()),
            disc.blocked(bar)
                .blocked(Aperture::regular_polygon(3, 0.5, 0.0, centre)),
        ]
    }

    /// Each obstruction with the same edge once made a cell take five hundred times as long.
    #[test]
    fn many_obstructions_with_one_edge_take_little_time() {
        let disc = Aperture::disc(1.0);
        let once = Aperture::disc(2.0).blocked(disc.clone());
        let often = (0..5).fold(once.clone(), |open, _| open.blocked(disc.clone()));
        let clock = Instant::now();
        for [x, y] in [[0.5, 0.5], [0.9, 0.0], [-1.3, 0.2]] {
            let share = |aperture: &Aperture| aperture.coverage(x, x + 0.4, y, y + 0.4);
            let (one, many) = (share(&once), share(&often));
            assert!((one - many).abs() < 2e-3, "{one} {many}");
        }
        let taken = clock.elapsed();
        assert!(taken < Duration::from_secs(5), "{taken:?}");
    }

    #[test]
    fn coverage_is_the_share_of_fine_points_inside() {
        let (n, fine) = (13, 100);
        let h = 4.0 / f64::from(n);
        for aperture in apertures() {
            let (mut sum, mut counted_sum) = (0.0, 0.0);
            for (j, i) in (0..n * n).map(|k| (k / n, k % n)) {
                let (x, y) = (-2.0 + f64::from(i) * h, -2.0 + f64::from(j) * h);
                let place = |k: i32| (f64::from(k) + 0.5) / f64::from(fine) * h;
                let inside = (0..fine * fine)
                    .filter(|k| aperture.contains(x + place(k % fine), y + place(k / fine)))
                    .count();
                let counted = inside as f64 / f64::from(fine * fine);
                let ours = aperture.coverage(x, x + h, y, y + h);
                assert!(
                    (ours - counted).abs() < 0.02,
                    "{aperture:?} {ours} {counted}"
                );
                (sum, counted_sum) = (sum + ours, counted_sum + counted);
            }
            assert!((sum - counted_sum).abs() < 3e-3 * sum, "{aperture:?}");
        }
    }

    #[test]
    fn areas_of_polygons_and_of_what_is_blocked_are_the_known_ones() {
        let area = |aperture: &Aperture| {
            let [x0, x1, y0, y1] = aperture.bounds().unwrap();
            aperture.coverage(x0, x1, y0, y1) * (x1 - x0) * (y1 - y0)
        };
        let hexagon = Aperture::regular_polygon(6, 1.3, 0.4, [3.0, 1.0]);
        assert!((area(&hexagon) - 1.5 * 3.0f64.sqrt() * 1.69).abs() < 1e-14);
        let turned = Aperture::turned_rectangle(0.9, 0.5, 1.1, [0.0, 2.0]);
        assert!((area(&turned) - 1.8).abs() < 1e-14);

        // A strip of half width b across a disc of radius 1: 2(b√(1−b²) + asin b) is covered, in cells
        // where the strip leaves the disc to the accuracy of their quartering.
        let b = 0.1f64;
        let strip = Aperture::turned_rectangle(2.0, b, 0.0, [0.0, 0.0]);
        let left = PI - 2.0 * (b * (1.0 - b * b).sqrt() + b.asin());
        let spider = Aperture::disc(1.0).blocked(strip);
        let n = 25;
        let h = 2.2 / f64::from(n);
        let edge = |i: i32| -1.1 + f64::from(i) * h;
        let cell = |i, j| spider.coverage(edge(i), edge(i + 1), edge(j), edge(j + 1)) * h * h;
        let sum: f64 = (0..n * n).map(|k| cell(k % n, k / n)).sum();
        assert!((sum - left).abs() < 1e-7, "{}", sum - left);
    }
}
