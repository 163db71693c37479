//! How one hop by local bands changes with the parameters of a system: its rays, the element on its first screen, and
//! the light of the source there.
//!
//! `beamlets_and_elements_match_differences` (in `tests/gradients/local_bands.rs`) tests the derivatives.

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::local_bands::source::source_light::{
    source_carrier, source_field, source_values,
};
use crate::engine::trace::complex_rate::pull_rate;
use crate::engine::trace::ray_sensitivity::{
    BLOCK, Number, PerturbedHops, Variation, VariedHop, pull,
};
use crate::engine::trace::ray_trace::BeamletStart;
use crate::math::complex::{Complex, Symmetric};
use crate::math::real::Real;
use crate::optics::screen::Screen;
use crate::optics::source::Source;
use crate::optics::system::Hop;
use crate::wave::beamlet::beamlet_kernel::Moments;
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::edge_sum::{EdgeBar, EdgeLight};
use crate::wave::local_bands::element_samples::{Element, ElementSamples};

/// A value a little below and a little above the planned one.
struct Perturbed<T> {
    below: T,
    above: T,
    /// The difference of the parameter's two values.
    distance: f64,
}

/// A parameter with which the rays of a hop change, or the light that the source sends into it.
struct Moving<'a> {
    parameter: usize,
    hops: PerturbedHops<'a>,
    /// The source and the first screen, where the light there changes.
    light: Option<Perturbed<(&'a Source, &'a Screen)>>,
}

/// How one hop changes with all parameters of a system.
pub(crate) struct HopChanges<'a> {
    k: f64,
    /// Number of parameters.
    pub count: usize,
    moving: Vec<Moving<'a>>,
    /// The hop with its moving parts, a block of parameters at a time.
    varied: Vec<VariedHop<'a>>,
    /// The element with each parameter that changes it.
    elements: Vec<(usize, Perturbed<Element<'a>>)>,
}

/// A beamlet that leaves a window: its start, total amplitude, and what the cotangent has under it where it lands.
pub(crate) struct SentBeamlet<'a> {
    /// The window.
    pub start: &'a ChirpedStart,
    /// Direction beside the carrier.
    pub dp: [f64; 2],
    /// Total amplitude where it lands.
    pub amplitude: Complex64,
    /// Moments of the cotangent under the beamlet, for amplitude one.
    pub moments: &'a Moments,
}

/// The samples of a tile that the source lights, their values over a carrier, and the cotangents of these.
pub(crate) struct SourceSamples<'a> {
    /// Places of the samples along x and y, in mm.
    pub samples: &'a [Axis; 2],
    /// The carrier by which the light is divided.
    pub carrier: &'a Carrier,
    /// The light, [y, x].
    pub values: &'a Array2<Complex64>,
    /// The cotangent of `values`, [y, x].
    pub bar: &'a Array2<Complex64>,
}

impl<'a> HopChanges<'a> {
    /// The changes of the hop with this number; those of the first hop take in the light of the source.
    ///
    /// # Errors
    /// When the element of a perturbed system has layers of a kind that local bands do not carry.
    pub(crate) fn new(
        variations: &'a [Variation],
        number: usize,
        hop: Hop<'a>,
    ) -> Result<Self, LocalBandError> {
        let all = || variations.iter().enumerate();
        let moving: Vec<Moving> = all()
            .filter_map(|(parameter, variation)| {
                let hops = variation.hop(number)?;
                let light = light_of(variation).filter(|_| number == 0);
                let still = hops.below.is_same(&hop) && hops.above.is_same(&hop);
                (!still || light.is_some()).then_some(Moving {
                    parameter,
                    hops,
                    light,
                })
            })
            .collect();
        let varied = moving.chunks(BLOCK).map(|block| {
            let hops: Vec<PerturbedHops> = block.iter().map(|moving| moving.hops).collect();
            VariedHop::new(hop, &hops)
        });
        let mut elements = Vec::new();
        for (parameter, variation) in all() {
            if let Some(element) = element_of(variation, number)? {
                elements.push((parameter, element));
            }
        }
        Ok(Self {
            k: hop.wavenumber(),
            count: variations.len(),
            varied: varied.collect(),
            moving,
            elements,
        })
    }

    /// Adds the derivatives that a beamlet of a window brings, the window's carrier held constant.
    pub(crate) fn pull_beamlet(&self, sent: &SentBeamlet, total: &mut [f64]) {
        for (varied, block) in self.varied.iter().zip(self.moving.chunks(BLOCK)) {
            let start = constant_start(sent.start, sent.dp, self.k);
            self.pull_block(varied, block, start, sent, total);
        }
    }

    /// Adds the derivatives that the beamlet of a window of a smooth source brings, whose carrier and `field` there
    /// change with the source.
    pub(crate) fn pull_source_beamlet(&self, sent: &SentBeamlet, total: &mut [f64]) {
        let at = sent.start.carrier.at;
        for (varied, block) in self.varied.iter().zip(self.moving.chunks(BLOCK)) {
            let mut start = constant_start(sent.start, sent.dp, self.k);
            for (slot, moving) in block.iter().enumerate() {
                let Some(light) = &moving.light else { continue };
                let carrier =
                    |(source, screen): (&Source, &Screen)| source_carrier(source, screen, at);
                let (below, above) = (carrier(light.below), carrier(light.above));
                let rate = |below: f64, above: f64| (above - below) / light.distance;
                for a in 0..2 {
                    start.p[a].tangent[slot] = rate(below.p[a], above.p[a]);
                }
                let q = [&mut start.q.xx, &mut start.q.xy, &mut start.q.yy];
                for (q, (below, above)) in q.into_iter().zip(below.q.into_iter().zip(above.q)) {
                    q.re.tangent[slot] = rate(below, above);
                }
                let field =
                    |(source, screen): (&Source, &Screen)| source_field(source, screen, at, self.k);
                let change = (field(light.above) / field(light.below)).ln() / light.distance;
                total[moving.parameter] += (change * sent.amplitude * sent.moments[0].conj()).re;
            }
            self.pull_block(varied, block, start, sent, total);
        }
    }

