//! What rims do to light, by rays of the source: the shares that they cut, that end there, and that chief rays misplace.

use crate::engine::beamlet::beamlet_launch::launch_beamlet;
use crate::engine::beamlet::starting_width::starting_width;
use crate::engine::plan::settings::Settings;
use crate::engine::rims::edge_diffraction::edge_energy;
use crate::engine::rims::onward::Onward;
use crate::engine::rims::source_ray::SourceRay;
use crate::engine::trace::direction_search::SearchRay;
use crate::math::erfc::erfc;
use crate::math::vec3::Vec3;
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::shape::Shape;
use crate::optics::surface::{Surface, without_edges};
use crate::optics::system::Hop;
use crate::wave::beamlet::wavelet::Arrival;

/// Rays followed to find what a rim sends to the target, and how near the rim they are to meet the surface, in
/// radii.
const RIM_RAYS: usize = 3000;
const NEAR_RIM: f64 = 0.15;

/// Shares of the energy on its way to the target, at the rim of one surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cut {
    /// What the edge cuts off.
    pub(crate) removed: f64,
    /// What stands on the wrong side of the edge when chief rays decide.
    pub(crate) misplaced: f64,
    /// Of the light in the square about the edge, what ends outside the edge.
    pub(crate) ended: f64,
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
    let rays: Vec<SearchRay> = leaving.iter().filter_map(|p| land(&open, p, to)).collect();
    light.extend(rays.iter().filter_map(|ray| arrive(hop, ray)));

    // Those that go on to the sensor; where none does, light gets there by diffraction, and all count.
    let going = |ray: &SearchRay| onward.leads_on(landed(ray));
    let on: Vec<SearchRay> = rays.iter().filter(|ray| going(ray)).copied().collect();
    let (rays, onward) = match on.is_empty() {
        true => (rays, &Onward::nowhere()),
        false => (on, onward),
    };

    // The mean shares of the beamlets along them, and what the rims themselves send to the target.
    let sigma = match (settings.sigma, rays.is_empty()) {
        (Some(sigma), _) => sigma,
        (None, true) => 0.0,
        (None, false) => starting_width(hop, from, &rays),
    };
    let landed: f64 = rays.iter().map(|ray| ray.area).sum();
    let share = |(number, surface): (usize, &Surface)| {
        let mut cut = Cut::default();
        if surface.aperture.outline == Outline::Open {
            return cut;
        }
        let rim = SurfaceEdge::of(number, surface);
        let sent = sent_by_rim(&open, onward, &rim, leaving);
        let total = landed + sent;
        if total > 0.0 {
            (cut.removed, cut.misplaced) = (sent / total, sent / total);
            for ray in &rays {
                let part = clipped(&open, &rim, ray.at, ray.p, sigma);
                cut.removed += part * ray.area / total;
                cut.misplaced += part.min(1.0 - part) * ray.area / total;
            }
        }
        cut
    };
    hop.train.iter().enumerate().map(share).collect()
}

/// The edge of a surface of a train.
struct SurfaceEdge<'a> {
    number: usize,
    surface: &'a Surface,
    /// The height of the surface at its edge, in mm.
    depth: f64,
}

impl<'a> SurfaceEdge<'a> {
    fn of(number: usize, surface: &'a Surface) -> Self {
        let sag = |[x, y]: [f64; 2]| surface.shape.height(x, y).map(|here| here.z);
        let edge = surface.aperture.rim();
        Self {
            number,
            surface,
            depth: edge.first().copied().and_then(sag).unwrap_or(0.0),
        }
    }

    /// How far the edge reaches from the vertex.
    fn radius(&self) -> Option<f64> {
        let edge = self.surface.aperture.rim();
        edge.iter().map(|[x, y]| x.hypot(*y)).reduce(f64::max)
    }

    /// The width over which diffraction on the way there blurs light at an edge of this radius.
    fn blur(&self, open: &Hop, radius: f64) -> f64 {
        let travelled = (self.surface.frame.origin - open.from.frame.origin).norm();
        (open.wavelength * travelled).sqrt().min(NEAR_RIM * radius)
    }
}

