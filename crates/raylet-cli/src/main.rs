//! The `raylet` program: one file per verb, thin.

#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

mod check;
mod compare;
mod design;
mod failure;
mod gradcheck;
mod hologram;
mod interrupt;
mod outputs;
mod overrides;
mod paper;
mod progress;
mod reference;
mod result_folder;
mod say;
mod schema;
mod simulate;
mod steps;
mod study_display;
mod wait;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::failure::Failure;
use crate::say::complain;

/// Simulates and designs optics made of lenses, mirrors and diffractive elements.
#[derive(Parser)]
#[command(version, about)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Simulate(simulate::Simulate),
    Reference(reference::Reference),
    Compare(compare::Compare),
    Check(check::Check),
    Hologram(hologram::Hologram),
    Design(design::Design),
    Gradcheck(gradcheck::Gradcheck),
    Schema(schema::Schema),
    Paper(paper::Paper),
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match interrupt::watch().and_then(|()| run(&arguments.verb)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            complain(&format!("error: {failure}"));
            ExitCode::from(2)
        }
    }
}

fn run(verb: &Verb) -> Result<(), Failure> {
    match verb {
        Verb::Simulate(verb) => verb.run(),
        Verb::Reference(verb) => verb.run(),
        Verb::Compare(verb) => verb.run(),
        Verb::Check(verb) => verb.run(),
        Verb::Hologram(verb) => verb.run(),
        Verb::Design(verb) => verb.run(),
        Verb::Gradcheck(verb) => verb.run(),
        Verb::Schema(verb) => verb.run(),
        Verb::Paper(verb) => verb.run(),
    }
}
