//! A panel that shows an array of values as colours, with its colour bar.

use ndarray::{Array2, CowArray, Ix2};
use raylet::file::arrays::image::{area_mean, area_mean_of, encode_rgb};

use crate::axis::{Axis, Direction, LengthUnit, TICK_SIZE};
use crate::colour::{ColourMap, ColourScale};
use crate::panel::{
    Aspect, BOTTOM_MARGIN, Content, FigureError, Heading, INK, LABEL_SIZE, Margins, draw_axes, ink,
    left_margin,
};
use crate::section_panel::below;
use crate::svg::{Anchor, Pen, Rect, Svg};

/// Most device pixels of a panel's picture along either side.
const MOST_PIXELS: f64 = 1600.0;

/// Shapes of the plot, width over height; longer pictures keep their shape inside it.
const SHAPES: [f64; 2] = [0.25, 5.0];

/// Pictures that are longer than this many times their other side are stretched across it.
const LONGEST: f64 = 10.0;

/// Distance of the colour bar from the plot, and its width.
const BAR: [f64; 2] = [10.0, 14.0];

/// Distance of a colour bar that is higher than the picture, beside whose lower end the last tick has its label.
const CLEAR: f64 = 24.0;

/// Decades that a logarithmic picture spans by default.
const DECADES: u32 = 5;

/// Values [y, x] shown as colours at their true aspect ratio, +x to the right and +y up. Very long pictures, of a few rows
/// or columns, are stretched, and a note says by how much.
///
/// Few values become crisp squares, many are averaged over each pixel of the picture (phases as
/// phasors). Values that are not finite are drawn in a grey-green and counted in a note.
#[derive(Clone, Debug)]
pub struct ImagePanel<'a> {
    values: CowArray<'a, f64, Ix2>,
    ranges_mm: [[f64; 2]; 2],
    found: ValueRange,
    title: String,
    notes: Vec<String>,
    colours: ColourMap,
    range: Option<[f64; 2]>,
    decades: Option<u32>,
    quantity: [String; 2],
    axes: [String; 2],
    missing: Option<String>,
}

/// What the values turned out to be.
#[derive(Clone, Copy, Debug)]
struct ValueRange {
    lo: f64,
    hi: f64,
    not_finite: usize,
}

/// The colour scale of a panel and what its colour bar says.
struct Bar {
    scale: ColourScale,
    /// Values are divided by this before they are looked up.
    divisor: f64,
    axis: Axis,
    label: String,
}

impl<'a> ImagePanel<'a> {
    /// See [`Panel::image`](crate::figure::Panel::image).
    pub(crate) fn new(
        values: CowArray<'a, f64, Ix2>,
        x_range_mm: [f64; 2],
        y_range_mm: [f64; 2],
    ) -> Self {
        let start = ValueRange {
            lo: f64::INFINITY,
            hi: f64::NEG_INFINITY,
            not_finite: 0,
        };
        let found = values.iter().fold(start, |found, &v| match v.is_finite() {
            true => ValueRange {
                lo: found.lo.min(v),
                hi: found.hi.max(v),
                ..found
            },
            false => ValueRange {
                not_finite: found.not_finite + 1,
                ..found
            },
        });
        ImagePanel {
            values,
            ranges_mm: [x_range_mm, y_range_mm],
            found,
            title: String::new(),
            notes: Vec::new(),
            colours: ColourMap::default(),
            range: None,
            decades: None,
            quantity: [String::new(), String::new()],
            axes: ["x".into(), "y".into()],
            missing: None,
        }
    }

    /// The title above the panel.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// A smaller line under the title.
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// What values that are not finite mean, in place of their count ("" for no note).
    pub fn missing(mut self, what: impl Into<String>) -> Self {
        self.missing = Some(what.into());
        self
    }

    /// The colours of the values; [`ColourMap::Inferno`] by default.
    pub fn colours(mut self, colours: ColourMap) -> Self {
        self.colours = colours;
        self
    }

    /// The values of the first and last colour, in place of those found in the array.
    ///
    /// Without effect on phases, which always span −π to π. A logarithmic panel takes them as
    /// absolute, both above zero.
    pub fn range(mut self, low_high: [f64; 2]) -> Self {
        self.range = Some(low_high);
        self
    }

    /// Colours in proportion to the logarithm, over five decades below the maximum.
    pub fn log(self) -> Self {
        self.decades(DECADES)
    }

    /// Colours in proportion to the logarithm, over so many decades below the maximum.
    ///
    /// The colour bar then shows fractions of the maximum, unless a range is given. Without
    /// effect on phases.
    pub fn decades(mut self, decades: u32) -> Self {
        self.decades = Some(decades.max(1));
        self
    }

    /// What the values are and in which unit, for the colour bar ("" for none).
    pub fn quantity(mut self, name: impl Into<String>, unit: impl Into<String>) -> Self {
        self.quantity = [name.into(), unit.into()];
        self
    }

