//! Elements given on the own coordinates of a curved surface: gratings obey the grating equation with their
//! period along the surface, and pixels lie where hand-made projections put them.

use std::path::Path;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::external::scatter::Scatter;
use raylet::engine::external::scatter_settings::{Coverage, Scattering};
use raylet::engine::plan::settings::Settings;
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::math::random::uniform;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::{Aperture, Outline};
use raylet::optics::bundle::Rays;
use raylet::optics::doe::Layer;
use raylet::optics::frame::Frame;
use raylet::optics::phase::profile::Profile;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::surface_coordinates::SurfaceCoordinates;
use raylet::optics::toric::Biconic;
use raylet::wave::free::rayleigh::{Emitter, Emitters};
use raylet::wave::grid::metrics::field_error;
use raylet_testkit::parts::{self, conic, element, lit, on_axis, pixel_layer, sensor};

fn screen(shape: Shape, layer: Layer, half: f64) -> Screen {
    let own = SurfaceCoordinates::of(&shape).unwrap();
    let outline = Outline::Rectangle {
        half_x: half,
        half_y: half,
    };
    let aperture = Aperture {
        outline,
        centre: [0.0; 2],
    };
    let doe = element(Layer::OnSurface(Box::new(own), vec![layer]), aperture);
    Screen {
        shape,
        ..parts::screen(Frame::GLOBAL, ScreenKind::Doe(doe))
    }
}

/// How many lines of a grating lie before (x, y), times their period.
type Lines<'a> = &'a dyn Fn(f64, f64) -> f64;

/// Light along z meets a grating at a few places; the mean direction of its patch's light is the input's
/// tangential part plus λ times the surface gradient of the number of lines, found by walking on the surface.
#[test]
fn gratings_turn_light_by_their_period_along_the_surface() {
    let (wavelength, period, radius) = (0.7e-3, 5e-3, 20.0);
    let grating = Layer::Phase(Profile::Linear {
        gradient: [std::f64::consts::TAU / period, 0.0],
    });
    let cylinder = Shape::Biconic(Biconic {
        x: Conic {
            curvature: 1.0 / radius,
            conic: 0.0,
        },
        y: Conic {
            curvature: 0.0,
            conic: 0.0,
        },
    });
    let arc = |t: f64| radius * (t / radius).asin();
    let on_sphere = move |x: f64, y: f64| arc(x.hypot(y)) * x / x.hypot(y);
    let on_cylinder = move |x: f64, _: f64| arc(x);
    let cases: [(Shape, Lines); 2] = [
        (conic(1.0 / radius, 0.0), &on_sphere),
        (cylinder, &on_cylinder),
    ];
    for (shape, lines) in cases {
        for [x, y] in [[6.0, 0.0], [10.0, 0.0], [3.0, 4.0], [-5.0, 2.0]] {
            // A small aperture about the place: the element is sampled as a whole.
            let mut element = screen(shape.clone(), grating.clone(), 0.065);
            if let ScreenKind::Doe(doe) = &mut element.kind {
                doe.aperture.centre = [x, y];
            }
            let here = element.height([x, y]).unwrap();
            let rays = Rays {
                position: &[[x, y, here.z]],
                direction: &[[0.0, 0.0, 1.0]],
                path: &[0.0],
                weight: &[Complex64::ONE],
            };
            let settings = Scattering {
                coverage: Coverage::Area(1.0),
                towards: Some([-0.2, 0.9, -0.5, 0.5]),
                ..Scattering::beamlets(0.02)
            };
            let scatter = Scatter::new(&element, wavelength, rays, None, settings).unwrap();
            let secondary = scatter.scatter(0..1);
            let (mut mean, mut total) = (Vec3::new(0.0, 0.0, 0.0), 0.0);
            for (weight, [a, b, c]) in secondary.weight.iter().zip(&secondary.direction) {
                mean = mean + Vec3::new(*a, *b, *c) * weight.norm_sqr();
                total += weight.norm_sqr();
            }
            let mean = mean * (1.0 / total);

            // Tangents over x and y, and how fast the lines pass along each.
            let h = 1e-5;
            let rate = [
                (lines(x + h, y) - lines(x - h, y)) / (2.0 * h),
                (lines(x, y + h) - lines(x, y - h)) / (2.0 * h),
            ];
            let [sx, sy] = here.slope;
            for (tangent, rate) in [
                (Vec3::new(1.0, 0.0, sx), rate[0]),
                (Vec3::new(0.0, 1.0, sy), rate[1]),
            ] {
                let expected = tangent.z + wavelength / period * rate;
                let off = (mean.dot(tangent) - expected).abs();
                assert!(off < 1e-4, "{x} {y}: {off:e}");
            }
            // On the meridian itself the period is the plain one.
            if y == 0.0 {
                let along = Vec3::new(1.0, 0.0, sx).unit();
                let off = mean.dot(along) - along.z - wavelength / period;
                assert!(off.abs() < 1e-4, "{x}: {off:e}");
            }
        }
    }
}

