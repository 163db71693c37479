//! Every method on the same problems, against references without rays: error, rays and time.
//!
//! `cargo run --release --example methods [free|lens] …`; lines are method, error, shape error, rays, s.

use ndarray::{Array1, Array2};
use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::hop_plan::Plan;
use raylet::engine::plan::settings::{Method, Paper, Settings};
use raylet::math::chirp::{Chirp2, Comb};
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::Layer;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::shape::Shape;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet_accuracy::numerics::pixels::Pixels as Boxes;
use raylet_accuracy::references::collins::{Abcd, CollinsIntegral};
use raylet_accuracy::references::rayleigh_sommerfeld::rayleigh_sommerfeld;
use raylet_testkit::noise::phases;
use raylet_testkit::parts::{self, box_pixels, conic, face, lit, on_axis, screen};

const WAVELENGTH: f64 = 0.7e-3;
const PITCH: f64 = 6.3e-3;

fn random_phase(n: usize) -> Array2<Complex64> {
    phases([n, n], 7)
}

/// A hologram: random pixels that are alike over `grain` of them send their light near the axis.
fn smooth_phase(n: usize, grain: usize) -> Array2<Complex64> {
    let coarse = random_phase(n);
    Array2::from_shape_fn((n, n), |(j, i)| coarse[[j / grain, i / grain]])
}

fn doe(values: Array2<Complex64>) -> Screen {
    screen(on_axis(0.0), box_pixels(values, PITCH))
}

fn sensor(z: f64, n: usize) -> Screen {
    screen(on_axis(z), parts::sensor(n, PITCH))
}

fn system(screens: Vec<Screen>, train: Vec<Surface>) -> System {
    System {
        wavelength: WAVELENGTH,
        ..lit(screens, vec![train])
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
    if let Some(Plan::Planes(p)) = hop.method.whole_field() {
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

/// What the source paper compares with: one sample per pixel, padded twice, its FFT's modes only.
fn spectrum_of_points(values: &Array2<Complex64>, z: f64, points: Comb) -> Array2<Complex64> {
    let (n, k) = (values.nrows(), std::f64::consts::TAU / WAVELENGTH);
    let pixels = Comb {
        start: -0.5 * (n as f64 - 1.0) * PITCH,
        step: PITCH,
        count: n,
    };
    let spacing = WAVELENGTH / (2.0 * n as f64 * PITCH);
    let modes = Comb {
        start: -(n as f64) * spacing,
        step: spacing,
        count: 2 * n,
    };
    let mut waves = Chirp2::new(pixels, pixels, modes, modes, -k).apply(values.view());
    for ((j, i), wave) in waves.indexed_iter_mut() {
        let q = (1.0 - modes.at(i).powi(2) - modes.at(j).powi(2)).sqrt();
        *wave *= Complex64::cis(k * q * z) / (4.0 * (n * n) as f64);
    }
    Chirp2::new(modes, modes, points, points, k).apply(waves.view())
}

fn free() {
    let (z, count, pitch) = (1.26, 50, 2.0 * PITCH);
    for (name, values) in [
        ("random pixels", random_phase(100)),
        ("grains of 4", smooth_phase(100, 4)),
    ] {
        let mut screens = vec![doe(values.clone()), sensor(z, count)];
        if let ScreenKind::Sensor(sensor) = &mut screens[1].kind {
            sensor.pitch = [pitch; 2];
        }
        let points = Comb {
            start: -0.5 * (count as f64 - 1.0) * pitch,
            step: pitch,
            count,
        };
        let everywhere: Vec<[f64; 3]> = (0..count * count)
            .map(|i| [points.at(i % count), points.at(i / count), z])
            .collect();
        let pixels = Boxes {
            pitch: PITCH,
            transmission: values.clone(),
        };
        let exact = rayleigh_sommerfeld(&pixels, [0.0; 2], WAVELENGTH, 10, &everywhere);
        let exact = Array2::from_shape_vec((count, count), exact).unwrap();
        println!("free space, {name}, against box pixels");
        let boxes = system(screens.clone(), vec![]);
        report("beamlet", &boxes, &with(Method::Beamlet), &exact);
        for (rays, orders) in [(128, 1), (2048, 1), (128, 3), (2048, 3), (64, 9)] {
            let label = format!("paper {rays} x 8000, orders {orders}");
            report(
                &label,
                &boxes,
                &paper(rays, 8000, 0.63, 2.0, orders),
                &exact,
            );
        }
        println!("free space, {name}, one sample per pixel, against the FFT's modes");
        if let ScreenKind::Doe(doe) = &mut screens[0].kind
            && let Layer::Pixels(pixels) = &mut doe.layers[0]
        {
            pixels.form = PixelForm::Point;
        }
        let exact = spectrum_of_points(&values, z, points);
        let samples = system(screens, vec![]);
        for rays in [128, 512, 2048, 8192] {
            let label = format!("paper {rays} x 8000");
            report(&label, &samples, &paper(rays, 8000, 0.63, 2.0, 1), &exact);
        }
    }
}

fn lens() {
    let (n, radius, index) = (200, 25.8, 1.513063997196);
    let face = |z: f64, shape: Shape, index: [f64; 2]| Surface {
        aperture: Aperture::disc(12.7),
        ..face(on_axis(z), shape, index)
    };
    let train = vec![
        face(3.0, conic(1.0 / radius, 0.0), [1.0, index]),
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
        let integral = CollinsIntegral {
            pixels: &pixels,
            wavelength: WAVELENGTH,
            train: abcd,
            nodes: 4,
        };
        let paraxial = integral.field([0.0; 2], [&axis, &axis]).unwrap();
        println!("lens, {name}: reference is a fine beamlet sum, then Collins");
        let fine = Settings {
            step: Some(1.25),
            period: Some(7.0),
            mode_threshold: Some(1e-4),
            footprint_threshold: Some(1e-5),
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
