//! Measures local bands on an objective with elements at its stop.
//!
//! `cargo run --release -p raylet-accuracy --example local_bands -- CASE ANGLE [WORD=VALUE ...]`, where CASE is bare, vortex,
//! cubic, lens or pixels, and ANGLE in degrees. The words: `sigma=100` the width of all windows in µm, which is chosen
//! without it; `radius` of the stop in mm; `sensor` its pixels of 1 µm along a side; `pitch` of the random pixels in µm;
//! `target`, `thr`, `step`, `period`, `corrected` the settings; `way=back` also measures the adjoint, `way=there` leaves
//! out the reference.

use std::error::Error;
use std::f64::consts::TAU;
use std::time::Instant;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::local_band_run::local_band_settings;
use raylet::engine::chain::outcome::Outcome;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::error::tally::Fate;
use raylet::engine::local_bands::carry::{LocalBandCotangent, carry_kept, carry_kept_adjoint};
use raylet::engine::local_bands::settings::LocalBandSettings;
use raylet::engine::plan::hop_method::HopMethod;
use raylet::engine::plan::settings::{Correction, Method, Settings};
use raylet::engine::progress::uncancelled;
use raylet::optics::doe::Layer;
use raylet::optics::phase::profile::Profile;
use raylet::optics::system::System;
use raylet::wave::grid::field::Field;
use raylet_accuracy::objective::masks::{cubic, random_pixels};
use raylet_accuracy::objective::ray_integral::{cell_nodes, field, polar_nodes};
use raylet_accuracy::objective::triplet::{Triplet, WAVELENGTH};
use raylet_accuracy::real_size::resources::{peak_megabytes, processor_seconds};

/// What the words after the angle say.
struct Words(Vec<(String, String)>);

impl Words {
    fn read() -> Self {
        let split = |word: String| {
            let (name, value) = word.split_once('=')?;
            Some((name.to_owned(), value.to_owned()))
        };
        Self(std::env::args().filter_map(split).collect())
    }

    fn text(&self, name: &str) -> Option<&str> {
        let found = self.0.iter().find(|(word, _)| word == name);
        found.map(|(_, value)| value.as_str())
    }

    fn number(&self, name: &str, usual: f64) -> Result<f64, Box<dyn Error>> {
        Ok(self.text(name).map_or(Ok(usual), str::parse)?)
    }

    /// The layers of a case.
    fn layers(&self, case: &str, radius: f64) -> Result<Vec<Layer>, Box<dyn Error>> {
        Ok(match case {
            "bare" => Vec::new(),
            "vortex" => vec![Layer::Phase(Profile::Vortex { charge: 1 })],
            "cubic" => vec![cubic(radius)],
            "lens" => vec![Layer::Phase(Profile::Lens {
                focal_length: 2000.0,
                wavenumber: TAU / WAVELENGTH,
            })],
            "pixels" => vec![random_pixels(
                [2.0 * radius; 2],
                self.number("pitch", 8.0)? * 1e-3,
            )],
            _ => return Err(format!("no case is named '{case}'").into()),
        })
    }

    fn settings(&self) -> Result<Settings, Box<dyn Error>> {
        let number = |name: &str| self.text(name).map(str::parse::<f64>).transpose();
        Ok(Settings {
            method: Method::LocalBands,
            target_error: self.number("target", 1e-3)?,
            sigma: number("sigma")?.map(|um| um * 1e-3),
            step: number("step")?,
            period: number("period")?,
            mode_threshold: number("thr")?,
            correction: match self.text("corrected") {
                Some("false") => Correction::Off,
                _ => Correction::Auto,
            },
            ..Settings::default()
        })
    }
}

/// The reference's field.
fn reference(triplet: &Triplet, radius: f64, system: &System) -> Option<Array2<Complex64>> {
    let doe = &triplet.element;
    if let Some(pixels) = doe.pixels() {
        let pitch = pixels.pitch[0];
        return field(system, &cell_nodes(doe, pitch));
    }
    let fine = match doe.layers.is_empty() {
        true => [200, 600],
        false => [300, 1440],
    };
    field(system, &polar_nodes(doe, radius, fine))
}

