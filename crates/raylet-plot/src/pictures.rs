//! The pictures of a result: the light on the sensor and the diffractive elements.

#![expect(
    clippy::indexing_slicing,
    reason = "axes are 0 and 1, and fields are numbered by their own wavelengths"
)]

use std::f64::consts::PI;

use ndarray::{Array2, ArrayView2, Axis};
use num_complex::Complex64;
use raylet::file::arrays::npz::Fields;
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::pixels::pixel_grid::PixelForm;

use crate::chart_panel::Series;
use crate::colour::ColourMap;
use crate::figure::{Figure, Panel};
use crate::panel::FigureError;
use crate::sensor_panels::{DECADES, PHASE_FLOOR, Quantity, SensorPanels, SensorRow};

/// Most samples of an element's picture along either axis.
const MOST_SAMPLES: usize = 1000;

/// Samples along the longer side of an element that has no pixels.
const SMOOTH_SAMPLES: f64 = 600.0;

/// Device pixels per pixel of a figure.
const SCALE: f64 = 1.5;

/// The light on the sensor as PNG, of runs with these names: the panels of [`SensorPanels`].
///
/// # Errors
/// A picture that cannot be drawn.
pub fn sensor_png(
    fields: &Fields,
    title: &str,
    names: &[String],
    is_sweep: bool,
) -> Result<Vec<u8>, FigureError> {
    let centres = [fields.x_mm.to_vec(), fields.y_mm.to_vec()];
    let plan = SensorPanels::new([&centres[0], &centres[1]], names, is_sweep);
    let light = |row: &SensorRow| {
        // The light of one run, or of all together.
        let field = row
            .channel
            .map(|channel| fields.field.index_axis(Axis(0), channel));
        let intensity = match &field {
            Some(field) => field.mapv(|u| u.norm_sqr()),
            None => fields.total_intensity(),
        };
        Light {
            phase: field.map(|field| lit_phase(field, &intensity)),
            intensity,
        }
    };
    let lights: Vec<Light> = plan.rows.iter().map(light).collect();
    let rows = plan.rows.iter().zip(&lights).map(|(row, light)| {
        let panels = row.quantities.iter().map(|quantity| match plan.line {
            Some(axis) => light.curve(*quantity, &centres[axis], axis, &row.note),
            None => light.picture(*quantity, plan.ranges_mm, &row.note),
        });
        panels.collect()
    });
    let rows = rows.collect();
    Figure::new(rows, title).width(1500.0).to_png(SCALE)
}

/// The light that a row of panels shows.
struct Light {
    intensity: Array2<f64>,
    /// Of one run; not a number in the dark.
    phase: Option<Array2<f64>>,
}

impl Light {
    /// What a panel shows, and the name and unit of its values.
    fn values(&self, quantity: Quantity) -> (&Array2<f64>, [&'static str; 2]) {
        match (quantity, &self.phase) {
            (Quantity::Phase, Some(phase)) => (phase, ["phase", "rad"]),
            _ => (&self.intensity, ["|U|²", ""]),
        }
    }

    /// A panel of colours.
    fn picture(&self, quantity: Quantity, [xs, ys]: [[f64; 2]; 2], note: &str) -> Panel<'_> {
        let (values, [name, unit]) = self.values(quantity);
        let panel = Panel::image(values, xs, ys).quantity(name, unit);
        let panel = panel.title(quantity.title());
        let panel = match quantity {
            Quantity::Intensity => panel,
            Quantity::Log => panel.decades(DECADES),
            Quantity::Phase => panel.colours(ColourMap::Phase),
        };
        let panel = panel.missing("intensity below 10⁻⁴ of its maximum");
        match note {
            "" => panel.into(),
            note => panel.note(note).into(),
        }
    }

    /// A panel with a curve, of a single line of pixels.
    fn curve(&self, quantity: Quantity, centres: &[f64], axis: usize, note: &str) -> Panel<'_> {
        let (values, [name, unit]) = self.values(quantity);
        let most = values.fold(0.0, |most: f64, v| most.max(*v));
        let scale = match quantity {
            Quantity::Log if most > 0.0 => most,
            _ => 1.0,
        };
        let points = centres
            .iter()
            .zip(values)
            .map(|(at, value)| [*at, value / scale]);
        let title = [quantity.title(), note].join(if note.is_empty() { "" } else { ", " });
        let panel = Panel::lines(vec![Series::line("", points)]).title(title);
        let panel = panel.x_axis(["x", "y"][axis], "mm");
        match quantity {
            Quantity::Intensity => panel.y_axis(name, unit),
            Quantity::Log => {
                let lowest = 10f64.powi(-(DECADES as i32));
                let panel = panel.y_axis(format!("{name} / maximum"), unit);
                panel.log_y().y_range([lowest, 1.0])
            }
            Quantity::Phase => panel.y_axis(name, unit).y_range([-PI, PI]),
        }
        .into()
    }
}

/// The phase where there is light enough for it to mean something.
fn lit_phase(field: ArrayView2<Complex64>, intensity: &Array2<f64>) -> Array2<f64> {
    let floor = PHASE_FLOOR * intensity.fold(0.0, |max: f64, v| max.max(*v));
    let lit = |u: &Complex64| u.norm_sqr() > floor;
    field.mapv(|u| if lit(&u) { u.arg() } else { f64::NAN })
}

