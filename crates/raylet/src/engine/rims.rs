//! Rims of small lenses that cut light: they become screens.
//!
//! A hard edge diffracts, and rays accepted or refused one by one do not. So where a rim cuts light and
//! the lens is small enough for its whole opening to be sampled, the field is summed on the plane of the
//! rim, in the medium behind the surface, reached by free flight (backward where the rim bulges
//! forward), cut there with exactly weighted edges, and sent on. Rims of larger lenses cut by chief ray:
//! their diffraction is a far smaller share of the light, and what they cut is in the tally.

use crate::engine::walk::{Stand, emit, walk};
use crate::math::vec3::Vec3;
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::bend::Interface;
use crate::optics::ray::Loss;
use crate::optics::screen::{Act, Screen};
use crate::optics::shape::Shape;
use crate::optics::surface::Surface;
use crate::optics::system::{Hop, System};

/// Most samples along a rim's diameter, at λ/(3n).
const AFFORDABLE: f64 = 1000.0;

/// Share of the rays that a rim must cut to count.
const NOTABLE: f64 = 0.01;

/// The system with a screen at every rim that cuts light and is small enough.
pub fn with_rims(system: &System) -> System {
    let mut expanded = System {
        screens: vec![],
        trains: vec![],
        ..system.clone()
    };
    for hop in system.hops() {
        expanded.screens.push(hop.from.clone());
        let mut train = Vec::new();
        for (number, surface) in hop.train.iter().enumerate() {
            let rim = rim_of(&hop, number).filter(|_| cuts(&hop, number));
            match rim {
                Some(screen) => {
                    train.push(Surface {
                        aperture: Aperture::OPEN,
                        ..surface.clone()
                    });
                    expanded.trains.push(std::mem::take(&mut train));
                    expanded.screens.push(screen);
                }
                None => train.push(surface.clone()),
            }
        }
        expanded.trains.push(train);
    }
    expanded.screens.extend(system.screens.last().cloned());
    expanded
}

/// The screen in the plane of a surface's rim, if the rim is a centred disc of affordable size on a
/// refracting surface of revolution.
fn rim_of(hop: &Hop, number: usize) -> Option<Screen> {
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
    if surface.interface != Interface::Refract || samples > AFFORDABLE {
        return None;
    }
    let sag = surface.shape.height(radius, 0.0)?.z;
    Some(Screen {
        name: format!("rim {} behind {}", number + 1, hop.from.name),
        frame: surface.frame.moved(Vec3::new(0.0, 0.0, sag)),
        act: Act::Stop(surface.aperture.clone()),
        index: after,
        shape: Shape::Plane,
        arrives: hop.from.leaves(),
    })
}

/// What the edge wave of a rim on a curved surface is off by, over the slope of the surface there and the
/// root of the share of the light that is cut: whether the field is cut along the surface or in the plane
/// of the rim, both within Kirchhoff's approximation. Measured on spheres of slope 0.25.
const EDGE: f64 = 0.06;

/// The relative error to expect because a share `cut` of the light ends at the rim that this screen stands
/// for; zero for other screens and for rims of planes.
pub fn edge_error(system: &System, screen: &Screen, cut: f64) -> f64 {
    let slope = |hop: &Hop, number: usize| {
        let surface = &hop.train[number];
        let Outline::Disc { radius } = surface.aperture.outline else {
            return None;
        };
        let found = rim_of(hop, number).is_some_and(|rim| rim == *screen);
        let height = surface.shape.height(radius, 0.0).filter(|_| found)?;
        Some(height.slope[0].abs())
    };
    let slope = system
        .hops()
        .find_map(|hop| (0..hop.train.len()).find_map(|number| slope(&hop, number)));
    EDGE * slope.unwrap_or(0.0) * cut.max(0.0).sqrt()
}

/// Positions and directions tried along each axis.
const POSITIONS: i32 = 5;
const DIRECTIONS: i32 = 24;

/// Whether a surface's rim cuts a notable share of the rays that come as far as the surface, from the
/// whole of the first screen in all directions.
fn cuts(hop: &Hop, number: usize) -> bool {
    let Some([x0, x1, y0, y1]) = hop.from.bounds() else {
        return false;
    };
    let place = |i: i32, low: f64, high: f64| {
        low + (high - low) * (f64::from(i) + 0.5) / f64::from(POSITIONS)
    };
    let slope =
        |i: i32| hop.from.index * ((2.0 * f64::from(i) + 1.0) / f64::from(DIRECTIONS) - 1.0);
    let (mut through, mut cut) = (0, 0);
    for (j, i) in pairs(POSITIONS) {
        let at = [place(i, x0, x1), place(j, y0, y1)];
        for (m, n) in pairs(DIRECTIONS) {
            let Ok(ray) = emit(&Stand::still(hop.from), at, [slope(n), slope(m)]) else {
                continue;
            };
            let Ok(ray) = walk(&hop.train[..number], ray, &mut ()) else {
                continue;
            };
            match walk(&hop.train[number..=number], ray, &mut ()) {
                Ok(_) => through += 1,
                Err(Loss::Clipped | Loss::Missed) => cut += 1,
                Err(_) => {}
            }
        }
    }
    f64::from(cut) > NOTABLE * f64::from(through + cut)
}

fn pairs(count: i32) -> impl Iterator<Item = (i32, i32)> {
    (0..count).flat_map(move |j| (0..count).map(move |i| (j, i)))
}
