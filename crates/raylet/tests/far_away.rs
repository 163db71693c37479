//! Small screens far apart: the light has spread over much more than either when it arrives.

use std::path::Path;

use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
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
        let coarse = error(z, 1e-3);
        assert!(coarse < 3e-4, "z = {z}: {coarse:e}");
        let fine = error(z, 1e-5);
        assert!(fine < 1e-4, "z = {z}: {fine:e}");
    }
}

/// The relative error on the axis with this target error.
fn error(z: f64, target_error: f64) -> f64 {
    let text = format!(
        "version = 1\nwavelength_um = 0.5\nsource = {{ kind = \"plane\" }}\n\
         [[element]]\nkind = \"stop\"\nthickness_mm = {z:?}\naperture = {{ disc = {{ radius_mm = 0.1 }} }}\n\
         [[element]]\nkind = \"sensor\"\npixels = [5, 5]\npitch_um = 1.0\n"
    );
    let scene = Scene::parse(&text, Path::new("far.toml")).unwrap();
    let system = build::system(&scene, 0).unwrap();
    let settings = Settings {
        target_error,
        ..Settings::default()
    };
    let outcome = simulate(&system, &settings, &|_| {}).unwrap();
    let (seen, exact) = (outcome.field.values[[2, 2]], exact(0.5e-3, 0.1, z));
    (seen - exact).norm() / exact.norm()
}
