//! Light that is given on a plane: modes of fibres, and samples of any field, against sums of their plane waves.

use std::collections::BTreeMap;
use std::path::Path;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::outcome::Outcome;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::file::arrays::array::BorrowedArray;
use raylet::file::decode::fault::Fault;
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::assembly::system_builder::SystemBuilder;
use raylet::optics::beams::fibre_mode::FibreMode;
use raylet_testkit::noise::noise;

/// Errors as measured, rounded up.
const FIBRE: f64 = 7e-4;
const MODE_POWER: f64 = 1e-4;
const SAMPLES: f64 = 4e-4;

const METHODS: [Method; 3] = [Method::Auto, Method::Beamlet, Method::LocalBands];
const PIXELS: usize = 24;

fn scene(source: &str, distance: f64, wavelength_um: f64, pitch_um: f64) -> String {
    format!(
        "version = 1\nwavelength_um = {wavelength_um:?}\nsource = {{ {source}, distance_mm = {distance:?} }}\n\
         [[element]]\nkind = \"sensor\"\npixels = [{PIXELS}, {PIXELS}]\npitch_um = {pitch_um:?}\n"
    )
}

fn run(text: &str, samples: Option<&Array2<Complex64>>, method: Method) -> Result<Outcome, Fault> {
    let scene = Scene::parse(text, Path::new("given.toml"))?;
    let view = samples.map(|samples| {
        (
            String::from("source.samples"),
            BorrowedArray::Complex(samples.view()),
        )
    });
    let lent: BTreeMap<String, BorrowedArray> = view.into_iter().collect();
    let arrays = scene.load_with(&lent)?;
    let system = build::system_with(&scene, &arrays, 0)?;
    let settings = Settings {
        method,
        ..Settings::default()
    };
    Ok(simulate(&system, &settings, &|_| {}).unwrap())
}

/// The relative error of a field.
fn error(outcome: &Outcome, exact: &Array2<Complex64>) -> f64 {
    let size = |values: &Array2<Complex64>| values.iter().map(|u| u.norm_sqr()).sum::<f64>();
    (size(&(&outcome.field.values - exact)) / size(exact)).sqrt()
}

/// A field of x and y at the pixels of a sensor of this pitch in mm.
fn on_sensor(pitch: f64, field: impl Fn(f64, f64) -> Complex64) -> Array2<Complex64> {
    let place = |i: usize| (i as f64 - 0.5 * (PIXELS as f64 - 1.0)) * pitch;
    Array2::from_shape_fn((PIXELS, PIXELS), |(j, i)| field(place(i), place(j)))
}

/// J_l by the mean of its plane waves, exact to rounding for so many of them.
fn bessel_j(l: u32, x: f64) -> f64 {
    let count = 20 + l + x.abs().ceil() as u32;
    let angle = |n: u32| std::f64::consts::PI * (f64::from(n) + 0.5) / f64::from(count);
    let part = |n: u32| (f64::from(l) * angle(n) - x * angle(n).sin()).cos();
    (0..count).map(part).sum::<f64>() / f64::from(count)
}

/// K_l of an argument that is not small, by the midpoint rule.
fn bessel_k(l: u32, x: f64) -> f64 {
    let t = |n: u32| 0.01 * (f64::from(n) + 0.5);
    (0..800)
        .map(|n| 0.01 * (-x * t(n).cosh()).exp() * (f64::from(l) * t(n)).cosh())
        .sum()
}

/// The mode of this order with the lowest u below its first limit: u, w and uJ_{l+1}(u)/J_l(u).
fn mode(l: u32, v: f64, limits: [f64; 2]) -> [f64; 3] {
    let [mut low, mut high] = limits;
    let inner = |u: f64| u * bessel_j(l + 1, u) / bessel_j(l, u);
    for _ in 0..60 {
        let u = 0.5 * (low + high);
        let w = (v * v - u * u).sqrt();
        match inner(u) > w * bessel_k(l + 1, w) / bessel_k(l, w) {
            true => high = u,
            false => low = u,
        }
    }
    [low, (v * v - low * low).sqrt(), inner(low)]
}

