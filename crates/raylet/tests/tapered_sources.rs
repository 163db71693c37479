//! Tapered beams and cones of light, against closed forms and integrals over circles, by every method.

use std::path::Path;

use num_complex::Complex64;
use raylet::engine::chain::outcome::Outcome;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::file::model::build;
use raylet::file::result::channel::Channel;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::aperture::Aperture;
use raylet::optics::assembly::system_builder::SystemBuilder;
use raylet::optics::system::System;

const WAVELENGTH: f64 = 0.55e-3;
const K: f64 = std::f64::consts::TAU / WAVELENGTH;
const PIXELS: usize = 48;

/// Errors as measured, rounded up.
const TAPERED_BEAM: f64 = 2e-4;
const LENS: f64 = 6e-4;
const SUPER_GAUSSIAN: f64 = 4e-4;
const CONE: f64 = 6e-4;
const BEHIND: f64 = 2e-6;
const LANDED: f64 = 8e-5;

/// A first element, and a sensor of square pixels at a distance.
struct Case {
    source: &'static str,
    element: String,
    distance: f64,
    pitch_um: f64,
}

impl Case {
    fn run(&self, method: Method) -> Outcome {
        let (source, element) = (self.source, &self.element);
        let (distance, pitch) = (self.distance, self.pitch_um);
        let text = format!(
            "version = 1\nwavelength_um = 0.55\nsource = {{ {source} }}\n\
             [[element]]\nthickness_mm = {distance:?}\n{element}\n\
             [[element]]\nkind = \"sensor\"\npixels = [{PIXELS}, {PIXELS}]\npitch_um = {pitch:?}\n"
        );
        let scene = Scene::parse(&text, Path::new("taper.toml")).unwrap();
        let system = build::system(&scene, 0).unwrap();
        let settings = Settings {
            method,
            ..Settings::default()
        };
        simulate(&system, &settings, &|_| {}).unwrap()
    }

    /// The relative error of the field against an exact one of x and y, without exp(ikz).
    fn error(&self, outcome: &Outcome, exact: impl Fn(f64, f64) -> Complex64) -> f64 {
        let plane = Complex64::cis(K * self.distance);
        let place = |i: usize| (i as f64 - 0.5 * (PIXELS as f64 - 1.0)) * self.pitch_um * 1e-3;
        let (mut off, mut all) = (0.0, 0.0);
        for ((j, i), value) in outcome.field.values.indexed_iter() {
            let exact = plane * exact(place(i), place(j));
            off += (value - exact).norm_sqr();
            all += exact.norm_sqr();
        }
        (off / all).sqrt()
    }
}

const METHODS: [Method; 3] = [Method::Auto, Method::Beamlet, Method::LocalBands];

fn stop(radius: f64) -> String {
    format!("kind = \"stop\"\naperture = {{ disc = {{ radius_mm = {radius:?} }} }}")
}

/// √(q₀/q) exp(ikx²/2q) of a Gaussian of radius w at its waist, seen from a distance.
fn gaussian(x: f64, w: f64, distance: f64) -> Complex64 {
    let rayleigh = 0.5 * K * w * w;
    let q = Complex64::new(distance, -rayleigh);
    let start = (Complex64::new(0.0, -rayleigh) / q).sqrt();
    start * (Complex64::new(0.0, 0.5 * K * x * x) / q).exp()
}

/// A tapered plane wave is a Gaussian beam in its waist, here aside of the axis and turned by a right angle.
#[test]
fn a_tapered_beam_spreads_as_a_gaussian_beam() {
    let case = Case {
        source: "kind = \"plane\", taper = { radius_mm = [0.07, 0.1], centre_mm = [0.02, -0.01], rotation_deg = 90 }",
        element: stop(0.6),
        distance: 40.0,
        pitch_um: 12.0,
    };
    for method in METHODS {
        let error = case.error(&case.run(method), |x, y| {
            gaussian(x - 0.02, 0.1, 40.0) * gaussian(y + 0.01, 0.07, 40.0)
        });
        assert!(error < TAPERED_BEAM, "{method:?}: {error:e}");
    }
}

