//! A panel of lines over x and y, linear or logarithmic, with a legend.

#![expect(
    clippy::indexing_slicing,
    reason = "what is drawn is numbered by the lists it was laid out from"
)]

use crate::axis::{Axis, Direction, LengthUnit};
use crate::label::Room;
use crate::panel::{
    Aspect, BOTTOM_MARGIN, Content, FigureError, Heading, Margins, PALETTE, draw_axes, draw_grid,
    left_margin,
};
use crate::svg::{Pen, Rect, Svg};

/// How the points of a series are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mark {
    Line,
    Dashed,
    Dots,
}

/// Points (x, y) under one name. Points that are not finite interrupt the line.
#[derive(Clone, Debug)]
pub struct Series {
    name: String,
    points: Vec<[f64; 2]>,
    mark: Mark,
}

impl Series {
    /// A series drawn as marked; a name of "" leaves it out of the legend.
    fn new(name: &str, points: impl IntoIterator<Item = [f64; 2]>, mark: Mark) -> Self {
        Series {
            name: name.to_owned(),
            points: points.into_iter().collect(),
            mark,
        }
    }

    /// A continuous line; a name of "" leaves it out of the legend.
    pub fn line(name: &str, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Series::new(name, points, Mark::Line)
    }

    /// A dashed line, for a goal or a reference.
    pub fn dashed(name: &str, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Series::new(name, points, Mark::Dashed)
    }

    /// Separate dots, for measurements.
    pub fn dots(name: &str, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Series::new(name, points, Mark::Dots)
    }

    /// The pen of the series of this number.
    fn pen(&self, number: usize) -> Pen<'static> {
        let colour = PALETTE[number % PALETTE.len()];
        match self.mark {
            Mark::Line => Pen::line(colour, 1.8),
            Mark::Dashed => Pen {
                dash: "6 4",
                ..Pen::line(colour, 1.8)
            },
            Mark::Dots => Pen::fill(colour),
        }
    }
}

/// One of the two axes as the caller wants it.
#[derive(Clone, Debug, Default)]
struct Choices {
    name: String,
    unit: String,
    log: bool,
    range: Option<[f64; 2]>,
}

impl Choices {
    /// The axis over its pixels and its label, for values from `lo` to `hi`.
    fn axis(&self, [lo, hi]: [f64; 2], pixels: [f64; 2], direction: Direction) -> (Axis, String) {
        let range = self.range.unwrap_or([lo, hi]);
        if self.log {
            let axis = Axis::logarithmic(range, pixels, direction);
            let label = axis.label(&self.name, &self.unit);
            return (axis, label);
        }

        // Lengths in mm get the unit that fits.
        let length = match self.unit.as_str() {
            "mm" => LengthUnit::for_span(range[1] - range[0]),
            _ => LengthUnit::MM,
        };
        let axis = Axis::linear(range, pixels, direction, length.per_mm);
        let unit = if self.unit == "mm" {
            length.sign
        } else {
            &self.unit
        };
        let label = axis.label(&self.name, unit);
        (axis, label)
    }

    /// Whether a value has a place on this axis.
    fn shows(&self, value: f64) -> bool {
        value.is_finite() && (!self.log || value > 0.0)
    }
}

/// Lines over x and y.
#[derive(Clone, Debug)]
pub struct ChartPanel {
    series: Vec<Series>,
    title: String,
    x: Choices,
    y: Choices,
}

impl ChartPanel {
    /// See [`Panel::lines`](crate::figure::Panel::lines).
    pub(crate) fn new(series: Vec<Series>) -> Self {
        ChartPanel {
            series,
            title: String::new(),
            x: Choices::default(),
            y: Choices::default(),
        }
    }

    /// The title above the panel.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// Name and unit of x ("" for none); lengths given in "mm" are shown in the unit that fits.
    pub fn x_axis(mut self, name: impl Into<String>, unit: impl Into<String>) -> Self {
        (self.x.name, self.x.unit) = (name.into(), unit.into());
        self
    }

