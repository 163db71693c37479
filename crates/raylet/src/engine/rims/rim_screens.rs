//! Rims of surfaces inside a train: which cut light, and what becomes of them.
//!
//! A hard edge diffracts, and rays accepted or refused one by one do not. So a rim that cuts light becomes a
//! screen where the surface is small enough for its whole aperture to be sampled: the field is summed on the
//! plane of the rim, in the medium behind the surface, reached by free flight (backward where the rim bulges
//! forward), cut there with exactly weighted edges, and sent on. A rim counts when the root of the share of
//! energy that it cuts, of what would land on the target, is more than half the target error: a safe bound of
//! the error of leaving it out. Rims of larger surfaces accept or refuse each beamlet by its chief ray; the
//! energy that this puts on the wrong side of the edge is in the error budget.

use crate::engine::beamlet::beamlet_launch::launch_beamlet;
use crate::engine::beamlet::starting_width::starting_width;
use crate::engine::plan::settings::Settings;
use crate::engine::rims::edge_diffraction::{edge_energy, edge_waves};
use crate::engine::rims::onward::Onward;
use crate::engine::rims::pixel_light::PixelValues;
use crate::engine::rims::source_ray::SourceRay;
use crate::engine::rims::source_rays::{rays_behind, source_rays};
use crate::engine::trace::direction_search::SearchRay;
use crate::math::erfc::erfc;
use crate::math::vec3::Vec3;
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::refraction::Interface;
use crate::optics::screen::{Act, Screen};
use crate::optics::shape::Shape;
use crate::optics::surface::Surface;
use crate::optics::system::{Hop, System};
use crate::wave::beamlet::wavelet::Arrival;

/// Most samples along a rim's diameter, at λ/(3n), where memory allows them.
const AFFORDABLE: f64 = 2500.0;

/// Share of the target error that a rim which is left out may cost.
const SHARE: f64 = 0.5;

/// Rays followed to find what a rim sends to the target, and how near the rim they are to meet the surface, in
/// radii.
const RIM_RAYS: usize = 3000;
const NEAR_RIM: f64 = 0.15;

/// How a run treats a rim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RimTreatment {
    /// It is a screen, and diffracts.
    Screen,
    /// It cuts too little to matter; what meets it is cut ray by ray.
    Ignored,
    /// It cuts light ray by ray, without diffraction, though it matters.
    ByRay,
}

/// The rim of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Rim {
    /// Name of the rim, which is also that of its screen if it has one.
    pub name: String,
    /// The hop in which its surface stands, of the system in which rims that matter are screens.
    pub hop: usize,
    /// Share of the energy on its way to the target that it cuts, by beamlets along rays of the source.
    pub cut: f64,
    /// Share of that energy which the decision by chief rays puts on the wrong side of the edge.
    pub misplaced: f64,
    /// How the run treats it.
    pub treatment: RimTreatment,
}

impl Rim {
    /// √cut, which the error of leaving the rim out does not exceed.
    pub fn bound(&self) -> f64 {
        self.cut.sqrt()
    }

    /// The expected error of a rim that clips single rays though it matters; zero of others. The light that
    /// is wrongly kept or lost is taken to be incoherent with the rest: it counts by the root of its energy.
    pub fn error(&self) -> f64 {
        match self.treatment {
            RimTreatment::Screen | RimTreatment::Ignored => 0.0,
            RimTreatment::ByRay => self.misplaced.sqrt(),
        }
    }
}

/// A system in which rims that matter are screens, as it is run.
#[derive(Clone, Debug)]
pub struct Rimmed {
    /// The system.
    pub system: System,
    /// The rims of all its surfaces that have one, along the way of the light.
    pub rims: Vec<Rim>,
    /// What the rim of each surface of the system as it was given cuts, hop by hop.
    cuts: Vec<Vec<Cut>>,
    /// The root of what a rim cuts above which it matters.
    limit: f64,
    /// Most samples along the diameter of a rim that becomes a screen.
    affordable: f64,
    /// Where the screens of the system as it was given stand among those of [`Rimmed::system`].
    pub own: Vec<usize>,
}