/// A beam of 0.2 mm in an ideal lens of 1.6 mm: the edge of the lens is dark. The beam converges to a
/// waist near the focus, as √(q₀/q) of the ABCD law has it.
#[test]
fn a_wide_lens_is_open_to_a_narrow_beam() {
    let (w, f, distance) = (0.2, 20.0, 12.0);
    let case = Case {
        source: "kind = \"plane\", taper = { radius_mm = 0.2 }",
        element: String::from(
            "kind = \"paraxial_lens\"\nfocal_length_mm = 20.0\naperture = { disc = { radius_mm = 0.8 } }",
        ),
        distance,
        pitch_um: 8.0,
    };
    // 1/q = 1/q₀ − 1/f behind the lens.
    let behind = (Complex64::new(0.0, 2.0 / (K * w * w)) - 1.0 / f).inv();
    let along = |x: f64| {
        let q = behind + distance;
        (behind / q).sqrt() * (Complex64::new(0.0, 0.5 * K * x * x) / q).exp()
    };
    for method in [Method::Auto, Method::LocalBands] {
        let outcome = case.run(method);
        let error = case.error(&outcome, |x, y| along(x) * along(y));
        assert!(error < LENS, "{method:?}: {error:e}");
    }
}

/// J₀ by the mean of its plane waves, exact to rounding for so many of them.
fn j0(x: f64) -> f64 {
    let count = 16 + x.abs().ceil() as u32;
    let angle = |n: u32| std::f64::consts::PI * (f64::from(n) + 0.5) / f64::from(count);
    (0..count).map(|n| (x * angle(n).sin()).cos()).sum::<f64>() / f64::from(count)
}

/// The field at a distance of an amplitude over a circle, without exp(ikz): its plane waves up to a sine, each summed by the
/// midpoint rule.
fn carried(
    amplitude: impl Fn(f64) -> f64,
    radius: f64,
    sine: f64,
    distance: f64,
) -> impl Fn(f64) -> Complex64 {
    const RINGS: u32 = 600;
    let middle = |n: u32, most: f64| most * (f64::from(n) + 0.5) / f64::from(RINGS);
    let wave = move |n: u32| {
        let p = middle(n, sine);
        let ring = |m: u32| {
            let s = middle(m, radius);
            amplitude(s) * j0(K * p * s) * s
        };
        let sum = (0..RINGS).map(ring).sum::<f64>() * radius / f64::from(RINGS);
        let turn = K * distance * ((1.0 - p * p).sqrt() - 1.0);
        let weight = sum * K * K * p * sine / f64::from(RINGS);
        (p, Complex64::from_polar(weight, turn))
    };
    let waves: Vec<(f64, Complex64)> = (0..RINGS).map(wave).collect();
    move |r| waves.iter().map(|(p, wave)| wave * j0(K * p * r)).sum()
}

/// A flat-topped beam of the third order.
#[test]
fn a_super_gaussian_beam_is_the_integral_over_its_circles() {
    let case = Case {
        source: "kind = \"plane\", taper = { radius_mm = 0.12, order = 3 }",
        element: stop(0.3),
        distance: 30.0,
        pitch_um: 12.0,
    };
    let exact = carried(|s| (-(s / 0.12).powi(6)).exp(), 0.3, 0.03, 30.0);
    for method in METHODS {
        let outcome = case.run(method);
        let error = case.error(&outcome, |x, y| exact(x.hypot(y)));
        assert!(error < SUPER_GAUSSIAN, "{method:?}: {error:e}");
    }
}

