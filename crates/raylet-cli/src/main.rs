//! The `raylet` program: one file per verb, thin.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `simulate` | `raylet simulate SCENE`: the field on the sensor, with pictures and numbers |
//! | `reference` | `raylet reference SCENE`: the same outputs by a method that needs no rays |
//! | `compare` | `raylet compare A B`: how alike the fields of two runs are |
//! | `check` | `raylet check SCENE`: what a scene says, what a run would do, and warnings |
//! | `hologram` | `raylet hologram SCENE`: the phase with which the sensor shows a picture |
//! | `design` | `raylet design SCENE`: phases and parameters of the system, found by gradients |
//! | `gradcheck` | `raylet gradcheck SCENE`: whether the gradients of a design are those of its loss |
//! | [`exchange`] | Verbs that exchange files with other programs: `import`, `export`, `convert`, `lenses` |
//! | `schema` | `raylet schema`: the JSON Schema of scene files |
//! | `paper` | `raylet paper NAME`: a study of the source paper, done again |
//! | `overrides` | Choices on the command line that take the place of the scene's |
//! | `sweep` | What a command line varies: fields of light, wavelengths and distances, a run for each |
//! | `run_lines` | Several runs as a table of few digits, a line for each, that fits into 80 columns |
//! | `outputs` | What the user allows for the files that a scene names |
//! | `result_folder` | Everything that a run leaves behind, as one folder |
//! | `absent` | Verbs that raylet does not have, and what there is instead |
//! | `say` | What the program says: answers on standard output, the rest on standard error |
//! | `failure` | What ends a verb early: one message for the user, exit code 2 |
//! | `interrupt` | What happens when the program is interrupted: no incomplete file stays behind |
//! | `progress` | How far a run has come |
//! | `steps` | How far a search has come, iteration by iteration |
//! | `study_display` | How far a study of the paper has come |
//! | `wait` | What is being done, from the first second of a wait to its end |

#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::string_slice,
    clippy::unreachable,
    clippy::unwrap_used
)]

mod absent;
mod check;
mod compare;
mod design;
mod exchange;
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
mod run_lines;
mod say;
mod schema;
mod simulate;
mod steps;
mod study_display;
mod sweep;
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
    Import(exchange::import::Import),
    Export(exchange::export::Export),
    Convert(exchange::convert::Convert),
    Lenses(exchange::lenses::Lenses),
    Schema(schema::Schema),
    Paper(paper::Paper),
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return refuse(&error),
    };
    match interrupt::watch().and_then(|()| run(&arguments.verb)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            complain(&format!("error: {failure}"));
            ExitCode::from(2)
        }
    }
}

/// Says what is wrong with a command line, or what was asked for, such as help.
fn refuse(error: &clap::Error) -> ExitCode {
    match absent::instead(error) {
        Some(text) => {
            complain(&format!("error: {text}"));
            ExitCode::from(2)
        }
        None => error.exit(),
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
        Verb::Import(verb) => verb.run(),
        Verb::Export(verb) => verb.run(),
        Verb::Convert(verb) => verb.run(),
        Verb::Lenses(verb) => verb.run(),
        Verb::Schema(verb) => verb.run(),
        Verb::Paper(verb) => verb.run(),
    }
}
