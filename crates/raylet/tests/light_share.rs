//! The share of the light that a sensor receives, where light meets it or the first element at an angle.

use std::path::Path;

use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::file::model::build;
use raylet::file::result::channel::Channel;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::system::System;

/// A Gaussian beam of radius 30 µm through a wide stop, 2 mm to a sensor of 0.48 mm turned by `tilt_deg`.
fn tilted(tilt_deg: f64) -> System {
    let text = format!(
        "version = 1\nwavelength_um = 0.55\nsource = {{ kind = \"plane\", taper = {{ radius_mm = 0.03 }} }}\n\
         [[element]]\nthickness_mm = 2.0\nkind = \"stop\"\naperture = {{ disc = {{ radius_mm = 0.1 }} }}\n\
         [[element]]\nkind = \"sensor\"\npixels = [600, 600]\npitch_um = 0.8\ntilt_deg = [0, {tilt_deg:?}, 0]\n"
    );
    let scene = Scene::parse(&text, Path::new("tilted.toml")).unwrap();
    build::system(&scene, 0).unwrap()
}

/// All of the light of a beam falls on a sensor that is wider than the beam, however it is turned, by every method.
#[test]
fn a_tilted_sensor_receives_all_light() {
    for tilt in [0.0, 30.0, 50.0] {
        let system = tilted(tilt);
        for method in [Method::Auto, Method::Beamlet, Method::LocalBands] {
            let settings = Settings {
                method,
                ..Settings::default()
            };
            let outcome = simulate(&system, &settings, &|_| {}).unwrap();
            let share = Channel::new(&outcome, &settings, 0.0).light_share.unwrap();
            assert!((share - 1.0).abs() < 2e-3, "{tilt}° {method:?}: {share}");
        }
    }
}
