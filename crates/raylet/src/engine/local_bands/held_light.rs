//! The light that arrives at a screen: of the source, or as beamlets.

use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::local_bands::source::source_light::{source_carrier, source_values};
use crate::optics::screen::Screen;
use crate::optics::source::Source;
use crate::wave::beamlet::beamlet_kernel::Moments;
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::gather::Gather;
use crate::wave::local_bands::local_band::{Spread, WindowBlock, bright_amplitude};
use crate::wave::local_bands::tiling::raster;

/// The directions of a source are looked at so many σ beyond the corners of a tile: there its windows are weak.
const SEEN: f64 = 2.0;

/// Beamlets on the screen to which they came, in the groups in which they came.
#[derive(Clone, Debug)]
pub(crate) struct HeldBeamlets {
    arrivals: Vec<Arrival>,
    groups: Vec<Group>,
    /// Place of the first beamlet of each tile.
    starts: Vec<usize>,
    /// Amplitude of the bright ones.
    bright: f64,
    /// Vacuum wavenumber in rad/mm.
    k: f64,
    /// Beamlets end at this share of their peak.
    edge: f64,
}

/// Neighbouring beamlets and the box of their footprints.
#[derive(Clone, Debug)]
struct Group {
    members: Range<usize>,
    bounds: [f64; 4],
}

/// The light that arrives at a screen.
#[derive(Clone, Copy)]
pub(crate) enum ArrivingLight<'a> {
    /// That of the source, on the first screen.
    Source(&'a Source, &'a Screen, f64),
    /// Beamlets.
    Beamlets(&'a HeldBeamlets),
}

/// The light under one tile, before it is summed.
pub(crate) struct TileLight<'a> {
    light: ArrivingLight<'a>,
    /// The beamlets that its windows see, and their places among all.
    selected: Vec<Arrival>,
    places: Vec<usize>,
    /// The wave that runs along with it.
    pub carrier: Carrier,
    /// How far its directions differ from the carrier's.
    pub spread: Spread,
}

impl HeldBeamlets {
    /// Beamlets of many tiles, tile by tile.
    pub(crate) fn new(tiles: Vec<Vec<Arrival>>, k: f64, edge: f64) -> Self {
        let (mut groups, mut starts) = (Vec::new(), Vec::new());
        let mut arrivals = Vec::with_capacity(tiles.iter().map(Vec::len).sum());
        for mut tile in tiles {
            starts.push(arrivals.len());
            if tile.is_empty() {
                continue;
            }
            let mut bounds = [f64::INFINITY, f64::NEG_INFINITY].repeat(2);
            for arrival in &tile {
                let reach = arrival.footprint(k, edge);
                for a in 0..2 {
                    bounds[2 * a] = bounds[2 * a].min(arrival.at[a] - reach[a]);
                    bounds[2 * a + 1] = bounds[2 * a + 1].max(arrival.at[a] + reach[a]);
                }
            }
            let first = arrivals.len();
            arrivals.append(&mut tile);
            groups.push(Group {
                members: first..arrivals.len(),
                bounds: [bounds[0], bounds[1], bounds[2], bounds[3]],
            });
        }
        let bright = bright_amplitude(&arrivals);
        Self {
            arrivals,
            groups,
            starts,
            bright,
            k,
            edge,
        }
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.arrivals.len()
    }

    /// Whether footprints of a tile of them meet a box.
    fn is_near(&self, area: [f64; 4]) -> bool {
        self.groups.iter().any(|group| meet(&group.bounds, area))
    }

    /// The place of the first beamlet of a tile.
    pub(crate) fn start(&self, tile: usize) -> usize {
        self.starts[tile]
    }

