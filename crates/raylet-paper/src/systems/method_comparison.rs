//! Ways to carry one system's light side by side: fields, what they cost, how alike they are, and the picture.

use std::time::Instant;

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;
use raylet::engine::chain::outcome::Progress;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::chain::simulate_error::SimulateError;
use raylet::engine::monte_carlo::repeated_runs::RepeatedRuns;
use raylet::engine::plan::settings::Settings;
use raylet::file::result::machine::Machine;
use raylet::math::part::part;
use raylet::optics::system::System;
use raylet::wave::grid::metrics::{field_error, ncc, peak, shape_error, unit_sum_mse};
use raylet_plot::chart_panel::Series;
use raylet_plot::colour::ColourMap;
use raylet_plot::figure::{Figure, Panel};
use raylet_plot::panel::FigureError;
use serde::Serialize;

/// The field of one method on the sensor, and its cost.
#[derive(Clone, Debug)]
pub struct MethodRun {
    /// Name of the method.
    pub name: String,
    /// The field on the sensor.
    pub field: Array2<Complex64>,
    /// Rays, time and memory.
    pub cost: Cost,
    /// The standard error that a random run estimated, over the norm of its field.
    pub standard_error: Option<f64>,
}

/// The cost of a field: rays, time and memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// Draws; equal to the rays where nothing is drawn.
    pub draws: f64,
    /// Rays followed.
    pub rays: u64,
    /// Seconds.
    pub seconds: f64,
    /// Most memory that the program held until then, in units of 10⁶ bytes.
    pub memory_mb: Option<f64>,
}

impl Cost {
    /// The cost of what began at `clock`.
    pub fn since(clock: Instant, rays: u64) -> Self {
        Self {
            draws: rays as f64,
            rays,
            seconds: clock.elapsed().as_secs_f64(),
            memory_mb: Machine::here().peak_memory_mb,
        }
    }
}

/// How alike a field is to a reference; absent numbers do not exist, as of dark fields.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Match {
    /// Normalised cross-correlation of the intensities, means not removed.
    pub ncc: Option<f64>,
    /// Mean square difference of the intensities after division by their sums.
    pub unit_sum_mse: Option<f64>,
    /// ‖A − B‖ / ‖B‖ of the complex fields.
    pub field_error: Option<f64>,
    /// ‖A − c·B‖ / ‖A‖ with the best complex factor c.
    pub shape_error: Option<f64>,
}

impl Match {
    /// Compares a field with a reference.
    pub fn of(field: ArrayView2<Complex64>, reference: ArrayView2<Complex64>) -> Self {
        let (a, b) = (light(field), light(reference));
        Self {
            ncc: ncc(a.view(), b.view()),
            unit_sum_mse: unit_sum_mse(a.view(), b.view()),
            field_error: field_error(field, reference),
            shape_error: shape_error(field, reference).map(|shape| shape.error),
        }
    }
}

/// |U|².
pub fn light(field: ArrayView2<Complex64>) -> Array2<f64> {
    field.mapv(|u| u.norm_sqr())
}

