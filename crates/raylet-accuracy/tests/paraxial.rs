//! raylet's paraxial optics against its ray tracer and against Collins' integral by direct sum.

use ndarray::{Array1, Array2};
use num_complex::Complex64;
use raylet::math::vec3::Vec3;
use raylet::optics::frame::Frame;
use raylet::optics::paraxial::Abcd;
use raylet::optics::refraction::Interface;
use raylet::optics::screen::Screen;
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::surface::Surface;
use raylet::optics::system::Hop;
use raylet::wave::free::collins::Collins;
use raylet::wave::grid::field::{Axis, Grid};
use raylet::wave::grid::raster::Raster;
use raylet_accuracy::numerics::pixels::Pixels;
use raylet_accuracy::references::collins::{Abcd as Direct, CollinsIntegral};
use raylet_testkit::noise::phases;
use raylet_testkit::parts::{face, open_screen};

/// A frame beside the global axis.
fn beside(z: f64) -> Frame {
    Frame::GLOBAL.moved(Vec3::new(0.2, -0.1, z))
}

fn screen(z: f64, index: f64, arrives: f64) -> Screen {
    Screen {
        index,
        arrives,
        ..open_screen(beside(z))
    }
}

fn surface(z: f64, radius: f64, interface: Interface, index: [f64; 2]) -> Surface {
    let shape = Shape::Asphere {
        base: Conic {
            curvature: 1.0 / radius,
            conic: -0.4,
        },
        coefficients: vec![1e-5, 2e-7],
    };
    Surface {
        interface,
        ..face(beside(z), shape, index)
    }
}

#[test]
fn ray_matrix_is_the_jacobian_at_the_axis() {
    use Interface::{Reflect, Refract};
    let doublet = vec![
        surface(4.0, 31.0, Refract, [1.0, 1.6]),
        surface(9.0, -25.0, Refract, [1.6, 1.75]),
        surface(11.0, -90.0, Refract, [1.75, 1.33]),
    ];
    // Through a lens, back from a mirror and through the lens the other way.
    let mut double_pass = vec![
        surface(4.0, 31.0, Refract, [1.0, 1.6]),
        surface(9.0, -25.0, Refract, [1.6, 1.0]),
        surface(30.0, -70.0, Reflect, [1.0, 1.0]),
    ];
    double_pass.push(surface(9.0, -25.0, Refract, [1.0, 1.6]));
    double_pass.push(surface(4.0, 31.0, Refract, [1.6, 1.0]));
    for (train, to) in [
        (doublet, screen(60.0, 1.33, 1.0)),
        (double_pass, screen(-12.0, 1.0, -1.0)),
    ] {
        let from = screen(0.0, 1.0, 1.0);
        let hop = Hop {
            wavelength: 0.7e-3,
            from: &from,
            train: &train,
            to: &to,
        };
        let matrix = Abcd::between(&hop).unwrap();
        let (landing, jacobian) = hop.jacobian([0.0; 2], [0.0; 2]).unwrap();
        for axis in 0..2 {
            let [s, p] = [jacobian[axis], jacobian[axis + 2]];
            for (paraxial, exact) in [
                (matrix.a, s[axis]),
                (matrix.b, s[axis + 2]),
                (matrix.c, p[axis]),
                (matrix.d, p[axis + 2]),
            ] {
                assert!((paraxial - exact).abs() < 1e-12 * (1.0 + exact.abs()));
            }
        }
        assert!((matrix.path - landing.path).abs() < 1e-13 * landing.path);
    }
}

#[test]
fn collins_equals_its_direct_sum() {
    // Random pixels before a thick lens, on both sides of its focus, on a raster off the axis.
    let (wavelength, pitch, count, nodes) = (0.7e-3, 6.3e-3, 60, 4);
    let pixels = Pixels {
        pitch,
        transmission: phases([count; 2], 5),
    };
    let axis = Axis::gauss(count, pitch, 0.0, nodes);
    let grid = Grid {
        x: axis.clone(),
        y: axis,
    };
    let field = Array2::from_shape_fn(grid.shape(), |(j, i)| {
        pixels.transmission[[j / nodes, i / nodes]]
    });
    let to = Raster {
        start: [-0.9, -0.2],
        pitch: [7e-3, 11e-3],
        size: [150, 90],
    };
    let points =
        |a: usize| Array1::from_iter((0..to.size[a]).map(|i| to.start[a] + i as f64 * to.pitch[a]));
    for sensor in [20.0, 44.7, 90.0] {
        let train = Abcd::IDENTITY
            .drift(3.0, 1.0)
            .thin_lens(0.0199)
            .drift(5.3, 1.513)
            .thin_lens(-0.003)
            .drift(sensor, 1.0);
        let direct = Direct::identity()
            .drift(3.0, 1.0)
            .refract(0.0199)
            .drift(5.3, 1.513)
            .refract(-0.003)
            .drift(sensor, 1.0);
        let integral = CollinsIntegral {
            pixels: &pixels,
            wavelength,
            train: direct,
            nodes,
        };
        let exact = integral.field([0.0; 2], [&points(1), &points(0)]).unwrap();
        let fast = Collins::new(wavelength, train, &grid, &to)
            .unwrap()
            .carry(field.view());
        let norm = |u: &Array2<Complex64>| u.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        let error = norm(&(&fast - &exact)) / norm(&exact);
        assert!(error < 1e-11, "{sensor}: {error:e}");
    }
}
