//! Measures local bands on an objective with elements at its stop.
//!
//! `cargo run --release -p raylet-accuracy --example local_bands -- CASE ANGLE SIGMA_A SIGMA_B [RADIUS [PIXELS]]`, where
//! CASE is bare, vortex, cubic or pixels; the widths σ in µm, zero to have them chosen; the angle in degrees, the radius of
//! the stop in mm. Words such as `thr=1e-4`, `step=1.5`, `corrected=false` behind them change the settings.

use std::error::Error;
use std::f64::consts::TAU;
use std::time::Instant;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::local_bands::carry::{LocalBandOutcome, carry};
use raylet::engine::local_bands::settings::LocalBandSettings;
use raylet::engine::local_bands::window_widths::window_widths;
use raylet::math::random::uniform;
use raylet::optics::doe::{Layer, PixelForm, Pixels};
use raylet::optics::profile::Profile;
use raylet::optics::system::System;
use raylet::optics::zernike::ZernikeSum;
use raylet_accuracy::objective::ray_integral::{StopNode, cell_nodes, field, polar_nodes};
use raylet_accuracy::objective::triplet::Triplet;

/// Pitch of the random pixels in mm.
const PIXEL: f64 = 8e-3;

/// Seconds of processor time that this process has used, where the system says so.
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split(' ').collect();
    let ticks = |n: usize| fields.get(n).and_then(|word| word.parse::<f64>().ok());
    (ticks(12).unwrap_or(0.0) + ticks(13).unwrap_or(0.0)) / 100.0
}

/// Largest memory that this process has had, in MB, where the system says so.
fn peak_megabytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
    kilobytes.unwrap_or(0.0) / 1e3
}

/// 20 waves of x³ + y³ over the radius, by Zernike polynomials: Z7 and Z9 hold y³, Z8 and Z10 x³.
fn cubic(radius: f64) -> Layer {
    let waves = 20.0 * TAU;
    let mut coefficients = vec![0.0; 10];
    // x³ = (Z10/√8 + 3·(Z8/√8 + 2Z2/2)/3)/4 and likewise y³ = (−Z9/√8 + 3·(Z7/√8 + 2Z3/2)/3)/4.
    let trefoil = waves / (4.0 * 8f64.sqrt());
    (coefficients[9], coefficients[7]) = (trefoil, trefoil);
    (coefficients[8], coefficients[6]) = (-trefoil, trefoil);
    (coefficients[1], coefficients[2]) = (waves / 4.0, waves / 4.0);
    Layer::Phase(Profile::Zernike(ZernikeSum::new(radius, coefficients)))
}

/// Pixels of random phase over the stop.
fn random_pixels(radius: f64) -> (Layer, usize) {
    let count = (2.0 * radius / PIXEL).round() as usize;
    let phase = |(j, i)| TAU * uniform(5, [j as u32, i as u32, 0, 0]);
    let values = Array2::from_shape_fn((count, count), |at: (usize, usize)| {
        Complex64::cis(phase(at))
    });
    let pixels = Pixels {
        pitch: [PIXEL; 2],
        values,
        form: PixelForm::Box,
    };
    (Layer::Pixels(pixels), count)
}

/// The nodes of the reference, and the width of their cells.
fn nodes(triplet: &Triplet, radius: f64, count: Option<usize>) -> (Vec<StopNode>, Option<f64>) {
    match count {
        Some(count) => (cell_nodes(&triplet.element, count, PIXEL), Some(PIXEL)),
        None => {
            let fine = if triplet.element.layers.is_empty() {
                [200, 600]
            } else {
                [300, 1440]
            };
            (polar_nodes(&triplet.element, radius, fine), None)
        }
    }
}

