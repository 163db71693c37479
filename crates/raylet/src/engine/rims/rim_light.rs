//! What rims do to light, by rays of the source: the shares that they cut, that end there, and that chief rays misplace.

use crate::engine::beamlet::beamlet_launch::launch_beamlet;
use crate::engine::beamlet::starting_width::starting_width;
use crate::engine::plan::settings::Settings;
use crate::engine::rims::curved_edge::{aslant_error, edge_difference};
use crate::engine::rims::edge_diffraction::edge_energy;
use crate::engine::rims::onward::{Onward, Reach};
use crate::engine::rims::source_ray::SourceRay;
use crate::engine::rims::surface_edge::{EdgeLight, SurfaceEdge};
use crate::engine::trace::direction_search::SearchRay;
use crate::math::erfc::erfc;
use crate::optics::refraction::Interface;
use crate::optics::surface::{Surface, without_edges};
use crate::optics::system::Hop;
use crate::wave::beamlet::wavelet::Arrival;

/// Rays followed to find what a rim sends to the target.
const RIM_RAYS: usize = 3000;

/// Normals of an edge that have less than this part along the target are seen from the side.
const SEEN: f64 = 0.1;

/// Shares of the energy on its way to the target, at the rim of one surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cut {
    /// What the edge cuts off.
    pub(crate) removed: f64,
    /// The part of it that rays of the light itself have; the rest is diffracted by the edge.
    pub(crate) clipped: f64,
    /// What stands on the wrong side of the edge when chief rays decide.
    pub(crate) misplaced: f64,
    /// The difference between a cut along the surface and one in the plane of its edge.
    pub(crate) difference: EdgeLight,
    /// What light aslant adds to the error of that difference.
    pub(crate) aslant: f64,
    /// The share of the light that leaves the first screen which is on its way to the target.
    pub(crate) landing: f64,
    /// Whether only light that goes on to the sensor counts.
    pub(crate) to_sensor: bool,
}

/// What each surface's rim does to the energy on its way to the target, of light that goes on to the sensor; `light`
/// becomes what arrives on the next screen.
pub(crate) fn cut_shares(
    hop: &Hop,
    onward: &Onward,
    leaving: &[SourceRay],
    light: &mut Vec<SourceRay>,
    settings: &Settings,
) -> Vec<Cut> {
    light.clear();
    let none = vec![Cut::default(); hop.train.len()];
    let (Some(from), Some(to)) = (hop.from.bounds(), hop.to.bounds()) else {
        return none;
    };

    // The rays that would land on the target if nothing had an edge, and those of them that do.
    let train = without_edges(hop.train);
    let open = Hop {
        train: &train,
        ..*hop
    };
    let mut rays: Vec<SearchRay> = leaving.iter().filter_map(|p| land(&open, p, to)).collect();
    if rays.is_empty() {
        rays.extend(leaving.iter().filter_map(|p| land_spread(&open, p, to)));
    }
    light.extend(rays.iter().filter_map(|ray| arrive(hop, ray)));

    // Those that go on to the sensor; where none does, light gets there by diffraction, and all count.
    let reaches = rays.iter().map(|ray| onward.reach(landed(ray)));
    let reaches: Vec<Reach> = reaches.collect();
    let seen = rays.iter().zip(&reaches);
    let seen = seen.map(|(ray, reach)| ray.area * reach.share).sum();
    let by_diffraction = reaches.iter().all(|reach| reach.near == 0.0);
    let mut going = reaches
        .iter()
        .map(|reach| by_diffraction || reach.near > 0.0);
    rays.retain(|_| going.next().unwrap_or(true));

    // The mean shares of the beamlets along them, and what the rims themselves send to the target.
    let sigma = match (settings.sigma, rays.is_empty()) {
        (Some(sigma), _) => sigma,
        (None, true) => 0.0,
        (None, false) => starting_width(hop, from, &rays),
    };
    let edges: Vec<Option<SurfaceEdge>> = { hop.train.iter().enumerate() }
        .map(|(number, surface)| SurfaceEdge::of(number, surface))
        .collect();
    let light = OnTheWay {
        open: &open,
        onward,
        leaving,
        seen,
        by_diffraction,
        turned: onward.turned(|at| nearest(&rays, at)),
        rays: &rays,
        sigma,
    };
    (0..edges.len())
        .map(|number| light.cut(&edges, number))
        .collect()
}

