//! Tests: surfaces and phases of written files, against the formulas that their types have in the manuals of the programs.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use crate::file::model::build::system;
use crate::file::prescription::export::lens_export::lens_file;
use crate::file::scene::scene_file::Scene;
use crate::optics::shape::Shape;
use crate::optics::system::System;

/// Points of a surface in mm.
const POINTS: [[f64; 2]; 4] = [[0.0, 0.0], [0.7, -0.4], [-1.1, 0.9], [0.2, 1.3]];

/// A scene of a stop, this element, and a sensor.
fn scene(element: &str) -> Scene {
    let distance = if element.contains("mirror") { -9 } else { 9 };
    let text = format!(
        "version = 1\nwavelength_um = 0.6\nsource = {{ kind = \"plane\" }}\n[[element]]\nkind = \"stop\"\nthickness_mm = 2\n\
         aperture = {{ disc = {{ radius_mm = 1.5 }} }}\n[[element]]\n{element}\nthickness_mm = {distance}\n[[element]]\nkind = \"sensor\"\n\
         pixels = [8, 8]\npitch_um = 1\n"
    );
    Scene::parse(&text, Path::new("a.toml")).unwrap_or_else(|fault| panic!("{fault}"))
}

fn text(scene: &Scene, name: &str) -> String {
    let written =
        lens_file(scene, Path::new(name), false).unwrap_or_else(|fault| panic!("{fault}"));
    String::from_utf8(written.bytes).unwrap()
}

/// The numbers of the second surface of a Zemax file: its words with their values, PARM and XDAT by their numbers.
fn records(text: &str) -> BTreeMap<String, f64> {
    let second = text.split("SURF ").nth(3).unwrap();
    let mut records = BTreeMap::new();
    for line in second.lines().skip(1) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let (key, value) = match words[..] {
            [word @ ("PARM" | "XDAT"), number, value, ..] => (format!("{word} {number}"), value),
            ["TYPE", word] => (word.to_owned(), "1"),
            [word, value, ..] => (word.to_owned(), value),
            _ => continue,
        };
        records.insert(key, value.parse().unwrap_or(0.0));
    }
    records
}

/// The height of a conic.
fn conic(records: &BTreeMap<String, f64>, square: f64) -> f64 {
    let c = records["CURV"];
    let k = records.get("CONI").copied().unwrap_or(0.0);
    c * square / (1.0 + (1.0 - (1.0 + k) * c * c * square).sqrt())
}

fn made(scene: &Scene) -> System {
    system(scene, 0).unwrap()
}

fn shape(scene: &Scene) -> Shape {
    made(scene).trains[0][0].shape.clone()
}

/// The Zernike Standard polynomials of the manual, terms 1 to 11, by radius and the angle from x.
fn zernike(p: f64, a: f64) -> [f64; 11] {
    let root = f64::sqrt;
    [
        1.0,
        root(4.0) * p * a.cos(),
        root(4.0) * p * a.sin(),
        root(3.0) * (2.0 * p.powi(2) - 1.0),
        root(6.0) * p.powi(2) * (2.0 * a).sin(),
        root(6.0) * p.powi(2) * (2.0 * a).cos(),
        root(8.0) * (3.0 * p.powi(3) - 2.0 * p) * a.sin(),
        root(8.0) * (3.0 * p.powi(3) - 2.0 * p) * a.cos(),
        root(8.0) * p.powi(3) * (3.0 * a).sin(),
        root(8.0) * p.powi(3) * (3.0 * a).cos(),
        root(5.0) * (6.0 * p.powi(4) - 6.0 * p.powi(2) + 1.0),
    ]
}

