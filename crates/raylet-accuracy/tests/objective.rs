//! Local bands through a photographic objective, against one integral over its stop.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::local_band_run::local_band_settings;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::local_bands::carry::carry;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::optics::doe::Layer;
use raylet::optics::phase::profile::Profile;
use raylet_accuracy::objective::ray_integral::{field, polar_nodes};
use raylet_accuracy::objective::triplet::Triplet;

/// Relative L2 error of the complex field, nothing fitted.
fn absolute_error(ours: &Array2<Complex64>, exact: &Array2<Complex64>) -> f64 {
    let power = |a: &Array2<Complex64>| a.iter().map(|u| u.norm_sqr()).sum::<f64>();
    (power(&(ours - exact)) / power(exact)).sqrt()
}

/// The error behind an element in a stop of 1.5 mm radius, and the megabytes of beamlets that are held.
fn measured(angle_deg: f64, layers: Vec<Layer>) -> (f64, f64) {
    let mut triplet = Triplet::bare(1.5, angle_deg);
    triplet.pixels = 16;
    triplet.element.layers = layers;
    let system = triplet.system().unwrap();
    let settings = local_band_settings(&system, &Settings::default()).unwrap();
    let outcome = carry(&system, &settings).unwrap();
    let nodes = polar_nodes(&triplet.element, 1.5, [60, 160]);
    let exact = field(&system, &nodes).unwrap();
    let held = outcome.hops.iter().map(|hop| hop.held).max().unwrap_or(0);
    (
        absolute_error(&outcome.field.values, &exact),
        held as f64 / 1e6,
    )
}

#[test]
fn a_bare_stop_agrees_with_the_integral_on_the_axis_and_aside() {
    for (angle, allowed) in [(0.0, 5e-4), (20.0, 6e-4)] {
        let (error, held) = measured(angle, Vec::new());
        assert!(error < allowed, "{angle}°: {error:e}");
        assert!(held < 3.0, "{held} MB");
    }
}

#[test]
fn a_vortex_at_the_stop_agrees_with_the_integral() {
    let vortex = Layer::Phase(Profile::Vortex { charge: 1 });
    let (error, _) = measured(14.0, vec![vortex]);
    assert!(error < 8e-4, "{error:e}");
}

/// The error is far below the target; the estimate covers it, and is no more than ten times larger: ends of footprints count in full, though they cancel in
/// smooth light.
#[test]
fn the_error_behind_a_mask_is_estimated() {
    for (angle, charge) in [(0.0, 0), (14.0, 1)] {
        let mut triplet = Triplet::bare(1.5, angle);
        triplet.pixels = 16;
        triplet.element.layers = vec![Layer::Phase(Profile::Vortex { charge })];
        let system = triplet.system().unwrap();
        let settings = Settings {
            method: Method::LocalBands,
            ..Settings::default()
        };
        let outcome = simulate(&system, &settings, &|_| {}).unwrap();
        let nodes = polar_nodes(&triplet.element, 1.5, [60, 160]);
        let exact = field(&system, &nodes).unwrap();
        let error = absolute_error(&outcome.field.values, &exact);
        let expected = outcome.expected_error().unwrap();
        assert!(error < 1e-4, "{angle}°: {error:e}");
        assert!(error < expected, "{angle}°: {error:e} of {expected:e}");
        assert!(
            expected < 5.0 * error,
            "{angle}°: {error:e} of {expected:e}"
        );
    }
}
