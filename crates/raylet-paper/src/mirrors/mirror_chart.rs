//! The picture of a mirror whose pixels were designed: the pixels, what the mirror shows, and the course of the search.

#![expect(
    clippy::indexing_slicing,
    reason = "what is drawn is numbered by the lists it was laid out from"
)]

use ndarray::Array2;
use num_complex::Complex64;
use raylet::wave::grid::metrics::peak;
use raylet_plot::chart_panel::Series;
use raylet_plot::colour::ColourMap;
use raylet_plot::figure::{Figure, Panel};
use raylet_plot::panel::FigureError;

use crate::mirrors::conformal_mirror::{Conformal, Show};
use crate::mirrors::conformal_seen::Seen;

/// What is shown.
pub struct MirrorChart<'a> {
    /// Its title.
    pub title: &'a str,
    /// The mirror.
    pub mirror: &'a Conformal,
    /// The reflections of its pixels, [y, x]; zero outside its aperture.
    pub values: &'a Array2<Complex64>,
    /// Shares of the light at the samples of the sensor as the design knows them, [y, x].
    pub shares: &'a Array2<f64>,
    /// Distance of these samples in mm.
    pub pitch: f64,
    /// The target there.
    pub target: &'a Array2<f64>,
    /// What the direct integral says.
    pub seen: &'a Seen,
    /// Name of the score, and its values over the iterations.
    pub course: (&'a str, Vec<[f64; 2]>),
}

impl MirrorChart<'_> {
    /// The picture as PNG.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        let rows = match self.mirror.show {
            Show::Foci => vec![self.pixels(), self.spots()],
            Show::Letter => vec![self.pixels(), self.letters()],
        };
        Figure::new(rows, self.title).width(1500.0).to_png(1.5)
    }

    /// The pixels, and the course of the search.
    fn pixels(&self) -> Vec<Panel<'_>> {
        let half = 0.5 * self.mirror.width();
        let ends = [-half, half];
        let dark = |of: fn(&Complex64) -> f64| {
            let shown = |value: &Complex64| {
                if value.norm() > 0.0 {
                    of(value)
                } else {
                    f64::NAN
                }
            };
            self.values.map(shown)
        };
        let phase = Panel::image(dark(|value| value.arg()), ends, ends)
            .title("Phase of the pixels")
            .missing("")
            .colours(ColourMap::Phase)
            .quantity("phase", "rad");
        let mut row: Vec<Panel> = vec![phase.into()];
        if self.mirror.show == Show::Foci {
            let modulus = Panel::image(dark(|value| value.norm()), ends, ends)
                .title("Modulus of the pixels")
                .missing("")
                .range([0.0, 2.0])
                .quantity("modulus", "");
            row.push(modulus.into());
        }
        let (score, points) = &self.course;
        if points.len() > 1 {
            let lines = Panel::lines(vec![Series::line("", points.iter().copied())])
                .title("Course of the design")
                .x_axis("iteration", "")
                .y_axis(*score, "");
            row.push(lines.into());
        }
        row
    }

    /// The sensor as the design knows it.
    fn sensor(&self) -> raylet_plot::image_panel::ImagePanel<'_> {
        let half = 0.5 * self.pitch * self.shares.ncols() as f64;
        let ends = [-half, half];
        Panel::image(self.shares.view(), ends, ends)
            .title("Sensor, as the design knows it")
            .quantity("share of the light in a sample", "")
    }

    /// The sensor, both foci, and lines through the first.
    fn spots(&self) -> Vec<Panel<'_>> {
        let mut row: Vec<Panel> = vec![self.sensor().log().into()];
        for (number, field) in self.seen.fields.iter().enumerate() {
            let middle = self.seen.middles[number];
            let x = field.grid.x.edges().map(|x| x + middle);
            let panel = Panel::image(field.intensity(), x, field.grid.y.edges())
                .title(
                    [
                        "Left focus, direct integral",
                        "Right focus, direct integral",
                    ][number % 2],
                )
                .quantity("|U|²", "");
            row.push(panel.into());
        }
        if let Some(field) = self.seen.fields.first() {
            let bright = field.intensity();
            let at = peak(bright.view()).map_or([0; 2], |peak| peak.at);
            let top = bright[at];
            let (x, y) = (&field.grid.x, &field.grid.y);
            let along_x = (0..x.len()).map(|i| [x.node(i), bright[[at[0], i]] / top]);
            let along_y = (0..y.len()).map(|j| [y.node(j), bright[[j, at[1]]] / top]);
            let lines = vec![
                Series::line("along x", along_x),
                Series::line("along y", along_y),
            ];
            let panel = Panel::lines(lines)
                .title("Through the left focus")
                .x_axis("distance from the focus", "mm")
                .y_axis("|U|² over its peak", "");
            row.push(panel.into());
        }
        row
    }

    /// The target, what the design knows and what the direct integral says.
    fn letters(&self) -> Vec<Panel<'_>> {
        let half = 0.5 * self.pitch * self.target.ncols() as f64;
        let target = Panel::image(self.target.view(), [-half, half], [-half, half])
            .title("Target")
            .quantity("intensity", "");
        let mut row: Vec<Panel> = vec![target.into(), self.sensor().into()];
        for field in &self.seen.fields {
            let note = self
                .seen
                .letter
                .map_or(String::new(), |like| format!("NCC {like:.4}"));
            let panel = Panel::image(
                field.intensity(),
                field.grid.x.edges(),
                field.grid.y.edges(),
            )
            .title("Sensor, direct integral over the surface")
            .note(note)
            .quantity("|U|²", "");
            row.push(panel.into());
        }
        row
    }
}
