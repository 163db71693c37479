//! A few chief rays through a whole system, for drawings.
//!
//! Behind a stop a ray goes straight on; behind a smooth element it takes the direction of the local phase
//! gradient; behind pixels it goes straight on and, aimed, towards both sides of the next screen.

use crate::engine::error::advice::turning;
use crate::engine::geometrical::system_trace::{passes, trace_system};
use crate::engine::trace::ray_trace::Landing;
use crate::math::real::Real;
use crate::math::vec3::Vec3;
use crate::optics::deflection::deflected;
use crate::optics::doe::Doe;
use crate::optics::frame::Axes;
use crate::optics::ray::Loss;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::{Hop, System};
use crate::wave::beamlet::wavelet::{Companion, Encounter};

/// The path of a ray of a layout picture.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutRay {
    /// Global points in mm: the source or a point before the first screen, then every meeting.
    pub points: Vec<Vec3>,
    /// How elements that spread light turned it.
    pub turn: Deflection,
    /// Whether it ends on the last screen.
    pub arrived: bool,
}

/// How an element that spreads light turned a ray of a layout picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deflection {
    /// It went straight on, or no element on its way spreads light.
    Straight,
    /// It was turned towards the upper side of the next screen.
    Up,
    /// It was turned towards the lower side.
    Down,
}

/// Places of the rays on the first screen, as shares of its half width.
const PLACES: [f64; 5] = [-0.9, -0.45, 0.0, 0.45, 0.9];

/// Steps across the first screen in which rays that come through are looked for.
const TRIED: i32 = 400;

/// Rays are targeted at these shares of the next screen's half width, the first that an element can reach.
const TARGET_SHARES: [f64; 5] = [0.8, 0.5, 0.3, 0.15, 0.05];

/// Beyond this number, elements that spread light let rays go straight on.
const MOST_RAYS: usize = 40;

/// Rays in the section whose plane has this global unit normal.
pub fn layout_rays(system: &System, normal: Vec3) -> Vec<LayoutRay> {
    let k = system.wavenumber();
    let Some(first) = system.screens.first() else {
        return Vec::new();
    };
    let mut live = launch(system, first, normal);
    let mut done = Vec::new();
    for hop in system.hops() {
        let mut next = Vec::new();
        let crowded = live.len() * 3 > MOST_RAYS;
        for ray in live {
            for (p, turn) in leaving(&hop, &ray, k, normal, crowded) {
                let mut layout_ray = ray.layout_ray.clone();
                layout_ray.points.pop();
                layout_ray.turn = turn;
                let mut steps = Steps(Vec::new());
                let landed = hop.trace(ray.at, p, &mut steps);
                layout_ray.points.extend(steps.0);
                match landed {
                    Ok(landing) if passes(hop.to, landing.at) => next.push(Arrived {
                        at: landing.at,
                        p: landing.cosines,
                        layout_ray,
                    }),
                    _ => done.push(layout_ray),
                }
            }
        }
        live = next;
    }
    done.extend(live.into_iter().map(|ray| LayoutRay {
        arrived: true,
        ..ray.layout_ray
    }));
    done
}

/// A ray that stands on a screen.
struct Arrived {
    at: [f64; 2],
    p: [f64; 2],
    layout_ray: LayoutRay,
}

/// The points that a trace visits.
struct Steps(Vec<Vec3>);

impl<T: Real> Companion<T> for Steps {
    fn fly(&mut self, _length: T, _index: T) {}
    fn refract<A: Axes<T>>(&mut self, _encounter: &Encounter<T, A>) {}
    fn visit(&mut self, point: Vec3<T>) {
        self.0.push(point.value());
    }
}

/// The unit vector along which a screen or surface is cut by planes of this normal, in its own x, y.
pub fn cut(frame: &crate::optics::frame::Frame, normal: Vec3) -> [f64; 2] {
    let line = frame.direction_to_local(frame.z.cross(normal));
    let length = line.x.hypot(line.y);
    if length < 1e-9 {
        return [1.0, 0.0];
    }
    [line.x / length, line.y / length]
}

/// Rays from the source to places across the first screen.
fn launch(system: &System, screen: &Screen, normal: Vec3) -> Vec<Arrived> {
    let Some([x0, x1, y0, y1]) = screen.bounds() else {
        return Vec::new();
    };
    let u = cut(&screen.frame, normal);
    let half = [0.5 * (x1 - x0) * u[0], 0.5 * (y1 - y0) * u[1]];
    let middle = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
    let stub = 0.12 * length_of(system);
    let place = |t: f64| [middle[0] + t * half[0], middle[1] + t * half[1]];
    let places = places_that_come_through(system, screen, &place).map(place);
    let open = places.into_iter().filter(|at| passes(screen, *at));
    open.map(|at| {
        let lift = screen.height(at).map_or(0.0, |height| height.z);
        let here = screen.frame.to_global(Vec3::new(at[0], at[1], lift));
        let direction = system.source.direction(here);
        let point = system.source.point_of_light();
        let near = point.filter(|point| (here - *point).norm() < 10.0 * stub);
        let start = near.unwrap_or(here + direction * -stub);
        let local = screen.frame.direction_to_local(direction);
        Arrived {
            at,
            p: [local.x * screen.index, local.y * screen.index],
            layout_ray: LayoutRay {
                points: vec![start, here],
                turn: Deflection::Straight,
                arrived: false,
            },
        }
    })
    .collect()
}

