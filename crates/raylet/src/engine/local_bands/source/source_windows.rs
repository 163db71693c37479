//! A smooth source: one beamlet a window.
//!
//! The light of a source is its carrier under every window, so it needs one direction there, and Gaussians that add up
//! to one instead of their squares. The windows stop where no beamlet reaches the target: the light falls off by itself.

use crate::engine::error::hop_statistics::HopStatistics;
use crate::engine::error::tally::Fate;
use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::emission::Emitted;
use crate::engine::local_bands::hop_changes::{HopChanges, SentBeamlet};
use crate::engine::local_bands::passing_light::OpenGate;
use crate::engine::local_bands::source::source_aberration::source_aberration;
use crate::engine::local_bands::source::source_light::{source_carrier, source_field};
use crate::engine::local_bands::target::TargetRegion;
use crate::optics::source::Source;
use crate::optics::system::Hop;
use crate::wave::beamlet::beamlet_kernel::Moments;
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::local_bands::tiling::{Tile, Tiling};

/// The middle ray of a tile represents the others to this factor.
const SAFETY: f64 = 2.0;

/// A smooth source and the target of its light.
pub(crate) struct SourceWindows<'a> {
    /// The source.
    pub source: &'a Source,
    /// The hop from the first screen.
    pub hop: &'a Hop<'a>,
    /// The target of the light.
    pub target: &'a TargetRegion,
    /// Where windows stand.
    pub tiling: &'a Tiling,
    /// Whether the aberration inside beamlets is corrected.
    pub corrected: bool,
    /// Energy that a window of a unit wave is counted with.
    pub unit: f64,
    /// The part of the cubic phase inside beamlets that their neighbours do not cancel.
    pub left_of_cubic: f64,
    /// The bare aperture at the end of the hop, where light may pass it.
    pub gate: Option<&'a OpenGate<'a>>,
}

impl SourceWindows<'_> {
    /// The beamlets of one tile.
    pub(crate) fn send(&self, tile: &Tile) -> Emitted {
        self.send_from(&self.starts(tile))
    }

    /// The beamlets of these windows of a tile; those that pass the aperture at the end of the hop apart.
    pub(crate) fn send_from(&self, starts: &[ChirpedStart]) -> Emitted {
        let mut out = Emitted::default();
        let gate = self.gate.filter(|gate| gate.lets_pass(starts));
        let (k, edge) = (self.hop.wavenumber(), self.target.edge);
        for start in starts {
            match self.beamlet(start, &mut out.statistics) {
                Some(beamlet) if gate.is_some_and(|gate| gate.holds(&beamlet, k, edge)) => {
                    out.passing.push(*start);
                }
                beamlet => out.arrivals.extend(beamlet),
            }
        }
        out
    }

    /// The derivatives with respect to the parameters with which the hop and the light of the source change, from the
    /// moments that the cotangent has under the beamlets of one tile, which `bars` gives.
    pub(crate) fn pull(
        &self,
        tile: &Tile,
        changes: &HopChanges,
        bars: impl FnOnce(&[Arrival]) -> Vec<Moments>,
    ) -> Vec<f64> {
        let mut parameters = vec![0.0; changes.count];
        let mut statistics = HopStatistics::default();
        let sent = self.starts(tile).into_iter().filter_map(|start| {
            let beamlet = self.beamlet(&start, &mut statistics)?;
            Some((start, beamlet))
        });
        let (starts, beamlets): (Vec<ChirpedStart>, Vec<Arrival>) = sent.unzip();
        let bars = bars(&beamlets);
        for ((start, beamlet), moments) in starts.iter().zip(&beamlets).zip(&bars) {
            let sent = SentBeamlet {
                start,
                dp: [0.0; 2],
                amplitude: beamlet.amplitude,
                moments,
            };
            changes.pull_source_beamlet(&sent, &mut parameters);
        }
        parameters
    }

    /// What the windows of a tile send out; nothing where none of it reaches the target.
    fn starts(&self, tile: &Tile) -> Vec<ChirpedStart> {
        if self.misses(tile) {
            return Vec::new();
        }
        let [columns, rows] = tile.windows.clone();
        let windows = rows.flat_map(|j| columns.clone().map(move |i| [i, j]));
        windows
            .map(|window| self.start(self.tiling.centre(window)))
            .collect()
    }

    /// Whether all light of a tile lands far from the target, as its middle ray has it.
    fn misses(&self, tile: &Tile) -> bool {
        let (at, k) = (self.tiling.middle(tile), self.hop.wavenumber());
        let start = self.start(at);
        let Ok((landing, j)) = self.hop.jacobian_along(at, start.carrier.p) else {
            return false;
        };
        let Ok(middle) = start.launch(self.hop, [0.0; 2]) else {
            return false;
        };
        let reach = middle.footprint(k, self.target.edge);
        let [x0, x1, y0, y1] = self.tiling.centres(tile);
        let half = [0.5 * (x1 - x0), 0.5 * (y1 - y0)];
        (0..2).any(|a| {
            let spread = j[a][0].abs() * half[0] + j[a][1].abs() * half[1] + reach[a];
            let [low, high] = [self.target.bounds[2 * a], self.target.bounds[2 * a + 1]];
            let at = landing.at[a];
            at + SAFETY * spread < low || at - SAFETY * spread > high
        })
    }

    /// What the window about a point sends out.
    fn start(&self, at: [f64; 2]) -> ChirpedStart {
        ChirpedStart {
            carrier: source_carrier(self.source, self.hop.from, at),
            sigma: self.tiling.positions[0].sigma,
        }
    }

    /// The beamlet of a window where it lands; nothing where it does not reach the target.
    fn beamlet(&self, start: &ChirpedStart, statistics: &mut HopStatistics) -> Option<Arrival> {
        let (hop, k) = (self.hop, self.hop.wavenumber());
        let [x, y] = &self.tiling.positions;
        let field = source_field(self.source, hop.from, start.carrier.at, k);
        let energy = self.unit * field.norm_sqr();
        let mut arrival = match start.launch(hop, [0.0; 2]) {
            Ok(arrival) => arrival,
            Err(loss) => {
                statistics.tally.count(Fate::Lost(loss), energy);
                return None;
            }
        };
        if !self.target.meets(&arrival, k) {
            statistics.tally.count(Fate::Outside, energy);
            return None;
        }
        let density = x.step * y.step / (std::f64::consts::TAU * x.sigma * y.sigma);
        arrival.amplitude *= field * density;
        let found = source_aberration(start, hop, self.source);
        if self.target.holds(arrival.at) {
            let error = found.map(|found| found.error().with_part_of_cubic(self.left_of_cubic));
            statistics.tally.add_aberration(error, energy);
        }
        if let Some(found) = found.filter(|_| self.corrected) {
            arrival.amplitude *= found.correction();
        }
        statistics.tally.count(Fate::Arrived, energy);
        statistics.windows += 1;
        statistics.modes += 1;
        Some(arrival)
    }
}