/// Light on its way to the target.
struct OnTheWay<'a> {
    open: &'a Hop<'a>,
    onward: &'a Onward<'a>,
    /// What leaves the first screen.
    leaving: &'a [SourceRay],
    /// The energy of what of it lands on the sensor, if nothing has an edge.
    seen: f64,
    /// Whether no ray leads to the sensor.
    by_diffraction: bool,
    /// How strongly pixels turn it to the sensor, where it lands on pixels.
    turned: Option<f64>,
    /// Those that do, or all that land, with their energy.
    rays: &'a [SearchRay],
    /// The width of beamlets along these.
    sigma: f64,
}

impl OnTheWay<'_> {
    /// What one of the edges of a train does to it.
    fn cut(&self, edges: &[Option<SurfaceEdge>], number: usize) -> Cut {
        let mut cut = Cut::default();
        let Some(rim) = &edges[number] else {
            return cut;
        };
        let (open, leaving) = (self.open, self.leaving);
        let sent = self.sent_by_rim(rim);
        let [sent_on, met_on] = match self.by_diffraction {
            true => [sent.landing, sent.met_landing],
            false => [sent.near, sent.met_near],
        };
        let landed: f64 = self.rays.iter().map(|ray| ray.area).sum();
        let total = landed + sent_on;
        if total > 0.0 {
            let met = (landed + met_on).max(f64::MIN_POSITIVE);
            (cut.removed, cut.misplaced) = (sent_on / total, met_on / met);
            for ray in self.rays {
                let part = clipped(open, rim, ray.at, ray.p, self.sigma);
                cut.clipped += part * ray.area / total;
                cut.misplaced += part.min(1.0 - part) * ray.area / met;
            }
            cut.removed += cut.clipped;
            let all: f64 = leaving.iter().map(|ray| ray.energy).sum();
            cut.landing = total / all;
            cut.to_sensor = self.onward.is_known();
        }

        // Of the difference only what lands on the sensor counts, beside the light that does.
        let seen = self.seen + sent.seen;
        if seen > 0.0 {
            cut.difference = edge_difference(open, self.onward, rim, leaving).over(seen);
            cut.aslant = aslant_error(open, edges[..number].iter().flatten(), rim, leaving);
        }
        cut
    }

    /// How strongly pixels turn light of these rays to the sensor, over that of the light on its way: one at most.
    fn beside_turned(&self, ray: impl Fn([f64; 2]) -> SourceRay) -> f64 {
        match (self.onward.turned(ray), self.turned) {
            (Some(own), Some(all)) if own < all => own / all,
            _ => 1.0,
        }
    }

    /// The energy that the rim of a surface sends into the box of the target, of light that meets the surface near it and
    /// does not land there by itself: as the edge of a plane aperture would from where its rays land, on the way left.
    fn sent_by_rim(&self, rim: &SurfaceEdge) -> Sent {
        let (open, leaving) = (self.open, self.leaving);
        let surface = rim.surface;
        let Some(to) = open.to.bounds() else {
            return Sent::default();
        };
        let way = (open.to.frame.origin - surface.frame.origin).norm();
        let index = open.to.index;
        let narrowest = (open.wavelength * index / way.max(open.wavelength)).sqrt();
        let width = index * (to[1] - to[0]).hypot(to[3] - to[2]) / way;
        let stride = leaving.len().div_ceil(RIM_RAYS).max(1);
        let one = |source_ray: &SourceRay| {
            let depth = rim.depth_near(open, source_ray)?;
            let landing = open.trace(source_ray.at, source_ray.p, &mut ()).ok()?;
            let beside = distance_beside(to, landing.at);
            if beside == 0.0 {
                return None;
            }
            let q = (index * beside / way).max(narrowest);
            let towards = |point: [f64; 2]| SourceRay {
                at: point,
                p: [0, 1].map(|a| landing.cosines[a] + index * (point[a] - landing.at[a]) / way),
                energy: 1.0,
                spread: [0.0; 2],
            };
            let sent = rim.per_depth(open, source_ray) * edge_energy(open.wavelength, q, width);
            let blur = narrowest * way / index;
            let across = met_share(open, rim, source_ray, landing.at, blur).unwrap_or(1.0);
            Some(SentByRay {
                depth,
                energy: sent * stride as f64,
                reach: self.onward.mean_reach(to, towards),
                met: across * self.beside_turned(towards),
            })
        };
        let some = leaving.iter().step_by(stride).filter_map(one);
        let some: Vec<SentByRay> = some.collect();
        let sum = |share: fn(&SentByRay) -> f64| {
            let lights = some.iter().map(|ray| (ray.depth, ray.energy * share(ray)));
            EdgeLight::of(lights, rim.blur(open)).fainter()
        };
        Sent {
            landing: sum(|_| 1.0),
            near: sum(|ray| ray.reach.near),
            seen: sum(|ray| ray.reach.share),
            met_landing: sum(|ray| ray.met),
            met_near: sum(|ray| ray.met * ray.reach.near),
        }
    }
}

