//! A tilted lens that sends little of its light to the sensor: the target error is met, and the estimated error is between
//! half the true one and five times it.

use raylet_accuracy::estimates::error_ratios::distance;
use raylet_accuracy::problems::dim::{DIM_LENSES, USUAL};
use raylet_accuracy::problems::strong::Effort;

/// At a target of 1e-3 the error was estimated as 1.07e-3 and was 7.5e-3. The accuracy report has this system and five
/// like it, and random systems with little light on the sensor are among those of its estimates.
#[test]
#[ignore = "takes 40 s of a processor; make accuracy runs it"]
fn errors_of_dim_sensors_are_met_and_estimated_slow() {
    let problem = DIM_LENSES[0].problem();
    let found = problem.measure().unwrap();
    assert!(found.absolute < 1e-3, "{found:?}");
    let ratio = found.estimate / found.absolute;
    assert!((0.5..5.0).contains(&ratio), "{found:?}");
}

/// The reference changes little with a longer period and denser samples.
#[test]
#[ignore = "takes a minute of a processor; make accuracy runs it"]
fn the_reference_has_converged() {
    let lens = DIM_LENSES[0];
    let frame = lens.problem().system.screens[1].frame;
    let finer = Effort {
        period: 500.0,
        density: 3.0,
    };
    let off = distance(&lens.exact(frame, USUAL), &lens.exact(frame, finer));
    assert!(off < 2e-4, "{off:e}");
}
