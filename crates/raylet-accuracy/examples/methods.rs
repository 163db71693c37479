//! Every method on the same problems, against references without rays: error, rays and time.
//!
//! `cargo run --release --example methods [free|lens] …`; lines are method, error, shape error, rays, s.

use ndarray::{Array1, Array2};
use num_complex::Complex64;
use raylet::engine::plan::Plan;
use raylet::engine::settings::{Method, Paper, Settings};
use raylet::engine::simulate::simulate;
use raylet::math::random::uniform;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::bend::{Coating, Interface};
use raylet::optics::doe::{Doe, Layer, PixelForm, Pixels};
use raylet::optics::frame::Frame;
use raylet::optics::screen::{Act, Screen, Sensor};
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::source::Source;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet_accuracy::collins::{Abcd, collins};
use raylet_accuracy::pixels::Pixels as Boxes;
use raylet_accuracy::rayleigh_sommerfeld::rayleigh_sommerfeld;

const WAVELENGTH: f64 = 0.7e-3;
const PITCH: f64 = 6.3e-3;

fn at(z: f64) -> Frame {
    Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, z))
}

fn random_phase(n: usize) -> Array2<Complex64> {
    let phase = |j: usize, i: usize| uniform(7, [j as u32, i as u32, 0, 0]);
    Array2::from_shape_fn((n, n), |(j, i)| {
        Complex64::cis(std::f64::consts::TAU * phase(j, i))
    })
}

/// A hologram: random pixels that are alike over `grain` of them send their light near the axis.
fn smooth_phase(n: usize, grain: usize) -> Array2<Complex64> {
    let coarse = random_phase(n);
    Array2::from_shape_fn((n, n), |(j, i)| coarse[[j / grain, i / grain]])
}

fn doe(values: Array2<Complex64>) -> Screen {
    let pixels = Pixels {
        pitch: [PITCH; 2],
        values,
        form: PixelForm::Box,
    };
    Screen {
        name: String::from("doe"),
        frame: Frame::GLOBAL,
        index: 1.0,
        arrives: 1.0,
        act: Act::Doe(Doe {
            layers: vec![Layer::Pixels(pixels)],
            aperture: Aperture::OPEN,
            reflect: false,
        }),
    }
}

fn sensor(z: f64, n: usize) -> Screen {
    Screen {
        name: String::from("sensor"),
        frame: at(z),
        index: 1.0,
        arrives: 1.0,
        act: Act::Sensor(Sensor {
            pixels: [n, n],
            pitch: [PITCH; 2],
        }),
    }
}

fn system(screens: Vec<Screen>, train: Vec<Surface>) -> System {
    System {
        wavelength: WAVELENGTH,
        source: Source::Plane {
            direction: Vec3::new(0.0, 0.0, 1.0),
            origin: Vec3::new(0.0, 0.0, 0.0),
        },
        screens,
        trains: vec![train],
    }
}

/// Relative error of the field, the same after the best complex factor, and NCC of the intensities.
fn judge(a: &Array2<Complex64>, b: &Array2<Complex64>) -> [f64; 3] {
    let norm = |f: &Array2<Complex64>| f.iter().map(|v| v.norm_sqr()).sum::<f64>();
    let error: f64 = a.iter().zip(b).map(|(x, y)| (x - y).norm_sqr()).sum();
    let cross: Complex64 = a.iter().zip(b).map(|(x, y)| x.conj() * y).sum();
    let shape = 1.0 - cross.norm_sqr() / norm(a) / norm(b);
    let both = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        a.iter()
            .zip(b)
            .map(|(x, y)| f(x.norm_sqr(), y.norm_sqr()))
            .sum()
    };
    let ncc = both(&|x, y| x * y) / (both(&|x, _| x * x) * both(&|_, y| y * y)).sqrt();
    [(error / norm(b)).sqrt(), shape.max(0.0).sqrt(), ncc]
}

fn report(name: &str, system: &System, settings: &Settings, exact: &Array2<Complex64>) {
    let outcome = match simulate(system, settings, &|_| {}) {
        Ok(outcome) => outcome,
        Err(error) => return println!("{name}: {error}"),
    };
    let hop = &outcome.hops[0];
    let [error, shape, ncc] = judge(&outcome.field.values, exact);
    println!(
        "{name}: error {error:.2e} shape {shape:.2e} ncc {ncc:.5} rays {:.3e} in {:.2} s",
        hop.tally.total_rays() as f64,
        hop.seconds
    );
    if let Plan::Planes(p) = &hop.plan {
        println!(
            "    sigma {:.4} step {:?} period {:.3} bands {:?} margin {:.3} fade {:?} expected {:.2e}",
            p.sigma,
            p.step,
            p.period,
            p.bands.map(|b| b.count),
            p.margin,
            p.fade,
            p.rays
        );
    }
}

