//! What every panel of a figure shares: its place, its title, its axes, and what can go wrong.

use crate::axis::{Axis, TICK_SIZE};
use crate::svg::{Anchor, Letters, Pen, Rect, Svg};

/// Letter size of axis labels, legends and text labels in pixels.
pub(crate) const LABEL_SIZE: f64 = 14.0;

/// Letter size of panel titles in pixels.
pub(crate) const TITLE_SIZE: f64 = 16.0;

/// Letter size of the notes under a title in pixels.
pub(crate) const NOTE_SIZE: f64 = 12.5;

/// Colour of letters and axes.
pub(crate) const INK: &str = "#24292f";

/// Colour of notes.
pub(crate) const FAINT: &str = "#5f6b76";

/// Colour of grid lines.
pub(crate) const GRID: &str = "#e4e8ec";

/// Line colours for groups and series, in order of use.
pub(crate) const PALETTE: [&str; 8] = [
    "#1f6fb4", "#d9541e", "#2a8f4c", "#8a4fbf", "#c2185b", "#8a6d1b", "#138d90", "#6b7280",
];

/// Why a figure could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// A panel holds something that cannot be shown.
    #[error("panel '{panel}': expected {expected}, found {found}")]
    Content {
        /// The panel's title.
        panel: String,
        /// What would have been accepted.
        expected: &'static str,
        /// What was given.
        found: String,
    },
    /// The scale or the resulting number of pixels is out of range.
    #[error(
        "figure: expected a positive scale giving at most 20000 pixels a side, found {scale} giving {width} x {height}"
    )]
    Scale {
        /// The requested scale.
        scale: f64,
        /// Pixels across that would result.
        width: f64,
        /// Pixels down that would result.
        height: f64,
    },
    /// The drawing could not be turned into pixels.
    #[error("figure: the drawing is not valid SVG: {0}")]
    Svg(#[from] resvg::usvg::Error),
    /// A picture could not be packed.
    #[error("figure: the PNG image could not be written: {0}")]
    Png(#[from] png::EncodingError),
}

/// Title of a panel and the smaller notes below it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Heading {
    pub(crate) title: String,
    pub(crate) notes: Vec<String>,
}

/// Space a panel needs around its plot, in pixels; the heading comes on top of this.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Margins {
    pub(crate) left: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
}

/// How wide a plot wants to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Aspect {
    /// Exactly so many times its height.
    Fixed(f64),
    /// About so many times its height, more where there is room.
    Flexible(f64),
}

impl Aspect {
    /// Width over height.
    pub(crate) fn ratio(self) -> f64 {
        match self {
            Aspect::Fixed(ratio) | Aspect::Flexible(ratio) => ratio,
        }
    }
}

/// A panel as the figure sees it.
pub(crate) trait Content {
    /// Title and notes.
    fn heading(&self) -> Heading;

    /// The requested shape of the plot.
    fn aspect(&self) -> Aspect;

    /// Space around a plot of about this width and height.
    fn margins(&self, plot: [f64; 2]) -> Margins;

    /// Draws into the rectangle of the plot and its margins; `density` is device pixels per pixel.
    fn draw(&self, svg: &mut Svg, plot: Rect, density: f64) -> Result<(), FigureError>;
}

/// Letters of the given size and anchor in ink.
pub(crate) fn ink(size: f64, anchor: Anchor) -> Letters {
    Letters {
        size,
        colour: INK,
        anchor,
    }
}

/// Space left of a plot for the ticks and label of its vertical axis.
pub(crate) fn left_margin(y: &Axis) -> f64 {
    y.widest() + 8.0 + 8.0 + LABEL_SIZE
}

/// Space below a plot for the ticks and label of its horizontal axis.
pub(crate) const BOTTOM_MARGIN: f64 = 9.0 + TICK_SIZE + 7.0 + LABEL_SIZE;

/// Grid lines behind a plot.
pub(crate) fn draw_grid(svg: &mut Svg, plot: Rect, x: &Axis, y: &Axis) {
    let pen = Pen::line(GRID, 1.0);
    for tick in &x.ticks {
        let at = x.at(tick.value);
        svg.line([at, plot.y], [at, plot.bottom()], pen);
    }
    for tick in &y.ticks {
        let at = y.at(tick.value);
        svg.line([plot.x, at], [plot.right(), at], pen);
    }
}

/// The frame of a plot with the ticks and labels of the x and y axes outside it.
pub(crate) fn draw_axes(svg: &mut Svg, plot: Rect, [x, y]: [&Axis; 2], labels: [&str; 2]) {
    let pen = Pen::line(INK, 1.0);
    svg.rect(plot, pen);

    // Below: ticks, their labels, the name of the axis.
    let [x_label, y_label] = labels;
    let bottom = plot.bottom();
    for tick in &x.ticks {
        let at = x.at(tick.value);
        svg.line([at, bottom], [at, bottom + 5.0], pen);
        let baseline = [at, bottom + 8.0 + 0.76 * TICK_SIZE];
        svg.text(baseline, &tick.label, ink(TICK_SIZE, Anchor::Middle), false);
    }
    for &value in &x.minor {
        svg.line([x.at(value), bottom], [x.at(value), bottom + 3.0], pen);
    }
    let middle = plot.x + plot.w / 2.0;
    let baseline = [middle, bottom + 9.0 + TICK_SIZE + 6.0 + 0.76 * LABEL_SIZE];
    svg.text(baseline, x_label, ink(LABEL_SIZE, Anchor::Middle), false);

    // Left: the same, the name turned to read upwards.
    for tick in &y.ticks {
        let at = y.at(tick.value);
        svg.line([plot.x - 5.0, at], [plot.x, at], pen);
        let baseline = [plot.x - 8.0, at + 0.36 * TICK_SIZE];
        svg.text(baseline, &tick.label, ink(TICK_SIZE, Anchor::End), false);
    }
    for &value in &y.minor {
        svg.line([plot.x - 3.0, y.at(value)], [plot.x, y.at(value)], pen);
    }
    let baseline = [plot.x - 8.0 - y.widest() - 8.0, plot.y + plot.h / 2.0];
    svg.text(baseline, y_label, ink(LABEL_SIZE, Anchor::Middle), true);
}
