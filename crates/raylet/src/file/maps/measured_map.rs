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
}
