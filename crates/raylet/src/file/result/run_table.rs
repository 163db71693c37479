//! The runs of a document as a table: a row for each field of light, wavelength and distance of the sensor.

use crate::file::result::channel::Channel;
use crate::file::result::report::Report;

/// A table of a document's runs. Columns of what was not varied are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct RunTable {
    /// The names of the columns, with their units.
    pub head: Vec<&'static str>,
    /// The cells of each run; empty where there is no such number.
    pub rows: Vec<Vec<String>>,
}

/// A column: its name, and its cell of a run that aims at a target error.
type Column = (&'static str, fn(&Channel, f64) -> Option<String>);

/// What a sweep varies beside the wavelength.
const VARIED: [Column; 6] = [
    ("angle_x_deg", |run, _| number(run.place.angle_deg?.first())),
    ("angle_y_deg", |run, _| number(run.place.angle_deg?.last())),
    ("source_x_mm", |run, _| {
        number(run.place.position_mm?.first())
    }),
    ("source_y_mm", |run, _| {
        number(run.place.position_mm?.get(1))
    }),
    ("source_z_mm", |run, _| {
        number(run.place.position_mm?.last())
    }),
    ("distance_mm", |run, _| {
        number(run.place.distance_mm.as_ref())
    }),
];

/// What every run has.
const FOUND: [Column; 14] = [
    ("wavelength_um", |run, _| number(Some(&run.wavelength_um))),
    ("error", |run, _| number(run.error.as_ref())),
    ("target_error", |_, target| number(Some(&target))),
    ("target_reached", |run, _| {
        Some(run.target_reached?.to_string())
    }),
    ("light_share", |run, _| number(run.light_share.as_ref())),
    ("peak", |run, _| number(Some(&run.metrics.peak))),
    ("peak_x_mm", |run, _| number(run.metrics.peak_mm?.first())),
    ("peak_y_mm", |run, _| number(run.metrics.peak_mm?.last())),
    ("fwhm_x_um", |run, _| {
        number(run.metrics.fwhm_um[0].as_ref())
    }),
    ("fwhm_y_um", |run, _| {
        number(run.metrics.fwhm_um[1].as_ref())
    }),
    ("radius_50_um", |run, _| {
        number(run.metrics.encircled_um?.first())
    }),
    ("radius_80_um", |run, _| {
        number(run.metrics.encircled_um?.last())
    }),
    ("method", |run, _| Some(run.methods().join(" "))),
    ("seconds", |run, _| number(Some(&run.seconds))),
];

/// A number with all its digits.
fn number(value: Option<&f64>) -> Option<String> {
    Some(format!("{:?}", value?))
}

impl RunTable {
    /// The table of a document.
    pub fn new(report: &Report) -> Self {
        let (runs, target) = (&report.channels, report.settings.target_error);
        let is_varied = |(_, cell): &&Column| runs.iter().any(|run| cell(run, target).is_some());
        let columns: Vec<&Column> = VARIED.iter().filter(is_varied).chain(&FOUND).collect();
        let row = |run: &Channel| {
            let cells = columns
                .iter()
                .map(|(_, cell)| cell(run, target).unwrap_or_default());
            cells.collect()
        };
        Self {
            head: columns.iter().map(|(name, _)| *name).collect(),
            rows: runs.iter().map(row).collect(),
        }
    }

    /// The table as a CSV file. No cell holds a comma or a quote.
    pub fn csv(&self) -> String {
        let rows = self.rows.iter().map(|row| row.join(","));
        let lines = std::iter::once(self.head.join(",")).chain(rows);
        lines.map(|line| line + "\n").collect()
    }
}
