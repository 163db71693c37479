//! Quadrature nodes of plane regions: discs, rectangles, and pixels that a disc may cut.

use crate::numerics::quadrature::gauss_legendre;

/// Nodes [x, y] and the area that each represents.
pub type Nodes = Vec<([f64; 2], f64)>;

/// How finely fields are sampled: the highest frequency along a line in 1/length, and how much finer than just
/// fine enough.
#[derive(Clone, Copy, Debug)]
pub struct Fineness {
    /// Cycles per length of what is integrated.
    pub frequency: f64,
    /// Factor on the number of nodes.
    pub effort: f64,
}

impl Fineness {
    /// Gauss nodes on an interval: half the largest phase in rad, and some.
    fn along(self, length: f64) -> usize {
        let phase = std::f64::consts::PI * self.frequency * length;
        (self.effort * (0.55 * phase + 3.5)).ceil() as usize
    }

    /// Equal angles around a circle.
    fn around(self, radius: f64) -> usize {
        let phase = std::f64::consts::TAU * self.frequency * radius;
        (self.effort * (1.1 * phase + 14.0)).ceil() as usize
    }
}

/// Gauss nodes between two ends.
fn between(from: f64, to: f64, count: usize) -> Vec<(f64, f64)> {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let rule = gauss_legendre(count).into_iter();
    rule.map(|(t, w)| (middle + half * t, half * w)).collect()
}

/// A disc in rings.
pub fn disc(radius: f64, centre: [f64; 2], fine: Fineness) -> Nodes {
    let mut nodes = Vec::new();
    for (r, width) in between(0.0, radius, fine.along(radius)) {
        let around = fine.around(r);
        let step = std::f64::consts::TAU / around as f64;
        for n in 0..around {
            let (s, c) = (step * (n as f64 + 0.5)).sin_cos();
            nodes.push(([centre[0] + r * c, centre[1] + r * s], width * step * r));
        }
    }
    nodes
}

/// The rectangle `[x0, x1] × [y0, y1]`.
pub fn rectangle([x0, x1, y0, y1]: [f64; 4], fine: Fineness) -> Nodes {
    let columns = between(x0, x1, fine.along(x1 - x0));
    let rows = between(y0, y1, fine.along(y1 - y0));
    let row = |(y, b): (f64, f64)| columns.iter().map(move |(x, a)| ([*x, y], a * b));
    rows.into_iter().flat_map(row).collect()
}

/// The part of a rectangle inside a disc about the origin: rows between the heights where the circle crosses its
/// sides, each as long as the chord.
pub fn rectangle_in_disc(bounds: [f64; 4], radius: f64, fine: Fineness) -> Nodes {
    let [x0, x1, y0, y1] = bounds;
    let far = x0.abs().max(x1.abs()).hypot(y0.abs().max(y1.abs()));
    if far <= radius {
        return rectangle(bounds, fine);
    }
    let mut heights = vec![y0, y1];
    for x in [x0, x1, 0.0] {
        let square = radius * radius - x * x;
        if square > 0.0 {
            heights.extend([square.sqrt(), -square.sqrt()]);
        }
    }
    heights.retain(|y| (y0..=y1).contains(y));
    heights.sort_by(f64::total_cmp);
    let mut nodes = Vec::new();
    for ends in heights.windows(2) {
        // Angles make the chord smooth where it closes.
        let [from, to] = [ends[0], ends[1]].map(|y| (y / radius).clamp(-1.0, 1.0).asin());
        for (angle, width) in between(from, to, fine.along(radius * (to - from)) + 4) {
            let (s, c) = angle.sin_cos();
            let (low, high) = (x0.max(-radius * c), x1.min(radius * c));
            if low < high {
                let chord = between(low, high, fine.along(high - low));
                let area = width * radius * c;
                nodes.extend(chord.iter().map(|(x, a)| ([*x, radius * s], a * area)));
            }
        }
    }
    nodes
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::estimates::nodes::{Fineness, Nodes, disc, rectangle_in_disc};
    use crate::numerics::disc::disc_transform;

    fn transform(nodes: &Nodes, frequency: f64) -> Complex64 {
        let turn = std::f64::consts::TAU * frequency;
        let wave =
            |([x, y], area): &([f64; 2], f64)| Complex64::cis(turn * (0.6 * x + 0.8 * y)) * area;
        nodes.iter().map(wave).sum()
    }

    /// Rings, and cells that the circle cuts, have the disc's transform: to 1e-5 of its area as the survey samples
    /// them, and with half as many nodes again along each line to 1e-7.
    #[test]
    fn discs_have_their_transform() {
        let radius = 7.3;
        let area = std::f64::consts::PI * radius * radius;
        for (effort, bound) in [(1.0, 1e-5), (1.5, 1e-7)] {
            let fine = Fineness {
                frequency: 1.0,
                effort,
            };
            let cells = |n: i32| {
                let h = 16.0 / f64::from(n);
                let cell = move |k: i32| {
                    let (x, y) = (-8.0 + f64::from(k % n) * h, -8.0 + f64::from(k / n) * h);
                    rectangle_in_disc([x, x + h, y, y + h], radius, fine)
                };
                (0..n * n).flat_map(cell).collect::<Nodes>()
            };
            for nodes in [disc(radius, [0.0; 2], fine), cells(3), cells(16)] {
                for frequency in [0.0, 0.3, 0.9] {
                    let exact = disc_transform(radius, std::f64::consts::TAU * frequency);
                    let error = (transform(&nodes, frequency) - exact).norm() / area;
                    assert!(error < bound, "{effort}, {frequency}: {error:e}");
                }
            }
        }
    }
}
