//! Derivatives of rays in blocks are those of single rays, for every kind of parameter.

use std::convert::Infallible;
use std::ops::ControlFlow;

use ndarray::{Array2, Axis};

use crate::engine::geometrical::system_trace::RaySensitivity;
use crate::engine::ray_block::ray_origins::RayOrigins;
use crate::engine::ray_block::system_derivatives::SystemDerivatives;
use crate::engine::trace::ray_sensitivity::Variation;
use crate::fixtures::parts::{conic, element, face, lit, mirror, on_axis, screen, sensor};
use crate::math::random::pair;
use crate::math::vec3::Vec3;
use crate::optics::aperture::Aperture;
use crate::optics::frame::Frame;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::shape::{Conic, Shape};
use crate::optics::surface::Surface;
use crate::optics::system::System;
use crate::optics::toric::Biconic;

/// Curvature and conic constant of the first surface, its place, a tilt and a coefficient of the asphere, the index of the glass, a
/// curvature behind the stop, the place of the stop, the medium before the sensor, and the place of the sensor.
const VALUES: [f64; 10] = [0.04, -0.6, 5.0, 0.07, 2e-5, 1.6, -0.03, 14.0, 1.2, 40.0];

/// A conic, a tilted asphere, a stop, a sphere in another medium, and a sensor.
fn lens_system(values: &[f64]) -> Result<System, Infallible> {
    let [
        c,
        k,
        place,
        tilt,
        coefficient,
        index,
        behind,
        stop,
        last,
        end,
    ] = *values
    else {
        return Ok(lit(Vec::new(), Vec::new()));
    };
    let aspheric = Shape::Asphere {
        base: Conic {
            curvature: -0.02,
            conic: 0.3,
        },
        coefficients: vec![coefficient],
    };
    let turned = on_axis(0.0)
        .moved(Vec3::new(0.1, -0.2, place + 4.0))
        .tilted([tilt, -0.03, 0.2]);
    let bounded = |surface: Surface| Surface {
        aperture: Aperture::disc(4.0),
        ..surface
    };
    let first = vec![
        bounded(face(on_axis(place), conic(c, k), [1.0, index])),
        bounded(face(turned, aspheric, [index, 1.0])),
    ];
    let second = vec![bounded(face(
        on_axis(stop + 6.0),
        conic(behind, 0.0),
        [1.0, last],
    ))];
    let image = Screen {
        index: last,
        ..screen(on_axis(end).tilted([0.0, 0.05, 0.1]), sensor(4, 0.1))
    };
    let open = |z: f64, radius: f64| screen(on_axis(z), ScreenKind::Stop(Aperture::disc(radius)));
    Ok(lit(
        vec![open(0.0, 10.0), open(stop, 2.5), image],
        vec![first, second],
    ))
}

/// A system by its values.
type Made = fn(&[f64]) -> Result<System, Infallible>;

fn variations(values: &[f64], system: Made) -> Vec<Variation> {
    let step = |value: f64| 1e-5 * value.abs();
    (0..values.len())
        .map(|i| {
            let Ok(found) = Variation::new(values, i, step(values[i]), system);
            found
        })
        .collect()
}

/// Curvatures and tilt of a mirror of two curvatures, its place, and that of a plane glass behind it.
const MIRROR_VALUES: [f64; 5] = [-0.008, -0.012, 0.1, 30.0, 20.0];

/// A stop, a tilted mirror, a face of glass, and a sensor.
fn mirror_system(values: &[f64]) -> Result<System, Infallible> {
    let [x, y, tilt, place, glass] = *values else {
        return Ok(lit(Vec::new(), Vec::new()));
    };
    let [x, y] = [x, y].map(|curvature| Conic {
        curvature,
        conic: -1.0,
    });
    let turned = on_axis(place).tilted([tilt, 0.02, 0.0]);
    let train = vec![
        mirror(turned, Shape::Biconic(Biconic { x, y })),
        face(on_axis(glass), Shape::Plane, [1.0, 1.5]),
    ];
    let image = Screen {
        index: 1.5,
        arrives: -1.0,
        ..screen(on_axis(-10.0), sensor(4, 0.1))
    };
    let stop = screen(on_axis(0.0), ScreenKind::Stop(Aperture::disc(5.0)));
    Ok(lit(vec![stop, image], vec![train]))
}

