//! Gaussian beams through free space and an ideal lens, against the closed form of the ABCD law, by every method.

use std::path::Path;

use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;

const WAVELENGTH: f64 = 0.55e-3;

/// A beam whose waist stands aside of the axis, its first element, and a sensor of 64² pixels at a distance.
struct Case {
    /// Radii of the waist along x and y, and where it stands, in mm.
    radii: [f64; 2],
    waist: [f64; 3],
    /// Radius of the element's aperture, and its focal length if it is a lens, in mm.
    aperture: f64,
    focal_length: Option<f64>,
    distance: f64,
    pitch_um: f64,
}

impl Case {
    fn text(&self) -> String {
        let ([wx, wy], [x, y, z]) = (self.radii.map(|w| w * 1e3), self.waist);
        let lens = self.focal_length.map_or(String::new(), |f| {
            format!("[[element.layer]]\nkind = \"lens\"\nfocal_length_mm = {f:?}\n")
        });
        let kind = if lens.is_empty() { "stop" } else { "doe" };
        let (distance, aperture, pitch) = (self.distance, self.aperture, self.pitch_um);
        format!(
            "version = 1\nwavelength_um = 0.55\n\
             source = {{ kind = \"gaussian\", waist_radius_um = [{wx:?}, {wy:?}], waist_mm = [{x:?}, {y:?}, {z:?}] }}\n\
             [[element]]\nkind = \"{kind}\"\nthickness_mm = {distance:?}\n\
             aperture = {{ disc = {{ radius_mm = {aperture:?} }} }}\n{lens}\
             [[element]]\nkind = \"sensor\"\npixels = [64, 64]\npitch_um = {pitch:?}\n"
        )
    }

    /// One axis of the field, without exp(ikz): the beam √(q₀/q) exp(ik(x−c)²/2q) on the lens, times exp(−ikx²/2f), carried on by
    /// Fresnel's integral, which is one over a Gaussian.
    fn along(&self, a: usize, x: f64) -> Complex64 {
        let k = std::f64::consts::TAU / WAVELENGTH;
        let (c, w, d) = (self.waist[a], self.radii[a], self.distance);
        let rayleigh = 0.5 * k * w * w;
        let q = Complex64::new(-self.waist[2], -rayleigh);
        let start = (Complex64::new(0.0, -rayleigh) / q).sqrt();
        let power = self.focal_length.map_or(0.0, |f| 1.0 / f);
        let square = q.inv() - power + 1.0 / d;
        let line = c / q + x / d;
        let phase = x * x / d + c * c / q - line * line / square;
        start * (square * d).inv().sqrt() * (Complex64::new(0.0, 0.5 * k) * phase).exp()
    }

    /// The relative error of the field by a method.
    fn error(&self, method: Method) -> f64 {
        let scene = Scene::parse(&self.text(), Path::new("beam.toml")).unwrap();
        let system = build::system(&scene, 0).unwrap();
        let settings = Settings {
            method,
            ..Settings::default()
        };
        let field = simulate(&system, &settings, &|_| {}).unwrap().field;
        let k = std::f64::consts::TAU / WAVELENGTH;
        let plane = Complex64::cis(k * (self.distance - self.waist[2]));
        let place = |i: usize| (i as f64 - 31.5) * self.pitch_um * 1e-3;
        let (mut off, mut all) = (0.0, 0.0);
        for ((j, i), value) in field.values.indexed_iter() {
            let exact = plane * self.along(0, place(i)) * self.along(1, place(j));
            off += (value - exact).norm_sqr();
            all += exact.norm_sqr();
        }
        (off / all).sqrt()
    }
}

const METHODS: [Method; 3] = [Method::Auto, Method::Beamlet, Method::LocalBands];

#[test]
fn an_elliptic_beam_spreads_from_its_waist() {
    let case = Case {
        radii: [0.1, 0.07],
        waist: [0.02, -0.01, -20.0],
        aperture: 0.6,
        focal_length: None,
        distance: 30.0,
        pitch_um: 10.0,
    };
    for method in METHODS {
        let error = case.error(method);
        assert!(error < 1e-3, "{method:?}: {error:e}");
    }
}

#[test]
fn a_lens_makes_a_waist_of_a_beam() {
    let case = Case {
        radii: [0.3, 0.3],
        waist: [0.02, -0.01, -100.0],
        aperture: 1.5,
        focal_length: Some(60.0),
        distance: 50.0,
        pitch_um: 3.0,
    };
    for method in METHODS {
        let error = case.error(method);
        assert!(error < 1e-3, "{method:?}: {error:e}");
    }
}
