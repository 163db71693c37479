//! Derivatives of rays in blocks are those of single rays, for every kind of parameter.

use std::convert::Infallible;
use std::ops::ControlFlow;

use ndarray::Axis;

use crate::engine::geometrical::system_trace::RaySensitivity;
use crate::engine::ray_block::ray_origins::RayOrigins;
use crate::engine::ray_block::system_derivatives::SystemDerivatives;
use crate::engine::trace::ray_sensitivity::Variation;
use crate::fixtures::parts::{conic, element, face, lit, on_axis, screen, sensor};
use crate::math::random::pair;
use crate::math::vec3::Vec3;
use crate::optics::aperture::Aperture;
use crate::optics::frame::Frame;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::shape::{Conic, Shape};
use crate::optics::surface::Surface;
use crate::optics::system::System;

/// Curvature and conic constant of the first surface, its place, a tilt and a coefficient of the asphere, the index of the glass, a
/// curvature behind the stop, the place of the stop, the medium before the sensor, and the place of the sensor.
const VALUES: [f64; 10] = [0.04, -0.6, 5.0, 0.07, 2e-5, 1.6, -0.03, 14.0, 1.2, 40.0];

/// A conic, a tilted asphere, a stop, a sphere in another medium, and a sensor.
fn system(values: &[f64]) -> Result<System, Infallible> {
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

fn variations() -> Vec<Variation> {
    let step = |value: f64| 1e-5 * value.abs();
    (0..VALUES.len())
        .map(|i| {
            let Ok(found) = Variation::new(&VALUES, i, step(VALUES[i]), system);
            found
        })
        .collect()
}

#[test]
fn derivatives_in_blocks_are_those_of_single_rays() {
    let Ok(system) = system(&VALUES);
    let variations = variations();
    let places: Vec<[f64; 2]> = (0..300)
        .map(|i| pair(5, [i, 0, 0, 0]).map(|u| 9.0 * (u - 0.5)))
        .collect();
    let columns = [0, 1].map(|axis| places.iter().map(|at| at[axis]).collect::<Vec<f64>>());
    let origins = RayOrigins::Lit {
        light: &[[0.03, -0.02, (1.0f64 - 13e-4).sqrt()]],
        at: [&columns[0], &columns[1]],
    };
    let blocks = SystemDerivatives::new(&system, &variations).unwrap();
    let found = blocks
        .derivatives(origins, &|| ControlFlow::Continue(()))
        .unwrap();
    let single = RaySensitivity::new(&system, &variations);
    let (mut arrived, mut largest) = (0, vec![[0.0_f64; 5]; VALUES.len()]);
    for (ray, at) in places.iter().enumerate() {
        let (source, _) = origins.of(&system, ray).unwrap();
        let Some(exact) = single.of(&source, *at) else {
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
    let Ok(mut system) = system(&VALUES);
    assert!(SystemDerivatives::new(&system, &variations()).is_some());
    let doe = element(
        crate::optics::doe::Layer::Sum(Vec::new()),
        Aperture::disc(1.0),
    );
    system.screens[1] = screen(Frame::GLOBAL, ScreenKind::Doe(doe));
    assert!(SystemDerivatives::new(&system, &[]).is_none());
}
