//! The chief ray: through the middle of the screen that limits the light.
//!
//! That is the aperture stop, as far as the light of the source tells: the screen that stops most of the rays which meet
//! the first one. Where none stops many, the first screen is the stop. Rims of lenses are no stops: at large fields they cut
//! the light too, but its stop stays the same.

use crate::engine::geometrical::system_trace::{passes, trace_system};
use crate::optics::screen::Screen;
use crate::optics::system::System;

/// Rays along each side of the first screen.
const SIDE: usize = 41;

/// A screen limits the light if it stops this share of the rays.
const LIMITS: f64 = 0.25;

/// Newton steps to the middle of the stop.
const STEPS: usize = 20;

/// Steps of differences, and how near the ray comes to the middle, over the width of the screen.
const STEP: f64 = 1e-6;
const CLOSE: f64 = 1e-9;

/// Where the chief ray meets the sensor, and how; nothing where it does not come there. Telescopes stop their chief ray: it goes
/// on without edges.
pub fn chief_landing(system: &System) -> Option<ChiefLanding> {
    let open = system.without_edges();
    let start = chief_start(system, &open)?;
    let ways = [system, &open].map(|system| trace_system(system, &system.source, start));
    let chief = ways.into_iter().find(|ray| ray.lost.is_none())?;
    let (frame, hit) = (system.screens.last()?.frame, chief.hits.last()?);
    let (at, along) = (
        frame.to_local(hit.point),
        frame.direction_to_local(hit.direction),
    );
    Some(ChiefLanding {
        at: [at.x, at.y],
        cosines: [along.x, along.y],
    })
}

/// Where the chief ray meets the first screen, in mm on its axes, whatever the edges; nothing where there is none.
pub fn chief_entry(system: &System) -> Option<[f64; 2]> {
    chief_start(system, &system.without_edges())
}

/// The chief ray on the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiefLanding {
    /// Where it meets the sensor, in mm on the sensor's axes.
    pub at: [f64; 2],
    /// The cosines of its direction to these axes.
    pub cosines: [f64; 2],
}

/// Where it meets the first screen, in mm on its axes.
fn chief_start(system: &System, open: &System) -> Option<[f64; 2]> {
    let first = system.screens.first()?;
    let ([x, width_x], [y, width_y]) = (middle(first, 0)?, middle(first, 1)?);
    let place = |i: usize| (i as f64 + 0.5) / SIDE as f64 - 0.5;
    let grid = (0..SIDE * SIDE)
        .map(|n| [x + width_x * place(n % SIDE), y + width_y * place(n / SIDE)])
        .filter(|at| passes(first, *at));
    let rays: Vec<([f64; 2], Vec<[f64; 2]>)> = grid
        .filter_map(|at| Some((at, places(open, at)?)))
        .collect();
    let Some((number, stop)) = limiting(system, &rays) else {
        return Some([x, y]);
    };

    // From the middle of the rays that come through the stop.
    let through: Vec<[f64; 2]> = (rays.iter())
        .filter(|(_, places)| passes(stop, places[number]))
        .map(|(at, _)| *at)
        .collect();
    let count = through.len() as f64;
    let mean = [0, 1].map(|a| through.iter().map(|at| at[a]).sum::<f64>() / count);
    let aim = [middle(stop, 0)?[0], middle(stop, 1)?[0]];
    Some(aimed(open, number, aim, mean, width_x.max(width_y)).unwrap_or(mean))
}

/// The middle and the width of a screen along an axis.
fn middle(screen: &Screen, axis: usize) -> Option<[f64; 2]> {
    let bounds = screen.bounds()?;
    let [low, high] = [bounds[2 * axis], bounds[2 * axis + 1]];
    Some([0.5 * (low + high), high - low])
}

/// The places where a ray meets each screen, on its axes; nothing where it is lost.
fn places(open: &System, at: [f64; 2]) -> Option<Vec<[f64; 2]>> {
    let ray = trace_system(open, &open.source, at);
    if ray.lost.is_some() {
        return None;
    }
    let mut number = 0;
    let mut all = Vec::new();
    for (hop, screen) in open.screens.iter().enumerate() {
        let local = screen.frame.to_local(ray.hits.get(number)?.point);
        all.push([local.x, local.y]);
        number += 1 + open.trains.get(hop).map_or(0, Vec::len);
    }
    Some(all)
}

/// The screen behind the first that stops most rays, with its number, if it stops many and lets some through.
fn limiting<'a>(
    system: &'a System,
    rays: &[([f64; 2], Vec<[f64; 2]>)],
) -> Option<(usize, &'a Screen)> {
    let through = |(number, screen): (usize, &Screen)| {
        let open = |(_, places): &&([f64; 2], Vec<[f64; 2]>)| passes(screen, places[number]);
        rays.iter().filter(open).count()
    };
    let behind = system.screens.iter().enumerate().skip(1);
    let (fewest, stop) = behind
        .map(|screen| (through(screen), screen))
        .min_by_key(|(count, _)| *count)?;
    let limits = (fewest as f64) < (1.0 - LIMITS) * rays.len() as f64;
    (limits && fewest > 0).then_some(stop)
}

/// The start of the ray that meets a screen at `aim`, by Newton's method.
fn aimed(
    open: &System,
    number: usize,
    aim: [f64; 2],
    mut at: [f64; 2],
    width: f64,
) -> Option<[f64; 2]> {
    let landing = |at: [f64; 2]| Some(places(open, at)?[number]);
    let step = STEP * width;
    for _ in 0..STEPS {
        let [x, y] = landing(at)?;
        let off = [aim[0] - x, aim[1] - y];
        if off[0].hypot(off[1]) < CLOSE * width {
            return Some(at);
        }
        let [along_x, along_y] = [[step, 0.0], [0.0, step]].map(|by| {
            let [u, v] = landing([at[0] + by[0], at[1] + by[1]])?;
            Some([(u - x) / step, (v - y) / step])
        });
        let ([a, c], [b, d]) = (along_x?, along_y?);
        let determinant = a * d - b * c;
        at[0] += (d * off[0] - b * off[1]) / determinant;
        at[1] += (a * off[1] - c * off[0]) / determinant;
    }
    None
}
