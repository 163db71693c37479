//! Discs of light behind a stop, on the axis in closed form: small screens far apart, where light has spread over much more than
//! either when it arrives, and wide ones.

use std::path::Path;

use num_complex::Complex64;
use raylet::engine::chain::outcome::Outcome;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::hop_method::HopMethod;
use raylet::engine::plan::hop_plan::Plan;
use raylet::engine::plan::settings::Settings;
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;

/// On the axis behind a disc of radius a, by Rayleigh and Sommerfeld's first integral of a plane wave in closed form:
/// exp(ikz) − z/r exp(ikr), r² = z² + a².
fn exact(wavelength: f64, radius: f64, z: f64) -> Complex64 {
    let (k, r) = (std::f64::consts::TAU / wavelength, z.hypot(radius));
    // The difference of two long paths, without their cancellation.
    let longer = radius * radius / (z + r);
    Complex64::cis(k * z) * (1.0 - z / r * Complex64::cis(k * longer))
}

#[test]
fn a_disc_far_away_is_as_in_closed_form() {
    for z in [20.0, 300.0, 1e3, 1e4] {
        let coarse = error(z, 1e-3, &SMALL);
        assert!(coarse < 3e-4, "z = {z}: {coarse:e}");
        let fine = error(z, 1e-5, &SMALL);
        assert!(fine < 1e-4, "z = {z}: {fine:e}");
    }
}

/// Screens so wide that a long period would have too many plane waves: the period leaves some Fresnel zones beside them, and
/// nodes resolve the light that reaches the sensor.
#[test]
fn a_wide_disc_is_as_in_closed_form() {
    let outcome = run(50.0, 1e-3, &WIDE);
    let HopMethod::WholeField(Plan::Free(_, plan)) = &outcome.hops[0].method else {
        panic!("a free hop");
    };
    let [span, period] = [plan.span[0], plan.period[0]];
    assert!(period < 3.2 * span, "{period} {span}");
    assert!(plan.reach[0] < 0.75 * plan.bands[0].at(0).abs());
    let error = on_the_axis(&outcome, 50.0, &WIDE);
    let expected = outcome.expected_error().unwrap();
    assert!(error < 2e-5 && expected < 2e-5, "{error:e} {expected:e}");
}

/// A stop and a sensor: the radius in mm, pixels along each side and their pitch in µm.
struct Sizes {
    radius: f64,
    pixels: usize,
    pitch_um: f64,
}

const SMALL: Sizes = Sizes {
    radius: 0.1,
    pixels: 5,
    pitch_um: 1.0,
};

const WIDE: Sizes = Sizes {
    radius: 1.0,
    pixels: 251,
    pitch_um: 8.0,
};

/// The relative error on the axis with this target error.
fn error(z: f64, target_error: f64, sizes: &Sizes) -> f64 {
    on_the_axis(&run(z, target_error, sizes), z, sizes)
}

fn on_the_axis(outcome: &Outcome, z: f64, sizes: &Sizes) -> f64 {
    let middle = sizes.pixels / 2;
    let seen = outcome.field.values[[middle; 2]];
    let exact = exact(0.5e-3, sizes.radius, z);
    (seen - exact).norm() / exact.norm()
}

fn run(z: f64, target_error: f64, sizes: &Sizes) -> Outcome {
    let Sizes {
        radius,
        pixels,
        pitch_um,
    } = sizes;
    let text = format!(
        "version = 1\nwavelength_um = 0.5\nsource = {{ kind = \"plane\" }}\n\
         [[element]]\nkind = \"stop\"\nthickness_mm = {z:?}\naperture = {{ disc = {{ radius_mm = {radius:?} }} }}\n\
         [[element]]\nkind = \"sensor\"\npixels = [{pixels}, {pixels}]\npitch_um = {pitch_um:?}\n"
    );
    let scene = Scene::parse(&text, Path::new("far.toml")).unwrap();
    let system = build::system(&scene, 0).unwrap();
    let settings = Settings {
        target_error,
        ..Settings::default()
    };
    simulate(&system, &settings, &|_| {}).unwrap()
}
