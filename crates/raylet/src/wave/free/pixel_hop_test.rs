//! Hops from large pixels of a mirror against the direct integral.

use ndarray::Array2;
use num_complex::Complex64;

use crate::fixtures::noise::noise;
use crate::fixtures::parts::open_screen;
use crate::optics::conic::Conic;
use crate::optics::frame::Frame;
use crate::optics::freeform::Term;
use crate::optics::screen::Screen;
use crate::optics::shape::Shape;
use crate::wave::free::pixel_hop::{PixelHop, TargetPlane};
use crate::wave::free::rayleigh::Emitters;
use crate::wave::grid::field::{Axis, Field, Grid};
use crate::wave::grid::heights::Heights;
use crate::wave::grid::metrics::field_error;
use crate::wave::grid::raster::Raster;

/// A mirror of this shape, for light that comes along −z.
fn mirror(shape: Shape) -> Screen {
    Screen {
        shape,
        arrives: -1.0,
        ..open_screen(Frame::GLOBAL)
    }
}

/// Random pixels of a mirror on a square, so many along an axis and this far apart, that send light to a target: the
/// distance from the direct integral with six nodes a pixel.
fn error_of_pixels(screen: &Screen, count: usize, pitch: f64, plane: TargetPlane) -> f64 {
    let light = |nodes| {
        let axis = Axis::gauss(count, pitch, 0.0, nodes);
        let grid = Grid {
            x: axis.clone(),
            y: axis,
        };
        let z = Heights::on(screen, &grid).z;
        let values = z.mapv(|z| Complex64::cis(-std::f64::consts::TAU * z));
        Field { values, grid }
    };
    let values = noise((count, count), 7);
    let found = PixelHop::new(screen, &light(1), plane, 1.0).carry(values.view());
    let mut behind = light(6);
    for ((j, i), value) in behind.values.indexed_iter_mut() {
        *value *= values[[j / 6, i / 6]];
    }
    let Raster { start, pitch, size } = *plane.target;
    let along = |a: usize, i: usize| start[a] + pitch[a] * i as f64;
    let points: Vec<[f64; 3]> = (0..size[0] * size[1])
        .map(|n| [along(0, n % size[0]), along(1, n / size[0]), plane.distance])
        .collect();
    let heights = Heights::on(screen, &behind.grid);
    let exact = Emitters::new(&behind, &heights).field_at(&points, 1.0);
    let exact = Array2::from_shape_vec(found.dim(), exact).unwrap();
    field_error(found.view(), exact.view()).unwrap()
}

/// Large pixels of a flat mirror send much less light aside than ahead. Nothing is approximated here but the
/// period, so a box that is a hundredth too wide or too strong shows.
#[test]
fn large_flat_pixels_as_the_direct_integral() {
    let screen = mirror(Shape::Plane);
    let target = Raster {
        start: [-14.0, -12.0],
        pitch: [2.0, 3.0],
        size: [15, 9],
    };
    let plane = TargetPlane {
        distance: 25.0,
        target: &target,
    };
    let error = error_of_pixels(&screen, 9, 2.0, plane);
    assert!(error < 1.2e-4, "{error:e}");
}

/// Large pixels of a tilted plane, and a small target beside the axis. The part of a pixel's spectrum that its tilt
/// changes is exact towards the middle of the target.
#[test]
fn large_tilted_pixels_as_the_direct_integral() {
    let base = Conic {
        curvature: 0.0,
        conic: 0.0,
    };
    let tilted = Term::Polynomial {
        radius: 1.0,
        terms: vec![([1, 0], 0.12), ([0, 1], -0.08)],
    };
    let screen = mirror(Shape::Freeform {
        base,
        terms: vec![tilted],
    });
    let target = Raster {
        start: [97.5, -77.5],
        pitch: [0.5, 0.5],
        size: [3, 3],
    };
    let plane = TargetPlane {
        distance: 400.0,
        target: &target,
    };
    let error = error_of_pixels(&screen, 3, 1.5, plane);
    assert!(error < 6e-3, "{error:e}");
}