    /// Name and unit of y ("" for none); lengths given in "mm" are shown in the unit that fits.
    pub fn y_axis(mut self, name: impl Into<String>, unit: impl Into<String>) -> Self {
        (self.y.name, self.y.unit) = (name.into(), unit.into());
        self
    }

    /// A logarithmic x axis; points at or below zero are left out and counted in a note.
    pub fn log_x(mut self) -> Self {
        self.x.log = true;
        self
    }

    /// A logarithmic y axis; points at or below zero are left out and counted in a note.
    pub fn log_y(mut self) -> Self {
        self.y.log = true;
        self
    }

    /// The ends of the x axis in place of those of the points.
    pub fn x_range(mut self, ends: [f64; 2]) -> Self {
        self.x.range = Some(ends);
        self
    }

    /// The ends of the y axis in place of those of the points.
    pub fn y_range(mut self, ends: [f64; 2]) -> Self {
        self.y.range = Some(ends);
        self
    }

    /// Whether a point has a place on both axes.
    fn shows(&self, point: &[f64; 2]) -> bool {
        self.x.shows(point[0]) && self.y.shows(point[1])
    }

    /// Ends of both axes from the points that can be shown, y with some room.
    fn ends(&self) -> [[f64; 2]; 2] {
        let none = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let points = self.series.iter().flat_map(|s| &s.points);
        let grow = |[lo, hi]: [f64; 2], v: f64| [lo.min(v), hi.max(v)];
        let [x, y] = points
            .filter(|p| self.shows(p))
            .fold(none, |[x, y], p| [grow(x, p[0]), grow(y, p[1])]);

        // Dots at either end of x need room to be seen whole.
        let dots = self.series.iter().any(|s| s.mark == Mark::Dots);
        let x = match (dots, self.x.log) {
            (false, _) => x,
            (true, false) => [x[0] - 0.03 * (x[1] - x[0]), x[1] + 0.03 * (x[1] - x[0])],
            (true, true) => [
                x[0] * (x[0] / x[1]).powf(0.03),
                x[1] * (x[1] / x[0]).powf(0.03),
            ],
        };
        let [y_lo, y_hi] = y;
        let y = match self.y.log {
            true => {
                let room = (y_hi / y_lo).powf(0.05).max(1.05);
                [y_lo / room, y_hi * room]
            }
            false => {
                // Amounts that come near zero are shown from zero.
                let room = 0.06 * (y_hi - y_lo);
                let from_zero = y_lo >= 0.0 && y_lo < 4.0 * room;
                [if from_zero { 0.0 } else { y_lo - room }, y_hi + room]
            }
        };
        [x, y]
    }

    /// Both axes with their labels over a plot.
    fn axes_over(&self, plot: Rect) -> [(Axis, String); 2] {
        let [x, y] = self.ends();
        [
            self.x.axis(x, [plot.x, plot.right()], Direction::Across),
            self.y.axis(y, [plot.bottom(), plot.y], Direction::Up),
        ]
    }

    /// Says what cannot be shown.
    fn check(&self) -> Result<(), FigureError> {
        let refuse = |expected, found| {
            Err(FigureError::Content {
                panel: self.title.clone(),
                expected,
                found,
            })
        };
        let mut points = self.series.iter().flat_map(|s| &s.points);
        if !points.any(|p| self.shows(p)) {
            let found = "none that is finite (and above zero on a logarithmic axis)";
            return refuse("at least one point", found.to_owned());
        }
        for axis in [&self.x, &self.y] {
            match axis.range {
                Some([a, b]) if !(axis.shows(a) && axis.shows(b) && a != b) => {
                    let expected = "two different usable ends of an axis";
                    return refuse(expected, format!("[{a}, {b}]"));
                }
                _ => (),
            }
        }
        Ok(())
    }

