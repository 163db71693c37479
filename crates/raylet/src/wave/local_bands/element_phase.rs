//! The smooth part of an element's phase under a tile: its carrier, and how far it turns light beside that.

use crate::optics::aperture::Aperture;
use crate::optics::doe::{Doe, Layer, Term};
use crate::optics::phase::profile::Profile;
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::pixel_parts::LightOverParts;

/// The phase of an element, or of a stop, which has none.
#[derive(Clone, Debug)]
pub(crate) struct ElementPhase<'a> {
    /// The element, where it is one.
    pub doe: Option<&'a Doe>,
    /// What is open.
    pub aperture: Aperture,
}

/// A tile as an element meets it.
#[derive(Clone, Debug)]
pub(crate) struct TileArea {
    /// The box of the light that counts, `[x_min, x_max, y_min, y_max]` in mm.
    pub bounds: [f64; 4],
    /// Samples of the arriving light.
    pub samples: [Axis; 2],
    /// Half the band of the arriving light under a window.
    pub half_band: [f64; 2],
    /// Largest pitch of nodes where the element has edges, in mm.
    pub edge_pitch: f64,
    /// Widest part of a pixel over which the light of a smooth wave under a window is linear, in mm.
    pub pixel_part: f64,
    /// The relative error that light which is not linear over parts of pixels may cause, along each axis.
    pub part_error: f64,
    /// Root mean square direction of the arriving light beside its carrier.
    pub spread: [f64; 2],
    /// Largest direction beside the arriving light's in which plane waves are computed.
    pub reach: [f64; 2],
    /// Vacuum wavenumber in rad/mm.
    pub k: f64,
    /// Complex values that an array may have.
    pub values_allowed: f64,
}

impl TileArea {
    /// What the light asks of the parts of pixels along an axis.
    pub(crate) fn over_parts(&self, a: usize) -> LightOverParts {
        LightOverParts {
            spread: self.spread[a],
            reach: self.reach[a],
            k: self.k,
            allowed: self.part_error,
        }
    }
}

/// Pitches of the nodes from a singular point beyond which its slopes are resolved.
const FAR_FROM_CORE: f64 = 8.0;

/// Steps of the search for the edge of an aperture.
const HALVINGS: usize = 20;

/// Points along each axis at which the band of a smooth phase is sampled.
const BAND_SAMPLES: usize = 9;