/// Shares of the energy on its way to the target, at the rim of one surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Cut {
    /// What the edge cuts off.
    removed: f64,
    /// What stands on the wrong side of the edge when chief rays decide.
    misplaced: f64,
}

/// The system with a screen at every rim that matters and is small enough, for the pixels as they are or for all
/// that they may become.
pub fn with_rims(system: &System, settings: &Settings, values: PixelValues) -> Rimmed {
    let mut light = source_rays(system);
    let cuts = system.hops().enumerate().map(|(number, hop)| {
        let onward = Onward::behind(system, number);
        let leaving = light_behind(&hop, &light, values);
        cut_shares(&hop, &onward, &leaving, &mut light, settings)
    });
    let empty = Rimmed {
        system: system.clone(),
        rims: Vec::new(),
        cuts: cuts.collect(),
        limit: SHARE * settings.target_error,
        affordable: AFFORDABLE.min((settings.samples_allowed() as f64).sqrt()),
        own: Vec::new(),
    };
    empty.filled(system)
}

impl Rimmed {
    /// A slightly changed system with screens at the same rims.
    pub(crate) fn like(&self, system: &System) -> System {
        self.clone().filled(system).system
    }

    /// The share of the light on its way to the target that ends at the rim which a screen replaces, its edge
    /// wave included; zero for other screens.
    pub(crate) fn cut_at(&self, screen: &Screen) -> f64 {
        let own = self.rims.iter().find(|rim| rim.name == screen.name);
        own.map_or(0.0, |rim| rim.cut.min(1.0))
    }

    /// The same choices made for the rims of a system, from its first hop on.
    fn filled(mut self, system: &System) -> Self {
        self.system = System {
            screens: vec![],
            trains: vec![],
            ..system.clone()
        };
        self.rims.clear();
        self.own.clear();
        for (number, hop) in system.hops().enumerate() {
            let cuts = self.cuts.get(number).cloned().unwrap_or_default();
            self.add(&hop, &cuts);
        }
        self.system.screens.extend(system.screens.last().cloned());
        self
    }

    /// Adds a hop whose rims cut these shares of the energy.
    fn add(&mut self, hop: &Hop, cuts: &[Cut]) {
        self.own.push(self.system.screens.len());
        self.system.screens.push(hop.from.clone());
        let mut train = Vec::new();
        for (number, (surface, &cut)) in hop.train.iter().zip(cuts).enumerate() {
            let matters = cut.removed.sqrt() > self.limit;
            let screen = rim_of(hop, number, self.affordable).filter(|_| matters);
            if surface.aperture.outline != Outline::Open {
                self.rims.push(Rim {
                    name: name_of(hop, number),
                    hop: self.system.trains.len(),
                    cut: cut.removed,
                    misplaced: cut.misplaced,
                    treatment: match (&screen, matters) {
                        (Some(_), _) => RimTreatment::Screen,
                        (None, true) => RimTreatment::ByRay,
                        (None, false) => RimTreatment::Ignored,
                    },
                });
            }
            match screen {
                Some(screen) => {
                    train.push(opened(surface));
                    self.system.trains.push(std::mem::take(&mut train));
                    self.system.screens.push(screen);
                }
                None => train.push(surface.clone()),
            }
        }
        self.system.trains.push(train);
    }
}

/// The surface without its edge.
fn opened(surface: &Surface) -> Surface {
    Surface {
        aperture: Aperture::OPEN,
        ..surface.clone()
    }
}

/// What a rim is called.
fn name_of(hop: &Hop, number: usize) -> String {
    format!("rim {} behind {}", number + 1, hop.from.name)
}

/// The screen in the plane of a surface's rim, if the rim is a centred disc on a surface of revolution and takes
/// no more than `affordable` samples along its diameter.
fn rim_of(hop: &Hop, number: usize, affordable: f64) -> Option<Screen> {
    let surface = &hop.train[number];
    let Outline::Disc { radius } = surface.aperture.outline else {
        return None;
    };
    // Only then does the rim lie in a plane.
    if surface.aperture.centre != [0.0; 2] || !surface.shape.is_round() {
        return None;
    }
    let after = surface.index[1];
    let samples = 2.0 * radius * 3.0 * after / hop.wavelength;
    if samples > affordable {
        return None;
    }
    let sag = surface.shape.height(radius, 0.0)?.z;
    Some(Screen {
        name: name_of(hop, number),
        frame: surface.frame.moved(Vec3::new(0.0, 0.0, sag)),
        act: Act::Stop(surface.aperture.clone()),
        index: after,
        behind: None,
        shape: Shape::Plane,
        arrives: side_behind(hop, number),
    })
}

