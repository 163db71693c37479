//! raylet's gradients against adjoints and differences of references that share no code with it.

use raylet_accuracy::gradients::gradient_problems::comparisons;

#[test]
fn gradients_stay_within_their_bounds_slow() {
    let mut failures = Vec::new();
    for comparison in comparisons(true) {
        let clock = std::time::Instant::now();
        let (error, entries) = comparison.measure().unwrap();
        let seconds = clock.elapsed().as_secs_f64();
        let (name, loss) = (&comparison.name, comparison.loss);
        println!("{name}, {loss}: {error:.1e} of {entries}, {seconds:.1} s");
        if comparison.bound().is_none_or(|bound| error > bound) {
            failures.push(format!("{name}, {loss}: {error:e}"));
        }
    }
    assert!(failures.is_empty(), "{failures:?}");
}