fn with(method: Method) -> Settings {
    Settings {
        method,
        ..Settings::default()
    }
}

fn paper(rays: usize, secondary: usize, patch: f64, padding: f64, orders: usize) -> Settings {
    Settings {
        paper: Paper {
            rays,
            secondary,
            patch: Some(patch),
            padding,
            orders,
            ..Settings::default().paper
        },
        ..with(Method::Paper)
    }
}

fn free() {
    for (name, values) in [
        ("random pixels", random_phase(100)),
        ("grains of 4", smooth_phase(100, 4)),
    ] {
        let system = system(vec![doe(values.clone()), sensor(1.26, 100)], vec![]);
        let axis: Vec<f64> = (0..100).map(|i| (i as f64 - 49.5) * PITCH).collect();
        let mut points = Vec::new();
        for y in &axis {
            for x in &axis {
                points.push([*x, *y, 1.26]);
            }
        }
        let pixels = Boxes {
            pitch: PITCH,
            transmission: values,
        };
        let exact = rayleigh_sommerfeld(&pixels, [0.0; 2], WAVELENGTH, 4, &points);
        let exact = Array2::from_shape_vec((100, 100), exact).unwrap();
        println!("free space, {name}");
        report("auto", &system, &with(Method::Auto), &exact);
        report("beamlet", &system, &with(Method::Beamlet), &exact);
        report("plane", &system, &with(Method::Plane), &exact);
        for orders in [1, 3] {
            for (rays, secondary) in [(128, 8000), (512, 8000), (2048, 8000)] {
                let label = format!("paper {rays} x {secondary}, orders {orders}");
                report(
                    &label,
                    &system,
                    &paper(rays, secondary, 0.63, 2.0, orders),
                    &exact,
                );
            }
        }
    }
}

fn lens() {
    let (n, radius, index) = (200, 25.8, 1.513063997196);
    let face = |z: f64, shape: Shape, index: [f64; 2]| Surface {
        shape,
        frame: at(z),
        aperture: Aperture::disc(12.7),
        interface: Interface::Refract,
        coating: Coating::Ideal,
        index,
    };
    let convex = Shape::Conic(Conic {
        curvature: 1.0 / radius,
        conic: 0.0,
    });
    let train = vec![
        face(3.0, convex, [1.0, index]),
        face(8.3, Shape::Plane, [index, 1.0]),
    ];
    for (name, values) in [
        ("random pixels", random_phase(n)),
        ("grains of 4", smooth_phase(n, 4)),
    ] {
        let system = system(vec![doe(values.clone()), sensor(53.0, 200)], train.clone());
        let abcd = Abcd::identity()
            .drift(3.0, 1.0)
            .refract((index - 1.0) / radius)
            .drift(5.3, index)
            .refract(0.0)
            .drift(44.7, 1.0);
        let axis = Array1::from_iter((0..200).map(|i| (i as f64 - 99.5) * PITCH));
        let pixels = Boxes {
            pitch: PITCH,
            transmission: values,
        };
        let paraxial = collins(&pixels, [0.0; 2], WAVELENGTH, abcd, 4, [&axis, &axis]).unwrap();
        println!("lens, {name}: reference is a fine beamlet sum, then Collins");
        let fine = Settings {
            step: 1.25,
            period: 7.0,
            mode_threshold: 1e-4,
            footprint_threshold: 1e-5,
            sigma: Some(0.06),
            ..with(Method::Beamlet)
        };
        let exact = simulate(&system, &fine, &|_| {}).unwrap().field.values;
        println!(
            "fine beamlets against Collins: {:?}",
            judge(&exact, &paraxial)
        );
        report("beamlet", &system, &with(Method::Beamlet), &exact);
        report("plane", &system, &with(Method::Plane), &exact);
        report(
            "plane against Collins",
            &system,
            &with(Method::Plane),
            &paraxial,
        );
        for (rays, secondary) in [(250, 10_000), (1000, 10_000)] {
            let label = format!("paper {rays} x {secondary}");
            report(
                &label,
                &system,
                &paper(rays, secondary, 0.63, 2.0, 1),
                &exact,
            );
        }
    }
}

fn main() {
    let which: Vec<String> = std::env::args().skip(1).collect();
    if which.is_empty() || which.iter().any(|w| w == "free") {
        free();
    }
    if which.is_empty() || which.iter().any(|w| w == "lens") {
        lens();
    }
}
