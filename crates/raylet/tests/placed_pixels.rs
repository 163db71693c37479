//! Pixels that are off centre, or turned, on their element.

use std::f64::consts::TAU;
use std::path::Path;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::linearised_system::LinearisedSystem;
use raylet::engine::chain::reference::{ReferenceOptions, reference};
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::screen::ScreenKind;
use raylet::optics::system::System;
use raylet::wave::grid::metrics::field_error;
use raylet_testkit::noise::noise;

/// Direction cosines of the light.
const LIGHT: [f64; 2] = [0.017, -0.009];

/// Collimated light at an angle, an element, and a sensor.
fn scene(element: &str) -> Result<Scene, String> {
    let [ax, ay] = LIGHT.map(|p| p.asin().to_degrees());
    let text = format!(
        "version = 1\nwavelength_um = 0.5\nsource = {{ kind = \"plane\", angle_deg = [{ax}, {ay}] }}\n\
         [[element]]\nkind = \"doe\"\nthickness_mm = 0.5\n{element}\n\
         [[element]]\nkind = \"sensor\"\npixels = [16, 12]\npitch_um = 4.0\n"
    );
    Scene::parse(&text, Path::new("placed.toml")).map_err(|fault| fault.to_string())
}

/// Its system with these pixels.
fn system(element: &str, values: &Array2<Complex64>) -> System {
    let mut system = build::system(&scene(element).unwrap(), 0).unwrap();
    let ScreenKind::Doe(doe) = &mut system.screens[0].kind else {
        panic!("no element")
    };
    doe.free_pixels_mut().unwrap().values = values.clone();
    system
}

fn apart(a: &Array2<Complex64>, b: &Array2<Complex64>) -> f64 {
    field_error(a.view(), b.view()).unwrap()
}

fn pixels(columns: usize, rows: usize, axes: &str) -> String {
    format!("{{ kind = \"pixels\", pitch_um = [6, 5], size = [{columns}, {rows}]{axes} }}")
}

/// The field on the sensor, and the gradient of its power by the pixels.
fn passed(system: &System, method: Method) -> (Array2<Complex64>, Array2<Complex64>) {
    let settings = Settings {
        method,
        ..Settings::default()
    };
    let linearised = LinearisedSystem::new(system, &[], &settings).unwrap();
    let passed = linearised.forward(system).unwrap();
    let field = passed.field.values.clone();
    let gradient = linearised.adjoint(system, &[], &passed, &field).unwrap();
    let pixels = gradient.pixels.into_iter().flatten().next();
    (field, pixels.unwrap())
}

/// Pixels beside a lens, and as a term of a sum, that are off centre and turned on their element, are those of an element that is
/// off centre and turned, on which the lens is placed the other way: its light, and the gradient by the pixels. The gradient
/// passes the dot-product test: the field is linear in the pixels.
#[test]
fn placed_pixels_are_those_of_a_placed_element() {
    let (angle, [x, y]) = (30f64.to_radians(), [0.012, -0.008]);
    let back = [
        -x * angle.cos() - y * angle.sin(),
        x * angle.sin() - y * angle.cos(),
    ];
    let lens = |[x, y]: [f64; 2]| {
        format!("{{ kind = \"lens\", focal_length_mm = 1, centre_mm = [{x}, {y}] }}")
    };
    let placed = format!(
        "aperture = {{ rectangle = {{ width_mm = 0.05, height_mm = 0.036, rotation_deg = 40, centre_mm = [{x}, {y}] }} }}\n\
         layer = [{}, {}]",
        pixels(
            10,
            8,
            &format!(", centre_mm = [{x}, {y}], rotation_deg = 30")
        ),
        lens([0.0; 2])
    );
    let moved = format!(
        "decenter_mm = [{x}, {y}]\ntilt_deg = [0, 0, 30]\n\
         aperture = {{ rectangle = {{ width_mm = 0.05, height_mm = 0.036, rotation_deg = 10 }} }}\nlayer = [{}, {}]",
        pixels(10, 8, ""),
        lens(back)
    );
    let values = noise((8, 10), 3);
    let [placed, moved] = [placed, moved].map(|element| system(&element, &values));
    for method in [Method::Auto, Method::LocalBands] {
        let (field, by_pixels) = passed(&placed, method);
        let (expected, by_same) = passed(&moved, method);
        // The light has no phase at the first vertex, which stands elsewhere.
        let ahead = TAU / 0.5e-3 * (LIGHT[0] * x + LIGHT[1] * y);
        let expected = expected * Complex64::cis(ahead);
        let error = apart(&field, &expected);
        let off = apart(&by_pixels, &by_same);
        assert!(
            error < 1e-13 && off < 1e-13,
            "{method:?}: {error:e} {off:e}"
        );
        let power: f64 = field.iter().map(|u| u.norm_sqr()).sum();
        let dot: Complex64 = values
            .iter()
            .zip(&by_pixels)
            .map(|(v, bar)| v * bar.conj())
            .sum();
        assert!(
            (dot - power).norm() < 1e-9 * power,
            "{method:?}: {dot} {power}"
        );
    }
    // Direct sums know the element by its transmission at points.
    let exact = reference(
        &placed,
        &Settings::default(),
        ReferenceOptions::default(),
        &|_| {},
    )
    .unwrap();
    let error = apart(&passed(&placed, Method::Auto).0, &exact.field.values);
    assert!(error < 4e-4, "{error:e}");
}

/// Pixels moved by whole pixels are dark pixels beside them.
#[test]
fn pixels_off_centre_are_a_larger_grid_with_dark_pixels() {
    let values = noise((8, 9), 4);
    let aperture = "aperture = { disc = { radius_mm = 0.03 } }\n";
    let placed = format!(
        "{aperture}layer = [{}]",
        pixels(9, 8, ", centre_mm = [0.018, -0.01]")
    );
    let padded = format!("{aperture}layer = [{}]", pixels(15, 12, ""));
    // Three columns to the right and two rows down.
    let larger = Array2::from_shape_fn((12, 15), |(row, column)| {
        let own = column
            .checked_sub(6)
            .and_then(|column| values.get([row, column]));
        own.copied().unwrap_or_default()
    });
    let field = |system: &System| {
        simulate(system, &Settings::default(), &|_| {})
            .unwrap()
            .field
            .values
    };
    let error = apart(
        &field(&system(&placed, &values)),
        &field(&system(&padded, &larger)),
    );
    assert!(error < 1e-11, "{error:e}");
}

#[test]
fn what_cannot_be_placed_is_refused() {
    let turned = pixels(9, 8, ", rotation_deg = 10");
    let aside = pixels(9, 8, ", centre_mm = [0.01, 0]");
    let fault = |element: &str| {
        let built = scene(element)
            .and_then(|scene| build::system(&scene, 0).map_err(|fault| fault.to_string()));
        built.err().unwrap_or_default()
    };
    let rim = "aperture = { disc = { radius_mm = 0.03 } }\n";
    let curved = |layer: &str| fault(&format!("{rim}radius_mm = 50\nlayer = [{layer}]"));
    assert!(
        curved(&aside).contains("off centre, or turned, on a curved surface"),
        "{}",
        curved(&aside)
    );
    assert_eq!(curved(&turned), "");
    let both = fault(&format!("{rim}layer = [{turned}, {aside}]"));
    assert!(both.contains("fill or place in one element"), "{both}");
}