    /// Names of the horizontal and the vertical axis; "x" and "y" by default.
    pub fn axes(mut self, across: impl Into<String>, up: impl Into<String>) -> Self {
        self.axes = [across.into(), up.into()];
        self
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
        let usable = |[a, b]: [f64; 2]| a.is_finite() && b.is_finite() && a != b;
        let (ny, nx) = self.values.dim();
        if nx == 0 || ny == 0 {
            return refuse("at least one value", format!("an array [{ny}, {nx}]"));
        }
        for [a, b] in self.ranges_mm {
            if !usable([a, b]) {
                let found = format!("[{a}, {b}] mm");
                return refuse("two different finite ends of an axis", found);
            }
        }
        match self.range {
            Some([a, b]) if !usable([a, b]) => {
                let found = format!("[{a}, {b}]");
                refuse("two different finite ends of the colour range", found)
            }
            Some([a, b]) if self.is_log() && !(a > 0.0 && b > 0.0) => {
                let found = format!("[{a}, {b}]");
                refuse("a colour range above zero on a logarithmic scale", found)
            }
            _ => Ok(()),
        }
    }

    /// Whether colours follow the logarithm.
    fn is_log(&self) -> bool {
        self.decades.is_some() && self.colours != ColourMap::Phase
    }

    /// The colour scale and its bar from bottom to top pixel.
    fn bar(&self, pixels: [f64; 2]) -> Bar {
        let map = self.colours;
        let [name, unit] = &self.quantity;

        // Without any finite value the range is as good as any other.
        let any = self.found.lo <= self.found.hi;
        let (lo, hi) = if any {
            (self.found.lo, self.found.hi)
        } else {
            (0.0, 1.0)
        };
        let relative = self.is_log() && self.range.is_none();
        let (range, divisor) = match (relative, self.range) {
            (true, _) => {
                let below = self.decades.unwrap_or(DECADES) as i32;
                ([10f64.powi(-below), 1.0], if hi > 0.0 { hi } else { 1.0 })
            }
            (false, Some(range)) if map != ColourMap::Phase => (range, 1.0),
            (false, _) => (ColourScale::fitted(map, lo, hi).range, 1.0),
        };
        let log = self.is_log();
        let scale = ColourScale { map, range, log };

        // Lengths in mm get the unit that fits, like the axes.
        let axis = scale.axis(pixels);
        match (relative, unit.as_str(), log || map == ColourMap::Phase) {
            (true, ..) => {
                let name = if name.is_empty() { "value" } else { name };
                let label = format!("{name} / maximum");
                Bar {
                    scale,
                    divisor,
                    axis,
                    label,
                }
            }
            (false, "mm", false) => {
                let length = LengthUnit::for_span(range[1] - range[0]);
                let axis = Axis::linear(range, pixels, Direction::Up, length.per_mm);
                let label = axis.label(name, length.sign);
                Bar {
                    scale,
                    divisor,
                    axis,
                    label,
                }
            }
            _ => {
                let label = axis.label(name, unit);
                Bar {
                    scale,
                    divisor,
                    axis,
                    label,
                }
            }
        }
    }

    /// Both axes over a plot, with the sign of their unit.
    fn axes_over(&self, plot: Rect) -> (Axis, Axis, &'static str) {
        let [xs, ys] = self.ranges_mm;
        let unit = unit(self.ranges_mm);
        let across = [plot.x, plot.right()];
        let up = [plot.bottom(), plot.y];
        (
            Axis::linear(xs, across, Direction::Across, unit.per_mm),
            Axis::linear(ys, up, Direction::Up, unit.per_mm),
            unit.sign,
        )
    }

    /// The distance of the colour bar from the picture in a plot of this size.
    fn bar_gap(&self, [w, h]: [f64; 2]) -> f64 {
        match w / self.shown_aspect() < h - 1.0 {
            true => CLEAR,
            false => BAR[0],
        }
    }

    /// Width over height of the picture as it is shown.
    fn shown_aspect(&self) -> f64 {
        let [across, up] = stretch(self.ranges_mm);
        true_aspect(self.ranges_mm) * across / up
    }

    /// The values averaged onto a grid [ny, nx]; NaN where there is no finite value.
    fn sampled(&self, shape: [usize; 2]) -> Array2<f64> {
        let cyclic = self.colours == ColourMap::Phase;
        if !cyclic && self.found.not_finite == 0 {
            return area_mean(self.values.view(), shape);
        }

        // Finite values count by their share of the pixel.
        let mean = |f: &dyn Fn(f64) -> f64| {
            let of_finite = |v: f64| if v.is_finite() { f(v) } else { 0.0 };
            area_mean_of(self.values.view(), shape, &of_finite)
        };
        let share = mean(&|_| 1.0);
        let mut out = match cyclic {
            true => {
                let (mut out, cosine) = (mean(&f64::sin), mean(&f64::cos));
                out.zip_mut_with(&cosine, |s, c| *s = s.atan2(*c));
                out
            }
            false => mean(&|v| v) / &share,
        };
        out.zip_mut_with(&share, |v, s| {
            if *s <= 0.0 {
                *v = f64::NAN;
            }
        });
        out
    }

