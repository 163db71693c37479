//! Gradients by local bands against central differences of the loss: of lenses, poses, sources, phases, apertures, pixels.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::linearised_system::LinearisedSystem;
use raylet::engine::plan::settings::{Correction, Method, Settings};
use raylet::engine::trace::ray_sensitivity::Variation;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::Layer;
use raylet::optics::frame::Frame;
use raylet::optics::phase::profile::Profile;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::refraction::Coating;
use raylet::optics::screen::{MediumBehind, ScreenKind};
use raylet::optics::shape::Shape;
use raylet::optics::system::System;
use raylet_testkit::parts::{
    conic, element, face, on_axis, pixel_layer, plane_wave, screen, sensor,
};

use crate::gradients::differences::loss;
use crate::gradients::stage::noise;

const WAVELENGTH: f64 = 0.55e-3;
const PIXELS: usize = 12;

/// What may change: half the aperture of the element (mm), a coefficient of its phase (rad), the curvature (1/mm), index and
/// decentre of a lens, the place of the element along the axis, the sensor's place and tilt, the source's direction, and the
/// curvature of the element's surface (1/mm).
const NAMES: [&str; 10] = [
    "aperture",
    "phase",
    "curvature",
    "index",
    "decentre",
    "element",
    "sensor",
    "tilt",
    "source",
    "surface",
];

/// Steps over which the loss changes by a part of itself.
const STEPS: [f64; 10] = [2e-3, 0.1, 2e-5, 2e-5, 3e-4, 2e-4, 1e-5, 2e-4, 5e-6, 5e-4];

/// Largest relative departures, in the order of the names. Carriers are found anew for each difference, so the error of the
/// method at the element's rim counts where the phase or the aperture changes.
const BEHIND_A_LENS: [f64; 10] = [0.15, 1e-2, 1e-2, 1e-4, 1e-2, 1e-2, 1e-5, 1e-5, 1e-2, 2e-3];
const LIT_BY_THE_SOURCE: [f64; 10] = [0.15, 2e-3, 1e-5, 1e-5, 1e-5, 1e-4, 1e-5, 1e-5, 1e-3, 1e-3];

/// Where the element stands.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// Behind a lens.
    BehindLens,
    /// There, on a surface of this curvature (1/mm) between two media.
    Interface(f64),
    /// Before a lens, lit by the source.
    LitBySource,
}

/// A lens, an element and a sensor behind a wide aperture; without the aperture the source lights the element itself.
fn system(place: Place, pixels: Option<&Array2<Complex64>>, by: [f64; 10]) -> System {
    let [
        aperture,
        phase,
        curvature,
        index,
        decentre,
        shift,
        distance,
        tilt,
        source,
        surface,
    ] = by;
    let radial = Profile::Radial {
        radius: 0.4,
        coefficients: vec![-60.0 + phase, 4.0],
    };
    let mut doe = element(Layer::Phase(radial), Aperture::disc(0.4 + aperture));
    if let Some(values) = pixels {
        doe.layers
            .push(pixel_layer(values.clone(), 0.1, PixelForm::Box));
    }
    let at = |z: f64| on_axis(z).moved(Vec3::new(decentre, 0.0, 0.0));
    let glass = 1.5 + index;
    let lens = vec![
        face(at(1.0), conic(0.03 + curvature, 0.0), [1.0, glass]),
        face(at(2.0), conic(-0.02, 0.0), [glass, 1.0]),
    ];
    let mut behind = screen(on_axis(4.0 + shift), ScreenKind::Doe(doe));
    let end = on_axis(14.0 + distance).tilted([0.3 * tilt, tilt, 0.0]);
    let mut end = screen(end, sensor(PIXELS, 6e-3));
    if let Place::Interface(own) = place {
        let coating = Coating::Fresnel;
        if own + surface != 0.0 {
            behind.shape = conic(own + surface, 0.0);
        }
        (behind.behind, end.index) = (
            Some(MediumBehind {
                index: 1.2,
                coating,
            }),
            1.2,
        );
    }
    let wide = screen(Frame::GLOBAL, ScreenKind::Stop(Aperture::disc(1.5)));
    let (screens, trains) = match place {
        Place::BehindLens | Place::Interface(_) => {
            (vec![wide, behind, end], vec![lens, Vec::new()])
        }
        Place::LitBySource => (vec![behind, end], vec![lens_between(at, curvature)]),
    };
    System {
        wavelength: WAVELENGTH,
        source: plane_wave([0.01 + source, -0.004]),
        screens,
        trains,
    }
}

/// A lens behind the element.
fn lens_between(
    at: impl Fn(f64) -> Frame,
    curvature: f64,
) -> Vec<raylet::optics::surface::Surface> {
    vec![
        face(at(6.0), conic(0.03 + curvature, 0.0), [1.0, 1.5]),
        face(at(7.0), Shape::Plane, [1.5, 1.0]),
    ]
}

/// Narrow windows and everything that is not quite dark, so that differences are smooth; no correction, which is held
/// constant.
fn settings() -> Settings {
    Settings {
        method: Method::LocalBands,
        sigma: Some(0.04),
        step: Some(1.0),
        mode_threshold: Some(1e-6),
        footprint_threshold: Some(1e-9),
        correction: Correction::Off,
        ..Settings::default()
    }
}

fn along(i: usize, by: f64) -> [f64; 10] {
    let mut all = [0.0; 10];
    all[i] = by * STEPS[i];
    all
}

