//! `docs/accuracy.md` has the rows of the problems that the code has, its quick rows are what the code measures, and its
//! bounds are close to what was measured.

use std::collections::BTreeSet;

use raylet_accuracy::gradients::gradient_problems::comparisons;
use raylet_accuracy::measured_again::{GRADIENT, SLOW_REFERENCES, is_measured_again, sentence};
use raylet_accuracy::problems::suite::problems;

const REPORT: &str = include_str!("../../../docs/accuracy.md");

/// The cells of the report's rows that have so many.
fn rows(cells: usize) -> Vec<Vec<&'static str>> {
    let rows = REPORT.lines().filter_map(|line| line.strip_prefix("| "));
    let rows = rows.map(|row| row.trim_end_matches(" |").split(" | ").collect::<Vec<_>>());
    rows.filter(|row| row.len() == cells).collect()
}

/// What a row says was measured, and what it says is allowed.
fn numbers(row: &[&str], measured: usize) -> Option<[f64; 2]> {
    let number = |text: &str| text.parse::<f64>().ok();
    Some([number(row.get(measured)?)?, number(row.last()?)?])
}

/// The row allows what the code allows: at least what was measured, and at most three times that, as far as two
/// digits show it.
fn assert_bound(row: &[&str], measured: usize, bound: Option<f64>) {
    let [measured, allowed] = numbers(row, measured).unwrap_or_else(|| panic!("{row:?}"));
    assert_eq!(Some(allowed), bound, "{row:?}");
    assert!(measured <= allowed && allowed <= 3.15 * measured, "{row:?}");
}

#[test]
fn every_problem_has_its_row_and_a_bound_near_its_error() {
    let rows = rows(8);
    for problem in problems(false) {
        let own: Vec<_> = rows.iter().filter(|row| row[0] == problem.name).collect();
        assert_eq!(own.len(), 1, "{}", problem.name);
        assert_eq!(own[0][1], problem.reference, "{}", problem.name);
        assert_bound(own[0], 2, problem.bound());
    }
    // The head of the table is the one row that is no problem.
    assert_eq!(rows.len(), problems(false).len() + 1);
}

#[test]
fn every_gradient_has_its_row_and_a_bound_near_its_error() {
    let rows = rows(6);
    let named = |row: &&Vec<&str>, name: &str, loss: &str| row[0] == name && row[1] == loss;
    for comparison in comparisons(false) {
        let (name, loss) = (&comparison.name, comparison.loss);
        let own: Vec<_> = rows.iter().filter(|row| named(row, name, loss)).collect();
        assert_eq!(own.len(), 1, "{name}, {loss}");
        assert_bound(own[0], 4, comparison.bound());
    }
}

/// A number of a row that was measured again is what the report says, to a tenth.
fn assert_as_reported(row: &[&str], measured: usize, found: f64) {
    let [reported, _] = numbers(row, measured).unwrap_or_else(|| panic!("{row:?}"));
    let off = (found - reported).abs();
    assert!(off <= 0.1 * reported, "{row:?}: found {found:e}");
}

/// Quick problems of every kind of reference but for slow ones.
#[test]
fn quick_rows_are_as_reported() {
    let (rows, mut references) = (rows(8), BTreeSet::from(SLOW_REFERENCES));
    for problem in problems(false) {
        if is_measured_again(&problem.name) {
            let row = rows.iter().find(|row| row[0] == problem.name).unwrap();
            let found = problem.measure().unwrap();
            let columns = [
                found.absolute,
                found.shape,
                found.estimate,
                found.rays as f64,
            ];
            for (column, found) in [2, 3, 5, 6].into_iter().zip(columns) {
                assert_as_reported(row, column, found);
            }
            references.insert(problem.reference);
        }
    }
    let all = problems(false).into_iter().map(|problem| problem.reference);
    assert_eq!(references, all.collect());
    assert!(REPORT.contains(&sentence()));
}

#[test]
fn a_quick_gradient_is_as_reported() {
    let (rows, mut measured) = (rows(6), 0);
    for comparison in comparisons(false) {
        if comparison.name == GRADIENT {
            let named = |row: &&Vec<&str>| row[0] == GRADIENT && row[1] == comparison.loss;
            let row = rows.iter().find(named).unwrap();
            assert_as_reported(row, 4, comparison.measure().unwrap().0);
            measured += 1;
        }
    }
    assert_eq!(measured, 2);
}
