//! The exact field of systems that are figures of revolution and lit along their axis, at their full size.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::Settings;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::{Aperture, Outline};
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::frame::Frame;
use raylet::optics::phase::profile::Profile;
use raylet::optics::refraction::Coating;
use raylet::optics::screen::{Screen, ScreenKind, Sensor};
use raylet::optics::shape::Shape;
use raylet::optics::system::System;

use crate::real_size::resources::processor_seconds;
use crate::references::axisymmetric_train::{AxisymmetricTrain, Face};

/// Nodes in each cycle of an integral.
const DENSITY: f64 = 2.5;

/// Why a system has no exact field here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotAxisymmetric(pub &'static str);

impl fmt::Display for NotAxisymmetric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no figure of revolution: {}", self.0)
    }
}

impl Error for NotAxisymmetric {}

/// A run beside the exact field.
#[derive(Clone, Copy, Debug)]
pub struct Compared {
    /// Expected relative error of the field.
    pub expected: f64,
    /// Relative L2 error of the complex field on all pixels, nothing fitted.
    pub error: f64,
    /// Processor time of the run and of the exact field, in seconds.
    pub seconds: [f64; 2],
}

/// A face with what it owns.
struct Part<'a> {
    z: f64,
    radius: f64,
    shape: &'a Shape,
    doe: Option<&'a Doe>,
    index: f64,
}

/// Runs a system, with [`with_unit_coatings`], beside its exact field for optical direction cosines up to `reach`.
///
/// # Errors
/// When the run is refused, or the system is no figure of revolution.
pub fn compare(
    system: &System,
    settings: &Settings,
    reach: f64,
) -> Result<Compared, Box<dyn Error>> {
    let system = with_unit_coatings(system);
    let start = processor_seconds();
    let exact = exact_field(&system, reach)?;
    let known = processor_seconds();
    let outcome = simulate(&system, settings, &|_| {})?;
    let pairs = outcome.field.values.iter().zip(&exact);
    let off: f64 = pairs.map(|(ours, exact)| (ours - exact).norm_sqr()).sum();
    let all: f64 = exact.iter().map(|exact| exact.norm_sqr()).sum();
    Ok(Compared {
        expected: outcome.expected_error().unwrap_or(0.0),
        error: (off / all).sqrt(),
        seconds: [processor_seconds() - known, known - start],
    })
}

/// The same system with amplitudes that go on unchanged at each interface, as the reference has them.
pub fn with_unit_coatings(system: &System) -> System {
    let mut same = system.clone();
    for surface in same.trains.iter_mut().flatten() {
        surface.coating = Coating::Unit;
    }
    for behind in same
        .screens
        .iter_mut()
        .filter_map(|screen| screen.behind.as_mut())
    {
        behind.coating = Coating::Unit;
    }
    same
}

/// The field on the sensor of light along the axis, for [`with_unit_coatings`] and optical direction cosines up to `reach`.
///
/// # Errors
/// A part that is not centred on the axis, is no disc, or differs from one azimuth to another.
pub fn exact_field(system: &System, reach: f64) -> Result<Array2<Complex64>, NotAxisymmetric> {
    let parts = parts(system)?;
    let sags: Vec<_> = parts.iter().map(|part| sag(part.shape)).collect();
    let factors: Vec<_> = parts.iter().map(|part| factor(part.doe)).collect();
    let faces: Vec<Face> = parts
        .iter()
        .zip(sags.iter().zip(&factors))
        .map(|(part, (sag, factor))| Face {
            z: part.z,
            radius: part.radius,
            sag,
            transmission: factor,
            vortex: part.doe.is_some_and(has_vortex),
            index: part.index,
        })
        .collect();
    let train = AxisymmetricTrain {
        wavelength: system.wavelength,
        reach,
        density: DENSITY,
    };
    let vortex = faces.iter().any(|face| face.vortex);
    let last = system.screens.last().ok_or(NotAxisymmetric("no sensor"))?;
    let z = on_axis(&last.frame)?;
    let ScreenKind::Sensor(sensor) = last.kind else {
        return Err(NotAxisymmetric("no sensor at the end"));
    };
    on_pixels(&sensor, vortex, |radii| train.field(&faces, z, radii))
}

/// The parts of a system in the order in which light meets them.
fn parts(system: &System) -> Result<Vec<Part<'_>>, NotAxisymmetric> {
    let mut parts = Vec::new();
    for hop in system.hops() {
        parts.push(screen(hop.from)?);
        for surface in hop.train {
            parts.push(Part {
                z: on_axis(&surface.frame)?,
                radius: disc(&surface.aperture)?,
                shape: &surface.shape,
                doe: None,
                index: surface.index[1],
            });
        }
    }
    Ok(parts)
}

