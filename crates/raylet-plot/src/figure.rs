//! Figures: panels in rows, as PNG pixels.
//!
//! The letters are built in, so a figure is the same on every machine.

#![expect(
    clippy::indexing_slicing,
    reason = "what is drawn is numbered by the lists it was laid out from"
)]

use std::sync::{Arc, LazyLock};

use ndarray::{CowArray, Ix2};
use raylet::file::arrays::image::encode_rgb;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb::Database};

use crate::chart_panel::{ChartPanel, Series};
use crate::image_panel::ImagePanel;
use crate::panel::{
    Aspect, Content, FAINT, FigureError, Heading, Margins, NOTE_SIZE, TITLE_SIZE, ink,
};
use crate::section_panel::{LayoutPanel, LayoutScene};
use crate::svg::{Anchor, FONT, FONT_FAMILY, Letters, Rect, Svg, wrap};

/// Letter size of the figure's title in pixels.
const FIGURE_TITLE_SIZE: f64 = 20.0;

/// Blank space around the figure and between panels, in pixels.
const BORDER: f64 = 16.0;
const GAP: [f64; 2] = [16.0, 22.0];

/// Least and most height of a plot in pixels, and the most of a plot of a fixed shape that has its row for itself.
const HEIGHTS: [f64; 2] = [80.0, 430.0];
const MOST_ALONE: f64 = 700.0;

/// Most device pixels along a side of a PNG.
const MOST_PIXELS: f64 = 20_000.0;

/// The built-in letters, unpacked once.
static FONTS: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut fonts = Database::new();
    fonts.load_font_data(FONT.to_vec());
    fonts.set_sans_serif_family(FONT_FAMILY);
    Arc::new(fonts)
});

/// One panel of a figure.
#[derive(Clone, Debug)]
pub enum Panel<'a> {
    /// Values as colours.
    Image(ImagePanel<'a>),
    /// Lines over x and y.
    Lines(ChartPanel),
    /// A section through an optical system.
    Layout(LayoutPanel),
}

impl<'a> Panel<'a> {
    /// Values [y, x] as colours; the ranges, in mm, are the outer edges of the first and last
    /// pixel, so the first row lies at `y_range_mm[0]`.
    pub fn image(
        values: impl Into<CowArray<'a, f64, Ix2>>,
        x_range_mm: [f64; 2],
        y_range_mm: [f64; 2],
    ) -> ImagePanel<'a> {
        ImagePanel::new(values.into(), x_range_mm, y_range_mm)
    }

    /// Lines over x and y.
    pub fn lines(series: Vec<Series>) -> ChartPanel {
        ChartPanel::new(series)
    }

    /// A section through an optical system.
    pub fn layout(scene: LayoutScene) -> LayoutPanel {
        LayoutPanel::new(scene)
    }

    /// The panel as the figure sees it.
    fn content(&self) -> &dyn Content {
        match self {
            Panel::Image(panel) => panel,
            Panel::Lines(panel) => panel,
            Panel::Layout(panel) => panel,
        }
    }
}

impl<'a> From<ImagePanel<'a>> for Panel<'a> {
    fn from(panel: ImagePanel<'a>) -> Self {
        Panel::Image(panel)
    }
}

impl From<ChartPanel> for Panel<'_> {
    fn from(panel: ChartPanel) -> Self {
        Panel::Lines(panel)
    }
}

impl From<LayoutPanel> for Panel<'_> {
    fn from(panel: LayoutPanel) -> Self {
        Panel::Layout(panel)
    }
}

/// Panels in rows under a title; plots of a row share their height.
#[derive(Clone, Debug)]
pub struct Figure<'a> {
    title: String,
    rows: Vec<Vec<Panel<'a>>>,
    width: f64,
}

/// A panel with its place.
struct Placed<'f> {
    content: &'f dyn Content,
    plot: Rect,
    /// Lines of the title and of the notes, broken to the panel's width.
    title: Vec<String>,
    notes: Vec<String>,
}