/// +1 when the light along the axis leaves a surface towards its +z, else −1.
fn side_behind(hop: &Hop, number: usize) -> f64 {
    let mut way = hop.from.frame.z * hop.from.leaves();
    for surface in &hop.train[..=number] {
        if surface.interface == Interface::Reflect {
            let normal = surface.frame.z;
            way = way + normal * (-2.0 * way.dot(normal));
        }
    }
    way.dot(hop.train[number].frame.z).signum()
}

/// Error of the edge wave of a rim on a curved surface, divided by the slope of the surface there and by the root of
/// the share of the light that is cut. Kirchhoff's approximation does not say whether the field is cut along the
/// surface or in the plane of the rim. Measured on 95 random systems in which this error is the largest: the true
/// one is 0.1 to 3.1 times the estimate, in the median 0.66 times.
const EDGE: f64 = 0.075;

/// The error to expect from the rims that cut light ray by ray in a hop.
pub(crate) fn cut_by_ray(rims: &[Rim], hop: usize) -> f64 {
    let here = rims.iter().filter(|rim| rim.hop == hop);
    here.map(Rim::error).fold(0.0, f64::hypot)
}

/// The relative error to expect because a share `cut` of the light ends at the rim that this screen stands
/// for; zero for other screens and for rims of planes.
pub(crate) fn edge_error(system: &System, screen: &Screen, cut: f64) -> f64 {
    let slope = |hop: &Hop, number: usize| {
        let surface = &hop.train[number];
        let Outline::Disc { radius } = surface.aperture.outline else {
            return None;
        };
        let found = rim_of(hop, number, AFFORDABLE).is_some_and(|rim| rim == *screen);
        let height = surface.shape.height(radius, 0.0).filter(|_| found)?;
        Some(height.slope[0].abs())
    };
    let slope = system
        .hops()
        .find_map(|hop| (0..hop.train.len()).find_map(|number| slope(&hop, number)));
    EDGE * slope.unwrap_or(0.0) * cut.max(0.0).sqrt()
}

/// The rays that leave a screen, those that its edge diffracts among them.
fn light_behind(hop: &Hop, light: &[SourceRay], values: PixelValues) -> Vec<SourceRay> {
    let mut leaving = rays_behind(hop, light, values);
    leaving.extend(edge_waves(hop, light));
    leaving
}

/// What each surface's rim does to the energy on its way to the target, of light that goes on to the sensor; `light`
/// becomes what arrives on the next screen.
fn cut_shares(
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
    let train: Vec<Surface> = hop.train.iter().map(opened).collect();
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
}

/// The energy that the rim of a surface sends into the box of the target and on to the sensor, of light that meets the
/// surface near it and does not land there by itself: as the edge of a plane aperture would from where its rays land,
/// on the way left.
fn sent_by_rim(open: &Hop, onward: &Onward, rim: &SurfaceEdge, leaving: &[SourceRay]) -> f64 {
    let surface = rim.surface;
    let Some(to) = open.to.bounds() else {
        return 0.0;
    };
    let edge = surface.aperture.rim();
    let Some(radius) = edge.iter().map(|[x, y]| x.hypot(*y)).reduce(f64::max) else {
        return 0.0;
    };
    let way = (open.to.frame.origin - surface.frame.origin).norm();
    let index = open.to.index;
    let narrowest = (open.wavelength * index / way.max(open.wavelength)).sqrt();
    let width = index * (to[1] - to[0]).hypot(to[3] - to[2]) / way;
    let travelled = (surface.frame.origin - open.from.frame.origin).norm();
    let blur = (open.wavelength * travelled).sqrt().min(NEAR_RIM * radius);
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
            act: Act::Stop(Aperture::OPEN),
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
    use crate::engine::rims::rim_screens::fainter_side;

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
