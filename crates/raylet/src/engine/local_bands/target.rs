//! The part of the next screen that beamlets must reach: the aperture of the next screen, or the pixels of a sensor.

use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::optics::aperture::Aperture;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::Hop;
use crate::wave::beamlet::wavelet::{Arrival, Tail};

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

    /// At most this share of a beamlet's energy falls on its box beyond the end of the footprint: none where the footprint
    /// covers the box.
    pub(crate) fn cut(&self, arrival: &Arrival, tail: &Tail, k: f64) -> f64 {
        let [x0, x1, y0, y1] = self.bounds;
        let corners = [[x0, y0], [x1, y0], [x0, y1], [x1, y1]];
        match corners.iter().all(|at| arrival.decay(*at, k) >= self.edge) {
            true => 0.0,
            false => tail.share.min(self.edge.powi(2)),
        }
    }

    /// The energy of the first orders of a grating of windows that falls on its box, over that of the light itself in a direction
    /// Δp beside the carrier, of which the share `own` does; at most one. Orders are `beside` the light, in optical cosines.
    pub(crate) fn orders(
        &self,
        hop: &Hop,
        start: &ChirpedStart,
        [p, q]: [f64; 2],
        beside: f64,
        own: f64,
    ) -> f64 {
        let directions = [
            [p + beside, q],
            [p - beside, q],
            [p, q + beside],
            [p, q - beside],
        ];
        let landed = start.launch_all(hop, &directions);
        let share = |order| Tail::of(order, self.bounds, hop.wavenumber()).share;
        let mean = landed.iter().flatten().map(share).sum::<f64>() / directions.len() as f64;
        (mean / own.max(f64::MIN_POSITIVE)).min(1.0)
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

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
    use crate::engine::local_bands::target::TargetRegion;
    use crate::fixtures::parts::{on_axis, open_screen, screen, sensor};
    use crate::optics::frame::Frame;
    use crate::optics::system::Hop;
    use crate::wave::beamlet::wavelet::{Arrival, Tail};
    use crate::wave::local_bands::carrier::Carrier;

    const K: f64 = 1e4;
    const EDGE: f64 = 1e-3;

    /// A beamlet that lands here, longer along one diagonal.
    fn beamlet(at: [f64; 2], width: f64) -> Arrival {
        let decay = |part: f64| Complex64::new(0.0, part / (K * width * width));
        Arrival {
            at,
            cosines: [0.0; 2],
            curvature: [decay(1.0), decay(-0.6), decay(1.0)],
            amplitude: Complex64::ONE,
        }
    }

    /// The share of a beamlet's energy on a box beyond the end of its footprint, by a sum over a fine grid.
    fn summed(beamlet: &Arrival, [x0, x1, y0, y1]: [f64; 4], width: f64) -> f64 {
        let count = 400;
        let place =
            |low: f64, high: f64, i: usize| low + (high - low) * (i as f64 + 0.5) / count as f64;
        let decays = (0..count * count)
            .map(|n| [place(x0, x1, n % count), place(y0, y1, n / count)])
            .map(|at| beamlet.decay(at, K));
        let beyond: f64 = decays.filter(|d| *d < EDGE).map(|d| d * d).sum();
        let whole = std::f64::consts::PI * width * width / (1.0f64 - 0.6 * 0.6).sqrt();
        beyond * (x1 - x0) * (y1 - y0) / (count * count) as f64 / whole
    }

    #[test]
    fn footprints_cut_off_what_lies_beyond_them() {
        let target = TargetRegion::of(&screen(on_axis(1.0), sensor(20, 0.1)), 0.0, EDGE).unwrap();
        for (width, at, covers) in [
            (0.8, [0.0, 0.0], true),
            (0.8, [0.6, 0.6], true),
            (0.6, [0.6, -0.6], false),
            (0.4, [0.0, 0.0], false),
            (0.1, [0.3, 0.2], false),
            (0.3, [1.5, 0.0], false),
        ] {
            let beamlet = beamlet(at, width);
            let tail = Tail::of(&beamlet, target.bounds, K);
            let [told, summed] = [
                target.cut(&beamlet, &tail, K),
                summed(&beamlet, target.bounds, width),
            ];
            assert_eq!(told == 0.0, covers, "{width} {at:?}: {told:e}");
            assert_eq!(summed == 0.0, covers, "{width} {at:?}: {summed:e}");
            assert!(summed <= told, "{width} {at:?}: {summed:e} of {told:e}");
        }
    }

    /// Windows of 0.2 mm about a focus 20 mm on: their orders land 0.04 mm beside it, within a sensor of 0.2 mm and beside one of
    /// 0.02 mm.
    #[test]
    fn orders_count_as_far_as_they_land_on_the_sensor() {
        let start = ChirpedStart {
            carrier: Carrier {
                at: [0.3, 0.0],
                p: [-0.015, 0.0],
                q: [-0.05, 0.0, -0.05],
            },
            sigma: 0.2,
        };
        let from = open_screen(Frame::GLOBAL);
        let orders = |pitch: f64| {
            let to = screen(on_axis(20.0), sensor(10, pitch));
            let hop = Hop {
                wavelength: 0.5e-3,
                from: &from,
                train: &[],
                to: &to,
            };
            let target = TargetRegion::of(&to, 0.0, 1e-3).unwrap();
            target.orders(&hop, &start, [0.0; 2], 0.5e-3 / 0.25, 1.0)
        };
        assert!(orders(0.02) > 0.99, "{}", orders(0.02));
        assert!(orders(0.002) < 0.01, "{}", orders(0.002));
    }
}
