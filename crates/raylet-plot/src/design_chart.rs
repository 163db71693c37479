//! The picture of a design: its course, the designed pixels, and the light on the sensor.

use ndarray::{Array2, ArrayView2};
use raylet::design::constraints::modulation::Shaped;
use serde::{Deserialize, Serialize};

use crate::chart_panel::Series;
use crate::colour::ColourMap;
use crate::figure::{Figure, Panel};
use crate::panel::FigureError;

/// One iteration of a design.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Its number.
    pub iteration: usize,
    /// Evaluations so far.
    pub evaluations: usize,
    /// The loss.
    pub loss: f64,
    /// Normalised cross-correlation of the intensity with the picture, over the sensor; the mean of all
    /// channels that have one.
    pub ncc: Option<f64>,
    /// Share of the light behind the first screen that falls within the picture's outline; the mean of all
    /// channels that have one.
    pub efficiency: Option<f64>,
    /// |gradient|.
    pub slope: f64,
}

/// The data of the charts of a design.
pub struct DesignChart<'a> {
    /// Its title.
    pub title: &'a str,
    /// The iterations so far.
    pub rows: &'a [Row],
    /// The elements as made.
    pub made: &'a [Shaped],
    /// Name, half width and half height in mm of each element.
    pub elements: &'a [(String, [f64; 2])],
    /// The target picture, [y, x], if there is one.
    pub target: Option<&'a Array2<f64>>,
    /// What each channel is called, and its intensity.
    pub intensities: Vec<(String, ArrayView2<'a, f64>)>,
    /// Half width and height of the sensor in mm.
    pub sensor: [f64; 2],
}

/// Panels side by side; fewer where they are this many times as wide as high.
const COLUMNS: usize = 3;
const WIDE: f64 = 2.5;

/// Intensities that are shown.
const SHOWN: usize = 9;

impl DesignChart<'_> {
    /// The picture as PNG.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        let mut rows = vec![self.course()];
        let elements = self.elements();
        let mut seen: Vec<Panel> = Vec::new();
        let [x, y] = self.sensor.map(|half| [-half, half]);
        if let Some(target) = self.target {
            let panel = Panel::image(target.view(), x, y);
            seen.push(panel.title("Target").quantity("intensity", "").into());
        }
        for (name, intensity) in self.intensities.iter().take(SHOWN) {
            let panel = Panel::image(*intensity, x, y);
            seen.push(panel.title(name).quantity("|U|²", "").into());
        }

        // One row where that is enough, else elements and sensor apart.
        let columns = match self.sensor[0] > WIDE * self.sensor[1] {
            true => COLUMNS - 1,
            false => COLUMNS,
        };
        let groups = match elements.len() + seen.len() <= columns {
            true => vec![elements.into_iter().chain(seen).collect::<Vec<_>>()],
            false => vec![elements, seen],
        };
        for group in groups {
            rows.extend(group.chunks(columns).map(<[Panel]>::to_vec));
        }
        Figure::new(rows, self.title).to_png(1.5)
    }

    /// Scores, where there is a picture, and the loss.
    fn course(&self) -> Vec<Panel<'_>> {
        let along = |of: fn(&Row) -> Option<f64>| {
            let points = self.rows.iter();
            points
                .filter_map(move |row| Some([row.iteration as f64, of(row)?]))
                .collect::<Vec<_>>()
        };
        let (ncc, light) = (along(|row| row.ncc), along(|row| row.efficiency));
        let mut panels: Vec<Panel> = Vec::new();
        if !ncc.is_empty() {
            let scores = Panel::lines(vec![
                Series::line("NCC", ncc),
                Series::line("light in the picture", light),
            ]);
            let scores = scores.title("Score").x_axis("iteration", "");
            panels.push(scores.y_axis("share", "").y_range([0.0, 1.0]).into());
        }
        let loss = Panel::lines(vec![Series::line("loss", along(|row| Some(row.loss)))]);
        let loss = loss.title("Loss").x_axis("iteration", "");
        panels.push(loss.y_axis("loss", "").into());
        panels
    }

    /// Phases and amplitudes of the elements.
    fn elements(&self) -> Vec<Panel<'_>> {
        let pi = std::f64::consts::PI;
        let mut panels: Vec<Panel> = Vec::new();
        for (shaped, (name, half)) in self.made.iter().zip(self.elements) {
            let [x, y] = half.map(|half| [-half, half]);
            let count = shaped.phases.len();
            for (plane, made) in shaped.phases.iter().enumerate() {
                let wrapped = made.phase.mapv(|p| (p + pi).rem_euclid(2.0 * pi) - pi);
                let title = match count {
                    1 => format!("Phase of {name} as made"),
                    _ => format!("Phase {} of {name} as made", plane + 1),
                };
                let panel = Panel::image(wrapped, x, y).title(&title);
                let panel = panel.colours(ColourMap::Phase).range([-pi, pi]);
                panels.push(panel.quantity("phase", "rad").into());
            }
            if let Some(amplitude) = &shaped.amplitude {
                let panel = Panel::image(amplitude.view(), x, y);
                let panel = panel.title(format!("Amplitude of {name}"));
                panels.push(panel.range([0.0, 1.0]).quantity("|t|", "").into());
            }
        }
        panels
    }
}