/// The field at the pixels behind a plane on which it is cos l(φ − turn) times a function of r whose Hankel transform of order l
/// is given, by the sum of its plane waves.
fn carried(
    transform: impl Fn(f64) -> f64,
    l: u32,
    turn: f64,
    [k, distance, pitch]: [f64; 3],
) -> Array2<Complex64> {
    let (count, most) = (800, 0.9);
    let wave = |n: u32| {
        let p = most * (f64::from(n) + 0.5) / f64::from(count);
        let weight = transform(k * p) * k * k * p * most / f64::from(count);
        let phase = k * distance * (1.0 - p * p).sqrt();
        (p, Complex64::from_polar(weight, phase))
    };
    let waves: Vec<(f64, Complex64)> = (0..count).map(wave).collect();
    on_sensor(pitch, |x, y| {
        let (r, angle) = (x.hypot(y), y.atan2(x));
        let sum: Complex64 = waves
            .iter()
            .map(|(p, wave)| wave * bessel_j(l, k * p * r))
            .sum();
        sum * (f64::from(l) * (angle - turn)).cos()
    })
}

/// The Gaussian of a mode field diameter by its Hankel transform.
#[test]
fn the_mode_of_a_mode_field_diameter_spreads_as_its_hankel_transform() {
    let (wavelength, distance) = (1.55e-3, 0.3);
    let k = std::f64::consts::TAU / wavelength;
    for (diameter, pitch) in [(10.4e-3, 4e-3)] {
        let w: f64 = 0.5 * diameter;
        let transform = |q: f64| 0.5 * w * w * (-(0.5 * q * w).powi(2)).exp();
        let exact = carried(transform, 0, 0.0, [k, distance, pitch]);
        let source = format!(
            "kind = \"fibre\", mode_field_diameter_um = {:?}",
            diameter * 1e3
        );
        for method in METHODS {
            let text = scene(&source, distance, 1.55, pitch * 1e3);
            let outcome = run(&text, None, method).unwrap();
            let error = error(&outcome, &exact);
            assert!(error < FIBRE, "{diameter} {method:?}: {error:e}");

            let found = outcome.hops[0].power[1].unwrap() / (0.5 * std::f64::consts::PI * w * w);
            assert!(
                (found - 1.0).abs() < MODE_POWER,
                "{diameter} {method:?}: {found}"
            );
        }
    }
}

/// A mode field diameter of 3 µm, whose light reaches sines of 0.5. Local bands correct the aberration in each direction by that
/// of light there; by that on the axis alone the error was 3.2e-3 and the estimate 5.1e-4.
#[test]
fn local_bands_know_the_aberration_of_wide_light() {
    let (wavelength, w, pitch) = (1.55e-3, 1.5e-3, 8e-3);
    let k = std::f64::consts::TAU / wavelength;
    let transform = |q: f64| 0.5 * w * w * (-(0.5 * q * w).powi(2)).exp();
    for distance in [0.3, 0.6] {
        let exact = carried(transform, 0, 0.0, [k, distance, pitch]);
        let source = "kind = \"fibre\", mode_field_diameter_um = 3.0";
        let text = scene(source, distance, 1.55, pitch * 1e3);
        let outcome = run(&text, None, Method::LocalBands).unwrap();
        let error = error(&outcome, &exact);
        let ratio = outcome.expected_error().unwrap() / error;
        assert!(error < 2e-3, "{distance}: {error:e}");
        assert!(
            (0.5..2.0).contains(&ratio),
            "{distance}: {error:e}, {ratio}"
        );
    }
}