impl<'a> ElementPhase<'a> {
    fn layers(&self) -> &'a [Layer] {
        self.doe.map_or(&[][..], |doe| &doe.layers)
    }

    /// Its analytic phases, of sums those of the strongest term.
    fn profiles(&self) -> impl Iterator<Item = &'a Profile> {
        self.layers().iter().flat_map(|layer| match layer {
            Layer::Sum(terms) => strongest(terms).iter().filter_map(phase).collect(),
            _ => Vec::from_iter(phase(layer)),
        })
    }

    /// How far the directions of all terms of its sums differ from that of the strongest at a point.
    fn beside_strongest(&self, [x, y]: [f64; 2], k: f64) -> [f64; 2] {
        let slope = |layers: &[Layer]| {
            let slopes = layers
                .iter()
                .filter_map(phase)
                .map(|own| own.gradient(x, y));
            slopes.fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
        };
        let mut total = [0.0; 2];
        for layer in self.layers() {
            let Layer::Sum(terms) = layer else { continue };
            let main = slope(strongest(terms));
            for (a, total) in total.iter_mut().enumerate() {
                let others = terms
                    .iter()
                    .map(|(_, layers)| (slope(layers)[a] - main[a]).abs());
                *total += others.fold(0.0, f64::max) / k;
            }
        }
        total
    }

    /// The smooth part of its phase about a point, as a carrier; singular phases take part where the singular point
    /// is at least `far` away.
    pub(crate) fn carrier(&self, at: [f64; 2], far: f64, k: f64) -> Carrier {
        let none = Carrier {
            at,
            p: [0.0; 2],
            q: [0.0; 3],
        };
        let [x, y] = self.within(at);
        let smooth = |profile: &&Profile| !has_core(profile, at, far);
        let inside =
            self.profiles()
                .filter(smooth)
                .fold(Carrier { at: [x, y], ..none }, |sum, profile| {
                    let slope = profile.gradient(x, y).map(|g| g / k);
                    sum.times(slope, profile.hessian(x, y).map(|h| h / k))
                });
        inside.about(at)
    }

    /// The last point in the aperture on the way from its centre to a point: no light passes outside, where a phase may be
    /// anything.
    pub(crate) fn within(&self, at: [f64; 2]) -> [f64; 2] {
        let centre = self.aperture.centre;
        let place = |share: f64| [0, 1].map(|a| centre[a] + share * (at[a] - centre[a]));
        let holds = |[x, y]: [f64; 2]| self.aperture.contains(x, y);
        if holds(at) || !holds(centre) {
            return at;
        }
        let halved = |[low, high]: [f64; 2], _| {
            let middle = 0.5 * (low + high);
            if holds(place(middle)) {
                [middle, high]
            } else {
                [low, middle]
            }
        };
        place((0..HALVINGS).fold([0.0, 1.0], halved)[0])
    }

    /// The direction that its smooth phase adds at a point, less that of `carrier`.
    pub(crate) fn beside(&self, carrier: &Carrier, far: f64, at: [f64; 2], k: f64) -> [f64; 2] {
        let at = self.within(at);
        let mut p = carrier.cosines(at).map(|p| -p);
        for profile in (self.profiles()).filter(|profile| !has_core(profile, carrier.at, far)) {
            let slope = profile.gradient(at[0], at[1]);
            p = [p[0] + slope[0] / k, p[1] + slope[1] / k];
        }
        p
    }

    /// Whether a singular point of its phase may lie under a tile.
    pub(crate) fn has_core(&self, carrier: &Carrier, far: f64) -> bool {
        self.profiles()
            .any(|profile| has_core(profile, carrier.at, far))
    }

    /// Whether the core of a vortex may lie under a tile.
    pub(crate) fn has_vortex(&self, carrier: &Carrier, far: f64) -> bool {
        self.profiles()
            .any(|profile| profile.vortex_charge().is_some() && has_core(profile, carrier.at, far))
    }

    /// Half the band of the light behind the element: that of the arriving light and of the phase beside its carrier.
    pub(crate) fn band(&self, area: &TileArea, carrier: &Carrier, far: f64) -> [f64; 2] {
        let mut widest = [0.0f64; 2];
        let [x0, x1, y0, y1] = area.bounds;
        let place = |low: f64, high: f64, i: usize| {
            low + (high - low) * i as f64 / (BAND_SAMPLES - 1) as f64
        };
        if self.doe.is_some() {
            for n in 0..BAND_SAMPLES * BAND_SAMPLES {
                let at = [
                    place(x0, x1, n % BAND_SAMPLES),
                    place(y0, y1, n / BAND_SAMPLES),
                ];
                let beside = self.beside(carrier, far, at, area.k);
                let others = self.beside_strongest(at, area.k);
                let singular = self.singular_slope(carrier, far, at, area);
                let all = |a: usize| beside[a].abs() + others[a] + singular[a];
                widest = [0, 1].map(|a| widest[a].max(all(a)));
            }
        }
        [0, 1].map(|a| area.half_band[a] + widest[a])
    }

    /// How far the phases with a singular point under the tile turn light at a place; no more than they do at a small distance
    /// from that point.
    fn singular_slope(
        &self,
        carrier: &Carrier,
        far: f64,
        at: [f64; 2],
        area: &TileArea,
    ) -> [f64; 2] {
        let at = self.within(at);
        let closest = area.edge_pitch * FAR_FROM_CORE;
        let cores = self.profiles().filter(|own| has_core(own, carrier.at, far));
        cores.fold([0.0; 2], |sum, own| {
            let own = own.gradient_beside(at, closest);
            [0, 1].map(|a| sum[a] + own[a].abs() / area.k)
        })
    }
}

/// Whether a layer is an analytic phase.
pub(crate) fn is_phase(layer: &Layer) -> bool {
    phase(layer).is_some()
}

/// The analytic phase of a layer, if it is one.
pub(crate) fn phase(layer: &Layer) -> Option<&Profile> {
    match layer {
        Layer::Phase(profile) => Some(profile),
        Layer::Pixels(_) | Layer::Sum(_) | Layer::OnSurface(..) => None,
    }
}

/// The layers of the strongest term of a sum.
fn strongest(terms: &[Term]) -> &[Layer] {
    let brighter = |a: &&Term, b: &&Term| a.0.norm_sqr().total_cmp(&b.0.norm_sqr());
    let main = terms.iter().max_by(brighter);
    main.map_or(&[], |(_, layers)| layers)
}

/// Whether a phase has a point, not farther than this from a place, at which it is not smooth.
pub(super) fn has_core(profile: &Profile, at: [f64; 2], far: f64) -> bool {
    let distance = |[x, y]: [f64; 2]| (x - at[0]).hypot(y - at[1]);
    profile
        .singular_point()
        .is_some_and(|core| distance(core) <= far)
}
