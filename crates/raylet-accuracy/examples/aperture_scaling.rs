//! Measures what local bands take when a lens grows at constant f-number, and how exact they are.
//!
//! `cargo run --release -p raylet-accuracy --example aperture_scaling` writes `docs/aperture_scaling.md` and its picture. All
//! lengths of the Cooke triplet f/4 are multiplied; the wavelength, the sensor (32 x 32 pixels of 1 um on the axis) and the
//! pixels of the random mask stay.

use std::error::Error;
use std::fmt::Write;
use std::path::Path;

use raylet::engine::chain::outcome::HopReport;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::error::tally::Fate;
use raylet::engine::plan::hop_method::HopMethod;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::optics::doe::Layer;
use raylet_accuracy::objective::masks::{cubic, random_pixels};
use raylet_accuracy::objective::ray_integral::{cell_nodes, field, polar_nodes};
use raylet_accuracy::objective::triplet::Triplet;
use raylet_accuracy::real_size::resources::processor_seconds;
use raylet_plot::chart_panel::Series;
use raylet_plot::figure::{Figure, Panel};

/// Diameters of the stop in mm; at f = 50 mm it has 8.
const DIAMETERS: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];

/// Pitch of the random pixels in mm.
const PITCH: f64 = 8e-3;

/// Bytes of a beamlet that is held.
const BEAMLET: f64 = 96.0;

const HEAD: &str = "\
# Cost and error against the aperture

`make aperture-scaling` makes this page. The Cooke triplet f/4 of [real size](real_size.md) is scaled as a whole, with a cubic
phase of 20 waves or random pixels of 8 µm at its stop; the wavelength of 0.55 µm and the sensor of 32 × 32 pixels of 1 µm
stay. Held are the beamlets that arrive at the stop, 96 bytes each. The error is that of the field against one integral over
the stop, nothing fitted.

![Processor time, memory and error against the diameter of the stop](aperture_scaling.png)

| mask | stop | processor | held | windows | expected | measured |
| --- | --- | --- | --- | --- | --- | --- |
";

/// One run.
struct Row {
    diameter: f64,
    seconds: f64,
    bytes: f64,
    windows: usize,
    expected: f64,
    error: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut page = HEAD.to_owned();
    let mut all = Vec::new();
    for name in ["cubic phase", "random pixels"] {
        let mut rows = Vec::new();
        for diameter in DIAMETERS {
            let row = measure(name, diameter)?;
            writeln!(
                page,
                "| {name} | {diameter} mm | {:.1} s | {:.1} MB | {} | {:.1e} | {:.1e} |",
                row.seconds,
                row.bytes * 1e-6,
                row.windows,
                row.expected,
                row.error
            )?;
            rows.push(row);
        }
        all.push((name, rows));
    }
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    std::fs::write(docs.join("aperture_scaling.md"), page)?;
    std::fs::write(docs.join("aperture_scaling.png"), picture(&all)?)?;
    Ok(())
}

/// Runs the triplet with a stop of this diameter.
fn measure(name: &str, diameter: f64) -> Result<Row, Box<dyn Error>> {
    let radius = 0.5 * diameter;
    let mut triplet = Triplet::bare(radius, 0.0);
    triplet.scale = diameter / 8.0;
    let layer: Layer = match name {
        "cubic phase" => cubic(radius),
        _ => random_pixels([diameter; 2], PITCH),
    };
    triplet.element.layers = vec![layer];
    let system = triplet.system()?;
    let settings = Settings {
        method: Method::LocalBands,
        ..Settings::default()
    };
    let start = processor_seconds();
    let outcome = simulate(&system, &settings, &|_| {})?;
    let seconds = processor_seconds() - start;

    let doe = &triplet.element;
    // The integral has as many nodes at least as at f = 50 mm: in a short lens a pixel is seen in different directions.
    let cell = PITCH / (8.0 / diameter).max(1.0);
    let exact = match doe.pixels() {
        Some(_) => field(&system, &cell_nodes(doe, cell)),
        None => field(&system, &polar_nodes(doe, radius, [200, 480])),
    };
    let exact = exact.ok_or("no light arrives by the integral")?;
    let pairs = exact.iter().zip(&outcome.field.values);
    let off: f64 = pairs.map(|(a, b)| (a - b).norm_sqr()).sum();
    let norm: f64 = exact.iter().map(|value| value.norm_sqr()).sum();

    let hops = &outcome.hops;
    let held = hops
        .first()
        .map_or(0.0, |hop| hop.tally.rays(Fate::Arrived) as f64);
    Ok(Row {
        diameter,
        seconds,
        bytes: BEAMLET * held,
        windows: hops.iter().map(windows).sum(),
        expected: outcome.expected_error().unwrap_or(0.0),
        error: (off / norm).sqrt(),
    })
}

/// Windows of a hop.
fn windows(hop: &HopReport) -> usize {
    match &hop.method {
        HopMethod::LocalBands(plan) => plan.windows[0] * plan.windows[1],
        HopMethod::WholeField(_) => 0,
    }
}

/// Three charts against the diameter of the stop.
fn picture(all: &[(&str, Vec<Row>)]) -> Result<Vec<u8>, Box<dyn Error>> {
    let chart = |of: &dyn Fn(&Row) -> f64, title: &str, unit: &str, range: [f64; 2]| {
        let series = all
            .iter()
            .map(|(name, rows)| Series::line(name, rows.iter().map(|row| [row.diameter, of(row)])));
        Panel::from(
            Panel::lines(series.collect())
                .title(title)
                .x_axis("diameter of the stop", "mm")
                .y_axis(title, unit)
                .y_range(range)
                .log_x()
                .log_y(),
        )
    };
    let charts = vec![
        chart(&|row| row.seconds, "processor time", "s", [0.1, 100.0]),
        chart(&|row| row.bytes * 1e-6, "beamlets held", "MB", [0.01, 10.0]),
        chart(&|row| row.error, "error of the field", "", [1e-5, 1e-2]),
    ];
    let figure = Figure::new(vec![charts], "A triplet f/4 that grows");
    Ok(figure.width(1500.0).to_png(1.0)?)
}
