//! Rays of the light itself: from the source, on through every screen, as the screens turn them.
//!
//! They tell where most of the energy goes before any field is known. Behind smooth elements there is one for
//! each place; behind pixels the pixels' own diffraction makes many.

use crate::math::vec3::Vec3;
use crate::optics::screen::{Act, Screen};
use crate::optics::system::{Hop, System};

/// Places along each axis of the first screen from which rays are sent: behind pixels, where each place sends
/// many, and behind smooth elements and stops, where each sends one.
const PLACES: [usize; 2] = [7, 41];

/// Directions along each axis behind pixels, closer together about the middle, over all sines up to this one and
/// over this many orders of their lattice at least to each side.
const DIRECTIONS: usize = 21;
const STEEPEST: f64 = 1.2;
const ORDERS: f64 = 1.5;

/// Most rays of one screen that are followed from the next.
const MOST: usize = 300;

/// A ray that stands on a screen before the screen acts.
#[derive(Clone, Copy, Debug)]
pub struct SourceRay {
    /// Its place in mm.
    pub at: [f64; 2],
    /// Its optical direction cosines.
    pub p: [f64; 2],
    /// The energy it stands for.
    pub energy: f64,
}

/// The source's light on its first screen, evenly over the opening.
pub fn source_rays(system: &System) -> Vec<SourceRay> {
    let screen = &system.screens[0];
    let Some([x0, x1, y0, y1]) = screen.bounds() else {
        return Vec::new();
    };
    let along = PLACES[usize::from(pitch_of(screen).is_none())];
    let place = |i: usize, a: f64, b: f64| a + (b - a) * (i as f64 + 0.5) / along as f64;
    let places = (0..along * along).map(|n| [place(n % along, x0, x1), place(n / along, y0, y1)]);
    let lit = places.filter(|at| is_open(screen, *at));
    lit.map(|at| {
        let z = screen.height(at).map_or(0.0, |here| here.z);
        let here = screen.frame.to_global(Vec3::new(at[0], at[1], z));
        let d = screen.frame.turn_in(system.source.direction(here));
        SourceRay {
            at,
            p: [d.x * screen.index, d.y * screen.index],
            energy: 1.0,
        }
    })
    .collect()
}

/// Whether light passes a screen at a place.
fn is_open(screen: &Screen, [x, y]: [f64; 2]) -> bool {
    match &screen.act {
        Act::Stop(aperture) => aperture.contains(x, y),
        Act::Doe(doe) => doe.aperture.contains(x, y),
        Act::Sensor(_) => true,
    }
}

/// Distance of a screen's pixels, if it has any.
fn pitch_of(screen: &Screen) -> Option<[f64; 2]> {
    match &screen.act {
        Act::Doe(doe) => doe.pixels().map(|pixels| pixels.pitch),
        Act::Stop(_) | Act::Sensor(_) => None,
    }
}

/// The rays that leave a screen for those that arrive: behind pixels, where there are many for each, for a part
/// of them.
pub fn rays_behind(hop: &Hop, arriving: &[SourceRay]) -> Vec<SourceRay> {
    let Some(pitch) = pitch_of(hop.from) else {
        return arriving
            .iter()
            .map(|source_ray| ray_behind(hop, source_ray))
            .collect();
    };
    let stride = arriving.len().div_ceil(MOST).max(1);
    let some = arriving.iter().step_by(stride);
    some.flat_map(|source_ray| diffract(hop, pitch, source_ray))
        .collect()
}

/// The ray that leaves a stop or a smooth element.
pub fn ray_behind(hop: &Hop, source_ray: &SourceRay) -> SourceRay {
    let SourceRay { at, p, energy } = *source_ray;
    let gradient = match &hop.from.act {
        Act::Doe(doe) => doe.phase_gradient(at[0], at[1]),
        Act::Stop(_) | Act::Sensor(_) => None,
    };
    let [gx, gy] = gradient.unwrap_or([0.0; 2]);
    let k = hop.wavenumber();
    SourceRay {
        at,
        p: [p[0] + gx / k, p[1] + gy / k],
        energy,
    }
}

/// The normal cosine of a direction: what a plane wave of unit amplitude carries through the screen.
pub fn obliquity(hop: &Hop, p: [f64; 2]) -> f64 {
    let sine = p[0].hypot(p[1]) / hop.from.index;
    (1.0 - sine * sine).max(0.0).sqrt()
}

/// The rays that leave pixels, by the energy that the diffraction of a pixel gives them.
fn diffract(hop: &Hop, pitch: [f64; 2], source_ray: &SourceRay) -> Vec<SourceRay> {
    let SourceRay { at, p, energy } = *source_ray;
    // The middles and widths of the orders' ranges, and the energy of a sinc², its mean beyond the first order.
    let range = |a: usize, i: usize| {
        let widest = ORDERS.max(STEEPEST * pitch[a] / hop.wavelength);
        let edge = |i: usize| {
            let t = 2.0 * i as f64 / DIRECTIONS as f64 - 1.0;
            widest * t * t.abs()
        };
        let (low, high) = (edge(i), edge(i + 1));
        (0.5 * (low + high), high - low)
    };
    let strength = |u: f64| {
        let phase = std::f64::consts::PI * u.abs();
        match phase {
            phase if phase < 1e-9 => 1.0,
            phase if u.abs() < 1.0 => (phase.sin() / phase).powi(2),
            phase => 0.5 / (phase * phase),
        }
    };
    let turned = |n: usize| {
        let orders = [range(0, n % DIRECTIONS), range(1, n / DIRECTIONS)];
        let p = [0, 1].map(|a| p[a] + orders[a].0 * hop.wavelength / pitch[a]);
        let strengths = orders.iter().map(|(u, width)| strength(*u) * width);
        SourceRay {
            at,
            p,
            energy: energy * strengths.product::<f64>() * obliquity(hop, p),
        }
    };
    (0..DIRECTIONS * DIRECTIONS).map(turned).collect()
}