    /// Adds the derivatives that one beamlet brings with respect to a block of parameters. A varied hop has the values of the
    /// hop itself, so a beamlet that arrived arrives again; only one at an edge may end by rounding.
    fn pull_block(
        &self,
        varied: &VariedHop,
        block: &[Moving],
        start: BeamletStart<Number>,
        sent: &SentBeamlet,
        total: &mut [f64],
    ) {
        let Ok(carried) = varied.carry_from(start) else {
            return;
        };
        let parts = pull(&carried, sent.amplitude, sent.moments, self.k);
        for (moving, part) in block.iter().zip(parts) {
            total[moving.parameter] += part;
        }
    }

    /// Adds the derivatives that an element brings whose transmission changes: from that at the nodes of a tile over
    /// the element's `carrier` there, and its cotangent.
    pub(crate) fn pull_element(
        &self,
        samples: &ElementSamples,
        carrier: &Carrier,
        bar: &Array2<Complex64>,
        total: &mut [f64],
    ) {
        let Some(here) = &samples.values else { return };
        for (parameter, pair) in &self.elements {
            let values = |element: &Element| element.values_at(samples, carrier, self.k);
            let (below, above) = (values(&pair.below), values(&pair.above));
            total[*parameter] += pull_rate([&below, &above], here, bar, pair.distance);
        }
    }

    /// The same for the edge under a tile, from the cotangents at its points: of the element there, and of where they lie.
    pub(crate) fn pull_edge(
        &self,
        edge: &EdgeLight,
        carrier: &Carrier,
        bar: &EdgeBar,
        total: &mut [f64],
    ) {
        let all = || edge.nodes.iter().map(|node| node.at);
        for (parameter, pair) in &self.elements {
            let values = |element: &Element| -> Vec<Complex64> {
                all()
                    .map(|at| element.value_at(at, carrier, self.k))
                    .collect()
            };
            let (below, above) = (values(&pair.below), values(&pair.above));
            let both = [&below[..], &above[..]];
            let element = pull_rate(both, &edge.through[..], &bar.through[..], pair.distance);

            // The edge moves outwards where a point comes to lie deeper inside.
            let depth = |element: &Element, [x, y]: [f64; 2]| element.aperture().depth(x, y);
            let moved = |at| depth(&pair.above, at) - depth(&pair.below, at);
            let place = all().zip(&bar.place).map(|(at, bar)| bar * moved(at));
            total[*parameter] += element + place.sum::<f64>() / pair.distance;
        }
    }

    /// Adds the derivatives that the light of the source brings on the samples of a tile.
    pub(crate) fn pull_light(&self, light: &SourceSamples, total: &mut [f64]) {
        for moving in &self.moving {
            let Some(pair) = &moving.light else { continue };
            let values = |(source, screen): (&Source, &Screen)| {
                source_values(source, screen, light.carrier, light.samples, self.k)
            };
            let (below, above) = (values(pair.below), values(pair.above));
            let part = pull_rate([&below, &above], light.values, light.bar, pair.distance);
            total[moving.parameter] += part;
        }
    }
}

/// The source and the first screen of a variation that changes the light there.
fn light_of(variation: &Variation) -> Option<Perturbed<(&Source, &Screen)>> {
    let (below, above) = (&variation.below, &variation.above);
    variation.moves_light().then_some(Perturbed {
        below: (&below.source, below.screens.first()?),
        above: (&above.source, above.screens.first()?),
        distance: variation.distance,
    })
}

/// The element of a variation on a screen; nothing where it stays the same.
fn element_of(
    variation: &Variation,
    screen: usize,
) -> Result<Option<Perturbed<Element<'_>>>, LocalBandError> {
    let pair = [&variation.below, &variation.above].map(|system| system.screens.get(screen));
    let [Some(below), Some(above)] = pair else {
        return Ok(None);
    };
    if below.kind == above.kind {
        return Ok(None);
    }
    let layers = |screen: &Screen| LocalBandError::Layers(screen.name.clone());
    Ok(Some(Perturbed {
        below: Element::of(below).ok_or_else(|| layers(below))?,
        above: Element::of(above).ok_or_else(|| layers(above))?,
        distance: variation.distance,
    }))
}

/// The start of a beamlet with a window's carrier held constant.
fn constant_start(start: &ChirpedStart, dp: [f64; 2], k: f64) -> BeamletStart<Number> {
    let Carrier { at, p, q } = start.carrier;
    let width = 1.0 / (k * start.sigma * start.sigma);
    let number = |re: f64, im: f64| Complex::new(Number::constant(re), Number::constant(im));
    BeamletStart {
        at: at.map(Number::constant),
        p: [p[0] + dp[0], p[1] + dp[1]].map(Number::constant),
        q: Symmetric {
            xx: number(q[0], width),
            xy: number(q[1], 0.0),
            yy: number(q[2], width),
        },
    }
}
