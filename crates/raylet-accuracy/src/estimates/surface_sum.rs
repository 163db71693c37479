//! The field on a sensor by surface integrals from each surface of a system to the next.
//!
//! Each screen and each lens surface is a set of quadrature nodes ([`SampledSurface`]) over its own aperture; light goes
//! from each node to each node of the next by the first Rayleigh–Sommerfeld integral. What a refracting or
//! reflecting surface sends on is corrected by its mean curvature (see [`crate::references::interface`]); interfaces let
//! everything through. Only heights, apertures and transmissions are raylet's.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::{Aperture, Outline};
use raylet::optics::doe::Doe;
use raylet::optics::frame::Frame;
use raylet::optics::refraction::Interface;
use raylet::optics::screen::{Screen, ScreenKind, Sensor};
use raylet::optics::shape::Shape;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;

use crate::estimates::nodes::{Fineness, Nodes, disc, rectangle, rectangle_in_disc};
use crate::problems::tilted::sensor_points;
use crate::references::direct::SampledSurface;

/// One surface on the way.
struct Station<'a> {
    shape: &'a Shape,
    frame: Frame,
    /// Its aperture; nothing for a sensor.
    aperture: Option<&'a Aperture>,
    doe: Option<&'a Doe>,
    interface: Option<Interface>,
    /// Index behind it.
    index: f64,
}

/// The exact field on the sensor of a system, indexed [y, x]; `effort` multiplies the number of nodes.
pub fn surface_sum(system: &System, effort: f64) -> Array2<Complex64> {
    let stations = stations(system);
    let points = sensor_of(system);
    let outlines: Vec<Vec<Vec3>> = stations
        .iter()
        .map(outline)
        .chain([points.clone()])
        .collect();
    let mut travel = middle(&outlines[1]) - middle(&outlines[0]);
    let mut before = system.screens[0].index;
    let mut light: Option<(SampledSurface, f64)> = None;
    for (number, station) in stations.iter().enumerate() {
        if number > 0 {
            travel = middle(&outlines[number]) - middle(&outlines[number - 1]);
        }
        let from = number.checked_sub(1).map(|n| outlines[n].as_slice());
        let frequency = [
            frequency(station, from, &outlines[number], before, system.wavelength),
            frequency(
                station,
                Some(&outlines[number + 1]),
                &outlines[number],
                station.index,
                system.wavelength,
            ),
            steepness(station),
        ];
        let fine = Fineness {
            frequency: frequency.iter().sum(),
            effort,
        };
        let bare = samples_of(station, travel, fine, system.wavelength);
        let arriving = match &light {
            None => {
                let k = std::f64::consts::TAU * before / system.wavelength;
                let points = bare.points.iter();
                points.map(|point| system.source.field(*point, k)).collect()
            }
            Some((samples, wavelength)) => samples.radiate(*wavelength, &bare.points),
        };
        light = Some((bare.times(&arriving), system.wavelength / station.index));
        before = station.index;
    }
    let field = light.map_or_else(Vec::new, |(samples, wavelength)| {
        samples.radiate(wavelength, &points)
    });
    let [nx, ny] = sensor_size(system);
    Array2::from_shape_fn((ny, nx), |(j, i)| field[j * nx + i])
}

/// All surfaces before the sensor, in order.
fn stations(system: &System) -> Vec<Station<'_>> {
    let mut all = Vec::new();
    for (screen, train) in system.screens.iter().zip(&system.trains) {
        all.push(screen_station(screen));
        all.extend(train.iter().map(surface_station));
    }
    all
}

fn screen_station(screen: &Screen) -> Station<'_> {
    let (aperture, doe) = match &screen.kind {
        ScreenKind::Stop(aperture) => (Some(aperture), None),
        ScreenKind::Doe(doe) => (Some(&doe.aperture), Some(doe)),
        ScreenKind::Sensor(_) => (None, None),
    };
    let (shape, frame, index) = (&screen.shape, screen.frame, screen.index);
    Station {
        shape,
        frame,
        aperture,
        doe,
        interface: None,
        index,
    }
}

fn surface_station(surface: &Surface) -> Station<'_> {
    Station {
        shape: &surface.shape,
        frame: surface.frame,
        aperture: Some(&surface.aperture),
        doe: None,
        interface: Some(surface.interface),
        index: surface.index[1],
    }
}

fn sensor(system: &System) -> Option<(&Screen, Sensor)> {
    let screen = system.screens.last()?;
    match &screen.kind {
        ScreenKind::Sensor(sensor) => Some((screen, *sensor)),
        ScreenKind::Stop(_) | ScreenKind::Doe(_) => None,
    }
}

/// The points of a square sensor.
fn sensor_of(system: &System) -> Vec<Vec3> {
    let sensor = sensor(system);
    sensor.map_or_else(Vec::new, |(screen, sensor)| {
        sensor_points(&screen.frame, sensor.pixels[0], sensor.pitch[0])
    })
}

fn sensor_size(system: &System) -> [usize; 2] {
    sensor(system).map_or([0; 2], |(_, sensor)| sensor.pixels)
}

fn middle(points: &[Vec3]) -> Vec3 {
    let sum = points
        .iter()
        .fold(Vec3::new(0.0, 0.0, 0.0), |sum, point| sum + *point);
    sum * (1.0 / points.len() as f64)
}

