//! Gradients against central differences of the loss itself.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::linearised_system::LinearisedSystem;
use raylet::engine::plan::hop_plan::Plan;
use raylet::engine::plan::settings::{Correction, Settings};
use raylet::engine::trace::ray_sensitivity::Variation;
use raylet::math::vec3::Vec3;
use raylet::optics::doe::Layer;
use raylet::optics::phase::profile::Profile;
use raylet::optics::screen::ScreenKind;
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::system::System;

use crate::gradients::stage::{Case, cases, noise};

/// A smooth real function of the field, and its cotangent there: Σ w|U|² + Re Σ v* U with random w and v, so that
/// modulus and phase both count.
pub(crate) fn loss(field: &Array2<Complex64>) -> (f64, Array2<Complex64>) {
    let (ny, nx) = field.dim();
    let (w, v) = (noise([ny, nx], 60).mapv(|w| w.re), noise([ny, nx], 61));
    let mut value = 0.0;
    for ((u, w), v) in field.iter().zip(&w).zip(&v) {
        value += w * u.norm_sqr() + (v.conj() * u).re;
    }
    let bar = Array2::from_shape_fn((ny, nx), |at| 2.0 * w[at] * field[at] + v[at]);
    (value, bar)
}

/// A system with a parameter that much larger.
type Change = Box<dyn Fn(&System, f64) -> System>;