#[test]
fn zernike_surfaces_have_the_heights_of_the_manual() {
    let scene = scene(
        "kind = \"mirror\"\nsemi_aperture_mm = 1.5\nradius_mm = -40\nconic = -0.5\naspheric = [2e-4, -3e-6]\nshape = { kind = \
         \"zernike\", norm_radius_mm = 2, coefficients_um = [1, -2, 3, 4, -5, 6, 7, -8, 9, 10, -11] }",
    );
    let found = records(&text(&scene, "a.zmx"));
    assert!(found.contains_key("SZERNSAG") && found["XDAT 1"] == 11.0);
    for [x, y] in POINTS {
        let square = x * x + y * y;
        let even = (1..=8).map(|i| {
            let a = found.get(&format!("PARM {i}")).copied().unwrap_or(0.0);
            a * square.powi(i)
        });
        let terms = zernike(square.sqrt() / found["XDAT 2"], y.atan2(x));
        let sum = (3..)
            .zip(terms)
            .map(|(i, z)| found[&format!("XDAT {i}")] * z);
        let height = conic(&found, square) + even.sum::<f64>() + sum.sum::<f64>();
        let ours = shape(&scene).sag(x, y).unwrap();
        assert!((height - ours).abs() < 1e-15, "{height} {ours}");
    }
}

#[test]
fn polynomials_and_aspheres_have_the_heights_of_the_manual() {
    let scene = scene(
        "kind = \"surface\"\nglass = \"N-BK7\"\nsemi_aperture_mm = 1.5\nradius_mm = 30\naspheric = [2e-4]\nshape = { kind = \
         \"xy\", norm_radius_mm = 2, terms = [{ x = 1, height_um = 2 }, { y = 3, height_um = 5 }, { x = 2, y = 1, height_um = \
         -7 }] }",
    );
    let found = records(&text(&scene, "a.zmx"));
    assert!(found.contains_key("XPOLYNOM"));
    // x, y, x², xy, y², x³, x²y, xy², y³, x⁴, …
    let powers = (1..=4).flat_map(|order: i32| (0..=order).map(move |j| [order - j, j]));
    let powers: Vec<[i32; 2]> = powers.collect();
    for [x, y] in POINTS {
        let terms = (3..).zip(&powers).map(|(i, [a, b])| {
            let coefficient = found.get(&format!("XDAT {i}")).copied().unwrap_or(0.0);
            coefficient * (x / found["XDAT 2"]).powi(*a) * (y / found["XDAT 2"]).powi(*b)
        });
        let height = conic(&found, x * x + y * y) + terms.sum::<f64>();
        let ours = shape(&scene).sag(x, y).unwrap();
        assert!((height - ours).abs() < 1e-15, "{height} {ours}");
    }
}

/// The phase of BINARY_2 is the order times Σ Aᵢ (r/ρ)^{2i}; that of DIF DOE is 2π/λ₀ Σ Cⱼ r^{2j}.
#[test]
fn phases_are_those_of_the_manuals() {
    let scene = scene(
        "kind = \"doe\"\naperture = { disc = { radius_mm = 1.5 } }\nradius_mm = 50\naspheric = [1e-5]\nglass = \"N-BK7\"\nlayer = \
         [{ kind = \"radial\", norm_radius_mm = 2, coefficients = [-300, 4, 0.5] }]",
    );
    let phase = |r: f64| {
        let u = (r / 2.0).powi(2);
        -300.0 * u + 4.0 * u * u + 0.5 * u.powi(3)
    };
    let found = records(&text(&scene, "a.zmx"));
    assert!(found.contains_key("BINARY_2") && found["PARM 0"] == 1.0);
    assert!((found["PARM 2"] - 1e-5).abs() < 1e-20);
    let seq = text(&scene, "a.seq");
    let value = |word: &str| {
        let line = seq.lines().find(|line| line.trim().starts_with(word));
        let number = line.unwrap().split_whitespace().last().unwrap();
        number.parse::<f64>().unwrap()
    };
    for r in [0.3, 0.8, 1.4] {
        let terms =
            (1..=3).map(|i| found[&format!("XDAT {}", i + 2)] * (r / found["XDAT 2"]).powi(2 * i));
        let sum: f64 = terms.sum();
        assert!((sum - phase(r)).abs() < 1e-12);
        let terms = (1..=3).map(|j| value(&format!("HCO C{j}")) * f64::powi(r, 2 * j));
        let sum = TAU / (value("HWL") * 1e-6) * terms.sum::<f64>();
        assert!((sum - phase(r)).abs() < 1e-11);
    }
}
