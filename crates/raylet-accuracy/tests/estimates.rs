//! The errors that raylet estimates for random small systems, beside their exact fields.

use raylet::engine::chain::forecast::{expected_error, forecast};
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::Settings;
use raylet::engine::rims::pixel_light::PixelValues;
use raylet::engine::rims::rim_screens::with_rims;
use raylet::optics::aperture::Aperture;
use raylet::optics::refraction::Coating;
use raylet::optics::screen::ScreenKind;
use rayon::prelude::*;

use raylet_accuracy::estimates::error_ratios::{
    EFFORT, FINER, Spread, case_at, distance, run_case,
};
use raylet_accuracy::estimates::random_systems::KINDS;
use raylet_accuracy::estimates::surface_sum::surface_sum;
use raylet_accuracy::problems::problem::face;
use raylet_testkit::parts::{lit, on_axis, screen, sensor};
use raylet_testkit::strong_mirror::strong_mirror;

const REPORT: &str = include_str!("../../../docs/accuracy.md");

/// Of the systems of the report, one in so many runs again; prime to the number of kinds, so that all kinds do.
const ONE_IN: usize = 11;

/// Ratios in the report, which has two digits behind the point, are those of a run again to this part of themselves.
const SAME: f64 = 0.1;

/// One in eleven of the systems of the report has the ratio of estimated to true error that it says. All of them are measured
/// again whenever the report is made.
#[test]
fn estimated_errors_are_as_reported_slow() {
    let ratios = reported_ratios();
    let count: usize = ratios.iter().map(|(_, ratios)| ratios.len()).sum();
    let again: Vec<usize> = (0..count).step_by(ONE_IN).collect();
    let cases = again.par_iter().map(|index| {
        let case = run_case(*index as u32).unwrap();
        let (kind, own) = &ratios[index % KINDS.len()];
        assert_eq!(*kind, format!("{:?}", case.kind));
        (own[case.number as usize], case)
    });
    let cases: Vec<_> = cases.collect();
    let apart: Vec<String> = cases
        .iter()
        .filter(|(reported, case)| (case.ratio() - reported).abs() > SAME * reported)
        .map(|(reported, case)| {
            format!(
                "{:?} {}: {:.2e} estimated, {:.2e} true, their ratio reported as {reported}",
                case.kind, case.number, case.estimate, case.truth
            )
        })
        .collect();
    assert!(apart.is_empty(), "{apart:#?}");
}

/// By the report, the estimated error is at least half of the true one in 95 of 100 systems, at most five times it in 93 of
/// 100, and never eight times too small. Its histogram counts its ratios.
#[test]
fn reported_ratios_cover_the_true_errors() {
    let ratios: Vec<f64> = reported_ratios()
        .into_iter()
        .flat_map(|(_, own)| own)
        .collect();
    let spread = Spread::of(&ratios);
    assert!(ratios.len() == 200 && spread.covers(), "{spread:?}");
    let reported = reported_counts();
    assert_eq!(reported.len(), spread.counts.len());
    for (place, (found, reported)) in spread.counts.iter().zip(&reported).enumerate() {
        // Two digits move ratios just below 1 over the bound between two bars.
        assert!(found.abs_diff(*reported) <= 2, "{place}: {spread:?}");
    }
}

/// The ratios of the systems of each kind in the report.
fn reported_ratios() -> Vec<(&'static str, Vec<f64>)> {
    let (_, table) = REPORT
        .split_once("| kind | ratio of each system |\n|---|---|\n")
        .unwrap();
    let (table, _) = table.split_once("\n\n").unwrap();
    let row = |line: &'static str| {
        let [_, kind, ratios, _] = line.split('|').collect::<Vec<_>>().try_into().unwrap();
        let ratios = ratios.split_whitespace().map(|word| word.parse().unwrap());
        (kind.trim(), ratios.collect())
    };
    table.lines().map(row).collect()
}

/// Systems by their ratio in the report, from its histogram.
fn reported_counts() -> Vec<usize> {
    let (_, histogram) = REPORT.split_once("ratio         systems\n").unwrap();
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

/// A stop of 60 λ stands before a lens of 80 λ. The forecast error and the error that the run estimates are within a factor of
/// three of the true one.
#[test]
fn estimates_of_a_small_stop_before_a_lens_are_true() {
    let stop = screen(on_axis(0.0), ScreenKind::Stop(Aperture::disc(30.0)));
    let last = screen(on_axis(225.0), sensor(12, 2.0));
    let train = vec![
        face(10.0, 120.0, 40.0, Coating::Unit, [1.0, 1.5]),
        face(25.0, f64::INFINITY, 40.0, Coating::Unit, [1.5, 1.0]),
    ];
    let mut system = lit(vec![stop, last], vec![train]);
    system.wavelength = 1.0;
    let settings = Settings::default();
    let rimmed = with_rims(&system, &settings, PixelValues::Fixed);
    let told = expected_error(&rimmed, &forecast(&rimmed.system, &settings).unwrap()).unwrap();
    let outcome = simulate(&system, &settings, &|_| {}).unwrap();
    let truth = distance(&outcome.field.values, &surface_sum(&system, EFFORT));
    let estimate = outcome.expected_error().unwrap();
    let found = format!("{told:.2e} told, {estimate:.2e} estimated, {truth:.2e} true");
    for error in [told, estimate] {
        assert!((1.0 / 3.0..3.0).contains(&(error / truth)), "{found}");
    }
}

/// A smaller target does not raise the expected error. In these systems it once did, by up to 11 %: rims make most of the
/// error, or a free hop has far less than its target. A target between two powers of ten is planned as the lower one.
#[test]
fn a_smaller_target_does_not_raise_the_expected_error() {
    assert_expected_errors_fall(&[(9, 1e-5), (10, 1e-4), (75, 1e-4)]);
}

/// The same in four more systems, two minutes of them: whenever the report is made.
#[test]
#[ignore = "slow: run by make accuracy"]
fn a_smaller_target_does_not_raise_the_expected_error_of_slow_systems() {
    assert_expected_errors_fall(&[21, 103, 110, 189].map(|index| (index, 1e-4)));
}

/// Runs systems of the report, each down to a smallest target.
fn assert_expected_errors_fall(systems: &[(u32, f64)]) {
    for (index, tightest) in systems {
        let (kind, number, _, system) = case_at(*index);
        let targets = [1e-2, 3e-3, 1e-3, 1e-4, 1e-5].into_iter();
        let targets = targets.filter(|target| target >= tightest);
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
