//! A smooth source: one beamlet a window.
//!
//! The light of a source is its carrier under every window, so it needs one direction there, and Gaussians that add up
//! to one instead of their squares. The windows stop where no beamlet reaches the target: the light falls off by itself.

use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::emission::Emitted;
use crate::engine::local_bands::held_light::{source_carrier, source_field};
use crate::engine::local_bands::target::Target;
use crate::optics::source::Source;
use crate::optics::system::Hop;
use crate::wave::local_bands::tiling::{Tile, Tiling};

/// A smooth source and where its light is wanted.
pub struct SourceWindows<'a> {
    /// The source.
    pub source: &'a Source,
    /// The hop from the first screen.
    pub hop: &'a Hop<'a>,
    /// Where the light is wanted.
    pub target: &'a Target,
    /// Where windows stand.
    pub tiling: &'a Tiling,
    /// Whether the aberration inside beamlets is made good.
    pub corrected: bool,
}

impl SourceWindows<'_> {
    /// The beamlets of one tile.
    pub fn tile(&self, tile: &Tile) -> Emitted {
        let [columns, rows] = tile.windows.clone();
        let mut out = Emitted::default();
        for window in rows.flat_map(|j| columns.clone().map(move |i| [i, j])) {
            self.window(window, &mut out);
        }
        out
    }

    fn window(&self, window: [usize; 2], out: &mut Emitted) {
        let (hop, k) = (self.hop, self.hop.wavenumber());
        let [x, y] = &self.tiling.positions;
        let at = self.tiling.centre(window);
        let start = ChirpedStart {
            carrier: source_carrier(self.source, hop.from, at),
            sigma: x.sigma,
        };
        let field = source_field(self.source, hop.from, at, k);
        let energy = field.norm_sqr();
        let Ok(mut arrival) = start.launch(hop, [0.0; 2]) else {
            out.account.lost += energy;
            return;
        };
        if !self.target.meets(&arrival, k) {
            out.account.beside += energy;
            return;
        }
        let density = x.step * y.step / (std::f64::consts::TAU * x.sigma * y.sigma);
        arrival.amplitude *= field * density;
        let found = start.wave_aberration(hop);
        out.account.aberrated += energy * found.map_or(1.0, |found| found.eta().powi(2));
        out.account.left += energy * found.map_or(1.0, |found| found.left().powi(2));
        if let Some(found) = found.filter(|_| self.corrected) {
            arrival.amplitude *= found.correction();
        }
        out.account.windows += 1;
        out.account.modes += 1;
        out.account.beamlets += 1;
        out.account.kept += energy;
        out.arrivals.push(arrival);
    }
}