/// The far field of a mode by the closed form of its Hankel transform, carried on by the sum of its plane waves. LP01 of V = 2.2
/// and LP11 of V = 3.5, turned by 30°.
#[test]
fn fibre_modes_spread_as_their_hankel_transforms() {
    let (wavelength, radius, distance, pitch) = (1.55e-3, 4e-3, 0.3, 4e-3);
    let k = std::f64::consts::TAU / wavelength;
    for (l, v, limits) in [(0, 2.2f64, [1.0, 2.19]), (1, 3.5, [2.405, 3.49])] {
        let [u, w, x] = mode(l, v, limits);
        // The mode's largest amplitude, in units of that at the edge of the core.
        let inside = (0..=20000).map(|n| bessel_j(l, u * f64::from(n) / 20000.0) / bessel_j(l, u));
        let peak = inside.fold(0.0, f64::max);
        let transform = |q: f64| {
            let q = q * radius;
            let ends = x * bessel_j(l, q) - q * bessel_j(l + 1, q);
            ends * v * v / ((u * u - q * q) * (w * w + q * q)) * radius * radius / peak
        };
        let exact = carried(transform, l, 30f64.to_radians(), [k, distance, pitch]);
        let aperture = v / (k * radius);
        let source = format!(
            "kind = \"fibre\", core_radius_um = 4.0, numerical_aperture = {aperture:?}, mode = [{l}, 1], rotation_deg = 30"
        );
        for method in METHODS {
            let text = scene(&source, distance, 1.55, pitch * 1e3);
            let outcome = run(&text, None, method).unwrap();
            let error = error(&outcome, &exact);
            assert!(error < FIBRE, "LP{l}1 {method:?}: {error:e}");

            // ∫|U|² of a mode that is one at the edge of the core: πa²V²K_{l+1}K_{l−1}/(u²K_l²), half of it for l > 0.
            let sides = bessel_k(l + 1, w) * bessel_k(l.abs_diff(1), w) / bessel_k(l, w).powi(2);
            let area = std::f64::consts::PI * (radius * v / u / peak).powi(2) * sides;
            let power = if l == 0 { area } else { 0.5 * area };
            let found = outcome.hops[0].power[1].unwrap() / power;
            assert!(
                (found - 1.0).abs() < MODE_POWER,
                "LP{l}1 {method:?}: {found}"
            );
        }
    }
}

/// Speckle in a Gaussian, whose directions end at the Nyquist frequency of its samples: the sum of the plane waves of the
/// samples.
#[test]
fn samples_at_the_nyquist_rate_make_no_orders_of_their_own() {
    let (wavelength, step, distance, pitch) = (0.55e-3, 2e-3, 0.5, 4e-3);
    let (k, count) = (std::f64::consts::TAU / wavelength, 40usize);
    let at = |i: usize| (i as f64 - 0.5 * (count as f64 - 1.0)) * step;
    let waves = noise((13, 13), 5);
    let turns = |m: usize, x: f64| std::f64::consts::PI * 0.65 * (m as f64 - 6.0) / 6.0 * x / step;
    let along = Array2::from_shape_fn((count, 13), |(i, m)| {
        Complex64::from_polar((-(at(i) / 0.012).powi(2)).exp(), turns(m, at(i)))
    });
    let samples = along.dot(&waves).dot(&along.t());

    // Plane waves over the band of the samples, first along x, then along y.
    let waves = 240usize;
    let widest = 0.5 * wavelength / step;
    let spacing = 2.0 * widest / waves as f64;
    let cosine = |m: usize| (m as f64 + 0.5) * spacing - widest;
    let toward = Array2::from_shape_fn((waves, count), |(m, i)| {
        Complex64::cis(-k * cosine(m) * at(i))
    });
    let mut spectrum = toward.dot(&samples).dot(&toward.t());
    let weight = (step * step * spacing * spacing) / (wavelength * wavelength);
    for ((n, m), value) in spectrum.indexed_iter_mut() {
        let q = (1.0 - cosine(m).powi(2) - cosine(n).powi(2)).sqrt();
        *value *= Complex64::from_polar(weight, k * q * distance);
    }
    let place = |i: usize| (i as f64 - 0.5 * (PIXELS as f64 - 1.0)) * pitch;
    let back = Array2::from_shape_fn((PIXELS, waves), |(i, m)| {
        Complex64::cis(k * cosine(m) * place(i))
    });
    let exact = back.dot(&spectrum).dot(&back.t());
    let text = scene(
        "kind = \"field\", samples = \"memory\", pitch_um = 2.0",
        distance,
        0.55,
        pitch * 1e3,
    );
    for method in METHODS {
        let outcome = run(&text, Some(&samples), method).unwrap();
        let error = error(&outcome, &exact);
        assert!(error < SAMPLES, "{method:?}: {error:e}");
    }
}

