//! Measures raylet against references that share no code with its rays, and prints `docs/accuracy.md`.
//!
//! `cargo run --release -p raylet-accuracy -- [--reduced] [--only WORDS] > docs/accuracy.md`

use std::process::ExitCode;

use raylet_accuracy::suite::problems;

fn main() -> ExitCode {
    let reduced = std::env::args().any(|word| word == "--reduced");
    println!("# Accuracy\n");
    println!(
        "Made by `cargo run --release -p raylet-accuracy{}`. Errors are relative L2 errors of the \
         complex field on the sensor: absolute (nothing fitted, not even a phase), and of shape (after \
         the best complex factor). NCC is the normalised cross-correlation of the intensities. The \
         references are in `crates/raylet-accuracy`; their own convergence is shown by its tests and \
         its `convergence` example. raylet runs with its default settings; its own estimate is \
         what it prints as the expected field error.\n",
        if reduced { " -- --reduced" } else { "" }
    );
    println!(
        "| problem | reference | absolute | shape | 1 − NCC | own estimate | rays | seconds | allowed |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut within = true;
    let only = std::env::args().skip_while(|word| word != "--only").nth(1);
    for problem in problems(reduced) {
        if only
            .as_ref()
            .is_some_and(|only| !problem.name.contains(only))
        {
            continue;
        }
        match problem.measure() {
            Ok(m) => {
                within &= m.absolute <= problem.limit;
                println!(
                    "| {} | {} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {} | {:.2} | {:.0e} |",
                    problem.name,
                    problem.reference,
                    m.absolute,
                    m.shape,
                    1.0 - m.ncc,
                    m.estimate,
                    m.rays,
                    m.seconds,
                    problem.limit
                );
            }
            Err(error) => {
                within = false;
                println!(
                    "| {} | {} | {error} | | | | | | |",
                    problem.name, problem.reference
                );
            }
        }
    }
    if within {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
