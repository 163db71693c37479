//! Pictures of a conformal diffractive mirror: its substrate, what it shows, and how each method errs.

#![expect(
    clippy::indexing_slicing,
    reason = "what is drawn is numbered by the lists it was laid out from"
)]

use ndarray::Array2;
use raylet::wave::grid::field::Field;
use raylet_plot::figure::{Figure, Panel};
use raylet_plot::panel::FigureError;

use crate::mirrors::conformal_methods::{Comparison, PropagationMethod, letter};
use crate::mirrors::conformal_mirror::{Conformal, Show};

/// Samples along each axis of the substrate's picture.
const SAMPLES: usize = 201;

/// The outer edges of a field along x and y, moved along x.
fn edges(field: &Field, shift: f64) -> [[f64; 2]; 2] {
    let [x, y] = [&field.grid.x, &field.grid.y].map(|axis| axis.edges());
    [x.map(|x| x + shift), y]
}

/// Height of the substrate in µm.
fn heights(mirror: &Conformal) -> Array2<f64> {
    let (shape, width) = (mirror.shape(), mirror.width());
    let place = |i: usize| width * ((i as f64 + 0.5) / SAMPLES as f64 - 0.5);
    Array2::from_shape_fn((SAMPLES, SAMPLES), |(j, i)| {
        let (x, y) = (place(i), place(j));
        let inside = x.hypot(y) <= 0.5 * width;
        let z = shape.height(x, y).filter(|_| inside);
        z.map_or(f64::NAN, |here| 1e3 * here.z)
    })
}

impl Comparison {
    /// The substrate and the whole sensor, then the windows by every method in the same colours.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn png(&self, title: &str, overview: &Field) -> Result<Vec<u8>, FigureError> {
        let half = 0.5 * self.mirror.width();
        let substrate = Panel::image(heights(&self.mirror), [-half, half], [-half, half])
            .title("Substrate")
            .missing("")
            .quantity("height", "µm");
        let [x, y] = edges(overview, 0.0);
        let sensor = Panel::image(overview.intensity(), x, y)
            .title("The sensor, by default")
            .quantity("|U|²", "");
        let sensor = match self.mirror.show {
            Show::Foci => sensor.log(),
            Show::Letter => sensor,
        };
        let mut rows: Vec<Vec<Panel>> = vec![vec![substrate.into(), sensor.into()]];
        if self.mirror.show == Show::Letter {
            let target = Panel::image(letter(&self.mirror, overview), x, y).title("Target");
            rows[0].push(target.quantity("intensity", "").into());
        }
        rows.push(self.windows());
        Figure::new(rows, title).to_png(1.5)
    }

    /// The first window by every method.
    fn windows(&self) -> Vec<Panel<'static>> {
        let shift = match self.mirror.show {
            Show::Foci => self.mirror.foci()[0],
            Show::Letter => 0.0,
        };
        let brightest = self.outcomes.first().map_or(1.0, |exact| {
            let bright = exact.fields[0].intensity();
            bright.iter().copied().fold(0.0, f64::max)
        });
        let panels = self.outcomes.iter().map(|outcome| {
            let field = &outcome.fields[0];
            let [x, y] = edges(field, shift);
            let note = match outcome.method {
                PropagationMethod::Exact => String::from("the reference"),
                _ => format!("error of the field {:.1e}", outcome.errors[0]),
            };
            let panel = Panel::image(field.intensity(), x, y)
                .title(outcome.method.name())
                .note(note)
                .range([0.0, brightest])
                .quantity("|U|²", "");
            panel.into()
        });
        panels.collect()
    }
}
