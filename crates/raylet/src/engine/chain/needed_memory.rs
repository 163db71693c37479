//! The memory limit at which a system that was refused would be carried, and which changes of it need less.

use crate::engine::chain::forecast::choose;
use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::plan::settings::Settings;
use crate::engine::rims::pixel_light::PixelValues;
use crate::engine::rims::rim_screens::with_rims;
use crate::math::vec3::Vec3;
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::frame::Frame;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::System;

/// Limits are whole multiples of these bytes.
const MEGABYTE: usize = 1_000_000;

/// Limits that are tried in turn.
const ROUNDS: usize = 12;

/// A change is worth a word if it needs less than this share of the memory.
const LESS: f64 = 0.8;

/// A change of a system that needs less memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saving {
    /// A greater distance before the screen.
    DistanceBefore,
    /// A greater distance behind it.
    DistanceBehind,
    /// A smaller aperture of it.
    Aperture,
}

impl Saving {
    /// All of them.
    const ALL: [Self; 3] = [Self::DistanceBefore, Self::DistanceBehind, Self::Aperture];

    /// In words, about a screen that was named before.
    pub fn words(self) -> &'static str {
        match self {
            Self::DistanceBefore => "a greater distance before it",
            Self::DistanceBehind => "a greater distance behind it",
            Self::Aperture => "a smaller aperture",
        }
    }
}

/// The least memory limit that was found with which the whole system has a plan, in bytes: a whole number of megabytes.
/// Nothing if memory is not what it lacks.
pub fn needed_memory(system: &System, settings: &Settings) -> Option<usize> {
    least_limit(settings.for_planning(), |trial| {
        // With more memory more rims may become screens.
        let rimmed = with_rims(system, trial, PixelValues::Fixed);
        choose(&rimmed.system, trial, |_, _| ()).map(|_| ())
    })
}

/// The first memory limit that a plan accepts, from that of the settings on: each fits what was too large before.
pub(crate) fn least_limit(
    mut trial: Settings,
    plan: impl Fn(&Settings) -> Result<(), SimulateError>,
) -> Option<usize> {
    for _ in 0..ROUNDS {
        let Err(error) = plan(&trial) else {
            return Some(trial.memory_limit);
        };
        let more = error.memory_needed()?.div_ceil(MEGABYTE);
        if more.saturating_mul(MEGABYTE) <= trial.memory_limit {
            return None;
        }
        trial.memory_limit = more.checked_mul(MEGABYTE)?;
    }
    None
}

/// The changes at the screen of this name with which the system needs clearly less than `bytes`: each was tried.
pub fn savings(system: &System, settings: &Settings, screen: &str, bytes: usize) -> Vec<Saving> {
    let Some(number) = (system.screens.iter()).position(|one| one.name == screen) else {
        return Vec::new();
    };
    let saves = |saving: &Saving| {
        let changed = changed(system, number, *saving);
        let needed = changed.and_then(|system| needed_memory(&system, settings));
        needed.is_some_and(|needed| (needed as f64) < LESS * bytes as f64)
    };
    Saving::ALL.into_iter().filter(saves).collect()
}

/// The system after a change at a screen; nothing if there is no such screen.
fn changed(system: &System, number: usize, saving: Saving) -> Option<System> {
    match saving {
        Saving::DistanceBefore => farther_before(system, number),
        Saving::DistanceBehind => farther_behind(system, number),
        Saving::Aperture => narrower(system, number),
    }
}

/// The system with a greater distance between a screen and the part before it.
fn farther_before(system: &System, number: usize) -> Option<System> {
    let before = number.checked_sub(1)?;
    let screen = system.screens.get(number)?;
    let neighbour = match system.trains.get(before)?.last() {
        Some(surface) => surface.frame.origin,
        None => system.screens.get(before)?.frame.origin,
    };
    let way = screen.frame.z * screen.arrives;
    Some(moved(
        system,
        [number, number],
        shift(screen, neighbour, way)?,
    ))
}

/// The system with a greater distance between a screen and the part behind it.
fn farther_behind(system: &System, number: usize) -> Option<System> {
    let screen = system.screens.get(number)?;
    let neighbour = match system.trains.get(number)?.first() {
        Some(surface) => surface.frame.origin,
        None => system.screens.get(number + 1)?.frame.origin,
    };
    let way = screen.frame.z * screen.leaves();
    Some(moved(
        system,
        [number + 1, number],
        shift(screen, neighbour, way)?,
    ))
}

/// The shift along `way` that doubles the distance of a neighbour, or adds the width of the screen if that is more.
fn shift(screen: &Screen, neighbour: Vec3, way: Vec3) -> Option<Vec3> {
    let [x0, x1, y0, y1] = screen.bounds()?;
    let distance = (screen.frame.origin - neighbour).dot(way).abs();
    Some(way * distance.max(x1 - x0).max(y1 - y0))
}

/// The system with all screens and trains from these on moved.
fn moved(system: &System, [screen, train]: [usize; 2], shift: Vec3) -> System {
    let mut moved = system.clone();
    for screen in moved.screens.iter_mut().skip(screen) {
        screen.frame = at(screen.frame, shift);
    }
    for surface in moved.trains.iter_mut().skip(train).flatten() {
        surface.frame = at(surface.frame, shift);
    }
    moved
}

/// A frame with its origin moved.
fn at(frame: Frame, shift: Vec3) -> Frame {
    Frame {
        origin: frame.origin + shift,
        ..frame
    }
}

/// The system with half the aperture of a screen along both axes.
fn narrower(system: &System, number: usize) -> Option<System> {
    let [x0, x1, y0, y1] = system.screens.get(number)?.bounds()?;
    let half = [0.25 * (x1 - x0), 0.25 * (y1 - y0)];
    let middle = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
    let small = Aperture {
        outline: Outline::Rectangle {
            half_x: half[0],
            half_y: half[1],
        },
        centre: middle,
    };
    let mut changed = system.clone();
    match &mut changed.screens.get_mut(number)?.kind {
        ScreenKind::Doe(doe) => doe.aperture = small,
        ScreenKind::Stop(aperture) => *aperture = small,
        ScreenKind::Sensor(_) => return None,
    }
    Some(changed)
}
