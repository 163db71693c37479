//! Gradients with respect to the pixels of an element, against adjoints of direct sums.
//!
//! Both sides take the cotangent of the loss from their own field. An error is the relative L2 difference of the
//! pixels' cotangents, both parts, nothing fitted.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::linearised_system::LinearisedSystem;
use raylet::engine::chain::linearised_system_error::LinearisedSystemError;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::optics::system::System;
use raylet_testkit::parts::plane_wave;

use crate::gradients::gradient_error::{Comparison, Loss};
use crate::gradients::sensitivity::through_lens;
use crate::numerics::pixels::Pixels;
use crate::problems::mirror::{self, Coat};
use crate::problems::problem::{axis, doe, random_pixels, sensor};
use crate::references::rayleigh_sommerfeld::{
    FieldBar, rayleigh_sommerfeld, rayleigh_sommerfeld_adjoint,
};

/// All comparisons; the reduced list leaves out the slow ones.
pub fn comparisons(reduced: bool) -> Vec<Comparison> {
    let mut list = Vec::new();
    for loss in [Loss::Image, Loss::Linear] {
        for (name, pixels, z, degrees, nodes) in [
            (
                "12² random 4λ pixels",
                random_pixels(12, 4.0),
                60.0,
                0.0,
                12,
            ),
            (
                "40² random λ/2 pixels",
                random_pixels(40, 0.5),
                40.0,
                10.0,
                5,
            ),
        ] {
            for method in [Method::Auto, Method::Beamlet] {
                let flight = Flight {
                    pixels: pixels.clone(),
                    nodes,
                    z,
                    degrees,
                };
                list.push(flight.comparison(name, method, loss));
            }
        }
    }
    for method in [Method::Auto, Method::Beamlet] {
        list.push(bump(method, Loss::Image));
    }
    list.extend(through_lens(reduced));
    list
}

/// The error of fields at which raylet aims here.
const TARGET: f64 = 1e-4;

/// The two parts of each number in turn.
fn parts(list: &Array2<Complex64>) -> Vec<f64> {
    list.iter().flat_map(|z| [z.re, z.im]).collect()
}

fn by(method: Method) -> &'static str {
    match method {
        Method::Beamlet => "by beamlets",
        _ => "without rays",
    }
}

/// raylet's cotangent of the pixels of the first screen.
fn ours(
    system: &System,
    settings: &Settings,
    loss: Loss,
) -> Result<Vec<f64>, LinearisedSystemError> {
    let linearised = LinearisedSystem::new(system, &[], settings)?;
    let trace = linearised.forward(system)?;
    let bar = loss.bar(&trace.field.values);
    let gradient = linearised.adjoint(system, &[], &trace, &bar)?;
    Ok(gradient.pixels[0].as_ref().map_or(vec![], parts))
}

/// Pixels in free space.
struct Flight {
    pixels: Pixels,
    /// Gauss nodes of a pixel along each axis, for the direct sum.
    nodes: usize,
    /// Distance of the sensor.
    z: f64,
    /// Angle of the light.
    degrees: f64,
}

impl Flight {
    fn comparison(self, name: &str, method: Method, loss: Loss) -> Comparison {
        let (count, pitch) = (24, 1.7);
        let tilt = [self.degrees.to_radians().sin(), 0.0];
        let system = System {
            wavelength: 1.0,
            source: plane_wave(tilt),
            screens: vec![doe(0.0, &self.pixels), sensor(self.z, count, pitch)],
            trains: vec![vec![]],
        };
        let settings = Settings {
            method,
            target_error: TARGET,
            ..Settings::default()
        };
        let name = format!(
            "{name}, {}λ of free space, light at {}°, {}",
            self.z,
            self.degrees,
            by(method)
        );
        let exact = move || {
            let at = axis(count, pitch);
            let row = |y: &f64| at.iter().map(|x| [*x, *y, self.z]).collect::<Vec<_>>();
            let points: Vec<[f64; 3]> = at.iter().flat_map(row).collect();
            let field = rayleigh_sommerfeld(&self.pixels, tilt, 1.0, self.nodes, &points);
            let field = Array2::from_shape_fn((count, count), |(j, i)| field[j * count + i]);
            let bar: Vec<Complex64> = loss.bar(&field).iter().copied().collect();
            let field_bar = FieldBar {
                points: &points,
                values: &bar,
            };
            rayleigh_sommerfeld_adjoint(&self.pixels, tilt, 1.0, self.nodes, field_bar)
        };
        Comparison::new(
            name,
            loss.name(),
            "adjoint of Rayleigh–Sommerfeld",
            Box::new(move || Ok([ours(&system, &settings, loss)?, parts(&exact())])),
        )
    }
}

/// Pixels of a mirror on a Gaussian bump.
fn bump(method: Method, loss: Loss) -> Comparison {
    let (width, nodes) = (60.0, 6);
    let mirror = move || mirror::MirrorProblem {
        coat: Coat::Random(2.0),
        width,
        distance: 120.0,
        points: 20,
        pitch: 1.7,
    };
    let settings = Settings {
        method,
        target_error: TARGET,
        ..Settings::default()
    };
    let problem = mirror().problem("", settings, nodes);
    Comparison::new(
        format!(
            "30² random 2λ pixels on a Gaussian bump (radius 506λ), {}",
            by(method)
        ),
        loss.name(),
        "adjoint of Rayleigh–Sommerfeld on the true surface",
        Box::new(move || {
            let ours = ours(&problem.system, &problem.settings, loss)?;
            let bar = loss.bar(&mirror().exact(nodes));
            Ok([ours, parts(&mirror().exact_adjoint(nodes, &bar))])
        }),
    )
}
