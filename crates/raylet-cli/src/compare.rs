//! `raylet compare A B`: how alike the fields of two runs are.

use std::path::PathBuf;

use clap::Args;
use raylet::file::arrays::memory::{MachineMemory, MemoryLimit};
use raylet::file::result::comparison::{Comparison, Likeness, Side};
use raylet::file::result::document;
use raylet::file::result::light_metrics::Metrics;
use raylet::file::storage::folder::{COMPARISON_FILE, COMPARISON_PICTURE, OutputFolder};
use raylet_plot::contrast::contrast_png;
use raylet_plot::text_table::table;

use crate::failure::Failure;
use crate::say::{complain, say};

/// Compares the fields of two runs on one sensor, the second taken as the reference.
#[derive(Args)]
pub(crate) struct Compare {
    /// A folder of results, a field.npz, or a beam file (.zbf).
    a: PathBuf,
    /// The reference: a folder of results, a field.npz, or a beam file (.zbf).
    b: PathBuf,
    /// Writes compare.json and compare.png into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// The most memory that the fields, numbers and pictures may take, in units of 10⁶ bytes; half of what is free by
    /// default.
    #[arg(long, value_name = "MB", value_parser = megabytes)]
    #[arg(allow_negative_numbers = true)]
    memory_limit_mb: Option<f64>,
}

impl Compare {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        // What cannot be written is refused before anything is read.
        let claim = |path: &PathBuf| OutputFolder::claim_as(path, COMPARISON_FILE);
        let target = self.out.as_ref().map(claim).transpose()?;
        let given = self
            .memory_limit_mb
            .map(|megabytes| (megabytes * 1e6) as u64);
        let limit = MemoryLimit {
            bytes: given.unwrap_or_else(|| MachineMemory::now().usual_limit()) / 2,
            set_by: "half of --memory-limit-mb, since numbers and pictures take as much again",
        };
        let a = Side::read(&self.a, limit)?;
        let b = Side::read(&self.b, limit.without(a.fields.bytes()))?;
        for side in [&a, &b] {
            for sentence in &side.left_out {
                complain(&format!("{}: left out: {sentence}", side.path.display()));
            }
        }
        let comparison = Comparison::of(&a, &b)?;
        let document = document::text(&comparison, COMPARISON_FILE)?;
        if let Some(target) = target {
            let mut draft = target.draft()?;
            let title = format!("A = {}, B = {}", self.a.display(), self.b.display());
            draft.write(COMPARISON_PICTURE, &contrast_png(&a, &b, &title)?)?;
            draft.publish(&document)?;
        }
        say(&text(&comparison))
    }
}

/// An amount of memory on the command line.
pub(crate) fn megabytes(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(megabytes) if megabytes > 0.0 && megabytes <= 1e12 => Ok(megabytes),
        _ => Err(String::from(
            "expected a number of megabytes, above zero, up to 1e12",
        )),
    }
}

/// The comparison as text: a block for each wavelength, and the total of several.
fn text(comparison: &Comparison) -> String {
    let (a, b) = (comparison.a.display(), comparison.b.display());
    let mut text = format!("A  {a}\nB  {b}  (reference)\n");
    for channel in &comparison.channels {
        text += &format!("\nWavelength {} µm\n", channel.wavelength_um);
        text += &block(&channel.likeness);
    }
    if comparison.channels.len() > 1 {
        text += "\nTotal: intensities added, fields with one factor for all wavelengths\n";
        text += &block(&comparison.total);
    }
    text
}

/// The numbers of one comparison.
fn block(likeness: &Likeness) -> String {
    let factor = likeness.factor.map_or(String::from("-"), |factor| {
        format!("{:.6} · exp({:+.6} i)", factor.modulus, factor.phase_rad)
    });
    let single = [
        ("intensity correlation (NCC)", fixed(likeness.ncc, 9)),
        ("unit-sum mean square error", number(likeness.unit_sum_mse)),
        ("field error ‖A − B‖ / ‖B‖", number(likeness.field_error)),
        ("with a factor ‖A − cB‖ / ‖A‖", number(likeness.shape_error)),
        ("the factor c", factor),
    ];
    let mut text = String::new();
    for (name, value) in single {
        text += &format!("  {name:<30}{value}\n");
    }
    let both = spot_metrics(&likeness.a)
        .into_iter()
        .zip(spot_metrics(&likeness.b));
    let rows: Vec<_> = both
        .map(|((name, a), (_, b))| vec![format!("{name:<28}"), a, b])
        .collect();
    text + &table(&["", "A", "B"], &rows, &[])
}

/// The lines about one spot.
fn spot_metrics(metrics: &Metrics) -> [(&'static str, String); 5] {
    let [width_x, width_y] = metrics.fwhm_um;
    let pair = |values: Option<[f64; 2]>, number: fn(Option<f64>) -> String| {
        let [p, q] = match values {
            Some(values) => values.map(|value| number(Some(value))),
            None => [number(None), number(None)],
        };
        format!("{p}, {q}")
    };
    let widths = format!("{}, {}", number(width_x), number(width_y));
    [
        ("power (mm²)", number(Some(metrics.power))),
        ("peak", number(Some(metrics.peak))),
        (
            "centroid x, y (mm)",
            pair(metrics.centroid_mm, |value| fixed(value, 6)),
        ),
        ("full width x, y (µm)", widths),
        ("50 %, 80 % radius (µm)", pair(metrics.encircled_um, number)),
    ]
}

/// So many decimals; zero has no sign.
fn fixed(value: Option<f64>, decimals: i32) -> String {
    let scale = 10f64.powi(decimals);
    value.map_or(String::from("-"), |value| {
        let rounded = (value * scale).round() / scale + 0.0;
        format!("{rounded:.*}", decimals as usize)
    })
}

/// Six digits, with an exponent where they would not fit.
fn number(value: Option<f64>) -> String {
    match value {
        None => String::from("-"),
        Some(0.0) => String::from("0"),
        Some(value) if (1e-3..1e5).contains(&value.abs()) => {
            let digits = 5 - value.abs().log10().floor() as i32;
            format!("{value:.*}", digits.max(0) as usize)
        }
        Some(value) => format!("{value:.5e}"),
    }
}