/// One wavelength's view of a diffractive element.
#[derive(Clone, Copy, Debug)]
pub struct DoeView<'a> {
    /// The element as it acts at this wavelength.
    pub doe: &'a Doe,
    /// The wavelength in micrometres.
    pub wavelength_um: f64,
}

/// A diffractive element as PNG: phase and amplitude of its transmission over its aperture, a row for
/// each wavelength; nothing when the element has no edge.
///
/// # Errors
/// A picture that cannot be drawn.
pub fn doe_png(views: &[DoeView], name: &str) -> Result<Option<Vec<u8>>, FigureError> {
    let mut rows = Vec::new();
    for view in views {
        let Some(bounds) = view.doe.bounds() else {
            return Ok(None);
        };
        rows.push(doe_panels(view, bounds, views.len() > 1));
    }
    let figure = Figure::new(rows, format!("Element '{name}'"));
    figure.to_png(SCALE).map(Some)
}

/// The transmission of an element over a box of its plane, at the centres of equal cells [y, x]: its pixels where
/// they are not too many. Zero where it is not open.
pub fn doe_map(doe: &Doe, bounds: [f64; 4]) -> Array2<Complex64> {
    let [x0, x1, y0, y1] = bounds;
    let [nx, ny] = samples(doe, bounds);
    let steps = [(x1 - x0) / nx as f64, (y1 - y0) / ny as f64];
    let place = |i: usize, low: f64, step: f64| low + (i as f64 + 0.5) * step;
    Array2::from_shape_fn((ny, nx), |(j, i)| {
        let (x, y) = (place(i, x0, steps[0]), place(j, y0, steps[1]));
        match doe.aperture.contains(x, y) {
            true => doe.transmission(x, y),
            false => Complex64::ZERO,
        }
    })
}

/// Phase and amplitude over the aperture.
fn doe_panels(view: &DoeView, bounds: [f64; 4], several: bool) -> Vec<Panel<'static>> {
    let [x0, x1, y0, y1] = bounds;
    let values = doe_map(view.doe, bounds);
    let (ny, nx) = values.dim();
    let steps = [(x1 - x0) / nx as f64, (y1 - y0) / ny as f64];
    let dark = |u: &Complex64| *u == Complex64::ZERO;
    let phase = values.mapv(|u| if dark(&u) { f64::NAN } else { u.arg() });
    let mut panel = Panel::image(phase, [x0, x1], [y0, y1])
        .title("Phase")
        .missing("no light passes")
        .colours(ColourMap::Phase)
        .quantity("phase", "rad");
    if several {
        panel = panel.note(format!("λ = {} µm", view.wavelength_um));
    }
    if let Some(note) = coarseness(view.doe, bounds, steps) {
        panel = panel.note(note);
    }
    let amplitude = values.mapv(|u| u.norm());
    let most = amplitude.fold(0.0, |max: f64, v| max.max(*v));
    let amplitude = Panel::image(amplitude, [x0, x1], [y0, y1])
        .title("Amplitude")
        .colours(ColourMap::Grey)
        .range([0.0, if most > 0.0 { most } else { 1.0 }])
        .quantity("|t|", "");
    vec![panel.into(), amplitude.into()]
}

/// Samples of a picture along a pixel that is off centre, or turned.
const PLACED_FINENESS: f64 = 4.0;

/// Samples [nx, ny] of a picture of an element: its pixels where they are not too many.
fn samples(doe: &Doe, [x0, x1, y0, y1]: [f64; 4]) -> [usize; 2] {
    let sizes = [x1 - x0, y1 - y0];
    match doe.pixels() {
        // Interpolated pixels are shown with what lies between them.
        Some(pixels) => [0, 1].map(|a| {
            let fine = match pixels.form {
                PixelForm::Bilinear | PixelForm::BandLimited => 4.0,
                _ if !pixels.placement.is_none() => PLACED_FINENESS,
                _ => 1.0,
            };
            let count = (fine * sizes[a] / pixels.pitch[a]).round();
            (count as usize).clamp(1, MOST_SAMPLES)
        }),
        None => {
            let longest = sizes[0].max(sizes[1]);
            sizes.map(|size| (SMOOTH_SAMPLES * size / longest).ceil().max(2.0) as usize)
        }
    }
}

/// A warning where the picture's samples are too far apart for the element.
fn coarseness(doe: &Doe, bounds: [f64; 4], steps: [f64; 2]) -> Option<String> {
    let steep = doe.steepest(bounds);
    let pixels = doe.pixels().map(|pixels| pixels.pitch);
    let skipped = pixels.is_some_and(|pitch| (0..2).any(|a| steps[a] > 1.01 * pitch[a]));
    let smooth = doe
        .layers
        .iter()
        .any(|layer| !matches!(layer, Layer::Pixels(_)));
    let aliased = smooth && (0..2).any(|a| steep[a] * steps[a] > PI);
    (skipped || aliased).then(|| String::from("finer than the picture: only some points are shown"))
}
