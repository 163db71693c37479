//! The errors that raylet estimates for random small systems, beside their exact fields.

use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::Settings;
use rayon::prelude::*;

use raylet_accuracy::estimates::error_ratios::{
    EFFORT, FINER, Spread, case_at, distance, run_case,
};
use raylet_accuracy::estimates::surface_sum::surface_sum;
use raylet_testkit::strong_mirror::strong_mirror;

/// Systems, as many as in the report.
const CASES: u32 = 200;

/// The estimated error is at least half of the true one in 95 of 100 systems, at most five times it in 90 of 100, and
/// never ten times too small.
#[test]
fn estimated_errors_cover_the_true_ones_slow() {
    let cases: Vec<_> = (0..CASES)
        .into_par_iter()
        .map(|index| run_case(index).unwrap())
        .collect();
    let spread = Spread::of(&cases);
    let apart: Vec<String> = cases
        .iter()
        .filter(|case| !(0.5..=5.0).contains(&case.ratio()))
        .map(|case| {
            format!(
                "{:?} {}: {:.2e} estimated, {:.2e} true",
                case.kind, case.number, case.estimate, case.truth
            )
        })
        .collect();
    assert!(spread.covers(), "{spread:?} {apart:#?}");

    // The report has the same histogram, but for systems whose ratio lies near a bound and differs between processors.
    let reported = reported_counts();
    assert_eq!(reported.len(), spread.counts.len());
    for (place, (found, reported)) in spread.counts.iter().zip(&reported).enumerate() {
        assert!(found.abs_diff(*reported) <= 2, "{place}: {spread:?}");
    }
}

/// Systems by their ratio in `docs/accuracy.md`, from its histogram.
fn reported_counts() -> Vec<usize> {
    let report = include_str!("../../../docs/accuracy.md");
    let (_, histogram) = report.split_once("ratio         systems\n").unwrap();
    let (histogram, _) = histogram.split_once("```").unwrap();
    let count = |line: &str| {
        line.split_whitespace()
            .filter_map(|word| word.parse().ok())
            .next_back()
    };
    histogram.lines().filter_map(count).collect()
}

/// The reference changes by less than 1e-5 when its nodes are made denser.
#[test]
fn surface_sums_have_converged() {
    for index in 0..12 {
        let (kind, number, _, system) = case_at(index);
        let (usual, finer) = (surface_sum(&system, EFFORT), surface_sum(&system, FINER));
        let off = distance(&usual, &finer);
        assert!(off < 1e-5, "{kind:?} {number}: {off:e}");
    }
}

/// Mirrors whose plans for a target of 1e-2 end far above it (at 6.9e-2 without tilt) meet it with the plan for a tighter
/// target: the true error is below the target and the expected one at most twice as large, and it covers the true one.
#[test]
fn another_plan_meets_a_missed_target() {
    for (radius, tilt) in [(60.0, 0.0), (60.0, 0.05)] {
        let system = strong_mirror(radius, tilt);
        let settings = Settings {
            target_error: 1e-2,
            ..Settings::default()
        };
        let outcome = simulate(&system, &settings, &|_| {}).unwrap();
        let truth = distance(&outcome.field.values, &surface_sum(&system, EFFORT));
        let expected = outcome.expected_error().unwrap();
        let found =
            format!("radius {radius}, tilt {tilt}: {expected:.2e} estimated, {truth:.2e} true");
        assert!(truth < settings.target_error, "{found}");
        // Raylet counts a target as missed where the expected error is above twice the target.
        assert!(expected <= 2.0 * settings.target_error, "{found}");
        assert!(expected > 0.5 * truth, "{found}");
    }
}

/// A smaller target does not raise the expected error. In these systems it once did, by up to 11 %: rims make most of the
/// error, or a free hop has far less than its target. A target between two powers of ten is planned as the lower one.
#[test]
fn a_smaller_target_does_not_raise_the_expected_error() {
    let with_rims_or_free = [10, 21, 75, 103, 110, 189].map(|index| (index, 1e-4));
    for (index, tightest) in [(9, 1e-5)].into_iter().chain(with_rims_or_free) {
        let (kind, number, _, system) = case_at(index);
        let targets = [1e-2, 3e-3, 1e-3, 1e-4, 1e-5].into_iter();
        let targets = targets.filter(|target| *target >= tightest);
        let expected = targets.map(|target_error| {
            let settings = Settings {
                target_error,
                ..Settings::default()
            };
            let outcome = simulate(&system, &settings, &|_| {}).unwrap();
            outcome.expected_error().unwrap()
        });
        let expected: Vec<f64> = expected.collect();
        let falls = expected.is_sorted_by(|looser, tighter| tighter <= looser);
        assert!(falls, "{kind:?} {number}: {expected:?}");
        assert_eq!(expected[1], expected[2], "{kind:?} {number}");
    }
}