/// The energy that a rim sends into the box of the target, of light that does not land there by itself: no more than this.
#[derive(Clone, Copy, Debug, Default)]
struct Sent {
    /// All.
    landing: f64,
    /// What of it gets near the sensor.
    near: f64,
    /// What of it lands on the sensor.
    seen: f64,
    /// All, and what gets near the sensor, of light that the rim sends towards the box, across the edge and not along it, and that
    /// pixels there turn to the sensor.
    met_landing: f64,
    met_near: f64,
}

/// What of it comes from one ray that meets the edge.
struct SentByRay {
    /// How far inside the edge the ray meets it.
    depth: f64,
    energy: f64,
    reach: Reach,
    /// The part of its directions for which the box lies across the edge, and of this what pixels turn to the sensor.
    met: f64,
}

/// The part of the directions of a ray that meets a rim and lands at `at` for which the box of the target lies across the edge, to
/// within `blur` mm: an edge turns light in the plane of its normal. Nothing behind mirrors and for edges seen from the side.
fn met_share(
    open: &Hop,
    rim: &SurfaceEdge,
    source_ray: &SourceRay,
    at: [f64; 2],
    blur: f64,
) -> Option<f64> {
    let reflects = |surface: &Surface| surface.interface == Interface::Reflect;
    if open.train[rim.number..].iter().any(reflects) {
        return None;
    }
    let [x, y] = rim.normal_by(open, source_ray)?;
    let (own, frame) = (&rim.surface.frame, &open.to.frame);
    let normal = own.x * x + own.y * y;
    let [x, y] = [normal.dot(frame.x), normal.dot(frame.y)];
    let length = x.hypot(y);
    if length < SEEN * normal.norm() {
        return None;
    }
    let along = [-y / length, x / length];

    // Along the edge: from the ray to the middle of the box, half the box, and half of what the ray stands for.
    let to = open.to.bounds()?;
    let way = (frame.origin - own.origin).norm() / open.to.index;
    let middle = |a: usize| 0.5 * (to[2 * a] + to[2 * a + 1]) - at[a];
    let half = |a: usize| 0.5 * (to[2 * a + 1] - to[2 * a]);
    let sum = |of: &dyn Fn(usize) -> f64| along[0].abs() * of(0) + along[1].abs() * of(1);
    let offset = along[0] * middle(0) + along[1] * middle(1);
    let reach = sum(&half) + blur;
    let spread = sum(&|a| source_ray.spread[a]) * way;
    let both = (offset + spread).min(reach) - (offset - spread).max(-reach);
    Some(match spread > 0.0 {
        true => (both / (2.0 * spread)).clamp(0.0, 1.0),
        false => f64::from(u8::from(offset.abs() <= reach)),
    })
}

/// How far a point is outside a box; zero inside.
fn distance_beside(outline: [f64; 4], at: [f64; 2]) -> f64 {
    let outside = |a: usize| {
        let [low, high] = [outline[2 * a] - at[a], at[a] - outline[2 * a + 1]];
        low.max(high).max(0.0)
    };
    outside(0).hypot(outside(1))
}

/// The ray with its Jacobian, if it lands in the box `to`; its area is the energy it represents.
fn land(open: &Hop, source_ray: &SourceRay, to: [f64; 4]) -> Option<SearchRay> {
    let SourceRay { at, p, energy, .. } = *source_ray;
    let (landing, jacobian) = open.jacobian(at, p).ok()?;
    let inside = |a: usize| (to[2 * a]..=to[2 * a + 1]).contains(&landing.at[a]);
    (inside(0) && inside(1)).then_some(SearchRay {
        at,
        p,
        area: energy,
        landing,
        jacobian,
    })
}