impl<'a> Figure<'a> {
    /// Panels in rows from the top, under a title ("" for none), 1200 pixels wide.
    pub fn new(rows: Vec<Vec<Panel<'a>>>, title: impl Into<String>) -> Self {
        Figure {
            title: title.into(),
            rows,
            width: 1200.0,
        }
    }

    /// The figure's width in pixels, from 200 to 10000; the height follows.
    pub fn width(mut self, pixels: f64) -> Self {
        self.width = pixels.clamp(200.0, 10_000.0);
        self
    }

    /// The figure as PNG with `scale` device pixels per pixel of [`Figure::width`].
    pub fn to_png(&self, scale: f64) -> Result<Vec<u8>, FigureError> {
        // The drawing says how high it is, so the number of pixels is known before they exist.
        let refuse = |height| FigureError::Scale {
            scale,
            width: self.width * scale,
            height: height * scale,
        };
        if !(scale > 0.0 && self.width * scale <= MOST_PIXELS) {
            return Err(refuse(f64::NAN));
        }
        let (svg, height) = self.drawn(scale)?;
        let [nx, ny] = [self.width, height].map(|v| (v * scale).round().max(1.0));
        if ny > MOST_PIXELS {
            return Err(refuse(height));
        }

        // The built-in letters replace every family.
        let options = Options {
            fontdb: FONTS.clone(),
            font_family: FONT_FAMILY.into(),
            ..Options::default()
        };
        let tree = Tree::from_str(&svg, &options)?;
        let mut pixels = Pixmap::new(nx as u32, ny as u32).ok_or_else(|| refuse(height))?;
        pixels.fill(resvg::tiny_skia::Color::WHITE);
        let scaled = Transform::from_scale(scale as f32, scale as f32);
        resvg::render(&tree, scaled, &mut pixels.as_mut());

        // The ground is opaque, so the alpha channel says nothing.
        let mut bytes = Vec::with_capacity(pixels.data().len() / 4 * 3);
        for pixel in pixels.data().chunks_exact(4) {
            bytes.extend_from_slice(&pixel[..3]);
        }
        Ok(encode_rgb([nx as usize, ny as usize], &bytes)?)
    }

    /// The figure as SVG, whose pictures have `density` device pixels per pixel, with its height in pixels.
    fn drawn(&self, density: f64) -> Result<(String, f64), FigureError> {
        let mut svg = Svg::default();

        // The title over everything.
        let mut y = BORDER;
        for line in wrap(&self.title, FIGURE_TITLE_SIZE, self.width - 2.0 * BORDER) {
            let baseline = [self.width / 2.0, y + 0.8 * FIGURE_TITLE_SIZE];
            svg.text(
                baseline,
                &line,
                ink(FIGURE_TITLE_SIZE, Anchor::Middle),
                false,
            );
            y += 1.3 * FIGURE_TITLE_SIZE;
        }
        if !self.title.is_empty() {
            y += 8.0;
        }

        // Row after row.
        for (row, sizes) in self.rows.iter().zip(self.sizes()) {
            let placed = self.place(row, &sizes, &mut y);
            for panel in &placed {
                draw_heading(&mut svg, panel);
                panel.content.draw(&mut svg, panel.plot, density)?;
            }
            y += GAP[1];
        }
        let gap = if self.rows.is_empty() { 0.0 } else { GAP[1] };
        let height = (y - gap + BORDER).ceil();
        Ok((svg.finish(self.width, height), height))
    }

    /// Plot sizes and margins of every panel.
    ///
    /// Margins depend on tick labels and those on plot sizes, so both are found in a few rounds.
    fn sizes(&self) -> Vec<Vec<([f64; 2], Margins)>> {
        let start = |panel: &Panel| [300.0 * panel.content().aspect().ratio(), 300.0];
        let rows = self.rows.iter();
        let mut plots: Vec<Vec<_>> = rows.map(|r| r.iter().map(start).collect()).collect();
        let mut margins = self.margins(&plots);
        for _ in 0..3 {
            for ((row, plot), margin) in self.rows.iter().zip(&mut plots).zip(&margins) {
                *plot = self.row_plots(row, margin);
            }
            margins = self.margins(&plots);
        }
        let zipped = plots.into_iter().zip(margins);
        zipped
            .map(|(p, m)| p.into_iter().zip(m).collect())
            .collect()
    }

