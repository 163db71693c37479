//! Random small systems of twelve kinds. Lengths are in wavelengths; the light goes towards +z first.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::math::random::uniform;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::frame::Frame;
use raylet::optics::phase::placement::Placement;
use raylet::optics::phase::profile::Profile;
use raylet::optics::pixels::active_area::ActiveArea;
use raylet::optics::pixels::pixel_grid::{PixelForm, Pixels};
use raylet::optics::refraction::{Coating, Interface};
use raylet::optics::screen::{Screen, ScreenKind, Sensor};
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::source::Source;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet_testkit::parts::{on_axis, plane_wave, screen};

use crate::problems::problem::face;

/// What a system consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An element, free space, the sensor.
    Free,
    /// The same with a tilted sensor.
    FreeTilted,
    /// An element, a lens, the sensor.
    Lens,
    /// The same, the sensor beside most of the light.
    LensDim,
    /// An element, two lenses, the sensor.
    TwoLenses,
    /// An element, a tilted lens, the sensor.
    TiltedLens,
    /// An element, a lens whose rim cuts the light, the sensor.
    Rim,
    /// An element, a lens, a stop, the sensor.
    Stop,
    /// An element, a concave mirror at an angle, the sensor.
    Mirror,
    /// An element on a curved surface, the sensor.
    Curved,
    /// Two elements in free space, the sensor.
    TwoElements,
    /// Elements before and behind a lens, the sensor.
    AroundLens,
}

/// All kinds.
pub const KINDS: [Kind; 12] = [
    Kind::Free,
    Kind::FreeTilted,
    Kind::Lens,
    Kind::LensDim,
    Kind::TwoLenses,
    Kind::TiltedLens,
    Kind::Rim,
    Kind::Stop,
    Kind::Mirror,
    Kind::Curved,
    Kind::TwoElements,
    Kind::AroundLens,
];

/// Numbers drawn in order from a seed.
struct Draw {
    seed: u32,
    count: u32,
}

impl Draw {
    /// Between two ends.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.count += 1;
        low + (high - low) * uniform(u64::from(self.seed), [self.count, 0, 0, 0])
    }

    /// Between two ends, small ones as likely as large ones by their ratio.
    fn ratio(&mut self, low: f64, high: f64) -> f64 {
        (self.between(low.ln(), high.ln())).exp()
    }

    /// True so often.
    fn chance(&mut self, share: f64) -> bool {
        self.between(0.0, 1.0) < share
    }

    /// A point within a distance of the origin, along each axis.
    fn offset(&mut self, most: f64) -> [f64; 2] {
        [self.between(-most, most), self.between(-most, most)]
    }
}

/// The random system of this kind and number.
pub fn random_system(kind: Kind, number: u32) -> System {
    let mut draw = Draw {
        seed: 1000 * (kind as u32 + 1) + number,
        count: 0,
    };
    let half = draw.between(4.5, 9.0);
    let first = element(&mut draw, 0.0, half);
    let mut system = System {
        wavelength: 1.0,
        source: source(&mut draw),
        screens: vec![first],
        trains: Vec::new(),
    };
    match kind {
        Kind::Free | Kind::FreeTilted => free(&mut draw, &mut system, kind == Kind::FreeTilted),
        Kind::Curved => {
            let radius = draw.ratio(100.0, 400.0) * if draw.chance(0.5) { 1.0 } else { -1.0 };
            system.screens[0].shape = sphere(radius);
            free(&mut draw, &mut system, false);
        }
        Kind::TwoElements => {
            let z = draw.ratio(25.0, 90.0);
            let half = draw.between(4.5, 9.0);
            let mut second = element(&mut draw, z, half);
            let [x, y] = draw.offset(3.0);
            second.frame = second.frame.moved(Vec3::new(x, y, 0.0));
            if draw.chance(0.5) {
                let tilt = draw.between(-0.3, 0.3);
                second.frame = second.frame.tilted([0.0, tilt, 0.0]);
            }
            system.trains.push(vec![]);
            system.screens.push(second);
            free(&mut draw, &mut system, false);
        }
        Kind::Mirror => mirror(&mut draw, &mut system),
        _ => lenses(&mut draw, &mut system, kind),
    }
    system
}

