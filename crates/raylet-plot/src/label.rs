//! Words inside a plot: labels and legends that keep clear of each other and of the lines.

#![expect(
    clippy::indexing_slicing,
    reason = "what is drawn is numbered by the lists it was laid out from"
)]

use crate::panel::{INK, LABEL_SIZE, ink};
use crate::svg::{Anchor, Pen, Rect, Svg, text_width};

/// Side of the squares in which ink is counted, in pixels.
const CELL: f64 = 4.0;

/// Distances of a label from its point, in pixels, nearest first.
const DISTANCES: [f64; 9] = [8.0, 16.0, 26.0, 38.0, 52.0, 68.0, 88.0, 112.0, 140.0];

/// Directions from its point to a label, preferred first.
const DIRECTIONS: [[f64; 2]; 8] = [
    [0.0, -1.0],
    [0.0, 1.0],
    [0.6, -0.8],
    [-0.6, -0.8],
    [0.6, 0.8],
    [-0.6, 0.8],
    [1.0, 0.0],
    [-1.0, 0.0],
];

/// Room inside a plot: what is drawn there and which words are placed already.
pub(crate) struct Room {
    area: Rect,
    across: usize,
    inked: Vec<bool>,
    taken: Vec<Rect>,
}

impl Room {
    /// An empty plot.
    pub(crate) fn new(area: Rect) -> Self {
        let across = (area.w / CELL).ceil().max(1.0) as usize;
        let down = (area.h / CELL).ceil().max(1.0) as usize;
        Room {
            area,
            across,
            inked: vec![false; across * down],
            taken: Vec::new(),
        }
    }

    /// Notes that a line is drawn along these points.
    pub(crate) fn add_ink(&mut self, points: &[[f64; 2]]) {
        for pair in points.windows(2) {
            // Step along the part of the segment that can be inside the plot.
            let [a, b] = [pair[0], pair[1]];
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            if !length.is_finite() {
                continue;
            }
            let steps = (length / (0.5 * CELL)).ceil().clamp(1.0, 1e4) as usize;
            for i in 0..=steps {
                let t = i as f64 / steps as f64;
                self.add_dot([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            }
        }
    }

    /// Notes that the region with these corners is filled.
    pub(crate) fn add_area(&mut self, corners: &[[f64; 2]]) {
        let rows = (self.area.h / CELL).ceil() as usize;
        for row in 0..rows {
            // The places where a line through the row's middle crosses the outline, from the left.
            let y = self.area.y + (row as f64 + 0.5) * CELL;
            let next = corners.iter().cycle().skip(1);
            let sides = corners.iter().zip(next);
            let across = sides.filter(|(a, b)| (a[1] <= y) != (b[1] <= y));
            let mut crossings: Vec<f64> = across
                .map(|(a, b)| a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]))
                .collect();
            crossings.sort_by(f64::total_cmp);
            for ends in crossings.chunks_exact(2) {
                self.add_ink(&[[ends[0], y], [ends[1], y]]);
            }
        }
    }

    /// Notes that something is drawn at a point.
    pub(crate) fn add_dot(&mut self, [x, y]: [f64; 2]) {
        if self.area.contains([x, y]) {
            let column = ((x - self.area.x) / CELL) as usize;
            let row = ((y - self.area.y) / CELL) as usize;
            let at = row * self.across + column.min(self.across - 1);
            if let Some(cell) = self.inked.get_mut(at) {
                *cell = true;
            }
        }
    }

    /// Keeps words out of a rectangle.
    pub(crate) fn take(&mut self, rect: Rect) {
        self.taken.push(rect);
    }

    /// How many cells of a rectangle carry ink.
    fn ink_under(&self, rect: &Rect) -> usize {
        let cell = |v: f64, from: f64| ((v - from) / CELL).floor().max(0.0) as usize;
        let columns = cell(rect.x, self.area.x)..=cell(rect.right(), self.area.x);
        let rows = cell(rect.y, self.area.y)..=cell(rect.bottom(), self.area.y);
        let row_ink = |row: usize| {
            let cells = columns.clone().filter(|c| *c < self.across);
            cells
                .filter(|c| self.inked.get(row * self.across + c) == Some(&true))
                .count()
        };
        rows.map(row_ink).sum()
    }

    /// What it costs to put words into a rectangle: sharing space with words is worst, then
    /// leaving the plot, then lying on lines.
    fn cost(&self, rect: &Rect) -> f64 {
        let words: f64 = self.taken.iter().map(|t| t.overlap(&rect.grown(3.0))).sum();
        let outside = rect.w * rect.h - rect.overlap(&self.area);
        let ink = self.ink_under(&rect.grown(1.0)) as f64;
        1e3 * words + 1e2 * outside + 12.0 * ink
    }

    /// The best rectangle of a size for words about a point, which then is taken.
    fn place_near(&mut self, point: [f64; 2], [w, h]: [f64; 2]) -> Rect {
        let candidates = DISTANCES.iter().flat_map(|distance| {
            DIRECTIONS.iter().enumerate().map(move |(order, [dx, dy])| {
                // The point lies outside the rectangle by the distance.
                let x = point[0] + dx * distance + 0.5 * w * (dx.signum() * dx.abs().round() - 1.0);
                let y = point[1] + dy * distance + 0.5 * h * (dy.signum() * dy.abs().round() - 1.0);
                (Rect { x, y, w, h }, distance + 1.5 * order as f64)
            })
        });
        let cost = |(rect, far): (Rect, f64)| (rect, far + self.cost(&rect));
        let best = candidates.map(cost).min_by(|a, b| a.1.total_cmp(&b.1));
        let [x, y] = point;
        let rect = best.map_or(Rect { x, y, w, h }, |(rect, _)| rect);
        self.take(rect);
        rect
    }

