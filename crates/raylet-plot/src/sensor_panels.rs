//! What the picture of a sensor shows: its panels, their unit and their shape, the same on the command line and in Python.

#![expect(clippy::indexing_slicing, reason = "axes are 0 and 1")]

use crate::image_panel::{stretch, unit};

/// More wavelengths than this are shown as their sum and the first of them.
pub const MOST_CHANNELS: usize = 3;

/// Phases are shown where the intensity is above this share of its maximum.
pub const PHASE_FLOOR: f64 = 1e-4;

/// Powers of ten that a logarithmic picture spans.
pub const DECADES: u32 = 5;

/// What a panel shows of the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The intensity.
    Intensity,
    /// The intensity by its logarithm, as a share of its maximum.
    Log,
    /// The phase where there is light enough for it to mean something.
    Phase,
}

impl Quantity {
    /// Its word in calls from Python.
    pub fn word(self) -> &'static str {
        match self {
            Quantity::Intensity => "intensity",
            Quantity::Log => "log",
            Quantity::Phase => "phase",
        }
    }

    /// The title of its panel.
    pub fn title(self) -> &'static str {
        match self {
            Quantity::Intensity => "Intensity",
            Quantity::Log => "Intensity, logarithmic",
            Quantity::Phase => "Phase",
        }
    }
}

/// A row of panels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SensorRow {
    /// The number of the run whose light it shows; none for the sum of all.
    pub channel: Option<usize>,
    /// What tells it from other rows; empty where there is one run.
    pub note: String,
    /// What its panels show, from the left.
    pub quantities: &'static [Quantity],
}

/// The picture of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorPanels {
    /// Its rows from the top.
    pub rows: Vec<SensorRow>,
    /// The outer edges of the sensor's pixels in x and y, in mm.
    pub ranges_mm: [[f64; 2]; 2],
    /// The unit of length along its axes, and how many of it make one millimetre.
    pub unit: (&'static str, f64),
    /// By how much pictures are stretched along x and y.
    pub stretch: [f64; 2],
    /// The axis, 0 or 1, along which a single line of pixels is drawn as a curve.
    pub line: Option<usize>,
}

impl SensorPanels {
    /// The picture of a sensor with these pixel centres in x and y, in mm: a row of intensity, its logarithm and phase for
    /// each of up to three runs with these names. Of more wavelengths it shows the summed intensity and the row of the
    /// first; of more runs of a sweep, which are no light of one moment, the first three.
    pub fn new(centres_mm: [&[f64]; 2], names: &[String], is_sweep: bool) -> Self {
        let is_summed = names.len() > MOST_CHANNELS && !is_sweep;
        let shown = if is_summed { 1 } else { MOST_CHANNELS };
        let mut rows = Vec::new();
        if is_summed {
            rows.push(SensorRow {
                channel: None,
                note: format!("sum of {} wavelengths", names.len()),
                quantities: &[Quantity::Intensity, Quantity::Log],
            });
        }
        for (channel, name) in names.iter().enumerate().take(shown) {
            rows.push(SensorRow {
                channel: Some(channel),
                note: String::from(if names.len() == 1 { "" } else { name }),
                quantities: &[Quantity::Intensity, Quantity::Log, Quantity::Phase],
            });
        }
        let ranges_mm = centres_mm.map(edges);
        let length = unit(ranges_mm);
        let counts = centres_mm.map(<[f64]>::len);
        Self {
            rows,
            ranges_mm,
            unit: (length.sign, length.per_mm),
            stretch: stretch(ranges_mm),
            line: (0..2).find(|axis| counts[*axis] > 1 && counts[1 - axis] == 1),
        }
    }
}

/// The outer edges of pixels with these centres, in mm.
pub(crate) fn edges(centres: &[f64]) -> [f64; 2] {
    let (first, last) = match centres {
        [] => return [-5e-4, 5e-4],
        [only] => (*only, *only),
        [first, .., last] => (*first, *last),
    };
    let half = match centres.len() {
        1 => 5e-4,
        n => 0.5 * (last - first) / (n - 1) as f64,
    };
    [first - half, last + half]
}

#[cfg(test)]
mod tests {
    use crate::sensor_panels::{Quantity, SensorPanels};

    /// Centres of so many pixels of 1 µm.
    fn centres(count: usize) -> Vec<f64> {
        let middle = 0.5 * (count - 1) as f64;
        (0..count).map(|i| 1e-3 * (i as f64 - middle)).collect()
    }

    fn panels(pixels: [usize; 2], runs: usize, is_sweep: bool) -> SensorPanels {
        let names: Vec<String> = (0..runs).map(|run| format!("run {run}")).collect();
        let [x, y] = pixels.map(centres);
        SensorPanels::new([&x, &y], &names, is_sweep)
    }

    #[test]
    fn up_to_three_runs_have_a_row_each() {
        for (runs, is_sweep, channels) in [
            (1, false, vec![Some(0)]),
            (3, false, vec![Some(0), Some(1), Some(2)]),
            (5, false, vec![None, Some(0)]),
            (5, true, vec![Some(0), Some(1), Some(2)]),
        ] {
            let rows = panels([8, 8], runs, is_sweep).rows;
            let found: Vec<_> = rows.iter().map(|row| row.channel).collect();
            assert_eq!(found, channels, "{runs} {is_sweep}");
            let last = rows.last().unwrap();
            let all = [Quantity::Intensity, Quantity::Log, Quantity::Phase];
            assert_eq!(last.quantities, all);
        }
        let notes = |runs| panels([8, 8], runs, false).rows[0].note.clone();
        assert_eq!(
            [1, 2, 4].map(notes),
            ["", "run 0", "sum of 4 wavelengths"].map(String::from)
        );
    }

    #[test]
    fn narrow_sensors_are_stretched_and_lines_are_curves() {
        let shape = |pixels| {
            let found = panels(pixels, 1, false);
            (found.stretch, found.line)
        };
        assert_eq!(shape([257, 32]), ([1.0, 1.0], None));
        assert_eq!(shape([128, 4]), ([1.0, 5.0], None));
        assert_eq!(shape([4, 128]), ([5.0, 1.0], None));
        assert_eq!(shape([24, 1]).1, Some(0));
        assert_eq!(shape([1, 24]).1, Some(1));
        assert_eq!(shape([1, 1]).1, None);
    }

    #[test]
    fn ranges_are_those_of_the_pixels_in_the_unit_that_fits() {
        let small = panels([200, 100], 1, false);
        let expected = [[-0.1, 0.1], [-0.05, 0.05]];
        for (found, wanted) in small
            .ranges_mm
            .iter()
            .flatten()
            .zip(expected.iter().flatten())
        {
            assert!((found - wanted).abs() < 1e-12);
        }
        assert_eq!(small.unit, ("µm", 1e3));
        assert_eq!(panels([1000, 100], 1, false).unit, ("mm", 1.0));
    }
}