/// The bounds of what is open of a station.
fn bounds(station: &Station) -> [f64; 4] {
    let pixels = station.doe.and_then(|doe| doe.bounds());
    let aperture = station.aperture.and_then(Aperture::bounds);
    pixels.or(aperture).unwrap_or([0.0; 4])
}

/// Points about the rim of a station and its middle.
fn outline(station: &Station) -> Vec<Vec3> {
    let [x0, x1, y0, y1] = bounds(station);
    let (x, y) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
    let corners = [
        [x, y],
        [x0, y0],
        [x1, y0],
        [x0, y1],
        [x1, y1],
        [x0, y],
        [x1, y],
        [x, y0],
        [x, y1],
    ];
    let open = |at: &[f64; 2]| {
        station
            .aperture
            .is_none_or(|aperture| aperture.depth(at[0], at[1]) > -1e-9)
    };
    let lift = |[x, y]: [f64; 2]| {
        station
            .frame
            .to_global(Vec3::new(x, y, height(station.shape, x, y)[0]))
    };
    corners.into_iter().filter(open).map(lift).collect()
}

/// Height, two slopes and mean curvature.
fn height(shape: &Shape, x: f64, y: f64) -> [f64; 4] {
    let Some(height) = shape.height(x, y) else {
        return [f64::NAN; 4];
    };
    let ([p, q], [r, s, t]) = (height.slope, height.hessian);
    let stretch = 1.0 + p * p + q * q;
    let bend = (1.0 + q * q) * r - 2.0 * p * q * s + (1.0 + p * p) * t;
    [height.z, p, q, bend / (2.0 * stretch.powf(1.5))]
}

/// The highest frequency that light between a station's rim and another's has along the station, in a medium.
fn frequency(
    station: &Station,
    other: Option<&[Vec3]>,
    own: &[Vec3],
    index: f64,
    wavelength: f64,
) -> f64 {
    // From a source of its own, light comes at no large angle.
    let Some(other) = other else {
        return 0.35 * index / wavelength;
    };
    let normal = station.frame.z;
    let pairs = own
        .iter()
        .flat_map(|a| other.iter().map(move |b| (*b - *a).unit()));
    let sines = pairs.map(|way| (1.0 - way.dot(normal).powi(2)).max(0.0).sqrt());
    index / wavelength * sines.fold(0.05, f64::max)
}

/// The highest frequency of a station's smooth phase.
fn steepness(station: &Station) -> f64 {
    let [x0, x1, y0, y1] = bounds(station);
    let at = |[x, y]: [f64; 2]| {
        let gradient = station
            .doe
            .and_then(|doe| doe.phase_gradient(x, y))
            .unwrap_or([0.0; 2]);
        gradient[0].hypot(gradient[1]) / std::f64::consts::TAU
    };
    [[x0, y0], [x1, y0], [x0, y1], [x1, y1]]
        .map(at)
        .into_iter()
        .fold(0.0, f64::max)
}

/// The nodes of a station with its transmission for a field; `travel` is the way the light comes.
fn samples_of(station: &Station, travel: Vec3, fine: Fineness, wavelength: f64) -> SampledSurface {
    let mut samples = SampledSurface::default();
    for ([x, y], area) in nodes(station, fine) {
        let [z, p, q, curvature] = height(station.shape, x, y);
        let normal = station.frame.direction_to_global(Vec3::new(-p, -q, 1.0));
        let along = normal.dot(travel).signum();
        let reflects = station.interface == Some(Interface::Reflect)
            || station.doe.is_some_and(|doe| doe.reflect);
        let leaves = if reflects { -along } else { along };
        let reduced = wavelength / (std::f64::consts::TAU * station.index);
        let correction = match station.interface {
            Some(_) => Complex64::new(1.0, -leaves * curvature * reduced),
            None => Complex64::ONE,
        };
        let through = station
            .doe
            .map_or(Complex64::ONE, |doe| doe.transmission(x, y));
        samples
            .points
            .push(station.frame.to_global(Vec3::new(x, y, z)));
        samples.areas.push(normal * (area * leaves));
        samples.field.push(correction * through);
    }
    samples
}

/// The quadrature nodes of a station's aperture over its local plane.
fn nodes(station: &Station, fine: Fineness) -> Nodes {
    let radius = match station.aperture.map(|aperture| &aperture.outline) {
        Some(Outline::Disc { radius }) => Some(*radius),
        _ => None,
    };
    let pixels = station.doe.and_then(|doe| doe.pixels());
    match (pixels, radius) {
        (None, Some(radius)) => {
            let centre = station
                .aperture
                .map_or([0.0; 2], |aperture| aperture.centre);
            disc(radius, centre, fine)
        }
        (None, None) => rectangle(bounds(station), fine),
        (Some(pixels), radius) => {
            let (rows, columns) = pixels.values.dim();
            let [width, height] = pixels.pitch;
            let cell = |k: usize| {
                let x = ((k % columns) as f64 - 0.5 * columns as f64) * width;
                let y = ((k / columns) as f64 - 0.5 * rows as f64) * height;
                let cell = [x, x + width, y, y + height];
                match radius {
                    Some(radius) => rectangle_in_disc(cell, radius, fine),
                    None => rectangle(cell, fine),
                }
            };
            (0..rows * columns).flat_map(cell).collect()
        }
    }
}