/// The shares of the half width at which rays start: spread over those whose rays come to the last screen, or over the whole
/// width where all or none of the light does.
fn places_that_come_through(
    system: &System,
    screen: &Screen,
    place: &impl Fn(f64) -> [f64; 2],
) -> [f64; 5] {
    let open = |t: &f64| passes(screen, place(*t));
    let comes = |t: &f64| {
        trace_system(system, &system.source, place(*t))
            .lost
            .is_none()
    };
    if PLACES.iter().filter(|t| open(t)).all(comes) {
        return PLACES;
    }
    let tried = (0..=TRIED).map(|i| 2.0 * f64::from(i) / f64::from(TRIED) - 1.0);
    let through: Vec<f64> = tried.filter(|t| open(t) && comes(t)).collect();
    PLACES.map(|share| {
        let last = through.len().saturating_sub(1) as f64;
        let at = (0.5 * (1.0 + share) * last).round() as usize;
        through.get(at).copied().unwrap_or(share)
    })
}

/// The greatest distance of a part from the first screen, in mm.
fn length_of(system: &System) -> f64 {
    let start = system.screens[0].frame.origin;
    let screens = system.screens.iter().map(|screen| screen.frame.origin);
    let surfaces = system.trains.iter().flatten().map(|s| s.frame.origin);
    screens
        .chain(surfaces)
        .map(|origin| (origin - start).norm())
        .fold(0.0, f64::max)
}

/// The directions in which a ray goes on from a screen.
fn leaving(
    hop: &Hop,
    ray: &Arrived,
    k: f64,
    normal: Vec3,
    crowded: bool,
) -> Vec<([f64; 2], Deflection)> {
    let ScreenKind::Doe(doe) = &hop.from.kind else {
        return vec![(ray.p, ray.layout_ray.turn)];
    };
    let gradient = doe.ray_gradient(ray.at[0], ray.at[1]);
    let kick = gradient.unwrap_or_default().map(|g| g / k);
    let Some(p) = deflected(hop.from, ray.at, ray.p, kick) else {
        return Vec::new();
    };
    let mut list = vec![(p, ray.layout_ray.turn)];
    if gradient.is_some() || crowded {
        return list;
    }
    let ray = &Arrived {
        p,
        at: ray.at,
        layout_ray: ray.layout_ray.clone(),
    };
    for (side, turn) in [(1.0, Deflection::Up), (-1.0, Deflection::Down)] {
        list.extend(direction_towards_side(hop, doe, ray, side, normal).map(|p| (p, turn)));
    }
    list
}

/// A direction within the element's band that leads to one side of the next screen, as far out as it can.
fn direction_towards_side(
    hop: &Hop,
    doe: &Doe,
    ray: &Arrived,
    side: f64,
    normal: Vec3,
) -> Option<[f64; 2]> {
    let [x0, x1, y0, y1] = hop.to.bounds()?;
    let u = cut(&hop.to.frame, normal);
    let limit = turning(doe, hop.wavelength);
    let within = |p: [f64; 2]| (0..2).all(|a| (p[a] - ray.p[a]).abs() <= limit[a] + 1e-9);
    TARGET_SHARES.iter().find_map(|share| {
        let t = side * share;
        let target = [
            0.5 * (x0 + x1) + t * 0.5 * (x1 - x0) * u[0],
            0.5 * (y0 + y1) + t * 0.5 * (y1 - y0) * u[1],
        ];
        let tolerance = 1e-3 * (x1 - x0).min(y1 - y0);
        seek(hop, ray, target, tolerance).filter(|p| within(*p))
    })
}

/// Newton's search for the direction that lands on a point.
fn seek(hop: &Hop, ray: &Arrived, target: [f64; 2], tolerance: f64) -> Option<[f64; 2]> {
    let mut p = ray.p;
    for _ in 0..12 {
        let found: Result<(Landing, _), Loss> = hop.jacobian(ray.at, p);
        let (landing, j) = found.ok()?;
        let [dx, dy] = [target[0] - landing.at[0], target[1] - landing.at[1]];
        if dx.hypot(dy) < tolerance {
            return Some(p);
        }
        let determinant = j[0][2] * j[1][3] - j[0][3] * j[1][2];
        let step = [
            (j[1][3] * dx - j[0][3] * dy) / determinant,
            (j[0][2] * dy - j[1][2] * dx) / determinant,
        ];
        // Long steps are cut, so that the ray stays within the train.
        let cut = (0.1 / step[0].hypot(step[1]).max(1e-12)).min(1.0);
        p = [p[0] + cut * step[0], p[1] + cut * step[1]];
        if !p[0].is_finite() || !p[1].is_finite() {
            return None;
        }
    }
    None
}