/// The builder's sources are those of scenes.
#[test]
fn the_builder_has_the_same_sources() {
    let sensor = |builder: SystemBuilder| {
        let system = builder.sensor([PIXELS; 2], [4e-3; 2]).build().unwrap();
        simulate(&system, &Settings::default(), &|_| {})
            .unwrap()
            .field
            .values
    };
    let samples = noise((8, 9), 3);
    let given = "kind = \"field\", samples = \"memory\", pitch_um = 2.0";
    let by_scene = run(&scene(given, 0.5, 0.55, 4.0), Some(&samples), Method::Auto).unwrap();
    let builder = SystemBuilder::new(0.55e-3).field_source(samples, [2e-3; 2], 0.5);
    assert!(error(&by_scene, &sensor(builder)) < 1e-9);

    let v = std::f64::consts::TAU / 1.55e-3 * 4e-3 * 0.2;
    let mode = FibreMode::new(4e-3, v, [1, 1], 0.5).unwrap();
    let given = format!(
        "kind = \"fibre\", core_radius_um = 4.0, numerical_aperture = 0.2, mode = [1, 1], rotation_deg = {:?}",
        0.5f64.to_degrees()
    );
    let by_scene = run(&scene(&given, 0.3, 1.55, 4.0), None, Method::Auto).unwrap();
    let builder = SystemBuilder::new(1.55e-3).fibre_source(mode, 0.3);
    assert!(error(&by_scene, &sensor(builder)) < 1e-9);
}

/// Faults name the field of the source.
#[test]
fn wrong_fields_and_modes_are_refused_where_they_stand() {
    let fibre = |rest: &str| {
        format!("kind = \"fibre\", core_radius_um = 4.0, numerical_aperture = 0.12, {rest}")
    };
    let field =
        |rest: &str| format!("kind = \"field\", samples = \"a.npy\", pitch_um = 2.0, {rest}");
    for (source, place, expected) in [
        (
            fibre("mode = [1, 1]"),
            "source.mode",
            "guides the mode from V = 2.4048",
        ),
        (fibre("mode = [0, 0]"), "source.mode", "m from 1 to 50"),
        (
            fibre("mode_field_diameter_um = 10.4"),
            "source.mode_field_diameter_um",
            "mode_field_diameter_um alone, or core_radius_um and numerical_aperture",
        ),
        (
            "kind = \"fibre\", numerical_aperture = 0.12".to_owned(),
            "source.mode_field_diameter_um",
            "found numerical_aperture",
        ),
        (
            "kind = \"fibre\", mode_field_diameter_um = 9.0, mode = [1, 1]".to_owned(),
            "source.mode",
            "it has one mode",
        ),
        (fibre("tilt = 3"), "source.tilt", "tilt_deg"),
        (field("size = [3, 4]"), "source.samples", "4 rows of 3"),
        (field("pitch = 1"), "source.pitch", "pitch_um"),
    ] {
        let samples = field("");
        let lent = source.starts_with(&samples[..14]).then(|| noise((5, 5), 1));
        let fault = run(&scene(&source, 1.0, 1.55, 1.0), lent.as_ref(), Method::Auto)
            .err()
            .unwrap();
        let text = fault.to_string();
        assert!(
            text.contains(place) && text.contains(expected) && text.contains("given.toml:3"),
            "{text}"
        );
    }
    let missing = run(
        &scene(&field("size = [3, 4]"), 1.0, 1.55, 1.0),
        None,
        Method::Auto,
    );
    let text = missing.err().unwrap().to_string();
    assert!(
        text.contains("source.samples") && text.contains("a.npy"),
        "{text}"
    );
}