/// A parameter of a system: its name, its step, and the system with the parameter that much larger.
type Parameter = (&'static str, f64, Change);

fn on_surface(index: usize, change: impl Fn(&mut Conic, f64) + 'static) -> Change {
    Box::new(move |system, by| {
        let mut changed = system.clone();
        if let Shape::Conic(conic) = &mut changed.trains[0][index].shape {
            change(conic, by);
        }
        changed
    })
}

/// Everything behind a surface of the first train moves: its thickness.
fn thickness(index: usize) -> Change {
    Box::new(move |system, by| {
        let mut changed = system.clone();
        let further = |frame: raylet::optics::frame::Frame| {
            let mut frame = frame;
            frame.origin.z += by;
            frame
        };
        for surface in changed.trains[0].iter_mut().skip(index) {
            surface.frame = further(surface.frame);
        }
        for screen in changed.screens.iter_mut().skip(1) {
            screen.frame = further(screen.frame);
        }
        changed
    })
}

fn screen(index: usize, offset: Vec3, tilt: [f64; 3]) -> Change {
    Box::new(move |system, by| {
        let mut changed = system.clone();
        let frame = &mut changed.screens[index].frame;
        *frame = frame.moved(offset * by).tilted(tilt.map(|t| t * by));
        changed
    })
}

fn lens_parameters() -> Vec<Parameter> {
    let pose = |offset: Vec3, tilt: [f64; 3]| -> Change {
        Box::new(move |system, by| {
            let mut changed = system.clone();
            for surface in &mut changed.trains[0] {
                surface.frame = surface
                    .frame
                    .moved(offset * by)
                    .tilted(tilt.map(|t| t * by));
            }
            changed
        })
    };
    let index = |system: &System, by: f64| {
        let mut changed = system.clone();
        changed.trains[0][0].index[1] += by;
        changed.trains[0][1].index[0] += by;
        changed
    };
    vec![
        (
            "curvature",
            5e-8,
            on_surface(0, |conic, by| conic.curvature += by),
        ),
        ("conic", 1e-2, on_surface(1, |conic, by| conic.conic += by)),
        ("thickness", 1e-3, thickness(1)),
        ("index", 1e-5, Box::new(index)),
        ("decentre", 1e-3, pose(Vec3::new(1.0, 0.0, 0.0), [0.0; 3])),
        (
            "tilt",
            2e-5,
            pose(Vec3::new(0.0, 0.0, 0.0), [1.0, 0.0, 0.0]),
        ),
        (
            "sensor",
            1e-3,
            screen(1, Vec3::new(0.0, 0.0, 1.0), [0.0; 3]),
        ),
        (
            "sensor tilt",
            5e-5,
            screen(1, Vec3::new(0.0, 0.0, 0.0), [0.3, 1.0, 0.2]),
        ),
        (
            "element shift",
            1e-3,
            screen(0, Vec3::new(0.4, 0.3, 1.0), [0.0; 3]),
        ),
        (
            "element tilt",
            2e-6,
            screen(0, Vec3::new(0.0, 0.0, 0.0), [0.5, -1.0, 0.7]),
        ),
    ]
}

fn pose_parameters(last: usize) -> Vec<Parameter> {
    vec![
        (
            "distance",
            1e-3,
            screen(last, Vec3::new(0.0, 0.0, 1.0), [0.0; 3]),
        ),
        (
            "shift",
            1e-3,
            screen(last, Vec3::new(1.0, -0.5, 0.0), [0.0; 3]),
        ),
        (
            "tilt",
            1e-4,
            screen(last, Vec3::new(0.0, 0.0, 0.0), [0.6, 1.0, 0.0]),
        ),
        (
            "element",
            1e-3,
            screen(0, Vec3::new(0.2, 0.4, 1.0), [0.0; 3]),
        ),
    ]
}

/// Footprints wide enough that no value jumps at their edge, and no correction, which is held constant.
fn smooth(case: &Case) -> Settings {
    Settings {
        footprint_threshold: Some(1e-11),
        correction: Correction::Off,
        ..case.settings.clone()
    }
}

/// Fourth-order central difference at zero.
fn slope(at: &dyn Fn(f64) -> f64, h: f64) -> f64 {
    (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
}

/// The gradient with respect to parameters, each found from perturbed systems a hundredth of its
/// step away, times its step.
fn gradient(case: &Case, parameters: &[Parameter]) -> (LinearisedSystem, Vec<f64>) {
    let perturbed = |(_, step, change): &Parameter| Variation {
        below: change(&case.system, -0.01 * step),
        above: change(&case.system, 0.01 * step),
        distance: 0.02,
    };
    let variations: Vec<Variation> = parameters.iter().map(perturbed).collect();
    let linearised = LinearisedSystem::new(&case.system, &variations, &smooth(case)).unwrap();
    let trace = linearised.forward(&case.system).unwrap();
    let (_, bar) = loss(&trace.field.values);
    let gradient = linearised.adjoint(&case.system, &variations, &trace, &bar);
    (linearised, gradient.unwrap().parameters)
}

/// Every parameter of a lens without rims, of its pose, and of the screens before and behind it, one by one.
#[test]
fn lens_and_pose_match_differences() {
    let cases = cases();
    let case = cases.iter().find(|case| case.name == "lens").unwrap();
    let parameters = lens_parameters();
    let (linearised, found) = gradient(case, &parameters);
    for ((name, step, change), found) in parameters.iter().zip(&found) {
        let value = |by: f64| {
            let trace = linearised
                .forward(&change(&case.system, by * step))
                .unwrap();
            loss(&trace.field.values).0
        };
        let slope = slope(&value, 1.0);
        let error = (found - slope).abs() / slope.abs();
        assert!(
            error < 1e-6,
            "{name}: {found:e} against {slope:e}, {error:e} apart"
        );
    }
}

/// All parameters at once, each as far as its step.
fn match_together(case: &Case, parameters: &[Parameter], free: bool) {
    let (linearised, found) = gradient(case, parameters);
    let is_free = |plan: &Plan| matches!(plan, Plan::Free(..));
    assert!(
        !free || linearised.plans().iter().all(is_free),
        "{}",
        case.name
    );
    let value = |by: f64| {
        let move_on = |system: System, (_, step, change): &Parameter| change(&system, by * step);
        let moved = parameters.iter().fold(case.system.clone(), move_on);
        loss(&linearised.forward(&moved).unwrap().field.values).0
    };
    let (slope, found) = (slope(&value, 1.0), found.iter().sum::<f64>());
    let error = (found - slope).abs() / slope.abs();
    assert!(
        error < 1e-6,
        "{}: {found:e} against {slope:e}, {error:e} apart",
        case.name
    );
}

/// All parameters of the other systems at once.
#[test]
fn whole_systems_match_differences_slow() {
    for case in cases() {
        let parameters = match case.name {
            "lens" => continue,
            "rims and a tilt" | "lens between elements" => lens_parameters(),
            _ => pose_parameters(1),
        };
        match_together(&case, &parameters, false);
    }
}

/// Screens that stay parallel are joined without rays.
#[test]
fn free_hops_match_differences_slow() {
    let free = ["free", "curved mirror", "two elements, one curved"];
    let mut cases = cases();
    cases.retain(|case| free.contains(&case.name));
    assert_eq!(cases.len(), free.len());
    for case in &cases {
        let mut parameters = pose_parameters(1);
        parameters.retain(|(name, ..)| *name != "tilt");
        match_together(case, &parameters, true);
    }
}

/// A coefficient of an element's analytic phase.
#[test]
fn profile_matches_differences() {
    let mut case = cases().swap_remove(0);
    let axicon = |slope: f64| Layer::Phase(Profile::Axicon { slope });
    if let ScreenKind::Doe(doe) = &mut case.system.screens[0].kind {
        doe.layers.push(axicon(0.1));
    }
    let change = move |system: &System, by: f64| {
        let mut changed = system.clone();
        if let ScreenKind::Doe(doe) = &mut changed.screens[0].kind {
            doe.layers[1] = axicon(0.1 + by);
        }
        changed
    };
    match_together(&case, &[("slope", 1e-3, Box::new(change))], true);
}

/// Phases and amplitudes of the pixels of each element, each along a pattern of its own.
#[test]
fn pixels_match_differences_slow() {
    // Pixel by pixel log t moves on by this times a step.
    let pattern = |at: (usize, usize)| {
        let wave = |x: usize, y: usize| (at.0 * x + at.1 * y) as f64 % 5.0 - 2.0;
        Complex64::new(wave(4, 9), wave(7, 3))
    };
    for case in cases() {
        let linearised = LinearisedSystem::new(&case.system, &[], &smooth(&case)).unwrap();
        let trace = linearised.forward(&case.system).unwrap();
        let (_, bar) = loss(&trace.field.values);
        let gradient = linearised.adjoint(&case.system, &[], &trace, &bar).unwrap();
        for (number, bar) in gradient.pixels.iter().enumerate() {
            let Some(bar) = bar else { continue };
            let value = |by: f64| {
                let mut changed = case.system.clone();
                for (at, value) in pixels_of(&mut changed, number).indexed_iter_mut() {
                    *value *= (pattern(at) * by).exp();
                }
                loss(&linearised.forward(&changed).unwrap().field.values).0
            };

            // Along the phases alone, along the amplitudes alone, and along both.
            let mut parts = Complex64::ZERO;
            for (at, value) in pixels_of(&mut case.system.clone(), number).indexed_iter() {
                let along = |way: Complex64| (bar[at].conj() * way * value).re;
                let Complex64 { re, im } = pattern(at);
                parts += Complex64::new(along(re.into()), along(Complex64::I * im));
            }
            assert!(
                parts.re.abs() > 1e-3 * parts.im.abs() && parts.im.abs() > 1e-3 * parts.re.abs()
            );

            // The loss is quartic in the pixels: two points this close are enough.
            let (step, found) = (1e-4, parts.re + parts.im);
            let slope = (value(step) - value(-step)) / (2.0 * step);
            let error = (found - slope).abs() / parts.re.abs().max(parts.im.abs());
            assert!(error < 1e-7, "{}, element {number}: {error:e}", case.name);
        }
    }
}

fn pixels_of(system: &mut System, number: usize) -> &mut Array2<Complex64> {
    match &mut system.screens[number].kind {
        ScreenKind::Doe(doe) => &mut doe.free_pixels_mut().unwrap().values,
        _ => panic!("screen {number} is no element"),
    }
}