const COUNT: usize = 24;
const PITCH: f64 = 2.0;
const RADIUS: f64 = 120.0;

fn pixels() -> Array2<Complex64> {
    Array2::from_shape_fn((COUNT, COUNT), |(j, i)| {
        Complex64::cis(std::f64::consts::TAU * uniform(5, [i as u32, j as u32, 0, 0]))
    })
}

/// The pixel of a sphere's point, projected by hand.
fn by_hand(values: &Array2<Complex64>, x: f64, y: f64) -> Complex64 {
    let r = x.hypot(y).max(1e-12);
    let stretch = RADIUS * (r / RADIUS).asin() / r;
    let place = |t: f64| (t * stretch / PITCH + 0.5 * COUNT as f64).floor();
    let (i, j) = (place(x), place(y));
    let inside = |t: f64| (0.0..COUNT as f64).contains(&t);
    if inside(i) && inside(j) {
        values[[j as usize, i as usize]]
    } else {
        Complex64::ZERO
    }
}

/// The transmission at every point, and the field 150 wavelengths behind against a direct sum over means of
/// cells so small that the pixels' edges hardly matter.
#[test]
fn pixels_lie_where_hand_made_projections_put_them() {
    let values = pixels();
    let layer = pixel_layer(values.clone(), PITCH, PixelForm::Box);
    let half = 0.5 * COUNT as f64 * PITCH;
    let element = screen(conic(1.0 / RADIUS, 0.0), layer, half);
    let ScreenKind::Doe(doe) = &element.kind else {
        unreachable!()
    };
    let fine = 800;
    let step = 2.0 * half / fine as f64;
    let place = |i: usize| -half + step * (i as f64 + 0.5);
    let mut nodes = Vec::new();
    for j in 0..fine {
        for i in 0..fine {
            let (x, y) = (place(i), place(j));
            let exact = by_hand(&values, x, y);
            assert_eq!(doe.transmission(x, y), exact);
            let parts = 6;
            let mut mean = Complex64::ZERO;
            for part in 0..parts * parts {
                let [a, b] = [part % parts, part / parts]
                    .map(|p| step * ((f64::from(p) + 0.5) / f64::from(parts) - 0.5));
                mean += by_hand(&values, x + a, y + b) / f64::from(parts * parts);
            }
            let z = RADIUS - (RADIUS * RADIUS - x * x - y * y).sqrt();
            let slope = [x, y].map(|t| t / (RADIUS - z));
            let light = Complex64::cis(std::f64::consts::TAU * z);
            nodes.push(Emitter {
                at: [x, y, z],
                slope,
                strength: mean * light * (step * step),
            });
        }
    }
    let (count, pitch, distance) = (16, 1.9, 150.0);
    let along = |i: usize| (i as f64 - 0.5 * (count as f64 - 1.0)) * pitch;
    let points: Vec<[f64; 3]> = (0..count * count)
        .map(|i| [along(i % count), along(i / count), distance])
        .collect();
    let exact = Emitters::of_nodes(nodes.into_iter()).field_at(&points, 1.0);
    let exact = Array2::from_shape_vec((count, count), exact).unwrap();
    let sensor = parts::screen(on_axis(distance), sensor(count, pitch));
    let system = lit(vec![element, sensor], vec![vec![]]);
    let ours = simulate(&system, &Settings::default(), &|_| {}).unwrap();
    let error = field_error(ours.field.values.view(), exact.view()).unwrap();
    assert!(error < 3e-3, "{error:e}");
}