fn sphere(radius: f64) -> Shape {
    Shape::Conic(Conic {
        curvature: 1.0 / radius,
        conic: 0.0,
    })
}

/// Collimated light or a point before the element.
fn source(draw: &mut Draw) -> Source {
    let p = draw.offset(0.15);
    if draw.chance(0.7) {
        return plane_wave(p);
    }
    let far = draw.ratio(60.0, 400.0);
    Source::Point {
        position: Vec3::new(-p[0] * far, -p[1] * far, -far),
        reference: Vec3::new(0.0, 0.0, 0.0),
    }
}

/// An element of half width `half` on the axis: pixels, a smooth phase or an aperture; round or square.
fn element(draw: &mut Draw, z: f64, half: f64) -> Screen {
    let form = draw.between(0.0, 1.0);
    let round = draw.chance(0.5);
    let mut aperture = if round {
        Aperture::disc(half)
    } else {
        Aperture::turned_rectangle(half, half, 0.0, [0.0; 2])
    };
    if form < 0.15 {
        return screen(on_axis(z), ScreenKind::Stop(aperture));
    }
    let layers = if form < 0.4 {
        let gradient = draw.offset(0.2).map(|p| std::f64::consts::TAU * p);
        let focus = draw.ratio(40.0, 300.0);
        let lens = Profile::Lens {
            focal_length: focus,
            wavenumber: std::f64::consts::TAU,
        };
        vec![
            Layer::Phase(Profile::Linear { gradient }),
            Layer::Phase(lens),
        ]
    } else {
        let pitch = if form < 0.9 {
            draw.ratio(0.6, 4.0)
        } else {
            draw.between(6.0, 9.0)
        };
        let count = (2.0 * half / pitch).floor().max(2.0) as usize;
        if !round {
            aperture = Aperture::OPEN;
        }
        let mut phase = || Complex64::cis(draw.between(0.0, std::f64::consts::TAU));
        let values = Array2::from_shape_simple_fn((count, count), &mut phase);
        vec![Layer::Pixels(Pixels {
            pitch: [pitch; 2],
            values,
            form: PixelForm::Box,
            active: ActiveArea::WHOLE,
            placement: Placement::NONE,
        })]
    };
    screen(
        on_axis(z),
        ScreenKind::Doe(Doe {
            layers,
            aperture,
            reflect: false,
        }),
    )
}

/// A sensor of 13² points in a frame.
fn sensor(draw: &mut Draw, frame: Frame) -> Screen {
    let pitch = draw.between(0.7, 2.0);
    let kind = ScreenKind::Sensor(Sensor {
        pixels: [13; 2],
        pitch: [pitch; 2],
    });
    Screen {
        frame,
        ..screen(on_axis(0.0), kind)
    }
}

/// Free space to a sensor.
fn free(draw: &mut Draw, system: &mut System, tilted: bool) {
    let last = system
        .screens
        .last()
        .map_or(0.0, |screen| screen.frame.origin.z);
    let z = last + draw.ratio(25.0, 150.0);
    let [x, y] = draw.offset(0.1 * (z - last));
    let mut frame = on_axis(z).moved(Vec3::new(x, y, 0.0));
    if tilted {
        let [a, b] = draw.offset(0.6);
        frame = frame.tilted([a, b, 0.0]);
    }
    system.screens.push(sensor(draw, frame));
    system.trains.push(vec![]);
}

