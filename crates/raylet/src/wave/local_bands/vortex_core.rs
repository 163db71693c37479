//! The core of a vortex at the equal nodes of a tile.
//!
//! A vortex sends light of its core in all directions, as l/2πf². Sampled at the nodes, what lies beyond their Nyquist rate comes
//! back below it, where it is a tenth of the light at half that rate and all of it at the rate itself. So the nodes about the core
//! have the transmission without that light: exp(ilφ)·F(r), F(r) = l·∫W(q)·J_l(qr)/q dq, with a pass band W that falls from one to
//! zero about the Nyquist rate. Without W the integral is one.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use crate::math::bessel::bessel_j;
use crate::optics::doe::Doe;
use crate::wave::grid::field::Axis;
use crate::wave::grid::singular_cells::SingularNodes;
use crate::wave::local_bands::element_phase::has_core;
use crate::wave::local_bands::element_samples::Element;

/// Where the pass band has fallen to a half, in turns from node to node, and its width: W(f) = ½erfc((f − HALF)/WIDTH).
const HALF: f64 = 0.5;
const WIDTH: f64 = 0.025;

/// Frequencies over which the fall of the pass band is summed, in turns: from this much below to this much above.
const FALL: f64 = 0.1;
const FALL_STEP: f64 = 0.01;

/// Distance from the core, in nodes, beyond which F is one to 1e-7.
const FARTHEST: f64 = 40.0;

/// Steps of the tables of F, in nodes, and of l·∫J_l(t)/t dt.
const STEP: f64 = 1.0 / 16.0;
const BESSEL_STEP: f64 = 0.1;

/// F about the core of a vortex, by the distance from it in nodes.
struct VortexCore {
    table: HermiteTable,
}

impl VortexCore {
    /// For a charge without its sign.
    fn new(charge: u32) -> Self {
        let hard = below_frequency(charge, TAU * (HALF + FALL) * FARTHEST);

        // A soft pass band is a sum of hard ones, by how fast it falls at each frequency.
        let count = (FALL / FALL_STEP).round() as i32;
        let falls: Vec<[f64; 2]> = (-count..=count)
            .map(|n| {
                let beside = f64::from(n) * FALL_STEP;
                let share = (-(beside / WIDTH).powi(2)).exp() * FALL_STEP / (WIDTH * PI.sqrt());
                [TAU * (HALF + beside), share]
            })
            .collect();
        let soft = |r: f64| {
            falls.iter().fold([0.0; 2], |[sum, rate], [q, share]| {
                let [value, slope] = hard.at(q * r);
                [sum + share * value, rate + share * q * slope]
            })
        };
        let nodes = 0..=(FARTHEST / STEP).ceil() as usize;
        Self {
            table: HermiteTable {
                step: STEP,
                nodes: nodes.map(|n| soft(n as f64 * STEP)).collect(),
            },
        }
    }

    /// F at a distance.
    fn at(&self, nodes: f64) -> f64 {
        match nodes < FARTHEST {
            true => self.table.at(nodes)[0],
            false => 1.0,
        }
    }
}

/// l·∫J_l(t)/t dt from zero to points of a table, with its derivative.
fn below_frequency(charge: u32, last: f64) -> HermiteTable {
    let l = f64::from(charge);
    let rate = |t: f64| match t > 0.0 {
        true => l * bessel_j(charge, t) / t,
        false if charge == 1 => 0.5,
        false => 0.0,
    };
    let mut nodes = vec![[0.0, rate(0.0)]];
    for n in 0..=(last / BESSEL_STEP).ceil() as usize {
        // Simpson's rule from point to point.
        let [sum, low] = nodes[n];
        let at = |part: f64| (n as f64 + part) * BESSEL_STEP;
        let (middle, high) = (rate(at(0.5)), rate(at(1.0)));
        nodes.push([sum + BESSEL_STEP / 6.0 * (low + 4.0 * middle + high), high]);
    }
    HermiteTable {
        step: BESSEL_STEP,
        nodes,
    }
}

/// A function by its values and slopes at equal steps from zero on.
struct HermiteTable {
    step: f64,
    /// Value and slope.
    nodes: Vec<[f64; 2]>,
}

impl HermiteTable {
    /// Value and slope at a place, from the cubic between its neighbours.
    fn at(&self, x: f64) -> [f64; 2] {
        let place = x / self.step;
        let n = (place as usize).min(self.nodes.len() - 2);
        let t = place - n as f64;
        let [[low, low_slope], [high, high_slope]] = [self.nodes[n], self.nodes[n + 1]];
        let (a, b) = (low_slope * self.step, high_slope * self.step);
        let rise = high - low;
        let (square, cube) = (3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise);
        [
            low + t * (a + t * (square + t * cube)),
            (a + t * (2.0 * square + 3.0 * t * cube)) / self.step,
        ]
    }
}

