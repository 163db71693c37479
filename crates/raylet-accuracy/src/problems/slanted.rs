//! The list of problems with tilted, decentred and folded parts.

use raylet::math::vec3::Vec3;
use raylet::optics::frame::Frame;
use raylet_testkit::parts::on_axis;

use crate::problems::fold::{tilted_element, tilted_sensor, toroidal_mirror};
use crate::problems::problem::{Problem, random_pixels, smooth_random};
use crate::problems::strong::{Effort, LENS};
use crate::problems::tilted::{Glass, Setup};

/// A direction in the plane y = 0, so many degrees from +z towards +x.
fn slanting(degrees: f64) -> Vec3 {
    let (s, c) = degrees.to_radians().sin_cos();
    Vec3::new(s, 0.0, c)
}

/// A frame turned about its own x and y axes, in degrees.
fn turned(frame: Frame, about_x: f64, about_y: f64) -> Frame {
    frame.tilted([about_x.to_radians(), about_y.to_radians(), 0.0])
}

/// The strong lens in a frame.
fn lens(frame: Frame) -> Glass {
    Glass {
        frame,
        radius: LENS.radius,
        rim: Some(LENS.semi_aperture),
        thickness: LENS.thickness,
        index: LENS.index,
    }
}

/// Tilted planes in free space.
pub fn tilted_planes() -> Vec<Problem> {
    let pixels = || random_pixels(30, 2.0);
    let element = turned(on_axis(120.0), 0.0, 25.0);
    vec![
        tilted_sensor(pixels(), turned(on_axis(120.0), 10.0, 30.0), 5),
        tilted_element(pixels(), random_pixels(20, 2.0), element, 5),
    ]
}

/// Behind glass, and behind a toroidal mirror.
pub fn slanted(effort: Effort) -> Vec<Problem> {
    let straight = Setup {
        name: "",
        light: slanting(0.0),
        pixels: random_pixels(30, 2.0),
        doe: on_axis(0.0),
        glass: lens(on_axis(20.0)),
        sensor: on_axis(165.0),
        points: (60, 0.7),
        effort,
    };
    let aside = on_axis(0.0).moved(Vec3::new(52.0, 0.0, 165.0));
    let decentred = on_axis(20.0).moved(Vec3::new(6.0, -4.0, 0.0));
    let far = Glass {
        radius: 400.0,
        ..lens(on_axis(20.0).moved(Vec3::new(40.0, 0.0, 0.0)))
    };
    let plate = Glass {
        radius: f64::INFINITY,
        rim: None,
        ..lens(turned(on_axis(50.0), 0.0, 25.0))
    };
    let list = [
        Setup {
            name: "random 2λ pixels, light at 20°, lens, sensor 120λ behind it",
            light: slanting(20.0),
            sensor: aside,
            ..straight.clone()
        },
        Setup {
            name: "random 2λ pixels, lens tilted 15° and decentred, sensor 120λ behind it",
            glass: lens(turned(decentred, 5.0, 15.0)),
            ..straight.clone()
        },
        Setup {
            name: "random 2λ pixels, plate tilted 25°, sensor",
            glass: plate,
            ..straight.clone()
        },
        Setup {
            name: "random 2λ pixels, lens, sensor tilted 25°",
            sensor: turned(on_axis(165.0), 10.0, 25.0),
            ..straight.clone()
        },
        Setup {
            name: "random 2λ pixels tilted 20°, lens, sensor 120λ behind it",
            doe: turned(on_axis(-10.0), 0.0, 20.0),
            ..straight.clone()
        },
        Setup {
            name: "random 2λ pixels, decentred lens with 54 % of the light within its rim, sensor 120λ behind it",
            glass: far,
            ..straight
        },
    ];
    let mut list: Vec<Problem> = list.into_iter().map(Setup::problem).collect();
    list.push(toroidal_mirror(smooth_random(70), 3));
    list
}
