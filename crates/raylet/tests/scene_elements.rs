//! What the layers and sensors of a scene do to light, by formulas of their own: a scene in water, whose layers are
//! evaluated for their phase gradient ∇φ and phase.

use std::f64::consts::TAU;
use std::path::Path;

use ndarray::array;
use ndarray_npy::write_npy;
use raylet::file::model::build::system;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::screen::ScreenKind;
use raylet::optics::system::System;

/// Index of the medium around the element.
const WATER: f64 = 1.33;

/// Wavelengths in mm.
const FIRST: f64 = 0.5e-3;
const SECOND: f64 = 0.6e-3;

/// The system at the wavelength `channel` with one element of this layer; heights of 0 to 0.3 µm lie beside it.
fn with_layer(layer: &str, channel: usize) -> System {
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        r#"
version = 1
ambient = {{ index = {WATER} }}
wavelength_um = [0.5, 0.6]
[source]
kind = "plane"
[[element]]
kind = "doe"
thickness_mm = 5
aperture = {{ disc = {{ radius_mm = 1 }} }}
[[element.layer]]
{layer}
[[element]]
kind = "sensor"
pixels = [4, 6]
pitch_um = [2.0, 3.0]
"#
    );
    let heights = array![[0.0, 0.1], [0.2, 0.3]];
    write_npy(folder.path().join("heights.npy"), &heights).unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    let scene = Scene::read(Path::new(&path)).unwrap();
    system(&scene, channel).unwrap()
}

fn gradient(system: &System, x: f64, y: f64) -> [f64; 2] {
    match &system.screens[0].kind {
        ScreenKind::Doe(doe) => doe.phase_gradient(x, y).unwrap(),
        _ => panic!("the first screen is the element"),
    }
}

fn assert_near(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() <= 1e-9 * expected.abs().max(1.0),
        "{found} against {expected}"
    );
}

/// An axicon turns light by its angle: its optical direction cosine is n·sin.
#[test]
fn axicons_turn_by_their_angle_in_their_medium() {
    for (channel, wavelength) in [(0, FIRST), (1, SECOND)] {
        let system = with_layer("kind = \"axicon\"\nangle_deg = 3", channel);
        let [gx, gy] = gradient(&system, 0.3, 0.4);
        let cosine = -WATER * 3f64.to_radians().sin();
        assert_near(gx * wavelength / TAU, 0.6 * cosine);
        assert_near(gy * wavelength / TAU, 0.8 * cosine);
    }
}

/// A lens sends light from (x, y) to its focus in its medium, at the wavelength that it is made for: the sine of that
/// ray times n. At another wavelength the gradient is the same, so that the cosine grows with the wavelength.
#[test]
fn lenses_focus_at_the_wavelength_they_are_made_for() {
    let sine = 0.5 / f64::hypot(0.5, 4.0);
    for (made_for, text) in [
        (FIRST, ""),
        (SECOND, "wavelength_um = 0.6"),
        (0.7e-3, "wavelength_um = 0.7"),
    ] {
        for channel in [0, 1] {
            let layer = format!("kind = \"lens\"\nfocal_length_mm = 4\n{text}");
            let [gx, gy] = gradient(&with_layer(&layer, channel), 0.3, -0.4);
            assert_near(gx * made_for / TAU, -0.6 * WATER * sine);
            assert_near(gy * made_for / TAU, 0.8 * WATER * sine);
        }
    }
}

/// A grating turned by 30° from x towards y sends its second order to cosines 2λ/d·(cos 30°, sin 30°).
#[test]
fn turned_gratings_send_light_towards_plus_y() {
    let layer = "kind = \"grating\"\nperiod_um = 20\ndirection_deg = 30\norder = 2";
    let [gx, gy] = gradient(&with_layer(layer, 0), 0.1, 0.2);
    let cosine = 2.0 * FIRST / 20e-3;
    assert_near(gx * FIRST / TAU, cosine * 30f64.to_radians().cos());
    assert_near(gy * FIRST / TAU, 0.5 * cosine);
}

/// A height h of a glass delays light against its medium by (n − n₀)h.
#[test]
fn heights_delay_against_their_medium() {
    let layer =
        "kind = \"height\"\npitch_um = 10\nheight_um = \"heights.npy\"\nglass = { index = 1.5 }";
    for (channel, wavelength) in [(0, FIRST), (1, SECOND)] {
        let system = with_layer(layer, channel);
        let ScreenKind::Doe(doe) = &system.screens[0].kind else {
            panic!("the first screen is the element")
        };
        for (at, height) in [
            ([-5e-3, -5e-3], 0.0),
            ([5e-3, -5e-3], 0.1),
            ([-5e-3, 5e-3], 0.2),
        ] {
            let phase = TAU / wavelength * (1.5 - WATER) * height * 1e-3;
            assert_near(doe.transmission(at[0], at[1]).arg(), phase);
        }
    }
}

/// The first number of a sensor's pixels and pitch is along x.
#[test]
fn sensors_have_a_pitch_along_each_axis() {
    let system = with_layer("kind = \"vortex\"\ncharge = 1", 0);
    let ScreenKind::Sensor(sensor) = &system.screens[1].kind else {
        panic!("the second screen is the sensor")
    };
    assert_eq!(sensor.pixels, [4, 6]);
    assert_near(sensor.pitch[0], 2e-3);
    assert_near(sensor.pitch[1], 3e-3);
    let [x0, x1, y0, y1] = system.screens[1].bounds().unwrap();
    assert_near(x1 - x0, 8e-3);
    assert_near(y1 - y0, 18e-3);
}