/// Prints what a run took, hop by hop.
fn tell(outcome: &LocalBandOutcome) {
    for hop in &outcome.hops {
        let account = &hop.account;
        println!(
            "  {} -> {}: {:.2} s, {:.2} MB held",
            hop.screens[0],
            hop.screens[1],
            hop.seconds,
            hop.held as f64 / 1e6
        );
        println!(
            "    windows {} modes {} beamlets {} evaluations {:.2e} largest tile {}",
            account.windows,
            account.modes,
            account.beamlets,
            account.evaluations as f64,
            account.largest_tile
        );
        let [eta, left] = account.aberration();
        println!(
            "    dropped {:.1e} eta {eta:.1e} left {left:.1e} kept {:.3} lost {:.1e} beside {:.1e}",
            account.dropped(),
            account.kept,
            account.lost,
            account.beside
        );
    }
}

/// Relative L2 error after the best factor, absolute, and that factor.
fn errors(ours: &Array2<Complex64>, exact: &Array2<Complex64>) -> ([f64; 2], Complex64) {
    let power = |a: &Array2<Complex64>| a.iter().map(|u| u.norm_sqr()).sum::<f64>();
    let overlap: Complex64 = ours.iter().zip(exact).map(|(a, b)| a * b.conj()).sum();
    let shape = (1.0 - overlap.norm_sqr() / power(ours) / power(exact))
        .max(0.0)
        .sqrt();
    let absolute = (power(&(ours - exact)) / power(exact)).sqrt();
    ([shape, absolute], overlap / power(exact))
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let word = |n: usize, usual: &str| words.get(n).cloned().unwrap_or_else(|| usual.to_owned());
    let (case, angle) = (word(0, "bare"), word(1, "0").parse::<f64>()?);
    let given: Vec<f64> = [word(2, "0"), word(3, "0")]
        .iter()
        .map(|word| word.parse::<f64>().map(|um| um * 1e-3))
        .collect::<Result<_, _>>()?;
    let radius = word(4, "4").parse::<f64>()?;
    let mut triplet = Triplet::bare(radius, angle);
    triplet.pixels = word(5, "32").parse()?;
    let mut count = None;
    match case.as_str() {
        "vortex" => triplet
            .element
            .layers
            .push(Layer::Phase(Profile::Vortex { charge: 1 })),
        "cubic" => triplet.element.layers.push(cubic(radius)),
        "pixels" => {
            let (layer, pixels) = random_pixels(radius);
            triplet.element.layers.push(layer);
            count = Some(pixels);
        }
        _ => (),
    }
    let system: System = triplet.system()?;

    let sigmas = match given.iter().all(|sigma| *sigma > 0.0) {
        true => given,
        false => window_widths(&system, 1e-3)?,
    };
    let mut settings = LocalBandSettings::new(sigmas.clone());
    for choice in words.iter().skip(6) {
        match choice.split_once('=') {
            Some(("thr", value)) => settings.threshold = value.parse()?,
            Some(("step", value)) => settings.step = value.parse()?,
            Some(("period", value)) => settings.period = value.parse()?,
            Some(("tile", value)) => settings.tile = value.parse()?,
            Some(("edge", value)) => settings.edge_nodes = value.parse()?,
            Some(("corrected", value)) => settings.corrected = value.parse()?,
            _ => (),
        }
    }
    let (clock, start) = (Instant::now(), processor_seconds());
    let outcome = carry(&system, &settings)?;
    let (wall, used) = (clock.elapsed().as_secs_f64(), processor_seconds() - start);
    let names: Vec<String> = sigmas
        .iter()
        .map(|sigma| format!("{:.0}", sigma * 1e3))
        .collect();
    println!("{case} {angle}° radius {radius}, σ {} µm", names.join(", "));
    println!(
        "  {used:.2} s of processor time, {wall:.2} s, at most {:.0} MB in use",
        peak_megabytes()
    );
    tell(&outcome);

    let clock = Instant::now();
    let (nodes, cell) = nodes(&triplet, radius, count);
    let exact = field(&system, &nodes, cell).ok_or("the reference lost a ray")?;
    let ([shape, absolute], factor) = errors(&outcome.field.values, &exact);
    println!(
        "  reference {:.1} s; shape {shape:.5} absolute {absolute:.5} factor {factor:.6}",
        clock.elapsed().as_secs_f64()
    );
    Ok(())
}
