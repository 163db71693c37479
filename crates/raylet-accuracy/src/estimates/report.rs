//! Estimated and true errors as a section of the accuracy report.

use crate::estimates::error_ratios::{BOUNDS, Case, Spread, run_case};
use crate::estimates::random_systems::KINDS;

/// Cells of the longest bar of the histogram.
const LONGEST: usize = 50;

/// Runs `count` cases and prints how estimated errors compare with true ones; whether they cover them as they should:
/// at least half of the true error in 95 of 100, at most five times in 93 of 100, and never eight times too small.
pub fn print_estimates(count: u32) -> bool {
    println!(
        "\n## Estimated errors\n\n{count} random systems of twelve kinds, each some 10 to 30 wavelengths across, with target \
         errors of 1e-3, 1e-2 and 1e-4 in turn, many with sensors on which little light falls. The true error is the \
         relative L2 distance of the complex field from surface integrals from each surface to the next, nothing \
         fitted. Ratios are of the estimated to the true error; errors below 2e-5 count as equal. Where the \
         estimated error is larger than the target, the target was not met, and raylet says so.\n"
    );
    let mut cases = Vec::new();
    for index in 0..count {
        match run_case(index) {
            Ok(case) => cases.push(case),
            Err(error) => println!("Refused, number {index}: {error}\n"),
        }
    }
    print_kinds(&cases);
    let ratios: Vec<f64> = cases.iter().map(Case::ratio).collect();
    let spread = Spread::of(&ratios);
    print_histogram(&spread);
    print_ratios(&cases);
    println!(
        "\nAt least half of the true error: {:.1} % (95 required). At most five times: {:.1} % (93 required). Smallest \
         ratio: {:.2} (0.12 required). The case is run alone by `cargo run --release -p raylet-accuracy --example \
         estimates`.",
        100.0 * spread.at_least_half,
        100.0 * spread.at_most_five,
        spread.least
    );
    cases.len() == count as usize && spread.covers()
}

/// A row for each kind.
fn print_kinds(cases: &[Case]) {
    println!("| kind | systems | target met | smallest ratio | median | largest |");
    println!("|---|---|---|---|---|---|");
    for kind in KINDS {
        let own: Vec<&Case> = cases.iter().filter(|case| case.kind == kind).collect();
        let mut ratios: Vec<f64> = own.iter().map(|case| case.ratio()).collect();
        ratios.sort_by(f64::total_cmp);
        let met = own.iter().filter(|case| case.truth <= case.target).count();
        if let (Some(least), Some(most)) = (ratios.first(), ratios.last()) {
            let median = ratios[ratios.len() / 2];
            println!(
                "| {kind:?} | {} | {met} | {least:.2} | {median:.2} | {most:.2} |",
                own.len()
            );
        }
    }
}

/// The ratio of each case, by kind: tests measure some of them again.
fn print_ratios(cases: &[Case]) {
    println!("\n| kind | ratio of each system |\n|---|---|");
    for kind in KINDS {
        let own = cases.iter().filter(|case| case.kind == kind);
        let ratios: Vec<String> = own.map(|case| format!("{:.2}", case.ratio())).collect();
        println!("| {kind:?} | {} |", ratios.join(" "));
    }
}

/// A bar for each range of ratios.
fn print_histogram(spread: &Spread) {
    let most = spread.counts.iter().copied().max().unwrap_or(0).max(1);
    println!("\n```text\nratio         systems");
    for (place, count) in spread.counts.iter().enumerate() {
        let low = place.checked_sub(1).map(|below| BOUNDS[below]);
        let range = match (low, BOUNDS.get(place)) {
            (None, Some(high)) => format!("below {high}"),
            (Some(low), Some(high)) => format!("{low} to {high}"),
            (low, None) => format!("above {}", low.unwrap_or_default()),
        };
        let bar = "#".repeat((count * LONGEST).div_ceil(most));
        println!("{range:<12} {count:>4} {bar}");
    }
    println!("```");
}