impl Element<'_> {
    /// What nodes of a tile have about singular points not farther than `far` from its carrier's place `at`: over cells where there
    /// are pixels, otherwise about cores of vortices.
    pub(super) fn singular_nodes(&self, axes: &[Axis; 2], at: [f64; 2], far: f64) -> SingularNodes {
        let mut phases = self.phase.doe.map_or_else(Vec::new, Doe::singular_phases);
        phases.retain(|(profile, _)| has_core(profile, at, far));
        if self.pixels.is_some() {
            return SingularNodes::of_cells(&phases, axes.each_ref());
        }
        let mut factors = Vec::new();
        for (profile, core) in phases {
            let charge = profile.vortex_charge().unwrap_or(0).unsigned_abs();
            if charge > 0 {
                factors.extend(about_core(charge, core, axes));
            }
        }
        SingularNodes { factors }
    }
}

/// The factors of the nodes about a core.
fn about_core(
    charge: u32,
    core: [f64; 2],
    [x, y]: &[Axis; 2],
) -> impl Iterator<Item = ([usize; 2], Complex64)> {
    let vortex = VortexCore::new(charge);
    let pitch = x.pitch.max(y.pitch);
    let within = |axis: &Axis, at: f64| {
        let side = FARTHEST * pitch;
        axis.below(at - side)..axis.below(at + side)
    };
    let columns = within(x, core[0]);
    let node = move |j: usize, i: usize| {
        let away = (x.node(i) - core[0]).hypot(y.node(j) - core[1]);
        ([j, i], Complex64::from(vortex.at(away / pitch)))
    };
    let nodes = within(y, core[1]).flat_map(move |j| columns.clone().map(move |i| (j, i)));
    nodes.map(move |(j, i)| node(j, i))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use num_complex::Complex64;

    use crate::fixtures::parts::{element, screen};
    use crate::math::bessel::bessel_j;
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::placement::Placement;
    use crate::optics::phase::profile::Profile;
    use crate::optics::screen::ScreenKind;
    use crate::wave::grid::field::Axis;
    use crate::wave::local_bands::carrier::Carrier;
    use crate::wave::local_bands::element_samples::{Element, ElementNodes};
    use crate::wave::local_bands::fourier_axis::CellFilter;

    /// Light of a core under a Gaussian window, in directions up to nine tenths of the Nyquist rate:
    /// ∫exp(ilφ − r²/2σ² + 2πi·p·x) = 2π·i^l·exp(ilθ)·∫J_l(2πpr)·exp(−r²/2σ²)·r dr. The pass band begins to fall
    /// at nine tenths.
    #[test]
    fn cores_under_a_window_have_their_spectrum() {
        let (pitch, sigma, core) = (0.02, 0.3, [0.013, -0.004]);
        let nodes = [
            Axis::uniform(200, pitch, 0.003),
            Axis::uniform(201, pitch, 0.0),
        ];
        for charge in [1i32, 2, -3] {
            let placement = Placement {
                centre: core,
                rotation: 0.0,
            };
            let own = Profile::Vortex { charge }.placed(placement);
            let doe = element(Layer::Phase(own), Aperture::disc(9.0));
            let screen = screen(Frame::GLOBAL, ScreenKind::Doe(doe));
            let element = Element::of(&screen).unwrap();
            let flat = Carrier {
                at: [0.0; 2],
                p: [0.0; 2],
                q: [0.0; 3],
            };
            let asked = ElementNodes {
                axes: nodes.clone(),
                at_samples: false,
                far: 1.0,
                filter: [CellFilter::Points; 2],
                half_band: None,
            };
            let samples = element.samples(asked, &flat, 1e4);
            let values = samples.values.as_ref().unwrap();
            for turns in [
                [0.02, 0.05],
                [0.2, -0.1],
                [0.0, 0.35],
                [0.25, 0.3],
                [0.45, 0.0],
            ] {
                let p: [f64; 2] = turns.map(|t: f64| t / pitch);
                let mut found = Complex64::ZERO;
                for ((j, i), value) in values.indexed_iter() {
                    let at = [nodes[0].node(i) - core[0], nodes[1].node(j) - core[1]];
                    let window = (-0.5 * (at[0] * at[0] + at[1] * at[1]) / (sigma * sigma)).exp();
                    let wave = Complex64::cis(TAU * (p[0] * at[0] + p[1] * at[1]));
                    found += value * wave * (window * pitch * pitch);
                }
                let exact = spectrum(charge, sigma, p);
                let error = (found - exact).norm() / exact.norm();
                let allowed = if turns[0] < 0.4 { 1e-6 } else { 0.02 };
                assert!(error < allowed, "{charge} {turns:?}: {error:e}");
            }
        }
    }

    fn spectrum(charge: i32, sigma: f64, [px, py]: [f64; 2]) -> Complex64 {
        let rings = Axis::gauss(200, sigma * 8.0 / 200.0, sigma * 4.0, 8);
        let order = charge.unsigned_abs();
        let ring = |i: usize| {
            let r = rings.node(i);
            let window = (-0.5 * (r / sigma).powi(2)).exp();
            rings.weight(i) * r * window * bessel_j(order, TAU * px.hypot(py) * r)
        };
        let sum: f64 = (0..rings.len()).map(ring).sum();
        TAU * sum * Complex64::I.powu(order) * Complex64::cis(f64::from(charge) * py.atan2(px))
    }
}
