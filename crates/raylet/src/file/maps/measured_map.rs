//! A map: samples, pitch, unit, and what must be decided about it.

use crate::file::arrays::array::Array;

/// Samples [y, x] on a grid, the first row at the smallest y.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredMap {
    /// The samples; NaN where one is missing.
    pub values: Array,
    /// Distance of neighbouring samples along x and y in micrometres, where the file says it.
    pub pitch_um: Option<[f64; 2]>,
    /// The unit of the values, where the file says it.
    pub unit: Option<String>,
    /// What the values are in the words of the file, such as "height"; empty where it does not say.
    pub quantity: String,
    /// What a user must decide about the map, because the file leaves it open.
    pub doubts: Vec<String>,
}

impl MeasuredMap {
    /// A map of values about which nothing else is known.
    pub(crate) fn of(values: Array) -> Self {
        Self {
            values,
            pitch_um: None,
            unit: None,
            quantity: String::new(),
            doubts: Vec::new(),
        }
    }

    /// Takes note of the positions that a file gives along an axis named `axis`, in µm. Scenes have maps about their middle: one
    /// that counts from its corner is meant so, any other place is left to the user. A half step counts for sources alone.
    pub(crate) fn place(&mut self, axis: &str, [first, last]: [f64; 2], field: &str) {
        let step = (last - first).abs() / (self.count(axis).max(2) - 1) as f64;
        let middle = 0.5 * (first + last);
        let is_source = field == "samples";
        let from_corner = first.abs().min(last.abs()) <= 1e-9 * step;
        let allowed = if is_source { 1e-6 } else { 0.5 + 1e-6 };
        if middle.abs() <= allowed * step || (from_corner && !is_source) {
            return;
        }
        self.doubts.push(format!(
            "a map whose middle along {axis} is at {} mm",
            middle * 1e-3
        ));
    }

    /// Samples along an axis.
    fn count(&self, axis: &str) -> usize {
        let [ny, nx] = self.values.borrowed().shape();
        if axis == "x" { nx } else { ny }
    }
}
