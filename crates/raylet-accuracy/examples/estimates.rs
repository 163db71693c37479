//! Prints estimated and true errors of random systems, one a line: `cargo run --release -p raylet-accuracy --example
//! estimates -- [FROM] [TO] [KIND]`; with the word `check` behind them how far the reference is from a finer one.

use raylet_accuracy::estimates::error_ratios::{EFFORT, FINER, case_at, distance, run_case};
use raylet_accuracy::estimates::surface_sum::surface_sum;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize, usual: u32| {
        words
            .get(at)
            .and_then(|word| word.parse().ok())
            .unwrap_or(usual)
    };
    let check = words.iter().any(|word| word == "check");
    let kind = words.get(2).filter(|word| *word != "check");
    println!(
        "kind number target estimated true ratio intensity seconds seconds | aberration windows dropped rims"
    );
    for index in number(0, 0)..number(1, 200) {
        let (its, number, _, system) = case_at(index);
        if kind.is_some_and(|kind| *kind != format!("{its:?}")) {
            continue;
        }
        if check {
            let (usual, finer) = (surface_sum(&system, EFFORT), surface_sum(&system, FINER));
            println!("{its:?} {number}: {:.1e}", distance(&usual, &finer));
            continue;
        }
        match run_case(index) {
            Ok(case) => println!(
                "{:?} {number} {:.0e} {:.2e} {:.2e} {:.2} {:.1e} {:.2} {:.2} | {}",
                case.kind,
                case.target,
                case.estimate,
                case.truth,
                case.ratio(),
                case.intensity,
                case.seconds[0],
                case.seconds[1],
                case.parts.map(|part| format!("{part:.1e}")).join(" ")
            ),
            Err(error) => println!("{its:?} {number}: {error}"),
        }
    }
}
