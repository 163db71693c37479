//! Power, peak and spot of the light on a sensor, as `result.json` has them.

#![expect(clippy::indexing_slicing, reason = "axes are 0 and 1")]

use ndarray::ArrayView2;
use serde::{Deserialize, Serialize};

use crate::wave::grid::field::Field;
use crate::wave::grid::metrics::{centroid, encircled_energy, fwhm, peak};

/// Micrometres in a millimetre.
const UM: f64 = 1e3;

/// Power, peak and spot of the intensity |U|² at the pixel centres of the sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Sum times pixel area, in mm² for unit amplitude.
    pub power: f64,
    /// The largest value.
    pub peak: f64,
    /// Place of the peak, [x, y] in mm; none where the sensor is dark.
    pub peak_mm: Option<[f64; 2]>,
    /// Centre of mass [x, y] in mm.
    pub centroid_mm: Option<[f64; 2]>,
    /// Full widths at half maximum through the peak, [x, y] in micrometres.
    pub fwhm_um: [Option<f64>; 2],
    /// Radii in micrometres about the centroid that hold 50 % and 80 % of the power.
    pub encircled_um: Option<[f64; 2]>,
}

impl Metrics {
    /// The metrics of a field on a sensor.
    pub(crate) fn of(field: &Field) -> Self {
        let (x, y) = (field.grid.x.nodes(), field.grid.y.nodes());
        Self::of_light(field.intensity().view(), [&x, &y], field.power())
    }

    /// The metrics of an intensity [y, x] at positions x and y in mm, with this power.
    pub(crate) fn of_light(
        intensity: ArrayView2<'_, f64>,
        [x, y]: [&[f64]; 2],
        power: f64,
    ) -> Self {
        let peak = peak(intensity);
        let centre = centroid(intensity, x, y);
        let radii = centre.and_then(|c| encircled_energy(intensity, x, y, c, &[0.5, 0.8]));
        Self {
            power,
            peak: peak.map_or(0.0, |peak| peak.value),
            peak_mm: peak.map(|peak| [x[peak.at[1]], y[peak.at[0]]]),
            centroid_mm: centre,
            fwhm_um: fwhm(intensity, x, y).map(|width| width.map(|w| w * UM)),
            encircled_um: radii.map(|r| [r[0] * UM, r[1] * UM]),
        }
    }
}
