//! Measures raylet against references that share no code with its rays, and prints `docs/accuracy.md`.
//!
//! `cargo run --release -p raylet-accuracy -- [--reduced] [--only WORDS] > docs/accuracy.md`

#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

use std::process::ExitCode;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::chain::simulate_error::SimulateError;
use raylet::engine::plan::settings::Settings;
use raylet_accuracy::estimates::report::print_estimates;
use raylet_accuracy::gradients::gradient_problems::comparisons;
use raylet_accuracy::measured_again::sentence;
use raylet_accuracy::problems::problem::{Measured, Problem};
use raylet_accuracy::problems::suite::{COLLINS, problems};

/// Random systems whose estimated errors are checked.
const ESTIMATES: u32 = 200;
const REDUCED_ESTIMATES: u32 = 24;

fn main() -> ExitCode {
    let reduced = std::env::args().any(|word| word == "--reduced");
    println!("# Accuracy\n");
    println!(
        "Made by `cargo run --release -p raylet-accuracy{}`. Errors are relative L2 errors of the \
         complex field on the sensor: absolute (nothing fitted, not even a phase), and of shape (after \
         the best complex factor). NCC is the normalised cross-correlation of the intensities. The \
         references are in `crates/raylet-accuracy`; their own convergence is shown by its tests and \
         its `convergence` example. raylet runs with its default settings; its own estimate is \
         what it prints as the expected field error. Each allowed error is at most three times the one that was \
         measured when it was set (`crates/raylet-accuracy/data/bounds.txt`).\n",
        if reduced { " -- --reduced" } else { "" }
    );
    println!("{}\n", sentence());
    println!(
        "| problem | reference | absolute | shape | 1 − NCC | own estimate | rays | allowed |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let only = std::env::args().skip_while(|word| word != "--only").nth(1);
    let chosen = |problem: &Problem| only.as_ref().is_none_or(|only| problem.name.contains(only));
    let (mut within, mut ratios) = (true, Vec::new());
    let mut paraxial = Vec::new();
    for problem in problems(reduced).into_iter().filter(chosen) {
        match problem.measure() {
            Ok(found) => {
                within &= problem.bound().is_some_and(|bound| found.absolute <= bound);
                if problem.reference != COLLINS {
                    ratios.push((problem.name.clone(), found.absolute / found.estimate));
                }
                println!("{}", row(&problem, &found));
            }
            Err(error) => {
                within = false;
                println!(
                    "| {} | {} | {error} | | | | | |",
                    problem.name, problem.reference
                );
            }
        }
        if problem.reference == COLLINS {
            paraxial.push(problem);
        }
    }
    print_coverage(&ratios);
    let doubts = paraxial.iter().try_for_each(doubt);
    let gradients = gradients(reduced, only.as_deref());
    let count = if reduced {
        REDUCED_ESTIMATES
    } else {
        ESTIMATES
    };
    let covered = only.is_some() || print_estimates(count);
    if within && gradients && covered && doubts.is_ok() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// The table of gradients, of those whose names hold a word; whether all are within their bounds.
fn gradients(reduced: bool, only: Option<&str>) -> bool {
    println!(
        "\n## Gradients\n\nRelative L2 errors of raylet's gradients, nothing fitted; each side takes the \
         cotangent of the loss from its own field. Of pixels both parts of the cotangent are compared, where no \
         phases are named. Against adjoints raylet aims at field errors of 1e-4, against differences at the usual \
         1e-3.\n"
    );
    println!("| gradient | loss | reference | entries | error | allowed |");
    println!("|---|---|---|---|---|---|");
    let mut within = true;
    let chosen = |name: &str| only.is_none_or(|only| name.contains(only));
    for comparison in comparisons(reduced) {
        if !chosen(&comparison.name) {
            continue;
        }
        let head = format!(
            "| {} | {} | {} |",
            comparison.name, comparison.loss, comparison.reference
        );
        match comparison.measure() {
            Ok((error, entries)) => {
                let bound = comparison.bound();
                within &= bound.is_some_and(|bound| error <= bound);
                println!("{head} {entries} | {error:.1e} | {} |", allowed(bound));
            }
            Err(error) => {
                within = false;
                println!("{head} {error} | | |");
            }
        }
    }
    within
}

/// A problem as a row of the table.
fn row(problem: &Problem, found: &Measured) -> String {
    format!(
        "| {} | {} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {} | {} |",
        problem.name,
        problem.reference,
        found.absolute,
        found.shape,
        1.0 - found.ncc,
        found.estimate,
        found.rays,
        allowed(problem.bound())
    )
}

/// A bound as it is written in the tables.
fn allowed(bound: Option<f64>) -> String {
    bound.map_or_else(
        || String::from("none recorded"),
        |bound| format!("{bound:.0e}"),
    )
}

/// How many errors the estimates cover, and which they do not, by name and the ratio of error to estimate. What
/// a paraxial reference calls an error is left out.
fn print_coverage(ratios: &[(String, f64)]) {
    let apart = ratios
        .iter()
        .filter(|(_, ratio)| !(0.5..=2.0).contains(ratio));
    let apart: Vec<String> = apart
        .map(|(name, ratio)| format!("{name} ({ratio:.1} times)"))
        .collect();
    println!(
        "\nOf the {} problems whose reference is exact, the error is between half the estimate and twice in {}; \
         it is not in: {}.",
        ratios.len(),
        ratios.len() - apart.len(),
        apart.join("; ")
    );
}

/// Collins' integral is paraxial. A run with a hundredth of the target error shows the integral's own error.
fn doubt(problem: &Problem) -> Result<(), SimulateError> {
    let fine = Settings {
        target_error: 1e-5,
        ..problem.settings.clone()
    };
    let run = |settings: &Settings| simulate(&problem.system, settings, &|_| {});
    let (usual, fine) = (run(&problem.settings)?, run(&fine)?);
    let exact = (problem.exact)();
    let fine = &fine.field.values;
    println!(
        "\n{}: a run with target_error = 1e-5 is {:.1e} from the run above, and {:.1e} from Collins' paraxial \
         integral.",
        problem.name,
        difference(&usual.field.values, fine),
        difference(fine, &exact)
    );
    Ok(())
}

/// Relative L2 difference of two fields.
fn difference(a: &Array2<Complex64>, b: &Array2<Complex64>) -> f64 {
    let off: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_sqr()).sum();
    (off / b.iter().map(|b| b.norm_sqr()).sum::<f64>()).sqrt()
}
