//! A panel that shows a section through an optical system: glass, surfaces, rays and names.
//!
//! Points are (z, transverse) in mm, z to the right and the transverse coordinate (x or y) up.

#![expect(
    clippy::indexing_slicing,
    reason = "what is drawn is numbered by the lists it was laid out from"
)]

use crate::axis::{Axis, Direction, tick_step};
use crate::label::Room;
use crate::panel::{
    Aspect, BOTTOM_MARGIN, Content, FAINT, FigureError, Heading, INK, Margins, NOTE_SIZE, PALETTE,
    draw_axes, left_margin,
};
use crate::svg::{Anchor, Letters, Pen, Rect, Svg, text_width};

/// Below this share of the plot's height a section drawn in true proportion is stretched.
const SLIM: f64 = 0.4;

/// From this width over height on, a section takes the whole width of its row.
const WIDE: f64 = 1.3;

/// Width of rays in pixels, and the part that they take of the distance between neighbours where that is little.
const RAY_WIDTHS: [f64; 2] = [0.5, 1.1];
const RAY_SHARE: f64 = 0.25;

/// The points (z, transverse) in mm of one ray, with the group whose colour it takes.
#[derive(Clone, Debug, Default)]
pub struct RayPath {
    /// Where the ray goes, in order; a point that is not finite interrupts the line.
    pub points: Vec<[f64; 2]>,
    /// Rays of one group share a colour.
    pub group: usize,
}

/// The part that a curve in a layout shows, which decides how it is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurveKind {
    /// A refracting surface: a thin line.
    #[default]
    Surface,
    /// A mirror: a line with hatching on its back, to the right when going along its points.
    Mirror,
    /// A diffractive element: a line with steps to the right when going along its points.
    Doe,
    /// A stop: its points span the aperture, and bars stand beyond its two ends.
    Stop,
    /// A sensor or other target: a thick line.
    Sensor,
    /// A screen where the field is looked at: a dashed line.
    Screen,
}

/// A curve in the section: at least two points (z, transverse) in mm across its aperture.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// The curve as a polyline.
    pub points: Vec<[f64; 2]>,
    /// The part that the curve shows.
    pub kind: CurveKind,
}

/// A closed region filled as glass: its corners (z, transverse) in mm.
#[derive(Clone, Debug, Default)]
pub struct Polygon {
    /// The corners in order.
    pub points: Vec<[f64; 2]>,
}

/// A name beside a point (z, transverse) in mm; it is moved to keep clear of other things.
#[derive(Clone, Debug, Default)]
pub struct Label {
    /// The point (z, transverse) in mm.
    pub at: [f64; 2],
    /// The name.
    pub text: String,
}

/// What a section panel shows, as plain geometry.
#[derive(Clone, Debug, Default)]
pub struct LayoutScene {
    /// The rays.
    pub rays: Vec<RayPath>,
    /// Names of the ray groups for the legend; none for no legend.
    pub ray_groups: Vec<String>,
    /// The surfaces and symbols.
    pub surfaces: Vec<Curve>,
    /// The filled regions.
    pub glass: Vec<Polygon>,
    /// The names.
    pub labels: Vec<Label>,
}

impl LayoutScene {
    /// Every finite point there is.
    fn points(&self) -> impl Iterator<Item = [f64; 2]> {
        let rays = self.rays.iter().flat_map(|r| &r.points);
        let surfaces = self.surfaces.iter().flat_map(|s| &s.points);
        let glass = self.glass.iter().flat_map(|g| &g.points);
        let labels = self.labels.iter().map(|l| &l.at);
        let all = rays.chain(surfaces).chain(glass).chain(labels);
        all.copied()
            .filter(|p| p[0].is_finite() && p[1].is_finite())
    }

    /// The ranges of z and of the transverse coordinate; `None` without a finite point.
    fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        self.points().fold(None, |bounds, [z, t]| {
            let [zs, ts] = bounds.unwrap_or([[z, z], [t, t]]);
            let grow = |[lo, hi]: [f64; 2], v: f64| [lo.min(v), hi.max(v)];
            Some([grow(zs, z), grow(ts, t)])
        })
    }
}