    /// The picture as PNG for a plot of so many device pixels.
    fn raster(&self, bar: &Bar, [w, h]: [f64; 2]) -> Result<Vec<u8>, FigureError> {
        let shrink = (MOST_PIXELS / w.max(h)).min(1.0);
        let [nx, ny] = [w, h].map(|side| (side * shrink).round().max(1.0) as usize);
        let sampled = self.sampled([ny, nx]);
        let rows = sampled.rows().into_iter().rev();
        let bytes = bar.scale.colours(rows.flatten(), bar.divisor);
        Ok(encode_rgb([nx, ny], &bytes)?)
    }

    /// The colour bar to the right of the plot.
    fn draw_bar(&self, svg: &mut Svg, plot: Rect, bar: &Bar) -> Result<(), FigureError> {
        let (gap, w) = (self.bar_gap([plot.w, plot.h]), BAR[1]);
        let place = Rect {
            x: plot.right() + gap,
            w,
            ..plot
        };
        let colours: Vec<u8> = bar.scale.ramp(256).into_iter().rev().flatten().collect();
        svg.png(place, &encode_rgb([1, 256], &colours)?);
        let pen = Pen::line(INK, 1.0);
        svg.rect(place, pen);

        // Ticks and label as on an axis, on the other side.
        for tick in &bar.axis.ticks {
            let at = bar.axis.at(tick.value);
            svg.line([place.right(), at], [place.right() + 4.0, at], pen);
            let baseline = [place.right() + 7.0, at + 0.36 * TICK_SIZE];
            svg.text(baseline, &tick.label, ink(TICK_SIZE, Anchor::Start), false);
        }
        let x = place.right() + 7.0 + bar.axis.widest() + 6.0 + 0.76 * LABEL_SIZE;
        let middle = [x, plot.y + plot.h / 2.0];
        svg.text(middle, &bar.label, ink(LABEL_SIZE, Anchor::Middle), true);
        Ok(())
    }
}

/// Width over height of a picture with these ranges of x and y.
fn true_aspect([xs, ys]: [[f64; 2]; 2]) -> f64 {
    let aspect = ((xs[1] - xs[0]) / (ys[1] - ys[0])).abs();
    if aspect.is_finite() { aspect } else { 1.0 }
}

/// By how much a picture with these ranges is stretched along x and y: by a round number where it is very long, so that a
/// few rows or columns are seen.
pub(crate) fn stretch(ranges_mm: [[f64; 2]; 2]) -> [f64; 2] {
    let aspect = true_aspect(ranges_mm);
    if aspect > LONGEST {
        [1.0, below(2.0 * aspect / LONGEST)]
    } else if aspect < 1.0 / LONGEST {
        [below(2.0 / (aspect * LONGEST)), 1.0]
    } else {
        [1.0; 2]
    }
}

/// The unit of length in which a picture with these ranges of x and y is labelled.
pub(crate) fn unit([xs, ys]: [[f64; 2]; 2]) -> LengthUnit {
    let span = (xs[1] - xs[0]).abs().max((ys[1] - ys[0]).abs());
    LengthUnit::for_span(span)
}

