//! The reduced accuracy suite: every problem within its bound.

use raylet_accuracy::suite::problems;

#[test]
fn reduced_suite_stays_within_its_bounds() {
    for problem in problems(true) {
        let measured = problem.measure().unwrap();
        assert!(
            measured.absolute <= problem.limit,
            "{}: {measured:?}, allowed {:e}",
            problem.name,
            problem.limit
        );
        assert!(measured.ncc > 0.9999, "{}: {measured:?}", problem.name);
    }
}