/// The energy that the rim of a surface sends into the box of the target and on to the sensor, of light that meets the
/// surface near it and does not land there by itself: as the edge of a plane aperture would from where its rays land,
/// on the way left.
fn sent_by_rim(open: &Hop, onward: &Onward, rim: &SurfaceEdge, leaving: &[SourceRay]) -> f64 {
    let surface = rim.surface;
    let Some(to) = open.to.bounds() else {
        return 0.0;
    };
    let Some(radius) = rim.radius() else {
        return 0.0;
    };
    let way = (open.to.frame.origin - surface.frame.origin).norm();
    let index = open.to.index;
    let narrowest = (open.wavelength * index / way.max(open.wavelength)).sqrt();
    let width = index * (to[1] - to[0]).hypot(to[3] - to[2]) / way;
    let blur = rim.blur(open, radius);
    let stride = leaving.len().div_ceil(RIM_RAYS).max(1);
    let one = |source_ray: &SourceRay| {
        let depth = depth_at_rim(open, rim, source_ray)?;
        let landing = open.trace(source_ray.at, source_ray.p, &mut ()).ok()?;
        if depth.abs() > NEAR_RIM * radius {
            return None;
        }
        let beside = distance_beside(to, landing.at);
        if beside == 0.0 {
            return None;
        }
        let q = (index * beside / way).max(narrowest);
        let a_length = source_ray.energy / (NEAR_RIM * radius + blur);
        let towards = |point: [f64; 2]| SourceRay {
            at: point,
            p: [0, 1].map(|a| landing.cosines[a] + index * (point[a] - landing.at[a]) / way),
            energy: 1.0,
        };
        let share = onward.share(to, towards);
        let sent = a_length * share * edge_energy(open.wavelength, q, width);
        Some((depth, sent * stride as f64))
    };
    let some = leaving.iter().step_by(stride).filter_map(one);
    fainter_side(some, blur)
}

/// The edges of surfaces, from the first of a train on.
fn edges(train: &[Surface]) -> Vec<SurfaceEdge<'_>> {
    let numbered = train.iter().enumerate();
    numbered
        .filter(|(_, surface)| surface.aperture.outline != Outline::Open)
        .map(|(number, surface)| SurfaceEdge::of(number, surface))
        .collect()
}

/// Of the light in the square about a surface's edge, the share that ends outside the edge, by rays that the edges before
/// it let pass. The edge is blurred as diffraction blurs light on the way there.
pub(crate) fn ended_at_rim(hop: &Hop, number: usize, leaving: &[SourceRay]) -> f64 {
    let train = without_edges(hop.train);
    let open = &Hop {
        train: &train,
        ..*hop
    };
    let (before, rim) = (
        edges(&hop.train[..number]),
        SurfaceEdge::of(number, &hop.train[number]),
    );
    let Some(radius) = rim.radius() else {
        return 0.0;
    };
    let blur = rim.blur(open, radius);
    let stride = leaving.len().div_ceil(RIM_RAYS).max(1);
    let (mut all, mut ended) = (0.0, 0.0);
    for ray in leaving.iter().step_by(stride) {
        let passes = |edge: &SurfaceEdge| depth_at_rim(open, edge, ray).is_some_and(|d| d > 0.0);
        let met = meet_rim(open, &rim, |hop| hop.trace(ray.at, ray.p, &mut ()).ok());
        let Some([x, y]) = met.map(|landing| landing.at) else {
            continue;
        };
        if x.abs().max(y.abs()) <= radius && before.iter().all(passes) {
            let depth = rim.surface.aperture.depth(x, y);
            all += ray.energy;
            ended += ray.energy * 0.5 * erfc(depth / blur);
        }
    }
    if all > 0.0 { ended / all } else { 0.0 }
}

/// How far a point is outside a box; zero inside.
fn distance_beside(outline: [f64; 4], at: [f64; 2]) -> f64 {
    let outside = |a: usize| {
        let [low, high] = [outline[2 * a] - at[a], at[a] - outline[2 * a + 1]];
        low.max(high).max(0.0)
    };
    outside(0).hypot(outside(1))
}

/// The energy on the fainter side of an edge, of light that meets it at these depths inside it: light that ends before the
/// edge does not reach it. What is nearer to it than light is blurred by diffraction counts on both sides.
fn fainter_side(light: impl Iterator<Item = (f64, f64)>, blur: f64) -> f64 {
    let (mut inside, mut outside) = (0.0, 0.0);
    for (depth, energy) in light {
        inside += if depth > -blur { energy } else { 0.0 };
        outside += if depth < blur { energy } else { 0.0 };
    }
    f64::min(inside, outside)
}