/// Labels along z; neighbours of one name share a label, with their number, above the highest of them.
pub(crate) fn shared(mut labels: Vec<Label>) -> Vec<Label> {
    labels.sort_by(|a, b| a.at[0].total_cmp(&b.at[0]));
    let runs = labels.chunk_by(|a, b| a.text == b.text);
    let share = |run: &[Label]| match run {
        [only] => only.clone(),
        run => {
            let middle = run.iter().map(|label| label.at[0]).sum::<f64>() / run.len() as f64;
            let top = run.iter().map(|label| label.at[1]);
            Label {
                at: [middle, top.fold(f64::NEG_INFINITY, f64::max)],
                text: format!("{} × {}", run.len(), run[0].text),
            }
        }
    };
    runs.map(share).collect()
}

/// A section through an optical system.
///
/// Lengths are in true proportion unless the system is so slim that it would be hard to see;
/// then the transverse direction is stretched and the picture says by how much.
#[derive(Clone, Debug)]
pub struct LayoutPanel {
    scene: LayoutScene,
    title: String,
    transverse: String,
}

/// The axes of a layout and how much more a transverse mm counts than one along z.
struct Frame {
    z: Axis,
    t: Axis,
    stretch: f64,
}

impl Frame {
    /// Pixels of a point in mm.
    fn at(&self, [z, t]: [f64; 2]) -> [f64; 2] {
        [self.z.at(z), self.t.at(t)]
    }

    /// Pixels of a line, in runs of finite points.
    fn runs(&self, points: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
        let runs = points.split(|p| !(p[0].is_finite() && p[1].is_finite()));
        runs.map(|run| run.iter().map(|p| self.at(*p)).collect())
            .collect()
    }
}

impl LayoutPanel {
    /// See [`Panel::layout`](crate::figure::Panel::layout).
    pub(crate) fn new(scene: LayoutScene) -> Self {
        LayoutPanel {
            scene,
            title: String::new(),
            transverse: "y".into(),
        }
    }

    /// The title above the panel.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// The name of the transverse coordinate; "y" by default.
    pub fn transverse(mut self, name: impl Into<String>) -> Self {
        self.transverse = name.into();
        self
    }

    /// The scene's ranges with some room about them, never without extent.
    fn ranges(&self) -> [[f64; 2]; 2] {
        let [zs, ts] = self.scene.bounds().unwrap_or([[-1.0, 1.0]; 2]);
        let longest = (zs[1] - zs[0]).max(ts[1] - ts[0]);
        let least = if longest > 0.0 { 0.02 * longest } else { 1.0 };
        let grown = |[a, b]: [f64; 2], share: f64| {
            let room = share * (b - a).max(least);
            [a - room, b + room]
        };
        // Names stand above and below the parts.
        [grown(zs, 0.04), grown(ts, 0.16)]
    }

    /// Axes over a plot: true proportions, or a stretch of 2, 5, 10 ... for a slim system.
    fn frame(&self, plot: Rect) -> Frame {
        let [zs, ts] = self.ranges();
        let (long, wide) = (zs[1] - zs[0], ts[1] - ts[0]);
        let per_mm = (plot.w / long).min(plot.h / wide);
        let share = per_mm * wide / plot.h;
        let stretch = if share < SLIM {
            below(1.0 / share)
        } else {
            1.0
        };

        // What does not fill the plot is centred in it.
        let about = |[a, b]: [f64; 2], pixels: f64, scale: f64| {
            let (middle, half) = ((a + b) / 2.0, pixels / scale / 2.0);
            [middle - half, middle + half]
        };
        let z = about(zs, plot.w, per_mm);
        let t = about(ts, plot.h, per_mm * stretch);
        Frame {
            z: Axis::linear(z, [plot.x, plot.right()], Direction::Across, 1.0),
            t: Axis::linear(t, [plot.bottom(), plot.y], Direction::Up, 1.0),
            stretch,
        }
    }