    /// The places of those whose footprints meet a box.
    fn within(&self, area: [f64; 4]) -> Vec<usize> {
        let near = |place: &usize| {
            let arrival = &self.arrivals[*place];
            let reach = arrival.footprint(self.k, self.edge);
            let [x, y] = arrival.at;
            let bounds = [x - reach[0], x + reach[0], y - reach[1], y + reach[1]];
            meet(&bounds, area)
        };
        let groups = self.groups.iter().filter(|group| meet(&group.bounds, area));
        groups
            .flat_map(|group| group.members.clone().filter(near))
            .collect()
    }
}

/// Whether two boxes meet.
fn meet(b: &[f64; 4], area: [f64; 4]) -> bool {
    b[0] <= area[1] && b[1] >= area[0] && b[2] <= area[3] && b[3] >= area[2]
}

impl<'a> ArrivingLight<'a> {
    /// Whether there may be light in a box.
    pub(crate) fn is_near(&self, area: [f64; 4]) -> bool {
        match self {
            Self::Source(..) => true,
            Self::Beamlets(beamlets) => beamlets.is_near(area),
        }
    }

    /// How many beamlets are held.
    pub(crate) fn held(&self) -> usize {
        match self {
            Self::Source(..) => 0,
            Self::Beamlets(beamlets) => beamlets.count(),
        }
    }

    /// The light under a block of windows that lie within `area`, its carrier found from what is within some `radius`
    /// of the middle, or at the point to which `open` moves the middle, where light goes on; nothing where it is dark.
    pub(crate) fn under(
        &self,
        block: &WindowBlock,
        area: [f64; 4],
        radius: f64,
        open: impl Fn([f64; 2]) -> [f64; 2],
    ) -> Option<TileLight<'a>> {
        let [x0, x1, y0, y1] = block.centres;
        let middle = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
        match self {
            Self::Source(source, screen, k) => {
                let carrier = source_carrier(source, screen, open(middle)).about(middle);
                let corner = |x: f64, y: f64| {
                    let at = open([x, y]);
                    let exact = source_carrier(source, screen, at).p;
                    let linear = carrier.cosines(at);
                    [0, 1].map(|a| (exact[a] - linear[a]).abs())
                };
                // Windows reach beyond their centres: near a point the directions there differ by more.
                let seen = SEEN * block.sigma;
                let [x0, x1, y0, y1] = [x0 - seen, x1 + seen, y0 - seen, y1 + seen];
                let corners = [
                    corner(x0, y0),
                    corner(x0, y1),
                    corner(x1, y0),
                    corner(x1, y1),
                ];
                let fading = source.spread_at(screen.frame.origin, k * screen.index) * screen.index;
                let widest = |a: usize| corners.iter().fold(0.0f64, |m, c| m.max(c[a]));
                let spread = Spread::even([0, 1].map(|a| widest(a) + fading));
                Some(TileLight {
                    light: *self,
                    selected: Vec::new(),
                    places: Vec::new(),
                    carrier,
                    spread,
                })
            }
            Self::Beamlets(beamlets) => {
                let places = beamlets.within(area);
                let all = &beamlets.arrivals;
                let selected: Vec<Arrival> = places.iter().map(|place| all[*place]).collect();
                let carrier = Carrier::fit(&selected, middle, radius)?;
                let block = WindowBlock {
                    bright: beamlets.bright,
                    ..*block
                };
                Some(TileLight {
                    light: *self,
                    spread: block.spread(&selected, &carrier),
                    selected,
                    places,
                    carrier,
                })
            }
        }
    }
}

