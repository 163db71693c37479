//! Small systems in wavelengths, with every kind of hop between them.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::freeform::Term;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::refraction::Coating;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::shape::{Conic, Shape};
use raylet::optics::source::Source;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet_testkit::noise::real_noise;
use raylet_testkit::parts::{self, conic, element, on_axis, pixel_layer, sensor};

/// A system and how it is carried.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) system: System,
    pub(crate) settings: Settings,
}

/// Complex values with parts from −½ to ½, [y, x].
pub(crate) fn noise(shape: [usize; 2], purpose: u32) -> Array2<Complex64> {
    let [re, im] = [0, 1].map(|part| real_noise(shape, 11, [part, purpose]) - 0.5);
    re.mapv(Complex64::from) + im.mapv(|im| Complex64::new(0.0, im))
}

pub(crate) fn screen(z: f64, kind: ScreenKind) -> Screen {
    parts::screen(on_axis(z), kind)
}

/// Random phases on square pixels.
pub(crate) fn pixels(count: usize, pitch: f64, purpose: u32, form: PixelForm) -> ScreenKind {
    let phase = |value: Complex64| Complex64::cis(12.0 * value.re);
    let values = noise([count, count], purpose).mapv(phase);
    ScreenKind::Doe(element(pixel_layer(values, pitch, form), Aperture::OPEN))
}

pub(crate) fn face(z: f64, curvature: f64, index: [f64; 2]) -> Surface {
    Surface {
        coating: Coating::Fresnel,
        ..parts::face(on_axis(z), conic(curvature, -0.4), index)
    }
}

pub(crate) fn lit(screens: Vec<Screen>, trains: Vec<Vec<Surface>>) -> System {
    System {
        wavelength: 1.0,
        source: Source::Plane {
            direction: Vec3::new(0.05, -0.02, 1.0).unit(),
            origin: Vec3::new(0.0, 0.0, 0.0),
        },
        screens,
        trains,
    }
}

/// A bump that only light of some wavelengths' path difference notices.
pub(crate) fn bump() -> Shape {
    Shape::Freeform {
        base: Conic {
            curvature: 0.0,
            conic: 0.0,
        },
        terms: vec![Term::Gaussian {
            height: 2.0,
            centre: [3.0, -2.0],
            sigma: 15.0,
        }],
    }
}

/// What is kept does not depend on the field, so that it is linear in each element.
pub(crate) fn exact() -> Settings {
    Settings {
        mode_threshold: Some(0.0),
        ..Settings::default()
    }
}

pub(crate) fn lens() -> Vec<Surface> {
    vec![
        face(40.0, 1.0 / 150.0, [1.0, 1.5]),
        face(80.0, -1.0 / 250.0, [1.5, 1.0]),
    ]
}

/// Every kind of hop: free between planes, from and to curved screens; beamlets from planes, from curved
/// screens, through rims, to tilted screens; one and two elements.
pub(crate) fn cases() -> Vec<Case> {
    let case = |name, system, settings| Case {
        name,
        system,
        settings,
    };
    let pixel = |purpose| pixels(7, 4.0, purpose, PixelForm::Box);
    let free = lit(
        vec![screen(0.0, pixel(1)), screen(100.0, sensor(12, 2.0))],
        vec![vec![]],
    );
    let behind_lens = lit(
        vec![screen(0.0, pixel(2)), screen(330.0, sensor(12, 2.0))],
        vec![lens()],
    );

    // A small lens whose second rim cuts light, and a tilted sensor.
    let mut rimmed = lit(
        vec![
            screen(0.0, pixels(4, 4.0, 8, PixelForm::Box)),
            screen(200.0, sensor(6, 2.0)),
        ],
        vec![vec![
            face(25.0, 1.0 / 60.0, [1.0, 1.5]),
            face(38.0, -1.0 / 90.0, [1.5, 1.0]),
        ]],
    );
    rimmed.trains[0][1].aperture = Aperture::disc(12.0);
    rimmed.screens[1].frame = rimmed.screens[1].frame.tilted([0.2, -0.1, 0.0]);

    let mut mirror = screen(0.0, pixels(8, 2.0, 3, PixelForm::Bilinear));
    mirror.shape = bump();
    let ScreenKind::Doe(doe) = &mut mirror.kind else {
        unreachable!("it is an element")
    };
    doe.reflect = true;
    let mut back = screen(-60.0, sensor(8, 2.0));
    back.arrives = -1.0;
    let curved = lit(vec![mirror, back], vec![vec![]]);

    let mut second = screen(45.0, pixels(4, 4.0, 5, PixelForm::Box));
    second.shape = bump();
    let two = lit(
        vec![
            screen(0.0, pixels(4, 4.0, 4, PixelForm::Box)),
            second,
            screen(100.0, sensor(8, 2.0)),
        ],
        vec![vec![], vec![]],
    );
    let mut between = screen(330.0, pixels(5, 3.0, 7, PixelForm::Box));
    between.shape = bump();
    let lens_between = lit(
        vec![
            screen(0.0, pixels(5, 4.0, 6, PixelForm::Box)),
            between,
            screen(400.0, sensor(8, 2.0)),
        ],
        vec![lens(), vec![]],
    );
    let by_beamlets = Settings {
        method: Method::Beamlet,
        ..exact()
    };
    vec![
        case("free", free, exact()),
        case("lens", behind_lens, exact()),
        case("rims and a tilt", rimmed, exact()),
        case("curved mirror", curved.clone(), exact()),
        case("curved mirror by beamlets", curved, by_beamlets),
        case("two elements, one curved", two, exact()),
        case("lens between elements", lens_between, exact()),
    ]
}