/// Measures the adjoint from a field: ⟨U, U⟩ by the sensor, and by the pixels and their cotangents.
fn measure_back(
    triplet: &Triplet,
    system: &System,
    settings: &LocalBandSettings,
) -> Result<(), Box<dyn Error>> {
    let (outcome, kept) = carry_kept(system, settings, &|_| uncancelled())?;
    let start = processor_seconds();
    let bar: Field = outcome.field.clone();
    let cotangent = LocalBandCotangent {
        field: &bar,
        variations: &[],
        pulse: &uncancelled,
    };
    let backs = carry_kept_adjoint(system, settings, &kept, &cotangent)?.pixels;
    let used = processor_seconds() - start;
    let there: f64 = bar.values.iter().map(|u| u.norm_sqr()).sum();
    let pixels = triplet.element.pixels().ok_or("no pixels")?;
    let back = backs.iter().flatten().next().ok_or("no cotangents")?;
    let pairs = back.iter().zip(&pixels.values);
    let here: Complex64 = pairs.map(|(bar, value)| bar.conj() * value).sum();
    println!(
        "  back: {used:.2} s of processor time; {:.1e} apart",
        (here - there).norm() / there
    );
    Ok(())
}

/// Prints what a run took, hop by hop, and what it expects of its error.
fn report(outcome: &Outcome) {
    let mut total = 0.0;
    for hop in &outcome.hops {
        let HopMethod::LocalBands(plan) = &hop.method else {
            continue;
        };
        let (tally, [nx, ny]) = (&hop.tally, plan.windows);
        println!(
            "  {} -> {}: σ {:.0} µm, {nx} × {ny} windows, {} beamlets, {:.2} s",
            hop.screens[0],
            hop.screens[1],
            plan.sigma * 1e3,
            tally.rays(Fate::Arrived),
            hop.seconds,
        );
        let Some(budget) = hop.budget() else {
            continue;
        };
        println!(
            "    expected: aberration {:.1e} of {:.1e}, windows {:.1e}, dropped {:.1e}, rims {:.1e}",
            budget.aberration,
            tally.eta(),
            budget.windows,
            budget.dropped,
            budget.rims
        );
        total = f64::hypot(total, budget.total());
    }
    println!("  expected error {total:.1e}");
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
    let mut places = std::env::args().skip(1);
    let case = places.next().unwrap_or_else(|| "bare".to_owned());
    let angle = places.next().map_or(Ok(0.0), |word| word.parse::<f64>())?;
    let words = Words::read();
    let radius = words.number("radius", 4.0)?;
    let mut triplet = Triplet::bare(radius, angle);
    triplet.pixels = words.number("sensor", 32.0)? as usize;
    triplet.element.layers = words.layers(&case, radius)?;
    let system = triplet.system()?;
    let settings = words.settings()?;

    let (clock, start) = (Instant::now(), processor_seconds());
    let outcome = simulate(&system, &settings, &|_| {})?;
    let (wall, used) = (clock.elapsed().as_secs_f64(), processor_seconds() - start);
    println!("{case} {angle}° radius {radius}");
    println!(
        "  {used:.2} s of processor time, {wall:.2} s, at most {:.0} MB in use",
        peak_megabytes()
    );
    report(&outcome);
    if words.text("way") == Some("back") {
        measure_back(&triplet, &system, &local_band_settings(&system, &settings)?)?;
    }
    if words.text("way") == Some("there") {
        return Ok(());
    }
    let exact = reference(&triplet, radius, &system).ok_or("the reference lost a ray")?;
    let ([shape, absolute], factor) = errors(&outcome.field.values, &exact);
    println!("  shape {shape:.5} absolute {absolute:.5} factor {factor:.6}");
    Ok(())
}
