//! The part of the next screen that beamlets must reach: the aperture of the next screen, or the pixels of a sensor.

use crate::optics::aperture::Aperture;
use crate::optics::screen::{Screen, ScreenKind};
use crate::wave::beamlet::wavelet::Arrival;

/// Distance from an aperture up to which light is summed, in σ of its windows: the sinc sums at its edge need it.
pub(crate) const MARGIN: f64 = 2.5;

/// The part of the receiving screen that matters.
#[derive(Clone, Debug)]
pub(crate) struct TargetRegion {
    /// Its box, `[x_min, x_max, y_min, y_max]` in mm.
    pub bounds: [f64; 4],
    /// The aperture inside; open for a sensor.
    aperture: Aperture,
    /// Distance from the aperture up to which light is summed, in mm.
    margin: f64,
    /// Beamlets end at this share of their peak.
    pub edge: f64,
}

impl TargetRegion {
    /// A screen's part that matters and a margin around it; nothing when the screen has no edge.
    pub(crate) fn of(screen: &Screen, margin: f64, edge: f64) -> Option<Self> {
        let [x0, x1, y0, y1] = screen.bounds()?;
        let (aperture, margin) = match &screen.kind {
            ScreenKind::Sensor(_) => (Aperture::OPEN, 0.0),
            ScreenKind::Stop(aperture) => (aperture.clone(), margin),
            ScreenKind::Doe(doe) => (doe.aperture.clone(), margin),
        };
        Some(Self {
            bounds: [x0 - margin, x1 + margin, y0 - margin, y1 + margin],
            aperture,
            margin,
            edge,
        })
    }

    /// Whether a point of the screen lies in its aperture, or on the sensor.
    pub(crate) fn holds(&self, [x, y]: [f64; 2]) -> bool {
        let [x0, x1, y0, y1] = self.bounds;
        let inside = (x0..=x1).contains(&x) && (y0..=y1).contains(&y);
        inside && self.aperture.contains(x, y)
    }

    /// Whether a beamlet's footprint may meet it.
    pub(crate) fn meets(&self, arrival: &Arrival, k: f64) -> bool {
        let reach = arrival.footprint(k, self.edge);
        let beside = (0..2).any(|a| {
            let [low, high] = [self.bounds[2 * a], self.bounds[2 * a + 1]];
            arrival.at[a] + reach[a] < low || arrival.at[a] - reach[a] > high
        });
        let depth = self.aperture.depth(arrival.at[0], arrival.at[1]);
        !beside && depth > -self.margin - reach[0].max(reach[1])
    }
}