    /// Margins for plots of these sizes; in a grid, columns share theirs so that plots line up.
    fn margins(&self, plots: &[Vec<[f64; 2]>]) -> Vec<Vec<Margins>> {
        let rows = self.rows.iter().zip(plots);
        let mut margins: Vec<Vec<Margins>> = rows
            .map(|(row, sizes)| {
                let panels = row.iter().zip(sizes);
                panels.map(|(p, size)| p.content().margins(*size)).collect()
            })
            .collect();
        let columns = margins.first().map_or(0, Vec::len);
        if margins.iter().all(|row| row.len() == columns) {
            for column in 0..columns {
                let most = |side: fn(&Margins) -> f64| {
                    margins.iter().map(|r| side(&r[column])).fold(0.0, f64::max)
                };
                let (left, right) = (most(|m| m.left), most(|m| m.right));
                for row in &mut margins {
                    (row[column].left, row[column].right) = (left, right);
                }
            }
        }
        margins
    }

    /// Plot sizes of a row that fill the figure's width at one common height.
    fn row_plots(&self, row: &[Panel], margins: &[Margins]) -> Vec<[f64; 2]> {
        let aspects: Vec<Aspect> = row.iter().map(|p| p.content().aspect()).collect();
        let taken: f64 = margins.iter().map(|m| m.left + m.right).sum();
        let gaps = GAP[0] * row.len().saturating_sub(1) as f64;
        let room = self.width - 2.0 * BORDER - gaps - taken;
        let ratios: f64 = aspects.iter().map(|a| a.ratio()).sum();
        let most = match aspects.as_slice() {
            [Aspect::Fixed(_)] => MOST_ALONE,
            _ => HEIGHTS[1],
        };
        let height = (room / ratios).clamp(HEIGHTS[0], most).round();

        // Plots too wide even at the least height become narrower, and what they show keeps its shape inside.
        let narrowed = match height > HEIGHTS[0] {
            true => 1.0,
            false => (room / (height * ratios)).clamp(0.05, 1.0),
        };

        // Plots that may be wider share what is left.
        let left = (room - height * ratios).max(0.0);
        let flexible = |a: &Aspect| match a {
            Aspect::Flexible(ratio) => *ratio,
            Aspect::Fixed(_) => 0.0,
        };
        let shares: f64 = aspects.iter().map(flexible).sum();
        let width = |a: &Aspect| {
            let share = if shares > 0.0 {
                flexible(a) / shares
            } else {
                0.0
            };
            (a.ratio() * height * narrowed + share * left).floor()
        };
        aspects.iter().map(|a| [width(a), height]).collect()
    }

    /// Places a row's panels below `y`, which moves to the row's bottom.
    fn place<'f>(
        &self,
        row: &'f [Panel],
        sizes: &[([f64; 2], Margins)],
        y: &mut f64,
    ) -> Vec<Placed<'f>> {
        // A row that cannot fill the width is centred.
        let outer = |([w, _], m): &([f64; 2], Margins)| m.left + w + m.right;
        let gaps = GAP[0] * row.len().saturating_sub(1) as f64;
        let total: f64 = sizes.iter().map(outer).sum::<f64>() + gaps;
        let mut x = ((self.width - total) / 2.0).max(BORDER);

        // Titles start at the plot's left edge and may run to the panel's right end.
        let mut placed: Vec<Placed> = Vec::new();
        for (panel, size) in row.iter().zip(sizes) {
            let ([w, h], margins) = *size;
            let content = panel.content();
            let Heading { title, notes } = content.heading();
            let room = w + margins.right;
            let plot = Rect {
                x: (x + margins.left).round(),
                y: 0.0,
                w,
                h,
            };
            let title = wrap(&title, TITLE_SIZE, room);
            let notes = notes
                .iter()
                .flat_map(|n| wrap(n, NOTE_SIZE, room))
                .collect();
            placed.push(Placed {
                content,
                plot,
                title,
                notes,
            });
            x += outer(size) + GAP[0];
        }

        // The highest heading sets where the plots of the row begin.
        let top = placed.iter().map(heading_height).fold(0.0, f64::max);
        placed
            .iter_mut()
            .for_each(|p| p.plot.y = (*y + top).round());
        let bottom = sizes.iter().map(|([_, h], m)| h + m.bottom);
        *y = (*y + top).round() + bottom.fold(0.0, f64::max);
        placed
    }
}

