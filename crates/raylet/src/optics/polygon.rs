//! Areas inside polygons.

/// Whether a point lies inside a polygon, by the number of its sides on one side of the point.
pub(crate) fn contains(corners: &[[f64; 2]], x: f64, y: f64) -> bool {
    let crosses = |[[x0, y0], [x1, y1]]: [[f64; 2]; 2]| {
        (y0 > y) != (y1 > y) && x < x0 + (y - y0) * (x1 - x0) / (y1 - y0)
    };
    sides(corners).filter(|side| crosses(*side)).count() % 2 == 1
}

/// The distance from a point to the nearest side.
pub(crate) fn distance(corners: &[[f64; 2]], x: f64, y: f64) -> f64 {
    let to_side = |[[x0, y0], [x1, y1]]: [[f64; 2]; 2]| {
        let (dx, dy) = (x1 - x0, y1 - y0);
        let along = ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy);
        let t = along.clamp(0.0, 1.0);
        (x - x0 - t * dx).hypot(y - y0 - t * dy)
    };
    sides(corners).map(to_side).fold(f64::INFINITY, f64::min)
}

/// The area common to a polygon and the box `[x0, x1] × [y0, y1]`, exactly.
pub(crate) fn area_within(corners: &[[f64; 2]], x0: f64, x1: f64, y0: f64, y1: f64) -> f64 {
    // The signed areas between each side and the bottom of the box add up to it.
    let below = |[[ax, ay], [bx, by]]: [[f64; 2]; 2]| {
        let (from, to) = (ax.clamp(x0, x1), bx.clamp(x0, x1));
        if from == to {
            return 0.0;
        }
        let slope = (by - ay) / (bx - ax);
        let y = |x: f64| ay + (x - ax) * slope - y0;
        (to - from) * mean_clamped(y(from), y(to), y1 - y0)
    };
    sides(corners).map(below).sum::<f64>().abs()
}

/// The signed area of a polygon, positive when its corners go from x towards y.
pub fn area(corners: &[[f64; 2]]) -> f64 {
    let twice = |[[ax, ay], [bx, by]]: [[f64; 2]; 2]| ax * by - bx * ay;
    0.5 * sides(corners).map(twice).sum::<f64>()
}

/// Whether two sides that are no neighbours meet.
pub fn crosses_itself(corners: &[[f64; 2]]) -> bool {
    let all: Vec<_> = sides(corners).collect();
    let last = all.len() - 1;
    let neighbours = |i: usize, j: usize| j == i + 1 || (i == 0 && j == last);
    (0..all.len()).any(|i| (i + 1..all.len()).any(|j| !neighbours(i, j) && meet(all[i], all[j])))
}

/// The sides of a closed polygon.
pub(crate) fn sides(corners: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| [*a, *b])
}

/// The mean of a line from `a` to `b` that is cut off at 0 and `top`.
fn mean_clamped(a: f64, b: f64, top: f64) -> f64 {
    let (a, b) = (a.min(b), a.max(b));
    if a == b {
        return a.clamp(0.0, top);
    }
    // The shares of the line below the bottom, and below the top.
    let below = |level: f64| ((level - a) / (b - a)).clamp(0.0, 1.0);
    let (out, under) = (below(0.0), below(top));
    let inside = 0.5 * (a.clamp(0.0, top) + b.clamp(0.0, top));
    (under - out) * inside + (1.0 - under) * top
}

/// Whether two line segments have a point in common.
fn meet([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let turn = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    let beside = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        turn(p, q, r) == 0.0 && (0..2).all(|i| p[i].min(q[i]) <= r[i] && r[i] <= p[i].max(q[i]))
    };
    let apart = turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0;
    apart || beside(a, b, c) || beside(a, b, d) || beside(c, d, a) || beside(c, d, b)
}

#[cfg(test)]
mod tests {
    use crate::optics::polygon::{area, area_within, contains, crosses_itself};

    /// An arrow head, which is not convex.
    const ARROW: [[f64; 2]; 4] = [[0.0, 1.2], [-1.0, -0.9], [0.1, -0.3], [0.8, -1.0]];

    #[test]
    fn boxes_add_up_to_the_area_and_match_counted_points() {
        let (n, fine) = (9, 60);
        let h = 3.0 / f64::from(n);
        let mut sum = 0.0;
        for (j, i) in (0..n * n).map(|k| (k / n, k % n)) {
            let (x, y) = (-1.5 + f64::from(i) * h, -1.5 + f64::from(j) * h);
            let exact = area_within(&ARROW, x, x + h, y, y + h);
            sum += exact;
            let place = |k: i32| (f64::from(k) + 0.5) / f64::from(fine) * h;
            let inside = (0..fine * fine)
                .filter(|k| contains(&ARROW, x + place(k % fine), y + place(k / fine)))
                .count();
            let counted = inside as f64 * h * h / f64::from(fine * fine);
            assert!((exact - counted).abs() < 2.0 * h * h / f64::from(fine));
        }
        assert!((sum - area(&ARROW)).abs() < 1e-14);
        assert_eq!(area_within(&ARROW, 2.0, 3.0, 0.0, 1.0), 0.0);
    }

    #[test]
    fn bow_ties_are_recognised() {
        assert!(!crosses_itself(&ARROW));
        assert!(crosses_itself(&[
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 0.0],
            [0.0, 1.0]
        ]));
        assert!(crosses_itself(&[
            [0.0, 0.0],
            [2.0, 0.0],
            [1.0, 1.0],
            [1.0, 0.0]
        ]));
    }
}
