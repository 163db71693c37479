//! Points along the edge of an aperture, for integrals along it.

use crate::optics::aperture::{Aperture, Outline};
use crate::optics::polygon;

/// A point of an edge, and the piece of the edge that it stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgePoint {
    /// Its place in mm.
    pub at: [f64; 2],
    /// The outward normal times the length of the piece, in mm.
    pub normal: [f64; 2],
}

/// The points of an edge at equal distances of `step` (in mm) at most, that lie in a box `[x_min, x_max, y_min, y_max]`. They are
/// the same for all boxes. Equal steps integrate what is smooth and falls off to both sides better than any other points.
pub(crate) fn edge_points(aperture: &Aperture, area: [f64; 4], step: f64) -> Vec<EdgePoint> {
    let [cx, cy] = aperture.centre;
    let seen = [area[0] - cx, area[1] - cx, area[2] - cy, area[3] - cy];
    let found = match &aperture.outline {
        Outline::Open => Vec::new(),
        Outline::Disc { radius } => circle(*radius, seen, step),
        Outline::Annulus { inner, outer } => {
            let inwards = circle(*inner, seen, step).into_iter().map(reversed);
            circle(*outer, seen, step)
                .into_iter()
                .chain(inwards)
                .collect()
        }
        Outline::Rectangle { half_x, half_y } => {
            let (x, y) = (*half_x, *half_y);
            lines(&[[-x, -y], [x, -y], [x, y], [-x, y]], seen, step)
        }
        Outline::Polygon { corners } => lines(corners, seen, step),
        Outline::Blocked { open, by } => {
            let is_left = |point: &EdgePoint| !by.contains(point.at[0], point.at[1]);
            let is_seen = |point: &EdgePoint| open.contains(point.at[0], point.at[1]);
            let own = edge_points(open, seen, step).into_iter().filter(is_left);
            let others = edge_points(by, seen, step).into_iter().filter(is_seen);
            own.chain(others.map(reversed)).collect()
        }
    };
    let moved = |point: EdgePoint| EdgePoint {
        at: [point.at[0] + cx, point.at[1] + cy],
        ..point
    };
    found.into_iter().map(moved).collect()
}

/// The edge of what lies on its other side.
fn reversed(point: EdgePoint) -> EdgePoint {
    EdgePoint {
        normal: point.normal.map(|n| -n),
        ..point
    }
}

/// Those of a centred circle around what is inside.
fn circle(radius: f64, area: [f64; 4], step: f64) -> Vec<EdgePoint> {
    let turn = std::f64::consts::TAU;
    let at = |angle: f64| {
        let (s, c) = angle.sin_cos();
        [radius * c, radius * s]
    };
    steps(turn * radius, step, area, |part| at(turn * part))
        .map(|(part, length)| {
            let place = at(turn * part);
            EdgePoint {
                at: place,
                normal: place.map(|x| x / radius * length),
            }
        })
        .collect()
}

/// Those of a polygon around what is inside.
fn lines(corners: &[[f64; 2]], area: [f64; 4], step: f64) -> Vec<EdgePoint> {
    let outwards = polygon::area(corners).signum();
    let side = |[from, to]: [[f64; 2]; 2]| {
        let d = [to[0] - from[0], to[1] - from[1]];
        let whole = d[0].hypot(d[1]);
        let at = move |part: f64| [from[0] + part * d[0], from[1] + part * d[1]];
        steps(whole, step, area, at).map(move |(part, length)| EdgePoint {
            at: at(part),
            normal: [d[1], -d[0]].map(|n| outwards * n / whole * length),
        })
    };
    polygon::sides(corners).flat_map(side).collect()
}

/// The middles of equal steps along a line of this length that lie in a box: their places as parts of the line, and the length of
/// a step; `at` has the places.
fn steps(
    length: f64,
    step: f64,
    [x0, x1, y0, y1]: [f64; 4],
    at: impl Fn(f64) -> [f64; 2],
) -> impl Iterator<Item = (f64, f64)> {
    let count = (length / step).ceil().max(1.0);
    let middles = (0..count as usize).map(move |n| (n as f64 + 0.5) / count);
    let within = move |part: &f64| {
        let [x, y] = at(*part);
        x0 <= x && x <= x1 && y0 <= y && y <= y1
    };
    middles
        .filter(within)
        .map(move |part| (part, length / count))
}

#[cfg(test)]
mod tests {
    use crate::optics::aperture::{Aperture, Outline};
    use crate::wave::local_bands::edge_points::edge_points;

    /// ∮ x·n dl is twice the area inside, and ∮ n dl is zero, wherever the aperture stands.
    #[test]
    fn edges_close_around_their_areas() {
        let at = |outline| Aperture {
            outline,
            centre: [0.3, -0.2],
        };
        let turn = std::f64::consts::PI;
        let rectangle = Outline::Rectangle {
            half_x: 0.7,
            half_y: 0.4,
        };
        let ring = Outline::Annulus {
            inner: 0.5,
            outer: 1.1,
        };
        let inside = Aperture::disc(1.0).blocked(Aperture::disc(0.3));
        let clockwise = vec![[0.0, 0.0], [0.0, 1.0], [2.0, 0.0]];
        let cases = [
            (at(Outline::Disc { radius: 0.8 }), turn * 0.64),
            (at(ring), turn * (1.21 - 0.25)),
            (at(rectangle), 4.0 * 0.28),
            (at(Outline::Polygon { corners: clockwise }), 1.0),
            (inside, turn * 0.91),
        ];
        let everywhere = [-9.0, 9.0, -9.0, 9.0];
        for (aperture, area) in cases {
            let points = edge_points(&aperture, everywhere, 0.1);
            let sum = |f: &dyn Fn(&[f64; 2], &[f64; 2]) -> f64| {
                points.iter().map(|p| f(&p.at, &p.normal)).sum::<f64>()
            };
            let twice = sum(&|x, n| x[0] * n[0] + x[1] * n[1]);
            assert!((twice - 2.0 * area).abs() < 1e-12, "{aperture:?}: {twice}");
            for a in 0..2 {
                assert!(sum(&|_, n| n[a]).abs() < 1e-12, "{aperture:?}");
            }
            let [left, right] = [[-9.0, 0.31, -9.0, 9.0], [0.31, 9.0, -9.0, 9.0]];
            let parts = [left, right].map(|area| edge_points(&aperture, area, 0.1).len());
            assert_eq!(parts[0] + parts[1], points.len());
        }
    }
}
