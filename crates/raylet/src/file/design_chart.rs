//! The picture of a design: how it went, what it makes, what that looks like.

use ndarray::Array2;
use serde::{Deserialize, Serialize};

use crate::design::constraint::Made;
use crate::file::chart::Series;
use crate::file::colour::ColourMap;
use crate::file::figure::{Figure, Panel};
use crate::file::panel::FigureError;

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
    /// channels.
    pub ncc: f64,
    /// Share of the light behind the element that falls within the picture's outline; the mean of all channels.
    pub efficiency: f64,
    /// |gradient|.
    pub slope: f64,
}

/// What is shown of a design.
pub struct DesignChart<'a> {
    /// Its title.
    pub title: &'a str,
    /// The iterations so far.
    pub rows: &'a [Row],
    /// The element as made.
    pub made: &'a Made,
    /// Half width and height of the element in mm.
    pub element: [f64; 2],
    /// The picture wanted and the intensity, [y, x].
    pub wanted: &'a Array2<f64>,
    /// The intensity of the first channel.
    pub intensity: &'a Array2<f64>,
    /// Half width and height of the sensor in mm.
    pub sensor: [f64; 2],
}

impl DesignChart<'_> {
    /// The picture as PNG.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        let along = |of: fn(&Row) -> f64| {
            let points = self.rows.iter();
            points
                .map(move |row| [row.iteration as f64, of(row)])
                .collect::<Vec<_>>()
        };
        let ends = |half: f64| [-half, half];
        let scores = Panel::lines(vec![
            Series::line("NCC", along(|row| row.ncc)),
            Series::line("light in the picture", along(|row| row.efficiency)),
        ])
        .title("Score")
        .x_axis("iteration", "")
        .y_axis("share", "")
        .y_range([0.0, 1.0]);
        let loss = Panel::lines(vec![Series::line("loss", along(|row| row.loss))])
            .title("Loss")
            .x_axis("iteration", "")
            .y_axis("loss", "");
        let pi = std::f64::consts::PI;
        let wrapped = self.made.phase.mapv(|p| (p + pi).rem_euclid(2.0 * pi) - pi);
        let phase = Panel::image(wrapped, ends(self.element[0]), ends(self.element[1]))
            .title("Phase as made")
            .colours(ColourMap::Phase)
            .range([-pi, pi])
            .quantity("phase", "rad");
        let (x, y) = (ends(self.sensor[0]), ends(self.sensor[1]));
        let wanted = Panel::image(self.wanted.view(), x, y)
            .title("Wanted")
            .quantity("intensity", "");
        let seen = Panel::image(self.intensity.view(), x, y)
            .title("On the sensor")
            .quantity("|U|²", "");
        let rows = vec![
            vec![scores.into(), loss.into()],
            vec![phase.into(), wanted.into(), seen.into()],
        ];
        Figure::new(rows, self.title).to_png(1.5)
    }
}