    /// Glass, the axis and the rays, whose ink is noted.
    fn draw_light(&self, svg: &mut Svg, room: &mut Room, plot: Rect, frame: &Frame) {
        let glass = Pen {
            fill: "#cfe2f4",
            ..Pen::line("none", 0.0)
        };
        for region in &self.scene.glass {
            for run in frame.runs(&region.points) {
                room.add_area(&run);
                svg.path(&run, true, glass);
            }
        }
        let axis = frame.t.at(0.0);
        let dashes = Pen {
            dash: "10 3 2 3",
            ..Pen::line("#9aa4ae", 0.8)
        };
        if axis > plot.y && axis < plot.bottom() {
            svg.line([plot.x, axis], [plot.right(), axis], dashes);
            room.add_ink(&[[plot.x, axis], [plot.right(), axis]]);
        }

        // Many rays are drawn fainter, and rays close to each other thinner.
        let starts = self.scene.rays.iter().filter_map(|ray| ray.points.first());
        let starts: Vec<[f64; 2]> = starts.map(|point| frame.at(*point)).collect();
        let gaps = starts.windows(2).map(|pair| {
            let [[x, y], [u, v]] = [pair[0], pair[1]];
            (u - x).hypot(v - y)
        });
        let least = gaps.filter(|gap| *gap > 1e-6).fold(f64::INFINITY, f64::min);
        let width = (RAY_SHARE * least).clamp(RAY_WIDTHS[0], RAY_WIDTHS[1]);
        let opacity = (40.0 / self.scene.rays.len().max(1) as f64).clamp(0.35, 0.9);
        for ray in &self.scene.rays {
            let colour = PALETTE[ray.group % PALETTE.len()];
            let pen = Pen {
                opacity,
                ..Pen::line(colour, width)
            };
            for run in frame.runs(&ray.points) {
                room.add_ink(&run);
                svg.path(&run, false, pen);
            }
        }
    }

    /// Says how much the picture is stretched, in a corner.
    fn draw_stretch(&self, svg: &mut Svg, room: &mut Room, plot: Rect, frame: &Frame) {
        if frame.stretch == 1.0 {
            return;
        }
        let text = format!("transverse ×{}", frame.stretch);
        let w = text_width(&text, NOTE_SIZE) + 2.0;
        let [x, y] = [plot.right() - w - 6.0, plot.bottom() - NOTE_SIZE - 7.0];
        let h = NOTE_SIZE + 2.0;
        let look = Letters {
            size: NOTE_SIZE,
            colour: FAINT,
            anchor: Anchor::Start,
        };
        room.take(Rect { x, y, w, h });
        svg.rect(
            Rect { x, y, w, h },
            Pen {
                opacity: 0.8,
                ..Pen::fill("white")
            },
        );
        svg.text([x + 1.0, y + 0.85 * NOTE_SIZE], &text, look, false);
    }
}

/// The largest 1, 2 or 5 times a power of ten that is not above a value.
pub(crate) fn below(value: f64) -> f64 {
    let step = tick_step(value, 1);
    match step <= value * (1.0 + 1e-9) {
        true => step,
        // The next smaller one: half of 2 or 10, two fifths of 5.
        false => {
            let leading = step / 10f64.powf(step.log10().floor());
            step * if (leading - 5.0).abs() < 0.5 {
                0.4
            } else {
                0.5
            }
        }
    }
}

/// Draws a curve as the symbol of what it means and notes its ink.
fn draw_curve(svg: &mut Svg, room: &mut Room, line: &[[f64; 2]], kind: CurveKind) {
    room.add_ink(line);
    match kind {
        CurveKind::Surface => svg.path(line, false, Pen::line("#3d5a75", 1.4)),
        CurveKind::Sensor => svg.path(line, false, Pen::line("#0f766e", 4.0)),
        CurveKind::Screen => {
            let dash = "5 4";
            svg.path(
                line,
                false,
                Pen {
                    dash,
                    ..Pen::line("#5f6b76", 1.3)
                },
            );
        }
        CurveKind::Mirror => {
            // Hatching leans backwards behind the line.
            svg.path(line, false, Pen::line(INK, 2.0));
            for ([x, y], [dx, dy]) in along(line, 7.0) {
                let end = [x - 5.0 * dy - 4.0 * dx, y + 5.0 * dx - 4.0 * dy];
                svg.line([x, y], end, Pen::line(INK, 0.9));
            }
        }
        CurveKind::Doe => {
            svg.path(line, false, Pen::line("#a3159a", 2.2));
            // A square wave on one side.
            let mut relief = Vec::new();
            for (i, ([x, y], [dx, dy])) in along(line, 3.5).into_iter().enumerate() {
                let (from, to) = if i % 2 == 0 { (0.0, 4.5) } else { (4.5, 0.0) };
                relief.push([x - from * dy, y + from * dx]);
                relief.push([x - to * dy, y + to * dx]);
            }
            svg.path(&relief, false, Pen::line("#a3159a", 1.2));
        }
        CurveKind::Stop => {
            // From each end away from the aperture, with a foot across it.
            let (Some(&first), Some(&last)) = (line.first(), line.last()) else {
                return;
            };
            for ([x, y], [u, v]) in [(first, last), (last, first)] {
                let length = (x - u).hypot(y - v).max(1e-9);
                let (dx, dy) = ((x - u) / length, (y - v) / length);
                let foot = [[x - 4.0 * dy, y + 4.0 * dx], [x + 4.0 * dy, y - 4.0 * dx]];
                let bar = [[x, y], [x + 16.0 * dx, y + 16.0 * dy]];
                room.add_ink(&bar);
                svg.path(&bar, false, Pen::line(INK, 2.6));
                svg.path(&foot, false, Pen::line(INK, 1.6));
            }
        }
    }
}