/// A lens of this semi-aperture whose first vertex stands at `z`, and where its last one does.
fn lens(draw: &mut Draw, z: f64, semi_aperture: f64) -> (Vec<Surface>, f64) {
    let index = draw.between(1.4, 1.8);
    let radius = draw.ratio(70.0, 220.0);
    let thickness = draw.between(6.0, 9.0);
    let other = if draw.chance(0.5) {
        f64::INFINITY
    } else {
        -draw.ratio(70.0, 220.0)
    };
    let (front, back) = if draw.chance(0.7) {
        (radius, other)
    } else {
        (-other, -radius)
    };
    let faces = vec![
        face(z, front, semi_aperture, Coating::Unit, [1.0, index]),
        face(
            z + thickness,
            back,
            semi_aperture,
            Coating::Unit,
            [index, 1.0],
        ),
    ];
    (faces, z + thickness)
}

/// An element, one lens or two, perhaps more, and a sensor.
fn lenses(draw: &mut Draw, system: &mut System, kind: Kind) {
    let semi_aperture = if kind == Kind::Rim {
        draw.between(5.0, 10.0)
    } else {
        draw.between(12.0, 15.0)
    };
    let gap = draw.between(10.0, 40.0);
    let (mut train, mut z) = lens(draw, gap, semi_aperture);
    if kind == Kind::TiltedLens {
        let (tilt, shift) = (draw.offset(0.2), draw.offset(3.0));
        let pivot = train[0].frame;
        let turned = pivot
            .moved(Vec3::new(shift[0], shift[1], 0.0))
            .tilted([tilt[0], tilt[1], 0.0]);
        for surface in &mut train {
            surface.frame = turned.moved(Vec3::new(0.0, 0.0, surface.frame.origin.z - gap));
        }
    }
    if kind == Kind::TwoLenses {
        let gap = draw.between(3.0, 30.0);
        let (second, end) = lens(draw, z + gap, semi_aperture);
        train.extend(second);
        z = end;
    }
    system.trains.push(train);
    if kind == Kind::Stop || kind == Kind::AroundLens {
        z += draw.between(8.0, 30.0);
        let half = draw.between(4.5, 9.0);
        let second = match kind {
            Kind::Stop => screen(on_axis(z), ScreenKind::Stop(Aperture::disc(half))),
            _ => element(draw, z, half),
        };
        system.screens.push(second);
        system.trains.push(vec![]);
    }
    z += draw.ratio(25.0, 200.0);
    let aside = if kind == Kind::LensDim {
        draw.between(16.0, 30.0)
    } else {
        draw.between(0.0, 6.0)
    };
    let turn = draw.between(0.0, std::f64::consts::TAU);
    let frame = on_axis(z).moved(Vec3::new(aside * turn.cos(), aside * turn.sin(), 0.0));
    system.screens.push(sensor(draw, frame));
}

/// An element, a concave or convex mirror at an angle to the light, and a sensor.
fn mirror(draw: &mut Draw, system: &mut System) {
    let (z, angle) = (draw.between(30.0, 60.0), draw.between(0.35, 0.7));
    let away = draw.ratio(50.0, 150.0);
    let radius = draw.ratio(150.0, 600.0) * if draw.chance(0.7) { -1.0 } else { 1.0 };
    let frame = on_axis(z).tilted([0.0, angle, 0.0]);
    let semi_aperture = draw.between(12.0, 17.0);
    let mirror = Surface {
        frame,
        interface: Interface::Reflect,
        ..face(z, radius, semi_aperture, Coating::Unit, [1.0; 2])
    };
    // The light along z goes on along its mirror image.
    let along = Vec3::new(0.0, 0.0, 1.0);
    let back = along + frame.z * (-2.0 * along.dot(frame.z));
    let turn = back.x.atan2(back.z);
    let standing = Frame {
        origin: frame.origin + back * away,
        ..Frame::GLOBAL
    };
    let [x, y] = draw.offset(4.0);
    let standing = standing
        .tilted([0.0, turn, 0.0])
        .moved(Vec3::new(x, y, 0.0));
    system.trains.push(vec![mirror]);
    system.screens.push(sensor(draw, standing));
}