/// Height of a panel's title and notes with the space below them.
fn heading_height(panel: &Placed) -> f64 {
    let title = 1.25 * TITLE_SIZE * panel.title.len() as f64;
    title + 1.3 * NOTE_SIZE * panel.notes.len() as f64 + 6.0
}

/// Writes title and notes so that they end just above the plot.
fn draw_heading(svg: &mut Svg, panel: &Placed) {
    let mut y = panel.plot.y - heading_height(panel);
    for line in &panel.title {
        let baseline = [panel.plot.x, y + 0.85 * TITLE_SIZE];
        svg.text(baseline, line, ink(TITLE_SIZE, Anchor::Start), false);
        y += 1.25 * TITLE_SIZE;
    }
    let look = Letters {
        size: NOTE_SIZE,
        colour: FAINT,
        anchor: Anchor::Start,
    };
    for line in &panel.notes {
        svg.text([panel.plot.x, y + 0.85 * NOTE_SIZE], line, look, false);
        y += 1.3 * NOTE_SIZE;
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use resvg::usvg::{Options, Tree};

    use crate::chart_panel::Series;
    use crate::colour::ColourMap;
    use crate::decoded_png::DecodedPng;
    use crate::figure::{BORDER, Figure, Panel};
    use crate::section_panel::{Curve, CurveKind, Label, LayoutScene, RayPath};

    /// A figure with every kind of panel.
    fn every_kind() -> Figure<'static> {
        let values = Array2::from_shape_fn((7, 5), |(y, x)| (y * x) as f64 - 3.0);
        let image = Panel::image(values, [-0.1, 0.1], [-0.14, 0.14]).title("a <b> & c");
        let lines = Panel::lines(vec![Series::line(
            "loss",
            (0..9).map(|i| [f64::from(i), 1.0]),
        )]);
        let scene = LayoutScene {
            rays: vec![RayPath {
                points: vec![[0.0, 1.0], [9.0, -1.0]],
                group: 0,
            }],
            surfaces: vec![Curve {
                points: vec![[4.0, -1.0], [4.0, 1.0]],
                kind: CurveKind::Doe,
            }],
            labels: vec![Label {
                at: [4.0, 1.0],
                text: "DOE".into(),
            }],
            ..Default::default()
        };
        let rows = vec![
            vec![image.colours(ColourMap::Difference).into(), lines.into()],
            vec![Panel::layout(scene).into()],
        ];
        Figure::new(rows, "every kind of panel")
    }

    #[test]
    fn svg_is_valid_and_png_has_its_size() {
        let svg = every_kind().drawn(2.0).unwrap().0;
        let size = Tree::from_str(&svg, &Options::default()).unwrap().size();
        for scale in [0.5, 2.0] {
            let picture = DecodedPng::of(&every_kind().to_png(scale).unwrap());
            let want = [size.width(), size.height()].map(|v| (f64::from(v) * scale).round());
            assert_eq!([picture.width as f64, picture.height as f64], want);
        }
        assert_eq!(size.width(), 1200.0);
    }

    #[test]
    fn plots_stay_inside_the_figure_and_apart() {
        let figure = every_kind();
        let mut y = 0.0;
        for (row, sizes) in figure.rows.iter().zip(figure.sizes()) {
            let placed = figure.place(row, &sizes, &mut y);
            for pair in placed.windows(2) {
                assert!(pair[0].plot.right() + 40.0 < pair[1].plot.x);
            }
            let last = placed.last().unwrap();
            assert!(placed[0].plot.x > 30.0 && last.plot.right() < 1190.0);
        }
    }

    /// A sensor's three pictures, with their colour bars, for square, wide, narrow and tall sensors.
    #[test]
    fn panels_and_bars_lie_inside_whatever_the_shape() {
        for (nx, ny) in [(64, 64), (257, 32), (128, 4), (4, 128), (1000, 2), (24, 1)] {
            let values = Array2::from_shape_fn((ny, nx), |(y, x)| 1e4 * (x + y) as f64);
            let panel = || {
                let (w, h) = (nx as f64 * 1e-3, ny as f64 * 1e-3);
                Panel::image(values.clone(), [-w, w], [-h, h]).quantity("|U|²", "")
            };
            let colours = [panel(), panel().log(), panel().colours(ColourMap::Phase)];
            let rows = vec![colours.map(Panel::from).to_vec(); 2];
            let figure = Figure::new(rows, "").width(1500.0);
            let mut y = BORDER;
            for (row, sizes) in figure.rows.iter().zip(figure.sizes()) {
                let placed = figure.place(row, &sizes, &mut y);
                for (panel, (_, margins)) in placed.iter().zip(&sizes) {
                    let ends = [
                        panel.plot.x - margins.left,
                        panel.plot.right() + margins.right,
                    ];
                    let inside = ends[0] >= BORDER - 1.0 && ends[1] <= 1501.0 - BORDER;
                    assert!(inside && panel.plot.w > 50.0, "{nx} x {ny}: {ends:?}");
                }
                for pair in placed.windows(2) {
                    assert!(pair[0].plot.right() < pair[1].plot.x, "{nx} x {ny}");
                }
            }
        }
    }

    #[test]
    fn the_largest_value_at_plus_x_plus_y_appears_at_the_top_right() {
        // Each corner pixel of the array has its own grey, the largest at [last, last].
        let mut values = Array2::from_elem((4, 4), 0.5);
        (values[[0, 0]], values[[0, 3]]) = (0.0, 0.2);
        (values[[3, 0]], values[[3, 3]]) = (0.8, 1.0);
        let panel = Panel::image(values, [0.0, 1.0], [0.0, 1.0]).colours(ColourMap::Grey);
        let figure = Figure::new(vec![vec![panel.into()]], "").width(400.0);
        let mut y = BORDER;
        let plot = figure.place(&figure.rows[0], &figure.sizes()[0], &mut y)[0].plot;
        let picture = DecodedPng::of(&figure.to_png(2.0).unwrap());

        // Look into the middle of each corner square.
        let grey = |x: f64, y: f64| {
            let place = [plot.x + x * plot.w, plot.y + y * plot.h];
            let [r, g, b] = picture.at(place.map(|v| (2.0 * v) as usize));
            assert_eq!((r, r), (g, b));
            r
        };
        assert_eq!([grey(0.125, 0.125), grey(0.875, 0.125)], [204, 255]);
        assert_eq!([grey(0.125, 0.875), grey(0.875, 0.875)], [0, 51]);
        // Squares are crisp: the values reach to three device pixels from their border.
        assert_eq!([grey(0.24, 0.125), grey(0.26, 0.125)], [204, 128]);
    }

    #[test]
    fn unusable_scales_are_refused() {
        for scale in [0.0, -1.0, f64::NAN, 1e3] {
            let error = every_kind().to_png(scale).unwrap_err().to_string();
            assert!(
                error.starts_with("figure: expected a positive scale"),
                "{error}"
            );
        }
    }
}