/// The places of 300 rays on the first screen.
fn places() -> [Vec<f64>; 2] {
    let places = (0..300).map(|i| pair(5, [i, 0, 0, 0]).map(|u| 9.0 * (u - 0.5)));
    places
        .map(|[x, y]| (x, y))
        .unzip::<f64, f64, Vec<_>, Vec<_>>()
        .into()
}

/// The direction of their light.
const LIGHT: [[f64; 3]; 1] = [[0.03, -0.02, 0.999_349_788_612_575_8]];

#[test]
fn gradients_are_dot_products_with_derivatives() {
    let [x, y] = places();
    let origins = RayOrigins::Lit {
        light: &LIGHT,
        at: [&x, &y],
        between: RayOrigins::IN_MM,
    };
    let weights = Array2::from_shape_fn((5, x.len()), |(row, ray)| {
        pair(9, [row, ray, 0, 0].map(|i| u32::try_from(i).unwrap()))[0] - 0.4
    });
    let going = || ControlFlow::Continue(());
    let kinds: [(&[f64], Made); 2] = [(&VALUES, lens_system), (&MIRROR_VALUES, mirror_system)];
    for (values, made) in kinds {
        let Ok(system) = made(values);
        let variations = variations(values, made);
        let rays = SystemDerivatives::new(&system, &variations).unwrap();
        let derivatives = rays.derivatives(origins, &going).unwrap();
        let columns = [0, 1, 2, 3, 4].map(|row| weights.row(row).to_slice());
        let gradient = rays.gradient(origins, &columns, &going).unwrap();
        for (found, slopes) in gradient.iter().zip(derivatives.outer_iter()) {
            let products = { weights.iter().zip(slopes) }
                .map(|(weight, slope)| weight * slope)
                .filter(|product| !product.is_nan());
            let (sum, scale) = products.fold((0.0, 0.0), |(sum, scale), product| {
                (sum + product, scale + product.abs())
            });
            assert!(scale > 1e-3, "{scale}");
            assert!((found - sum).abs() < 1e-12 * scale, "{found} {sum}");
        }
    }
}

#[test]
fn derivatives_in_blocks_are_those_of_single_rays() {
    let Ok(system) = lens_system(&VALUES);
    let variations = variations(&VALUES, lens_system);
    let [x, y] = places();
    let origins = RayOrigins::Lit {
        light: &LIGHT,
        at: [&x, &y],
        between: RayOrigins::IN_MM,
    };
    let blocks = SystemDerivatives::new(&system, &variations).unwrap();
    let found = blocks
        .derivatives(origins, &|| ControlFlow::Continue(()))
        .unwrap();
    let single = RaySensitivity::new(&system, &variations);
    let (mut arrived, mut largest) = (0, vec![[0.0_f64; 5]; VALUES.len()]);
    for (ray, at) in x.iter().zip(&y).map(|(x, y)| [*x, *y]).enumerate() {
        let (source, _) = origins.of(&system, ray).unwrap();
        let Some(exact) = single.of(&source, at) else {
            let rows = found.index_axis(Axis(2), ray);
            assert!(rows.iter().all(|value| value.is_nan()), "{ray}");
            continue;
        };
        arrived += 1;
        for (parameter, exact) in exact.iter().enumerate() {
            for (i, exact) in exact.iter().enumerate() {
                let difference = (found[[parameter, i, ray]] - exact).abs();
                let largest = &mut largest[parameter][i];
                *largest = largest.max(exact.abs());
                assert!(
                    difference < 1e-8 * (1.0 + exact.abs()),
                    "{parameter} {i} {ray}: {difference:e} of {exact:e}"
                );
            }
        }
    }
    assert!((100..290).contains(&arrived), "{arrived}");
    // Every parameter moves rays, or changes their paths.
    assert!(
        largest
            .iter()
            .all(|row| row.iter().any(|most| *most > 1e-3))
    );
}

/// Elements turn rays, which only single rays can tell.
#[test]
fn systems_with_elements_have_single_rays() {
    let Ok(mut system) = lens_system(&VALUES);
    assert!(SystemDerivatives::new(&system, &variations(&VALUES, lens_system)).is_some());
    let doe = element(
        crate::optics::doe::Layer::Sum(Vec::new()),
        Aperture::disc(1.0),
    );
    system.screens[1] = screen(Frame::GLOBAL, ScreenKind::Doe(doe));
    assert!(SystemDerivatives::new(&system, &[]).is_none());
}