/// A diode in the front focus of an ideal lens: behind the lens the wave is flat, its amplitude the taper's over the sine
/// r/R, and f/R of the spherical wave.
#[test]
fn a_lens_collimates_a_tapered_cone() {
    let (f, sine) = (2.0f64, 5f64.to_radians().sin());
    let case = Case {
        source: "kind = \"point\", position_mm = [0, 0, -2], taper = { half_angle_deg = 5 }",
        element: "kind = \"doe\"\naperture = { disc = { radius_mm = 0.5 } }\n\
                  [[element.layer]]\nkind = \"lens\"\nfocal_length_mm = 2.0\n"
            .to_owned(),
        distance: 20.0,
        pitch_um: 15.0,
    };
    let amplitude = |s: f64| {
        let far = f.hypot(s);
        f / far * (-(s / far / sine).powi(2)).exp()
    };
    let exact = carried(amplitude, 0.5, 0.01, 20.0);
    for method in METHODS {
        let outcome = case.run(method);
        let error = case.error(&outcome, |x, y| exact(x.hypot(y)));
        assert!(error < CONE, "{method:?}: {error:e}");
    }
}

/// A Gaussian of radius w has the power πw²/2, of which a disc of radius a passes 1 − exp(−2a²/w²). Where a is wide, all of
/// it arrives.
#[test]
fn the_power_of_a_tapered_beam_is_counted() {
    let w = 0.2f64;
    let whole = 0.5 * std::f64::consts::PI * w * w;
    for (a, arrives) in [(0.15, false), (0.5, true)] {
        let case = Case {
            source: "kind = \"plane\", taper = { radius_mm = 0.2 }",
            element: stop(a),
            distance: 20.0,
            pitch_um: 30.0,
        };
        let passed = whole * (1.0 - (-2.0 * (a / w).powi(2)).exp());
        for method in METHODS {
            let outcome = case.run(method);
            let [_, behind, landed] = outcome.hops[0].power;
            let ratios = [behind, landed].map(|power| power.unwrap() / passed);
            let [behind, landed] = ratios.map(|ratio| (ratio - 1.0).abs());
            assert!(behind < BEHIND, "{method:?} {a}: {behind:e}");
            assert!(!arrives || landed < LANDED, "{method:?}: {landed:e}");
        }
    }
}

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
        for method in METHODS {
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

/// Numerical apertures are sines times the index around; the builder's cone is that of a scene.
#[test]
fn a_numerical_aperture_is_the_sine_of_a_half_angle_in_the_medium() {
    let source = |ambient: &str, taper: &str| {
        let text = format!(
            "version = 1\nwavelength_um = 0.55\nambient = {ambient}\n\
             source = {{ kind = \"point\", position_mm = [0, 0, -2], taper = {{ {taper} }} }}\n\
             [[element]]\nthickness_mm = 1.0\n{}\n\
             [[element]]\nkind = \"sensor\"\npixels = [4, 4]\npitch_um = 1.0\n",
            stop(0.5)
        );
        let scene = Scene::parse(&text, Path::new("taper.toml"))?;
        Ok::<_, raylet::file::decode::fault::Fault>(build::system(&scene, 0)?.source)
    };
    let water = "{ index = 1.25 }";
    let given = source(water, "numerical_aperture = [0.5, 0.25]").unwrap();
    let [x, y] = [0.4f64, 0.2].map(|sine| sine.asin().to_degrees());
    let angles = source(water, &format!("half_angle_deg = [{x:?}, {y:?}]")).unwrap();
    let built = SystemBuilder::new(WAVELENGTH)
        .tapered_point([0.0, 0.0, -2.0], [0.4f64.asin(), 0.2f64.asin()], 1)
        .stop(Aperture::disc(0.5))
        .gap(1.0)
        .sensor([4, 4], [1e-3, 1e-3])
        .build()
        .unwrap();
    for source in [angles, built.source] {
        let at = raylet::math::vec3::Vec3::new(0.3, -0.4, 0.1);
        assert!((given.field(at, K) - source.field(at, K)).norm() < 1e-9);
    }
    for (taper, expected) in [
        ("numerical_aperture = 1.3", "less than 1.25, the index"),
        ("half_angle_deg = 90", "half angles below 90"),
        ("", "half_angle_deg or numerical_aperture"),
        ("half_angle_deg = 9, order = 0", "from 1 to 50"),
        ("half_angle_deg = -9", "above zero"),
    ] {
        let fault = source(water, taper).unwrap_err().to_string();
        let placed = fault.contains("source.taper") && fault.contains("taper.toml:4");
        assert!(placed && fault.contains(expected), "{fault}");
    }
}