/// Points at equal distances along a polyline, each with the unit direction of the line there.
fn along(line: &[[f64; 2]], distance: f64) -> Vec<([f64; 2], [f64; 2])> {
    let mut out = Vec::new();
    let mut wait = 0.0;
    for pair in line.windows(2) {
        let [[x, y], [u, v]] = [pair[0], pair[1]];
        let length = (u - x).hypot(v - y);
        if length <= 0.0 {
            continue;
        }
        let (dx, dy) = ((u - x) / length, (v - y) / length);
        while wait <= length && out.len() < 10_000 {
            out.push(([x + wait * dx, y + wait * dy], [dx, dy]));
            wait += distance;
        }
        wait -= length;
    }
    out
}

impl Content for LayoutPanel {
    fn heading(&self) -> Heading {
        let title = self.title.clone();
        let notes = vec![];
        Heading { title, notes }
    }

    fn aspect(&self) -> Aspect {
        let [zs, ts] = self.ranges();
        match (zs[1] - zs[0]) / (ts[1] - ts[0]) {
            // A high one, as of a folded system, takes no more width than it needs.
            ratio if ratio < WIDE => Aspect::Fixed(ratio.max(0.4)),
            ratio => Aspect::Flexible(ratio.min(4.0)),
        }
    }

    fn margins(&self, [w, h]: [f64; 2]) -> Margins {
        let frame = self.frame(Rect {
            x: 0.0,
            y: 0.0,
            w,
            h,
        });
        Margins {
            left: left_margin(&frame.t),
            right: 14.0,
            bottom: BOTTOM_MARGIN,
        }
    }