    /// Draws one series and notes where its ink is.
    fn draw_series(&self, svg: &mut Svg, room: &mut Room, number: usize, axes: [&Axis; 2]) {
        let series = &self.series[number];
        let pen = series.pen(number);
        let runs = series.points.split(|p| !self.shows(p));
        for run in runs {
            let place = |p: &[f64; 2]| [axes[0].at(p[0]), axes[1].at(p[1])];
            let line: Vec<_> = run.iter().map(place).collect();
            if series.mark == Mark::Dots {
                for &dot in &line {
                    svg.disc(dot, 3.0, pen);
                    room.add_dot(dot);
                }
                continue;
            }
            room.add_ink(&line);
            svg.path(&line, false, pen);
        }
    }
}

impl Content for ChartPanel {
    fn heading(&self) -> Heading {
        let points = self.series.iter().flat_map(|s| &s.points);
        let notes = match points.filter(|p| !self.shows(p)).count() {
            0 => vec![],
            1 => vec!["1 point cannot be shown on these axes".into()],
            n => vec![format!("{n} points cannot be shown on these axes")],
        };
        let title = self.title.clone();
        Heading { title, notes }
    }

    fn aspect(&self) -> Aspect {
        Aspect::Flexible(1.45)
    }

    fn margins(&self, [w, h]: [f64; 2]) -> Margins {
        let [_, (y, _)] = self.axes_over(Rect {
            x: 0.0,
            y: 0.0,
            w,
            h,
        });
        Margins {
            left: left_margin(&y),
            right: 14.0,
            bottom: BOTTOM_MARGIN,
        }
    }

    fn draw(&self, svg: &mut Svg, plot: Rect, _density: f64) -> Result<(), FigureError> {
        self.check()?;
        let [(x, x_label), (y, y_label)] = self.axes_over(plot);
        draw_grid(svg, plot, &x, &y);

        // Lines first, then the legend where they leave room.
        let mut room = Room::new(plot);
        svg.clipped(plot, |svg| {
            for number in 0..self.series.len() {
                self.draw_series(svg, &mut room, number, [&x, &y]);
            }
        });
        let numbered = self.series.iter().enumerate();
        let named = numbered.filter(|(_, s)| !s.name.is_empty());
        let entries: Vec<_> = named.map(|(i, s)| (s.name.as_str(), s.pen(i))).collect();
        room.draw_legend(svg, &entries);
        draw_axes(svg, plot, [&x, &y], [&x_label, &y_label]);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::chart_panel::{ChartPanel, Series};
    use crate::panel::Content;
    use crate::svg::{Rect, Svg};

    const PLOT: Rect = Rect {
        x: 50.0,
        y: 10.0,
        w: 300.0,
        h: 200.0,
    };

    #[test]
    fn a_logarithmic_axis_leaves_out_and_counts_what_it_cannot_show() {
        let points = [[0.0, 1.0], [1.0, 0.0], [2.0, 1e-3], [3.0, f64::NAN]];
        let panel = ChartPanel::new(vec![Series::line("loss", points)]).log_y();
        let notes = panel.heading().notes;
        assert_eq!(notes, ["2 points cannot be shown on these axes"]);
        let [_, (y, _)] = panel.axes_over(PLOT);
        assert!(y.at(1e-3) < PLOT.bottom() && y.at(1.0) > PLOT.y);
    }

    #[test]
    fn points_lie_where_the_axes_say() {
        let panel = ChartPanel::new(vec![Series::line("", [[0.0, 0.0], [0.02, 5.0]])])
            .x_axis("x", "mm")
            .y_range([0.0, 10.0]);
        let [(x, label), (y, _)] = panel.axes_over(PLOT);
        assert_eq!(label, "x (µm)");
        assert_eq!([x.at(0.02), y.at(5.0)], [350.0, 110.0]);
    }

    #[test]
    fn nothing_to_show_is_an_error_with_the_title() {
        let panel = ChartPanel::new(vec![Series::dots("", [[1.0, -1.0]])]);
        let panel = panel.title("loss").log_y();
        let error = panel.draw(&mut Svg::default(), PLOT, 1.0).unwrap_err();
        assert!(
            error
                .to_string()
                .starts_with("panel 'loss': expected at least one point")
        );
    }
}