/// The same of a ray that stands for many directions: with the part of its energy that lands in the box when its light is
/// even over these. So a target that is smaller than what a direction spans is not missed.
fn land_spread(open: &Hop, source_ray: &SourceRay, to: [f64; 4]) -> Option<SearchRay> {
    let SourceRay {
        at,
        p,
        energy,
        spread,
    } = *source_ray;
    let (landing, jacobian) = open.jacobian(at, p).ok()?;
    let part = |a: usize| {
        let half = jacobian[a][2].abs() * spread[0] + jacobian[a][3].abs() * spread[1];
        let low = to[2 * a].max(landing.at[a] - half);
        let high = to[2 * a + 1].min(landing.at[a] + half);
        (high - low).max(0.0) / (2.0 * half)
    };
    let share = part(0) * part(1);
    (share > 0.0).then_some(SearchRay {
        at,
        p,
        area: energy * share,
        landing,
        jacobian,
    })
}

/// The ray on the next screen that lands next to a place; along its axis where none does.
fn nearest(rays: &[SearchRay], [x, y]: [f64; 2]) -> SourceRay {
    let far = |ray: &SourceRay| (ray.at[0] - x).hypot(ray.at[1] - y);
    let axis = SourceRay {
        at: [f64::INFINITY; 2],
        p: [0.0; 2],
        energy: 0.0,
        spread: [0.0; 2],
    };
    let closer = |a: SourceRay, b: SourceRay| if far(&b) < far(&a) { b } else { a };
    rays.iter().map(landed).fold(axis, closer)
}

/// What a ray is on the next screen.
fn landed(ray: &SearchRay) -> SourceRay {
    SourceRay {
        at: ray.landing.at,
        p: ray.landing.cosines,
        energy: ray.area,
        spread: [0.0; 2],
    }
}

/// What a ray is on the next screen, unless an edge stops it.
fn arrive(hop: &Hop, ray: &SearchRay) -> Option<SourceRay> {
    let landing = hop.trace(ray.at, ray.p, &mut ()).ok()?;
    Some(SourceRay {
        at: landing.at,
        p: landing.cosines,
        energy: ray.area,
        spread: [0.0; 2],
    })
}

/// The share of a beamlet's energy that the rim of a surface cuts: ½ erfc(d/w), d the depth of its ray inside
/// the edge and w the half width of its energy at 1/e, the wider one.
fn clipped(open: &Hop, rim: &SurfaceEdge, at: [f64; 2], p: [f64; 2], sigma: f64) -> f64 {
    let Some(arrival) = at_rim(open, rim, at, p, sigma) else {
        return 0.0;
    };
    let [wx, wy] = arrival.footprint(open.wavenumber(), (-0.5f64).exp());
    let depth = rim.surface.aperture.depth(arrival.at[0], arrival.at[1]);
    0.5 * erfc(depth / wx.max(wy))
}

/// A beamlet from the place `at` of the first screen with the cosines p, where its ray crosses the plane of a
/// surface's rim, before the surface.
fn at_rim(open: &Hop, rim: &SurfaceEdge, at: [f64; 2], p: [f64; 2], sigma: f64) -> Option<Arrival> {
    rim.meet(open, |hop| launch_beamlet(hop, at, p, sigma).ok())
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::engine::plan::settings::Settings;
    use crate::engine::rims::pixel_light::PixelValues;
    use crate::engine::rims::rim_screens::with_rims;
    use crate::fixtures::parts::{box_pixels, face, lit, on_axis, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::frame::Frame;
    use crate::optics::shape::Shape;

    /// A sensor of 2 λ by 2 λ in the first order of a lattice of 8 λ sees light that no single ray has: directions are wider
    /// there. The rim of the large plate before it cuts nothing of that light.
    #[test]
    fn a_narrow_sensor_in_an_order_sees_light_by_directions() {
        let pixels = Array2::from_elem((64, 64), Complex64::ONE);
        let mut plate = face(on_axis(20.0), Shape::Plane, [1.0, 1.5]);
        plate.aperture = Aperture::disc(600.0);
        let mut last = screen(on_axis(4000.0), sensor(2, 1.0));
        last.index = 1.5;
        last.frame.origin.x = 4000.0 * (0.125_f64 / 1.5).asin().tan() + 3.0;
        let first = screen(Frame::GLOBAL, box_pixels(pixels, 8.0));
        let system = lit(vec![first, last], vec![vec![plate]]);
        let rimmed = with_rims(&system, &Settings::default(), PixelValues::Fixed);
        assert!(rimmed.rims[0].cut < 1e-6, "{:?}", rimmed.rims[0]);
        assert!(rimmed.rims[0].landing > 0.0, "{:?}", rimmed.rims[0]);
    }
}
