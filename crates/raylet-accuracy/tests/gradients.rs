//! raylet's gradients against adjoints and differences of references that share no code with it.

use raylet_accuracy::gradients::gradient_problems::comparisons;

#[test]
fn gradients_stay_within_their_bounds_slow() {
    let mut failures = Vec::new();
    for comparison in comparisons(true) {
        let (error, entries) = comparison.measure().unwrap();
        if comparison.bound().is_none_or(|bound| error > bound) {
            let (name, loss) = (&comparison.name, comparison.loss);
            failures.push(format!("{name}, {loss}: {error:e} of {entries}"));
        }
    }
    assert!(failures.is_empty(), "{failures:?}");
}