impl MethodRun {
    /// One run.
    ///
    /// # Errors
    /// As [`simulate`].
    pub fn once(
        name: &str,
        system: &System,
        settings: &Settings,
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<Self, SimulateError> {
        let clock = Instant::now();
        let outcome = simulate(system, settings, progress)?;
        let rays = outcome.hops.iter().map(|hop| hop.tally.total_rays()).sum();
        let cost = Cost::since(clock, rays);
        Ok(Self {
            name: name.to_owned(),
            field: outcome.field.values,
            cost,
            standard_error: None,
        })
    }

    /// What the parts of a random run have given so far.
    pub fn of_parts(name: &str, parts: &RepeatedRuns) -> Self {
        Self {
            name: name.to_owned(),
            field: parts.mean(),
            cost: Cost {
                draws: parts.draws,
                rays: parts.rays,
                seconds: parts.seconds,
                memory_mb: Machine::here().peak_memory_mb,
            },
            standard_error: parts.standard_error(),
        }
    }

    /// The run with its field on these rows and columns of the sensor only.
    pub fn cropped(&self, [rows, columns]: [std::ops::Range<usize>; 2]) -> Self {
        let part = part(self.field.view(), rows, columns);
        Self {
            field: part.to_owned(),
            ..self.clone()
        }
    }

    /// Row and column of the brightest sample.
    pub fn peak(&self) -> Option<[usize; 2]> {
        peak(light(self.field.view()).view()).map(|peak| peak.at)
    }
}

/// A picture of an intensity: its title, its values divided by their sum, and its outline in mm.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The title.
    pub title: String,
    /// A smaller line under it; empty for none.
    pub note: String,
    /// Intensities.
    pub values: Array2<f64>,
    /// Outer edges along x and along y in mm.
    pub edges: [[f64; 2]; 2],
}

/// Rows of pictures, all of one row in the same colours, and under them curves of quantities over the number of
/// draws.
///
/// # Errors
/// A picture that cannot be drawn.
pub fn figure(
    title: &str,
    rows: Vec<Vec<Shown>>,
    curves: Vec<(&str, Vec<Series>)>,
) -> Result<Vec<u8>, FigureError> {
    let mut panels: Vec<Vec<Panel>> = rows.into_iter().map(row_of_panels).collect();
    let charts = curves.into_iter().map(|(quantity, series)| {
        let chart = Panel::lines(series)
            .x_axis("secondary rays drawn", "")
            .y_axis(quantity, "")
            .log_x();
        chart.into()
    });
    panels.push(charts.collect());
    panels.retain(|row| !row.is_empty());
    Figure::new(panels, title).width(1500.0).to_png(1.5)
}

fn row_of_panels(row: Vec<Shown>) -> Vec<Panel<'static>> {
    let unit_sum = |shown: &Shown| {
        let sum = shown.values.sum();
        shown.values.mapv(|v| if sum > 0.0 { v / sum } else { v })
    };
    let values: Vec<Array2<f64>> = row.iter().map(unit_sum).collect();
    let most = values
        .iter()
        .flatten()
        .fold(0.0, |most: f64, v| most.max(*v));
    let panels = row.into_iter().zip(values).map(|(shown, values)| {
        let [x, y] = shown.edges;
        let panel = Panel::image(values, x, y)
            .title(shown.title)
            .colours(ColourMap::Inferno)
            .range([0.0, if most > 0.0 { most } else { 1.0 }])
            .quantity("share in a pixel", "");
        match shown.note.is_empty() {
            true => panel.into(),
            false => panel.note(shown.note).into(),
        }
    });
    panels.collect()
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use raylet::engine::plan::settings::Settings;
    use raylet::optics::pixels::pixel_grid::PixelForm;
    use raylet_testkit::paper_systems::near_hologram;

    use crate::systems::method_comparison::{Match, MethodRun, Shown, figure, light};

    #[test]
    fn a_way_is_like_itself_and_shown_slow() {
        let phase = Array2::from_shape_fn((12, 12), |(j, i)| (i * j) as f64);
        let system = near_hologram(&phase, PixelForm::Box);
        let run = MethodRun::once("free", &system, &Settings::default(), &|_| {}).unwrap();
        let found = Match::of(run.field.view(), run.field.view());
        assert_eq!(found.field_error, Some(0.0));
        let [row, column] = run.peak().unwrap();
        let around = run.cropped([row..row + 1, column..column + 1]);
        assert_eq!(around.peak(), Some([0, 0]));
        let shown = Shown {
            title: String::from("ours"),
            note: String::new(),
            values: light(run.field.view()),
            edges: [[-1.0, 1.0]; 2],
        };
        assert!(
            figure("one", vec![vec![shown]], Vec::new())
                .unwrap()
                .starts_with(b"\x89PNG")
        );
    }
}