/// How far inside a surface's edge a ray meets it.
fn depth_at_rim(open: &Hop, rim: &SurfaceEdge, source_ray: &SourceRay) -> Option<f64> {
    let landing = meet_rim(open, rim, |hop| {
        hop.trace(source_ray.at, source_ray.p, &mut ()).ok()
    })?;
    Some(rim.surface.aperture.depth(landing.at[0], landing.at[1]))
}

/// The ray with its Jacobian, if it lands in the box `to`; its area is the energy it represents.
fn land(open: &Hop, source_ray: &SourceRay, to: [f64; 4]) -> Option<SearchRay> {
    let SourceRay { at, p, energy } = *source_ray;
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

/// What a ray is on the next screen.
fn landed(ray: &SearchRay) -> SourceRay {
    SourceRay {
        at: ray.landing.at,
        p: ray.landing.cosines,
        energy: ray.area,
    }
}

/// What a ray is on the next screen, unless an edge stops it.
fn arrive(hop: &Hop, ray: &SearchRay) -> Option<SourceRay> {
    let landing = hop.trace(ray.at, ray.p, &mut ()).ok()?;
    Some(SourceRay {
        at: landing.at,
        p: landing.cosines,
        energy: ray.area,
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
    meet_rim(open, rim, |hop| launch_beamlet(hop, at, p, sigma).ok())
}

/// What `follow` finds on the way to the plane of a surface's rim, before the surface.
fn meet_rim<T>(open: &Hop, rim: &SurfaceEdge, follow: impl Fn(&Hop) -> Option<T>) -> Option<T> {
    let surface = rim.surface;
    let cross = |arrives: f64| {
        let plane = Screen {
            name: String::new(),
            frame: surface.frame.moved(Vec3::new(0.0, 0.0, rim.depth)),
            kind: ScreenKind::Stop(Aperture::OPEN),
            index: surface.index[0],
            behind: None,
            shape: Shape::Plane,
            arrives,
        };
        follow(&Hop {
            train: &open.train[..rim.number],
            to: &plane,
            ..*open
        })
    };
    // Behind mirrors light may come from either side.
    cross(1.0).or_else(|| cross(-1.0))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use crate::engine::rims::rim_light::{ended_at_rim, fainter_side};
    use crate::engine::rims::source_rays::source_rays;
    use crate::fixtures::parts::{face, lit, on_axis, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::frame::Frame;
    use crate::optics::screen::ScreenKind;
    use crate::optics::shape::Shape;

    /// Of even light in the square about a disc, 1 − π/4 ends outside. What passes one disc passes a second one behind it.
    #[test]
    fn a_disc_ends_the_corners_of_its_square() {
        let square = Aperture::turned_rectangle(2.05, 2.05, 0.0, [0.0; 2]);
        let disc = |z: f64, index: [f64; 2]| {
            let mut surface = face(on_axis(z), Shape::Plane, index);
            surface.aperture = Aperture::disc(1.05);
            surface
        };
        let first = screen(Frame::GLOBAL, ScreenKind::Stop(square));
        let last = screen(on_axis(2.0), sensor(10, 0.1));
        let train = vec![disc(0.5, [1.0, 1.5]), disc(1.0, [1.5, 1.0])];
        let mut system = lit(vec![first, last], vec![train]);
        system.wavelength = 1e-6;
        let light = source_rays(&system);
        let hop = system.hops().next().unwrap();
        let [first, second] = [0, 1].map(|number| ended_at_rim(&hop, number, &light));
        assert!((first - (1.0 - FRAC_PI_4)).abs() < 0.02, "{first}");
        assert!(second < 1e-6, "{second:e}");
    }

    /// Even light of density 1 that reaches from the depth 1 inside an edge to this one.
    fn even_light(end: f64) -> impl Iterator<Item = (f64, f64)> {
        let depths = (0..1000).map(|n| 1.0 - 0.002 * (f64::from(n) + 0.5));
        depths
            .filter(move |depth| *depth > end)
            .map(|depth| (depth, 0.002))
    }

    /// Light across an edge counts by its density. Light that ends before the edge does not count, unless diffraction blurs
    /// it that far.
    #[test]
    fn light_that_ends_inside_an_edge_does_not_reach_it() {
        assert!((fainter_side(even_light(-1.0), 0.0) - 1.0).abs() < 1e-9);
        assert_eq!(fainter_side(even_light(0.1), 0.0), 0.0);
        assert!((fainter_side(even_light(0.1), 0.2) - 0.1).abs() < 3e-3);
    }
}
