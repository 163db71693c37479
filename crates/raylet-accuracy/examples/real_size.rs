//! Measures systems at their real size, and prints `docs/real_size.md`.
//!
//! `cargo run --release -p raylet-accuracy --example real_size -- [--only WORDS] > docs/real_size.md`. Each case runs in a
//! process of its own, which is this program with the word `--case` and the name of the case.

use std::error::Error;
use std::process::Command;

use raylet_accuracy::real_size::cases::{Case, cases, convergence};
use raylet_accuracy::real_size::measure::{Measured, measure};

/// What stands before the table.
const HEAD: &str = "\
# Systems at their real size

`make real-size` makes this page. Each row is one run of a scene in `scenes/real_size`, by `simulate` with the settings of the
scene, in a process of its own, on a machine with THREADS threads. The sensor stands about the chief ray, for the
grating about its first order: 96 × 96 pixels of 1 µm (of the hybrid lenses 0.25 µm and 0.5 µm, of the lenses for phones 0.5 µm
and 0.8 µm, of the combiner 41.7 µm), for the modulator 1024 × 1024 pixels of 3.45 µm.

| column | meaning |
| --- | --- |
| mask | what stands at the stop; its pixels, if it has any, cover the whole stop |
| field | angle of the collimated light to the axis |
| processor | processor time of all threads, in seconds |
| wall | time by the clock, in seconds; other work on the machine lengthens it |
| peak | the largest memory of the process, arrays of the mask included |
| expected | the error that raylet expects: all causes, all hops |
| rims | the part of it that is counted for edges of lenses, which the reference does not know |
| measured | relative L2 error of the complex field on a block of pixels about the brightest one, nothing fitted, not even a phase |

The reference is one integral over the stop: the geometrical field on it, times the mask, times the ray Green's function of
what stands behind it (`crates/raylet-accuracy/src/objective/ray_integral.rs`). It takes rays from raylet and nothing else. It
knows no rim but the stop: light that the edges of the lenses diffract is in the expected error only, and the measured error is
to be compared with what is expected without rims. The block has 32 × 32
pixels, for the modulator 16 × 16. For the combiner the reference is the Rayleigh–Sommerfeld integral over the mirror
(`surface_integral.rs` beside it), without rays, at 3 × 3 pixels that are spread over the eye box.

| system | mask | field | processor | wall | peak | expected | rims | measured |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |";

/// What stands before the second table.
const CONVERGENCE: &str = "
## Errors and target errors

Some of these systems at other target errors. The reference knows no rim but the stop, so errors of some 1e-5 may be its own.

| system | mask | field | target | processor | wall | peak | expected | rims | measured |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |";

/// What stands behind it.
const TAIL: &str = "
## What is not there yet

With random pixels the modulator goes by beamlets from a whole field and takes three times as long as with its array of spots,
which has few directions and goes by local bands.

At target errors of 1e-4 and 1e-5 errors of some 1e-5 may be those of the reference.

Off the axis of the double Gauss lens at f/2 the expected error is 30 times too large: nearly all of it is counted for
the edges of the lenses behind the stop. These edges do not diffract. With its full opening the edge of a lens before the stop cuts
light at 10° and diffracts it, which takes 10 s. At 12° and 14° more edges do, one after the other; their light would take more than
four minutes, so that they cut single rays, and errors of 7e-2 and 8e-2 are expected. Edges before the stop of the triplet with
a grating or pixels at 20° do so too.

All rows are of one run. From run to run times differ by up to a third.

The edge of the combiner sends 6e-3 of the field into the eye box, at 20° to the light. It is summed along the edge, with
narrower windows; without it the run took 2 s.

Missing are a metasurface on a curved face, and mirrors with pixels.";

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().collect();
    let behind = |name: &str| words.iter().skip_while(|word| *word != name).nth(1);
    if let Some(name) = behind("--case") {
        let mut all = cases().into_iter().chain(convergence());
        return match all.find(|case| case.key() == *name) {
            Some(case) => run(&case),
            None => Err(format!("no case is named '{name}'").into()),
        };
    }
    let threads = std::thread::available_parallelism()?.to_string();
    println!("{}", HEAD.replace("THREADS", &threads));
    for case in &cases() {
        apart(case, behind("--only"))?;
    }
    println!("{CONVERGENCE}");
    for case in &convergence() {
        apart(case, behind("--only"))?;
    }
    println!("{TAIL}");
    Ok(())
}

/// Runs a case in a process of its own, if its name holds a word.
fn apart(case: &Case, only: Option<&String>) -> Result<(), Box<dyn Error>> {
    let name = case.key();
    if only.is_some_and(|only| !name.contains(only)) {
        return Ok(());
    }
    let this = std::env::current_exe()?;
    let ended = Command::new(this).args(["--case", &name]).status()?;
    if !ended.success() {
        println!("{} ended with {ended} | | | | | |", place(case));
    }
    Ok(())
}

/// Prints the row of a case.
fn run(case: &Case) -> Result<(), Box<dyn Error>> {
    match measure(case) {
        Ok(found) => println!("{}", row(case, &found)),
        Err(refusal) => println!("{} refused: {refusal} | | | | | |", place(case)),
    }
    Ok(())
}

/// The cells that name a case.
fn place(case: &Case) -> String {
    let scene = case.scene.replace('_', " ");
    let target = case
        .target
        .map_or(String::new(), |target| format!(" {target:.0e} |"));
    format!(
        "| {scene} | {} | {}° |{target}",
        case.place(),
        case.angle_deg
    )
}

fn row(case: &Case, found: &Measured) -> String {
    let error = found.error;
    format!(
        "{} {:.1} s | {:.1} s | {:.0} MB | {:.1e} | {:.1e} | {} |",
        place(case),
        found.processor,
        found.wall,
        found.megabytes,
        found.expected,
        found.rims,
        error.map_or("–".to_owned(), |error| format!("{error:.1e}"))
    )
}