/// A screen before the sensor.
fn screen(screen: &Screen) -> Result<Part<'_>, NotAxisymmetric> {
    let (aperture, doe) = match &screen.kind {
        ScreenKind::Stop(aperture) => (aperture, None),
        ScreenKind::Doe(doe) => (&doe.aperture, Some(doe)),
        ScreenKind::Sensor(_) => return Err(NotAxisymmetric("a sensor before the end")),
    };
    let radius = disc(aperture)?;
    if doe.is_some_and(|doe| !is_round(doe, radius)) {
        return Err(NotAxisymmetric(
            "an element that differs from one azimuth to another",
        ));
    }
    Ok(Part {
        z: on_axis(&screen.frame)?,
        radius,
        shape: &screen.shape,
        doe,
        index: screen.index_behind(),
    })
}

/// Whether an element is the same at all azimuths, but for a vortex of charge 1.
fn is_round(doe: &Doe, radius: f64) -> bool {
    let turned = |r: f64, angle: f64| {
        let vortex = if has_vortex(doe) { angle } else { 0.0 };
        doe.transmission(r * angle.cos(), r * angle.sin()) * Complex64::cis(-vortex)
    };
    let alike = |r: f64| {
        let first = turned(r, 0.0);
        [0.4, 1.9, 2.6]
            .iter()
            .all(|angle| (turned(r, *angle) - first).norm() < 1e-6)
    };
    (1..8).all(|i| alike(radius * f64::from(i) / 8.0))
}

/// Whether a layer is a vortex of charge 1.
fn has_vortex(doe: &Doe) -> bool {
    let vortex = Layer::Phase(Profile::Vortex { charge: 1 });
    doe.layers.contains(&vortex)
}

/// The place on the axis of a frame that is not turned.
fn on_axis(frame: &Frame) -> Result<f64, NotAxisymmetric> {
    let here = frame.origin;
    let upright = frame.direction_to_global(Vec3::new(0.0, 0.0, 1.0));
    if here.x.hypot(here.y) > 1e-9 || (upright.z - 1.0).abs() > 1e-12 {
        return Err(NotAxisymmetric("a part that is turned or off the axis"));
    }
    Ok(here.z)
}

/// The radius of a centred disc.
fn disc(aperture: &Aperture) -> Result<f64, NotAxisymmetric> {
    match aperture.outline {
        Outline::Disc { radius } if aperture.centre == [0.0; 2] => Ok(radius),
        _ => Err(NotAxisymmetric("an aperture that is no centred disc")),
    }
}

/// Height and slope of a shape at a radius.
fn sag(shape: &Shape) -> impl Fn(f64) -> [f64; 2] + Sync + '_ {
    |r: f64| {
        let height = shape.height(r, 0.0);
        height.map_or([f64::NAN; 2], |height| [height.z, height.slope[0]])
    }
}

/// The transmission at a radius.
fn factor(doe: Option<&Doe>) -> impl Fn(f64) -> Complex64 + Sync + '_ {
    move |r: f64| doe.map_or(Complex64::ONE, |doe| doe.transmission(r, 0.0))
}

/// The field on square pixels about the axis, from that at the different radii that they have.
fn on_pixels(
    sensor: &Sensor,
    vortex: bool,
    field: impl Fn(&[f64]) -> Vec<Complex64>,
) -> Result<Array2<Complex64>, NotAxisymmetric> {
    let [pitch, other] = sensor.pitch;
    if pitch != other {
        return Err(NotAxisymmetric("pixels that are no squares"));
    }
    // Twice the place of a pixel, in pixels.
    let twice = |i: usize, a: usize| 2 * i as i64 + 1 - sensor.pixels[a] as i64;
    let square = |i: usize, j: usize| twice(i, 0).pow(2) + twice(j, 1).pow(2);
    let [nx, ny] = sensor.pixels;
    let all = (0..ny).flat_map(|j| (0..nx).map(move |i| square(i, j)));
    let mut values: BTreeMap<i64, Complex64> = all.map(|key| (key, Complex64::ZERO)).collect();
    let radii: Vec<f64> = values
        .keys()
        .map(|key| 0.5 * pitch * (*key as f64).sqrt())
        .collect();
    for (value, found) in values.values_mut().zip(field(&radii)) {
        *value = found;
    }
    Ok(Array2::from_shape_fn((ny, nx), |(j, i)| {
        let angle = (twice(j, 1) as f64).atan2(twice(i, 0) as f64);
        let turn = if vortex {
            Complex64::cis(angle)
        } else {
            Complex64::ONE
        };
        values[&square(i, j)] * turn
    }))
}