    /// The emptiest place along the plot's edge for a box, which then is taken.
    fn place_box(&mut self, [w, h]: [f64; 2]) -> Rect {
        let a = self.area.grown(-8.0);
        let xs = [a.right() - w, a.x, a.x + (a.w - w) / 2.0];
        let ys = [a.y, a.bottom() - h, a.y + (a.h - h) / 2.0];
        let places = ys
            .iter()
            .flat_map(|&y| xs.iter().map(move |&x| Rect { x, y, w, h }));
        let cost = |(order, rect): (usize, Rect)| (rect, self.cost(&rect) + order as f64);
        let best = places
            .enumerate()
            .map(cost)
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let rect = best.map_or(Rect { w, h, ..a }, |(rect, _)| rect);
        self.take(rect);
        rect
    }

    /// Writes a word beside a point, with a thin line to it where it had to move away.
    pub(crate) fn draw_label(&mut self, svg: &mut Svg, point: [f64; 2], text: &str) {
        let size = [text_width(text, LABEL_SIZE), LABEL_SIZE];
        let rect = self.place_near(point, size);

        // The line runs to the nearest point of the word's rectangle.
        let [x, y] = point;
        let end = [
            x.clamp(rect.x, rect.right()),
            y.clamp(rect.y, rect.bottom()),
        ];
        if (end[0] - x).hypot(end[1] - y) > 12.0 {
            svg.line(
                point,
                end,
                Pen {
                    opacity: 0.55,
                    ..Pen::line(INK, 0.8)
                },
            );
        }
        // A veil keeps the word readable where lines cannot be avoided.
        let veil = Pen {
            opacity: 0.75,
            ..Pen::fill("white")
        };
        svg.rect(rect.grown(1.0), veil);
        let baseline = [rect.x, rect.y + 0.82 * LABEL_SIZE];
        svg.text(baseline, text, ink(LABEL_SIZE, Anchor::Start), false);
    }

    /// Draws a legend where the plot is emptiest: a sample of each line and its name.
    pub(crate) fn draw_legend(&mut self, svg: &mut Svg, entries: &[(&str, Pen)]) {
        if entries.is_empty() {
            return;
        }
        let line = LABEL_SIZE + 6.0;
        let widths = entries.iter().map(|(name, _)| text_width(name, LABEL_SIZE));
        let w = 8.0 + 24.0 + 8.0 + widths.fold(0.0, f64::max) + 8.0;
        let rect = self.place_box([w, line * entries.len() as f64 + 8.0]);
        svg.rect(
            rect,
            Pen {
                opacity: 0.85,
                ..Pen::fill("white")
            },
        );
        svg.rect(rect, Pen::line("#c5ccd3", 1.0));
        for (i, (name, pen)) in entries.iter().enumerate() {
            let middle = rect.y + 4.0 + (i as f64 + 0.5) * line;
            let from = rect.x + 8.0;
            match pen.stroke {
                // Dots are dots.
                "none" => svg.disc([from + 12.0, middle], 3.0, *pen),
                _ => svg.line([from, middle], [from + 24.0, middle], *pen),
            }
            let baseline = [from + 32.0, middle + 0.36 * LABEL_SIZE];
            svg.text(baseline, name, ink(LABEL_SIZE, Anchor::Start), false);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::label::Room;
    use crate::svg::Rect;

    const AREA: Rect = Rect {
        x: 10.0,
        y: 20.0,
        w: 400.0,
        h: 300.0,
    };

    #[test]
    fn labels_about_one_point_do_not_share_space() {
        let mut room = Room::new(AREA);
        let placed: Vec<_> = (0..8)
            .map(|_| room.place_near([200.0, 150.0], [60.0, 14.0]))
            .collect();
        for (i, a) in placed.iter().enumerate() {
            assert!((a.overlap(&AREA) - 60.0 * 14.0).abs() < 1e-9);
            assert!(
                placed[..i].iter().all(|b| a.overlap(b) == 0.0),
                "{placed:?}"
            );
        }
    }

    #[test]
    fn labels_keep_off_lines_and_inside_the_plot() {
        let mut room = Room::new(AREA);
        room.add_ink(&[[10.0, 140.0], [410.0, 140.0]]);
        let rect = room.place_near([200.0, 150.0], [60.0, 14.0]);
        assert_eq!(room.ink_under(&rect), 0);
        let corner = room.place_near([409.0, 21.0], [60.0, 14.0]);
        assert!((corner.overlap(&AREA) - 60.0 * 14.0).abs() < 1e-9);
    }

    #[test]
    fn labels_keep_off_filled_regions() {
        let mut room = Room::new(AREA);
        room.add_area(&[
            [150.0, 100.0],
            [250.0, 100.0],
            [250.0, 250.0],
            [150.0, 250.0],
        ]);
        let rect = room.place_near([200.0, 110.0], [60.0, 14.0]);
        assert_eq!(room.ink_under(&rect), 0);
        assert!(rect.bottom() < 101.0, "{rect:?}");
    }

    #[test]
    fn legends_go_where_there_is_no_line() {
        let mut room = Room::new(AREA);
        room.add_ink(&[[10.0, 320.0], [410.0, 20.0]]);
        let rect = room.place_box([120.0, 60.0]);
        assert_eq!(room.ink_under(&rect), 0);
        assert!(rect.x < 100.0 && rect.y < 100.0, "{rect:?}");
    }
}
