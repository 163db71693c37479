//! Cotangents of a hop: of what it sends, and of what arrives.

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::local_bands::held_light::HeldBeamlets;
use crate::engine::local_bands::hop_changes::HopChanges;
use crate::engine::local_bands::tile_run::TileBar;
use crate::engine::progress::Pulse;
use crate::optics::system::Hop;
use crate::wave::beamlet::beamlet_kernel::Moments;
use crate::wave::beamlet::direction_sectors::SectorBar;
use crate::wave::beamlet::wavelet::Arrival;

/// Tiles that the adjoint works on at a time at most: it holds the cotangents of the pixels of these tiles and of the beamlets that
/// arrived.
const CHUNK_BACK: usize = 8;

/// The cotangents of the arrived beamlets take at most this part of the memory limit.
const SHARE_BACK: usize = 4;

/// Cotangents of what a hop sends.
pub(crate) enum Bars<'a> {
    /// Of the field on the sensor.
    Sensor(&'a SectorBar),
    /// The moments that they have under beamlets that are held.
    Beamlets(&'a HeldBeamlets, &'a [Moments]),
}

/// The input of the adjoint of a hop.
pub(crate) struct Back<'a> {
    /// Cotangents of the light that the hop sends.
    pub bars: Bars<'a>,
    /// Changes of the hop with each parameter of the system.
    pub changes: HopChanges<'a>,
    /// Plane waves weaker than this were left out.
    pub weakest: f64,
    /// Called after each chunk of work.
    pub pulse: &'a Pulse<'a>,
}

/// The result of the adjoint of a hop.
pub(crate) struct HopBar {
    /// Moments of the cotangent under the beamlets that arrive at its first screen.
    pub arriving: Vec<Moments>,
    /// Cotangents of the pixels of the element there, [y, x]; nothing where it has none.
    pub pixels: Option<Array2<Complex64>>,
    /// Derivatives with respect to the parameters.
    pub parameters: Vec<f64>,
}

impl Bars<'_> {
    /// The place of the first beamlet of a tile.
    pub(crate) fn start(&self, tile: usize) -> usize {
        match self {
            Self::Sensor(_) => 0,
            Self::Beamlets(held, _) => held.start(tile),
        }
    }

    /// Of beamlets that were sent one after another from a place on.
    pub(crate) fn of(
        &self,
        beamlets: &[Arrival],
        place: usize,
        hop: &Hop,
        edge: f64,
    ) -> Vec<Moments> {
        match self {
            Self::Sensor(bar) => bar.add_adjoint(beamlets, hop.wavenumber(), edge),
            Self::Beamlets(_, bars) => bars[place..place + beamlets.len()].to_vec(),
        }
    }
}

impl HopBar {
    /// Adds what a tile found.
    pub(crate) fn add(&mut self, bar: TileBar) {
        for (place, moments) in bar.arriving {
            let total = self.arriving[place].iter_mut();
            total.zip(moments).for_each(|(total, part)| *total += part);
        }
        let total = self.parameters.iter_mut();
        total
            .zip(bar.parameters)
            .for_each(|(total, part)| *total += part);
        if let Some(pixels) = &mut self.pixels {
            for (pixel, value) in bar.pixels {
                pixels[pixel] += value;
            }
        }
    }
}

/// How many tiles the adjoint works on at a time: each may see all `held` beamlets.
pub(crate) fn chunk_back(held: usize, memory_limit: usize) -> usize {
    let of_tile = held * size_of::<(usize, Moments)>();
    (memory_limit / SHARE_BACK / of_tile.max(1)).clamp(1, CHUNK_BACK)
}

#[cfg(test)]
mod tests {
    use crate::engine::local_bands::hop_cotangents::{CHUNK_BACK, chunk_back};
    use crate::wave::beamlet::beamlet_kernel::Moments;

    /// Cotangents of what arrived at several tiles keep to a quarter of the memory limit, unless those of one tile do not.
    #[test]
    fn tiles_on_the_way_back_keep_to_the_memory_limit() {
        let limit = 24_000_000;
        for held in [0, 10, 5_000, 20_000, 60_000, 250_000] {
            let at_once = chunk_back(held, limit);
            let taken = at_once * held * size_of::<Moments>();
            assert!(4 * taken <= limit || at_once == 1, "{held}: {at_once}");
        }
        assert_eq!(chunk_back(10, limit), CHUNK_BACK);
        assert_eq!(chunk_back(20_000, limit), 2);
    }
}