const SCENE: &str = r#"version = 1
title = "A grating ruled along a sphere"
wavelength_um = 0.7
[source]
kind = "plane"
[[element]]
kind = "doe"
name = "grating"
radius_mm = 20
coordinates = "surface"
thickness_mm = 30
aperture = { disc = { radius_mm = 1 } }
[[element.layer]]
kind = "grating"
period_um = 20
[[element]]
kind = "sensor"
pixels = [8, 8]
pitch_um = 10
"#;

fn refusal(text: &str) -> String {
    let scene = Scene::parse(text, Path::new("demo.toml"));
    let built = scene.and_then(|scene| build::system(&scene, 0).map(|_| ()));
    built
        .err()
        .map(|fault| fault.to_string())
        .unwrap_or_default()
}

#[test]
fn scenes_choose_coordinates() {
    let scene = Scene::parse(SCENE, Path::new("demo.toml")).unwrap();
    let system = build::system(&scene, 0).unwrap();
    let ScreenKind::Doe(doe) = &system.screens[0].kind else {
        unreachable!()
    };
    // Where the sphere is tilted by 30° its lines are closer by cos 30° over x.
    let [gx, _] = doe.phase_gradient(10.0, 0.0).unwrap();
    let expected = std::f64::consts::TAU / 20e-3 / 0.75f64.sqrt();
    assert!((gx - expected).abs() < 1e-9 * expected);

    let both = "shape = { kind = \"biconic\", radius_x_mm = 20, radius_y_mm = -30 }";
    let text = refusal(&SCENE.replace("radius_mm = 20\n", &format!("{both}\n")));
    let words = [
        "coordinates",
        "curved in two ways",
        "surface of revolution",
        "projected",
    ];
    assert!(words.iter().all(|word| text.contains(word)), "{text}");
    let text = refusal(&SCENE.replace("\"surface\"", "\"polar\""));
    assert!(
        text.contains("coordinates") && text.contains("projected"),
        "{text}"
    );
    assert_eq!(refusal(SCENE), "");
}

/// A phase along the surface of a lens, on an interface: the field is that of the same phase as a table of the radius over x
/// and y, from the closed form of the arc. Pixels there are refused for the true reason.
#[test]
fn phases_along_an_interface_are_carried() {
    const CURVE: f64 = 0.5;
    let scene = |coordinates: &str, layer: &str| {
        format!(
            r#"version = 1
wavelength_um = 0.5
source = {{ kind = "plane" }}
[[element]]
kind = "doe"
name = "front"
radius_mm = {CURVE}
glass = {{ index = 1.5 }}
coordinates = "{coordinates}"
thickness_mm = 1.2
aperture = {{ disc = {{ radius_mm = 0.12 }} }}
layer = [{layer}]
[[element]]
kind = "sensor"
pixels = [24, 24]
pitch_um = 1
"#
        )
    };
    let run = |text: &str| {
        let scene = Scene::parse(text, Path::new("demo.toml")).unwrap();
        let system = build::system(&scene, 0).unwrap();
        let outcome = simulate(&system, &build::settings(&scene), &|_| {});
        outcome.map(|outcome| outcome.field.values)
    };
    let radial = r#"{ kind = "radial", norm_radius_mm = 0.12, coefficients = [-40] }"#;
    let radii: Vec<f64> = (0..=80).map(|i| f64::from(i) * 0.002).collect();
    let phases = radii
        .iter()
        .map(|r| -40.0 * (CURVE * (r / CURVE).asin() / 0.12).powi(2));
    let phases: Vec<f64> = phases.collect();
    let table =
        format!(r#"{{ kind = "radial_table", radius_mm = {radii:?}, phase_rad = {phases:?} }}"#);
    let along = run(&scene("surface", radial)).unwrap();
    let exact = run(&scene("projected", &table)).unwrap();
    let error = field_error(along.view(), exact.view()).unwrap();
    assert!(error < 3e-4, "{error:e}");
    let flat = run(&scene("projected", radial)).unwrap();
    let other = field_error(flat.view(), exact.view()).unwrap();
    assert!(other > 0.1, "{other:e}");

    let pixels = r#"{ kind = "pixels", size = [12, 12], pitch_um = 20 }"#;
    let text = run(&scene("surface", pixels)).unwrap_err().to_string();
    assert!(
        text.contains("pixels over x and y of one lattice"),
        "{text}"
    );
}