impl Content for ImagePanel<'_> {
    fn heading(&self) -> Heading {
        let mut notes = self.notes.clone();
        match (self.found.not_finite, &self.missing) {
            (0, _) => (),
            (_, Some(what)) if what.is_empty() => (),
            (_, Some(what)) => notes.push(format!("grey-green: {what}")),
            (1, None) => notes.push("1 value is not finite (grey-green)".into()),
            (n, None) => notes.push(format!("{n} values are not finite (grey-green)")),
        }
        for (factor, name) in stretch(self.ranges_mm).into_iter().zip(&self.axes) {
            if factor > 1.0 {
                notes.push(format!("{name} stretched ×{factor}"));
            }
        }
        let title = self.title.clone();
        Heading { title, notes }
    }

    fn aspect(&self) -> Aspect {
        Aspect::Fixed(self.shown_aspect().clamp(SHAPES[0], SHAPES[1]))
    }

    fn margins(&self, [w, h]: [f64; 2]) -> Margins {
        let plot = Rect {
            x: 0.0,
            y: 0.0,
            w,
            h,
        };
        let (_, y, _) = self.axes_over(plot);
        let bar = self.bar([h, 0.0]);
        let label = if bar.label.is_empty() {
            0.0
        } else {
            6.0 + LABEL_SIZE
        };
        Margins {
            left: left_margin(&y),
            right: self.bar_gap([w, h]) + BAR[1] + 7.0 + bar.axis.widest() + label,
            bottom: BOTTOM_MARGIN,
        }
    }

    fn draw(&self, svg: &mut Svg, plot: Rect, density: f64) -> Result<(), FigureError> {
        self.check()?;

        // A long or tall picture keeps its shape inside the plot; its colour bar has the height of the plot.
        let aspect = self.shown_aspect();
        let (w, h) = (plot.w.min(plot.h * aspect), plot.h.min(plot.w / aspect));
        let (x, y) = (plot.x + (plot.w - w) / 2.0, plot.y + (plot.h - h) / 2.0);
        let beside = Rect { x, w, ..plot };
        let plot = Rect { x, y, w, h };

        let bar = self.bar([beside.bottom(), beside.y]);
        svg.png(plot, &self.raster(&bar, [w * density, h * density])?);
        self.draw_bar(svg, beside, &bar)?;
        let (across, up, unit) = self.axes_over(plot);
        let labels = [
            across.label(&self.axes[0], unit),
            up.label(&self.axes[1], unit),
        ];
        draw_axes(svg, plot, [&across, &up], [&labels[0], &labels[1]]);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, array};

    use crate::colour::ColourMap;
    use crate::image_panel::ImagePanel;
    use crate::panel::Content;
    use crate::svg::{Rect, Svg};

    /// A panel over 2 mm squared.
    fn panel(values: Array2<f64>) -> ImagePanel<'static> {
        ImagePanel::new(values.into(), [-1.0, 1.0], [-1.0, 1.0]).title("test")
    }

    /// What drawing says.
    fn drawn(panel: &ImagePanel) -> Result<(), String> {
        let [x, y, w, h] = [0.0, 0.0, 90.0, 90.0];
        let drawn = panel.draw(&mut Svg::default(), Rect { x, y, w, h }, 1.0);
        drawn.map_err(|error| error.to_string())
    }

    #[test]
    fn missing_values_are_counted_and_do_not_spread() {
        let panel = panel(array![[1.0, f64::NAN], [3.0, f64::INFINITY]]);
        assert_eq!(
            panel.heading().notes,
            ["2 values are not finite (grey-green)"]
        );
        let sampled = panel.sampled([4, 4]);
        assert_eq!(sampled.column(1), array![1.0, 1.0, 3.0, 3.0]);
        assert!(sampled.column(2).iter().all(|v| v.is_nan()));
        assert_eq!(panel.sampled([1, 1])[[0, 0]], 2.0);
        drawn(&panel).unwrap();
    }

    #[test]
    fn phases_are_averaged_around_the_ring() {
        let panel = panel(array![[3.1, -3.1]]).colours(ColourMap::Phase);
        let mean = panel.sampled([1, 1])[[0, 0]];
        assert!((mean.abs() - std::f64::consts::PI).abs() < 1e-12, "{mean}");
    }

    #[test]
    fn logarithmic_bars_show_fractions_of_the_maximum() {
        let panel = panel(array![[0.0, 2.0e-3], [40.0, 4.0]]).log();
        let bar = panel.quantity("irradiance", "W/mm²");
        let bar = bar.bar([200.0, 0.0]);
        assert_eq!(bar.label, "irradiance / maximum");
        assert_eq!(bar.divisor, 40.0);
        assert_eq!(bar.axis.ticks.last().unwrap().label, "1");
        assert_eq!(bar.axis.ticks[0].label, "10⁻⁵");
    }

    #[test]
    fn heights_are_shown_in_the_unit_that_fits() {
        let panel = panel(array![[0.0, 1.2e-3]]).quantity("height", "mm");
        let bar = panel.bar([200.0, 0.0]);
        assert_eq!(bar.label, "height (µm)");
        assert_eq!(bar.axis.ticks.last().unwrap().label, "1.2");
    }

    #[test]
    fn what_cannot_be_shown_is_an_error_with_the_title() {
        assert_eq!(
            drawn(&panel(Array2::zeros((0, 3)))).unwrap_err(),
            "panel 'test': expected at least one value, found an array [0, 3]"
        );
        let flat = ImagePanel::new(Array2::zeros((2, 2)).into(), [1.0, 1.0], [0.0, 1.0]);
        assert!(drawn(&flat).unwrap_err().contains("[1, 1] mm"));
        let log = panel(array![[1.0]]).log().range([0.0, 1.0]);
        assert!(drawn(&log).unwrap_err().contains("above zero"));
        // Nothing but zeros or missing values can be shown.
        drawn(&panel(Array2::zeros((2, 2))).log()).unwrap();
        drawn(&panel(array![[f64::NAN]])).unwrap();
    }
}