#[test]
fn beamlets_and_elements_match_differences_slow() {
    let cases = [
        (Place::BehindLens, BEHIND_A_LENS, 0..9),
        // The phase, the lens's curvature and index, its decentre and the place of the element; its surface, a plane too.
        (Place::Interface(0.05), BEHIND_A_LENS, 1..6),
        (Place::Interface(0.05), BEHIND_A_LENS, 9..10),
        (Place::Interface(0.0), BEHIND_A_LENS, 9..10),
        (Place::LitBySource, LIT_BY_THE_SOURCE, 0..9),
    ];
    for (place, bounds, names) in cases {
        let base = system(place, None, [0.0; 10]);
        let perturbed = |i: usize| Variation {
            below: system(place, None, along(i, -0.01)),
            above: system(place, None, along(i, 0.01)),
            distance: 0.02,
        };
        let variations: Vec<Variation> = (0..NAMES.len()).map(perturbed).collect();
        let linearised = LinearisedSystem::new(&base, &variations, &settings()).unwrap();
        assert!(linearised.plans().is_empty());
        let pass = linearised.forward(&base).unwrap();
        let (_, bar) = loss(&pass.field.values);
        let found = linearised.adjoint(&base, &variations, &pass, &bar);
        let found = found.unwrap().parameters.into_iter().enumerate();
        for (i, found) in found.filter(|(i, _)| names.contains(i)) {
            let value = |by: f64| {
                let moved = system(place, None, along(i, by));
                loss(&linearised.forward(&moved).unwrap().field.values).0
            };
            // Where more than 1e-3 is allowed, two points are enough.
            let near = value(0.5) - value(-0.5);
            let slope = match bounds[i] < 1e-3 {
                true => (8.0 * near - (value(1.0) - value(-1.0))) / 6.0,
                false => near,
            };
            let error = (found - slope).abs() / slope.abs().max(1e-6);
            let name = NAMES[i];
            assert!(
                error < bounds[i],
                "{place:?}, {name}: {found:e} against {slope:e}, {error:e} apart"
            );
        }
    }
}

#[test]
fn pixels_match_differences_by_local_bands() {
    let values = noise([8, 8], 3).mapv(|v| v / v.norm());
    let base = system(Place::BehindLens, Some(&values), [0.0; 10]);
    let linearised = LinearisedSystem::new(&base, &[], &settings()).unwrap();
    let pass = linearised.forward(&base).unwrap();
    let (_, bar) = loss(&pass.field.values);
    let found = linearised.adjoint(&base, &[], &pass, &bar).unwrap();
    let [None, Some(back)] = &found.pixels[..] else {
        panic!("cotangents of the pixels of the second screen only");
    };
    let pattern = |at: (usize, usize)| (at.0 * 7 + at.1 * 3) as f64 % 5.0 - 2.0;
    let value = |by: f64| {
        let mut moved = values.clone();
        for (at, value) in moved.indexed_iter_mut() {
            *value *= Complex64::cis(pattern(at) * by);
        }
        let moved = system(Place::BehindLens, Some(&moved), [0.0; 10]);
        loss(&linearised.forward(&moved).unwrap().field.values).0
    };
    let terms = back.indexed_iter().zip(&values);
    let found: f64 = terms
        .map(|((at, bar), value)| (bar.conj() * Complex64::I * pattern(at) * value).re)
        .sum();
    let step = 1e-3;
    let slope = (value(step) - value(-step)) / (2.0 * step);
    let error = (found - slope).abs() / slope.abs();
    assert!(error < 1e-5, "{found:e} against {slope:e}: {error:e}");
}

/// What the edge of an element sends to a sensor aside, with this cosine of the light, coefficient of a phase (rad) and change of the
/// radius (mm).
fn prism([source, phase, radius]: [f64; 3]) -> System {
    let bent = Profile::Radial {
        radius: 0.35,
        coefficients: vec![10.0 + phase],
    };
    let screens = vec![
        screen(
            on_axis(0.0),
            ScreenKind::Doe(element(Layer::Phase(bent), Aperture::disc(0.35 + radius))),
        ),
        screen(
            Frame {
                origin: Vec3::new(1.25, 0.0, 2.0),
                ..on_axis(2.0)
            },
            sensor(PIXELS, 2e-3),
        ),
    ];
    System {
        wavelength: WAVELENGTH,
        source: plane_wave([0.01 + source, 0.0]),
        screens,
        trains: vec![Vec::new()],
    }
}

/// Light of an edge alone: with the direction of the source, the phase of the element, and its radius.
#[test]
fn light_of_an_edge_matches_differences_slow() {
    let steps = [2e-6, 1e-2, 1e-6];
    let along = |i: usize, by: f64| {
        let mut at = [0.0; 3];
        at[i] = by * steps[i];
        at
    };
    let base = prism([0.0; 3]);
    let variations: Vec<Variation> = (0..3)
        .map(|i| Variation {
            below: prism(along(i, -0.01)),
            above: prism(along(i, 0.01)),
            distance: 0.02 * steps[i],
        })
        .collect();
    let settings = Settings {
        sigma: Some(0.017),
        ..settings()
    };
    let linearised = LinearisedSystem::new(&base, &variations, &settings).unwrap();
    let pass = linearised.forward(&base).unwrap();
    let (_, bar) = loss(&pass.field.values);
    let found = linearised.adjoint(&base, &variations, &pass, &bar);
    for (i, found) in found.unwrap().parameters.into_iter().enumerate() {
        let value = |by: f64| {
            loss(
                &linearised
                    .forward(&prism(along(i, by)))
                    .unwrap()
                    .field
                    .values,
            )
            .0
        };
        let slope = (value(1.0) - value(-1.0)) / (2.0 * steps[i]);
        let error = (found - slope).abs() / slope.abs();
        let text = format!("{i}: {found:e} against {slope:e}, {error:e} apart");
        assert!(error < [1e-2, 3e-3, 2e-2][i], "{text}");
    }
}