impl TileLight<'_> {
    /// The direction of the light of a source at a point, less that of the carrier; zero for beamlets.
    pub(crate) fn beside(&self, at: [f64; 2]) -> [f64; 2] {
        match self.light {
            ArrivingLight::Source(source, screen, _) => {
                let exact = source_carrier(source, screen, at).p;
                let linear = self.carrier.cosines(at);
                [0, 1].map(|a| exact[a] - linear[a])
            }
            ArrivingLight::Beamlets(_) => [0.0; 2],
        }
    }

    /// The carrier of the light of a source about another point, nearest which light goes on at `open`; that of the tile itself
    /// for beamlets.
    pub(crate) fn carrier_about(&self, at: [f64; 2], open: [f64; 2]) -> Carrier {
        match self.light {
            ArrivingLight::Source(source, screen, _) => {
                source_carrier(source, screen, open).about(at)
            }
            ArrivingLight::Beamlets(_) => self.carrier.about(at),
        }
    }

    /// The light over its carrier at samples, [y, x], and how many values were evaluated.
    pub(crate) fn at(&self, samples: &[Axis; 2]) -> (Array2<Complex64>, u64) {
        match self.light {
            ArrivingLight::Source(source, screen, k) => {
                let values = source_values(source, screen, &self.carrier, samples, k);
                (values, 0)
            }
            ArrivingLight::Beamlets(beamlets) => {
                self.gather(beamlets, samples).apply(&self.selected)
            }
        }
    }

    /// The conjugate transpose with respect to the amplitudes of the beamlets: their places among all, with the moments of
    /// the cotangent under each, of which the first is the cotangent of its amplitude; none for light of a source.
    pub(crate) fn at_adjoint(
        &self,
        samples: &[Axis; 2],
        bar: &Array2<Complex64>,
    ) -> Vec<(usize, Moments)> {
        let ArrivingLight::Beamlets(beamlets) = self.light else {
            return Vec::new();
        };
        let gather = self.gather(beamlets, samples);
        let bars = gather.apply_adjoint(&self.selected, bar);
        self.places.iter().copied().zip(bars).collect()
    }

    fn gather(&self, beamlets: &HeldBeamlets, samples: &[Axis; 2]) -> Gather {
        Gather {
            carrier: self.carrier,
            raster: raster(samples),
            k: beamlets.k,
            edge: beamlets.edge,
        }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::engine::local_bands::held_light::{ArrivingLight, HeldBeamlets};
    use crate::fixtures::noise::noise;
    use crate::wave::beamlet::wavelet::Arrival;
    use crate::wave::grid::field::Axis;
    use crate::wave::local_bands::local_band::WindowBlock;

    #[test]
    fn at_dot_product() {
        let amplitudes = noise((6, 8), 0);
        let beamlet = |j: usize, i: usize| Arrival {
            at: [0.1 * i as f64, 0.12 * j as f64],
            cosines: [0.01 * i as f64, -0.02 * j as f64],
            amplitude: amplitudes[[j, i]],
            curvature: [
                Complex64::new(0.1, 0.05),
                Complex64::new(0.0, 0.01),
                Complex64::new(-0.2, 0.04),
            ],
        };
        let tile = |j: usize| (0..8).map(|i| beamlet(j, i)).collect();
        let held = HeldBeamlets::new((0..6).map(tile).collect(), 6e3, 1e-3);
        let light = ArrivingLight::Beamlets(&held);
        let block = WindowBlock {
            centres: [0.3, 0.4, 0.2, 0.3],
            sigma: 0.05,
            threshold: 1e-3,
            bright: 0.0,
        };
        let under = light
            .under(&block, [0.1, 0.6, 0.0, 0.5], 0.2, |at| at)
            .unwrap();
        let samples = [Axis::uniform(31, 0.02, 0.35), Axis::uniform(29, 0.02, 0.25)];
        let (there, _) = under.at(&samples);
        let bar = noise(there.dim(), 1);
        let back = under.at_adjoint(&samples, &bar);
        let inner = |a: &Array2<Complex64>, b: &Array2<Complex64>| -> Complex64 {
            a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
        };
        let forward = inner(&bar, &there);
        let all: Vec<&Complex64> = amplitudes.iter().collect();
        let reverse: Complex64 = back
            .iter()
            .map(|(place, moments)| moments[0].conj() * all[*place])
            .sum();
        assert!((forward - reverse).norm() < 1e-11, "{forward} {reverse}");
    }
}