    fn draw(&self, svg: &mut Svg, plot: Rect, _density: f64) -> Result<(), FigureError> {
        if self.scene.bounds().is_none() {
            return Err(FigureError::Content {
                panel: self.title.clone(),
                expected: "at least one finite point to lay out",
                found: "none".into(),
            });
        }

        // Light lies behind the parts, words in front of both.
        let frame = self.frame(plot);
        let mut room = Room::new(plot);
        svg.clipped(plot, |svg| {
            self.draw_light(svg, &mut room, plot, &frame);
            for curve in &self.scene.surfaces {
                for run in frame.runs(&curve.points) {
                    draw_curve(svg, &mut room, &run, curve.kind);
                }
            }
        });
        self.draw_stretch(svg, &mut room, plot, &frame);
        for label in &self.scene.labels {
            room.draw_label(svg, frame.at(label.at), &label.text);
        }
        let groups = self.scene.ray_groups.iter().enumerate();
        let pen = |i: usize| Pen::line(PALETTE[i % PALETTE.len()], 1.8);
        let entries: Vec<_> = groups.map(|(i, name)| (name.as_str(), pen(i))).collect();
        room.draw_legend(svg, &entries);
        let transverse = frame.t.label(&self.transverse, "mm");
        let z = frame.z.label("z", "mm");
        draw_axes(svg, plot, [&frame.z, &frame.t], [&z, &transverse]);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::panel::{Aspect, Content};
    use crate::section_panel::{Label, LayoutPanel, LayoutScene, RayPath, along, below, shared};
    use crate::svg::{Rect, Svg};

    const PLOT: Rect = Rect {
        x: 0.0,
        y: 0.0,
        w: 800.0,
        h: 300.0,
    };

    /// A panel with one ray.
    fn panel(points: Vec<[f64; 2]>) -> LayoutPanel {
        let rays = vec![RayPath { points, group: 0 }];
        LayoutPanel::new(LayoutScene {
            rays,
            ..Default::default()
        })
    }

    #[test]
    fn proportions_are_true_unless_the_system_is_slim() {
        let round = panel(vec![[0.0, -10.0], [50.0, 10.0]]).frame(PLOT);
        assert_eq!(round.stretch, 1.0);
        let along = round.z.at(1.0) - round.z.at(0.0);
        let up = round.t.at(0.0) - round.t.at(1.0);
        assert!((along - up).abs() < 1e-9);
        // A slim one is stretched by a round number and still fits.
        let slim = panel(vec![[0.0, -1.0], [200.0, 1.0]]).frame(PLOT);
        let along = slim.z.at(1.0) - slim.z.at(0.0);
        let up = slim.t.at(0.0) - slim.t.at(1.0);
        assert!((up / along - slim.stretch).abs() < 1e-9);
        assert_eq!(slim.stretch, 20.0);
        assert!(slim.t.at(1.0) > 0.0 && slim.t.at(-1.0) < 300.0);
    }

    #[test]
    fn a_folded_system_takes_no_more_width_than_it_needs() {
        let folded = panel(vec![[0.0, 0.0], [10.0, 0.0], [10.0, 50.0]]);
        let Aspect::Fixed(ratio) = folded.aspect() else {
            panic!("{:?}", folded.aspect());
        };
        assert!(ratio < 0.5, "{ratio}");
        let long = panel(vec![[0.0, -10.0], [50.0, 10.0]]);
        assert!(matches!(long.aspect(), Aspect::Flexible(_)));
    }

    #[test]
    fn neighbours_of_one_name_share_it() {
        let label = |z: f64, text: &str| Label {
            at: [z, 10.0 - z],
            text: text.into(),
        };
        let given = [(3.0, "lens"), (0.0, "stop"), (1.0, "lens"), (4.0, "stop")];
        let found = shared(given.map(|(z, text)| label(z, text)).to_vec());
        let found: Vec<_> = found.iter().map(|l| (l.at, l.text.as_str())).collect();
        assert_eq!(
            found,
            [
                ([0.0, 10.0], "stop"),
                ([2.0, 9.0], "2 × lens"),
                ([4.0, 6.0], "stop")
            ]
        );
    }

    #[test]
    fn the_stretch_is_said_on_the_picture() {
        let mut svg = Svg::default();
        let slim = panel(vec![[0.0, -1.0], [200.0, 1.0]]);
        slim.draw(&mut svg, PLOT, 1.0).unwrap();
        assert!(svg.finish(800.0, 300.0).contains("transverse ×20"));
    }

    #[test]
    fn round_numbers_below() {
        let cases = [
            (1.0, 1.0),
            (1.9, 1.0),
            (2.0, 2.0),
            (4.9, 2.0),
            (5.0, 5.0),
            (9.9, 5.0),
            (31.0, 20.0),
        ];
        for (value, want) in cases {
            assert!(
                (below(value) - want).abs() < 1e-9,
                "{value}: {}",
                below(value)
            );
        }
    }

    #[test]
    fn symbols_are_spaced_evenly_around_corners() {
        let points = along(&[[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]], 4.0);
        assert_eq!(points.len(), 6);
        assert_eq!(points[3], ([10.0, 2.0], [0.0, 1.0]));
    }

    #[test]
    fn an_empty_scene_is_an_error() {
        let empty = LayoutPanel::new(LayoutScene::default()).title("system");
        let error = empty.draw(&mut Svg::default(), PLOT, 1.0).unwrap_err();
        assert!(error.to_string().starts_with("panel 'system': expected"));
        // Broken points are left out, one point or a line along z is no trouble.
        panel(vec![[f64::NAN, 0.0], [1.0, 0.0], [2.0, 0.0]])
            .draw(&mut Svg::default(), PLOT, 1.0)
            .unwrap();
        panel(vec![[1.0, 1.0]])
            .draw(&mut Svg::default(), PLOT, 1.0)
            .unwrap();
    }
}
