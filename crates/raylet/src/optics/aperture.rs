//! Clear apertures and the share of a small cell that lies inside them.

/// The open part of a surface or screen, in its local x, y plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aperture {
    /// Its outline.
    pub outline: Outline,
    /// Its centre, in mm.
    pub centre: [f64; 2],
}

/// The outline of an aperture; lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
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
        /// Radius of the opening.
        outer: f64,
    },
    /// Within a rectangle along x and y.
    Rectangle {
        /// Half the width along x.
        half_x: f64,
        /// Half the height along y.
        half_y: f64,
    },
}

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

    /// Whether a point is inside.
    #[inline(always)]
    pub fn contains(&self, x: f64, y: f64) -> bool {
        let (x, y) = (x - self.centre[0], y - self.centre[1]);
        match self.outline {
            Outline::Open => true,
            Outline::Disc { radius } => x * x + y * y <= radius * radius,
            Outline::Annulus { inner, outer } => {
                let square = x * x + y * y;
                inner * inner <= square && square <= outer * outer
            }
            Outline::Rectangle { half_x, half_y } => x.abs() <= half_x && y.abs() <= half_y,
        }
    }

    /// The bounding box `[x_min, x_max, y_min, y_max]`, or nothing when there is no edge.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        let (half_x, half_y) = match self.outline {
            Outline::Open => return None,
            Outline::Disc { radius } => (radius, radius),
            Outline::Annulus { outer, .. } => (outer, outer),
            Outline::Rectangle { half_x, half_y } => (half_x, half_y),
        };
        let [x, y] = self.centre;
        Some([x - half_x, x + half_x, y - half_y, y + half_y])
    }

    /// The share of the cell `[x0, x1] × [y0, y1]` that is open, between 0 and 1, by exact areas.
    pub fn coverage(&self, x0: f64, x1: f64, y0: f64, y1: f64) -> f64 {
        let area = (x1 - x0) * (y1 - y0);
        let (x0, x1) = (x0 - self.centre[0], x1 - self.centre[0]);
        let (y0, y1) = (y0 - self.centre[1], y1 - self.centre[1]);
        let open = match self.outline {
            Outline::Open => area,
            Outline::Disc { radius } => disc_area(radius, x0, x1, y0, y1),
            Outline::Annulus { inner, outer } => {
                disc_area(outer, x0, x1, y0, y1) - disc_area(inner, x0, x1, y0, y1)
            }
            Outline::Rectangle { half_x, half_y } => {
                let span = |a: f64, b: f64, half: f64| (b.min(half) - a.max(-half)).max(0.0);
                span(x0, x1, half_x) * span(y0, y1, half_y)
            }
        };
        (open / area).clamp(0.0, 1.0)
    }
}

/// Area common to the disc of this radius about the origin and a rectangle.
fn disc_area(radius: f64, x0: f64, x1: f64, y0: f64, y1: f64) -> f64 {
    // Cells wholly inside or outside, nearly all of them, need no arcs.
    let far = x0.abs().max(x1.abs()).hypot(y0.abs().max(y1.abs()));
    if far <= radius {
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
    if gap(x0, x1).hypot(gap(y0, y1)) >= radius {
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

    use crate::optics::aperture::{Aperture, Outline};

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
}
