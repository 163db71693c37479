//! Systems in code are those of scene files, and what is wrong with them is one clear error.

use std::path::Path;

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::geometrical::system_trace::trace_system;
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::aperture::Aperture;
use raylet::optics::assembly::system_builder::SystemBuilder;
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::phase::profile::Profile;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::refraction::Coating;
use raylet::optics::screen::ScreenKind;
use raylet::optics::shape::Shape;
use raylet::optics::system::System;
use raylet_testkit::parts::{conic, element, pixel_layer};

fn of_text(text: &str) -> System {
    let scene = Scene::parse(text, Path::new("scene.toml")).unwrap();
    build::system(&scene, 0).unwrap()
}

/// A stop, a tilted lens in water, and a mirror that sends the light back to a sensor on a turned axis.
#[test]
fn parts_stand_where_a_scene_puts_them() {
    let scene = of_text(
        r#"
version = 1
wavelength_um = 0.55
ambient = "water"
source = { kind = "plane", angle_deg = [2, -1] }
settings = { coating = "fresnel" }
[[element]]
kind = "stop"
name = "stop"
thickness_mm = 2.5
aperture = { disc = { radius_mm = 1.5 } }
[[element]]
kind = "surface"
thickness_mm = 4
radius_mm = 30
glass = "SF6"
semi_aperture_mm = 5
decenter_mm = [0.1, -0.2]
tilt_deg = [3, 0, 0]
[[element]]
kind = "surface"
thickness_mm = 20
radius_mm = -50
semi_aperture_mm = 5
[[element]]
kind = "coordinate_break"
tilt_deg = [0, 10, 0]
[[element]]
kind = "mirror"
thickness_mm = -15
radius_mm = -80
semi_aperture_mm = 6
[[element]]
kind = "sensor"
name = "sensor"
pixels = [8, 6]
pitch_um = 3
"#,
    );
    let angle = [2f64, -1.0].map(f64::to_radians);
    let code = SystemBuilder::new(0.55e-3)
        .ambient("water")
        .collimated(angle)
        .coating(Coating::Fresnel)
        .stop(Aperture::disc(1.5))
        .gap(2.5)
        .offset([0.1, -0.2], [3f64.to_radians(), 0.0, 0.0])
        .surface(30.0, "SF6", 5.0)
        .gap(4.0)
        .surface(-50.0, "water", 5.0)
        .gap(20.0)
        .turn([0.0; 2], [0.0, 10f64.to_radians(), 0.0])
        .mirror(-80.0, 6.0)
        .gap(-15.0)
        .sensor([8, 6], [3e-3, 3e-3])
        .build()
        .unwrap();
    assert_eq!(code, scene);
    assert_eq!(code.screens[1].arrives, -1.0);
}

/// A parabolic mirror brings collimated light to its focus, half its radius before it, over equal paths.
#[test]
fn a_parabolic_mirror_focuses() {
    let (to_mirror, focal_length) = (150.0, 100.0);
    let parabola = conic(-0.5 / focal_length, -1.0);
    let system = SystemBuilder::new(0.5e-3)
        .stop(Aperture::disc(40.0))
        .gap(to_mirror)
        .shaped_mirror(parabola, Aperture::disc(45.0))
        .gap(-focal_length)
        .sensor([8, 8], [1e-3; 2])
        .build()
        .unwrap();
    for at in [[0.0, 0.0], [12.0, 0.0], [-20.0, 16.0], [0.0, -40.0]] {
        let ray = trace_system(&system, &system.source, at);
        assert_eq!(ray.lost, None, "{at:?}");
        let end = ray.hits.last().unwrap();
        let aside = end.point.x.hypot(end.point.y);
        let path = end.path - (to_mirror + focal_length);
        assert!(aside < 1e-12 && path.abs() < 1e-12, "{at:?}: {end:?}");
        assert!((end.point.z - (to_mirror - focal_length)).abs() < 1e-12);
    }
}

const HYBRID: &str = r#"
version = 1
wavelength_um = 0.55
source = { kind = "plane" }
[[element]]
kind = "stop"
name = "stop"
thickness_mm = 1
aperture = { disc = { radius_mm = 1.5 } }
[[element]]
kind = "surface"
thickness_mm = 3
glass = "SF6"
semi_aperture_mm = 5
[[element]]
kind = "doe"
name = "back"
thickness_mm = 10
radius_mm = -40
conic = 0
glass = "air"
coating = "fresnel"
aperture = { disc = { radius_mm = 1.2 } }
layer = [{ kind = "lens", focal_length_mm = 50 }]
[[element]]
kind = "sensor"
name = "sensor"
pixels = [8, 6]
pitch_um = 3
"#;

/// A lens with an element on its back; the element's focal length is that in the air behind it.
#[test]
fn an_element_stands_on_the_back_of_a_lens() {
    let scene = of_text(HYBRID);
    let lens = Profile::Lens {
        focal_length: 50.0,
        wavenumber: std::f64::consts::TAU / 0.55e-3,
    };
    let doe = element(Layer::Phase(lens), Aperture::disc(1.2));
    let mut code = SystemBuilder::new(0.55e-3)
        .coating(Coating::Fresnel)
        .stop(Aperture::disc(1.5))
        .gap(1.0)
        .surface(f64::INFINITY, "SF6", 5.0)
        .gap(3.0)
        .element_into("back", Shape::sphere(-40.0), doe, "air")
        .gap(10.0)
        .sensor([8, 6], [3e-3, 3e-3])
        .build()
        .unwrap();
    // The scene states the coating of the element alone.
    code.trains[0][0].coating = Coating::Ideal;
    assert_eq!(code, scene);
    let back = &scene.screens[1];
    assert_eq!(back.index, scene.trains[0][0].index[1]);
    assert_eq!(back.index_behind(), 1.0);
    assert_eq!(scene.screens[2].index, 1.0);
}

#[test]
fn what_cannot_stand_on_an_interface_is_one_clear_error() {
    let fault_of = |text: &str| {
        let scene = Scene::parse(text, Path::new("scene.toml"));
        let built = scene.and_then(|scene| build::system(&scene, 0));
        built.unwrap_err().to_string()
    };
    let fault = |from: &str, to: &str| fault_of(&HYBRID.replace(from, to));
    let back = HYBRID.replace("thickness_mm = 10", "thickness_mm = -10");
    let bare = back.replace("coating = \"fresnel\"\n", "");
    let mirror = fault_of(&bare.replace("conic = 0", "reflect = true"));
    assert!(mirror.contains("element[2].glass"), "{mirror}");
    assert!(mirror.contains("reflects light"), "{mirror}");
    let unknown = fault("glass = \"air\"", "glass = \"XY7\"");
    assert!(unknown.contains("element[2].glass"), "{unknown}");

    let doe = Doe {
        reflect: true,
        ..element(
            pixel_layer(Array2::ones((2, 2)), 0.1, PixelForm::Box),
            Aperture::OPEN,
        )
    };
    let builder = SystemBuilder::new(0.5e-3).element_into("mirror", Shape::Plane, doe, 1.5);
    let error = builder
        .gap(1.0)
        .sensor([4, 4], [0.1; 2])
        .build()
        .unwrap_err();
    assert_eq!(error.part, "element 'mirror'");
    assert_eq!(error.expected, "exactly one of the two");
}

/// Where a lens meets the light first, the aperture before it has the beam's radius.
#[test]
fn a_beam_enters_by_its_radius() {
    let build = |builder: SystemBuilder| {
        let lens = builder
            .point_source([0.0, 0.0, -100.0])
            .surface(40.0, 1.5, 8.0);
        let system = lens.gap(3.0).sensor([4, 4], [0.1; 2]).build().unwrap();
        system.screens[0].kind.clone()
    };
    let new = || SystemBuilder::new(0.5e-3);
    assert_eq!(build(new()), ScreenKind::Stop(Aperture::disc(8.0)));
    assert_eq!(
        build(new().beam_radius(2.0)),
        ScreenKind::Stop(Aperture::disc(2.0))
    );
}

#[test]
fn phases_become_transmissions() {
    let phases = Array2::from_shape_fn((2, 3), |(j, i)| 0.1 * (i + 10 * j) as f64);
    let system = SystemBuilder::new(0.5e-3)
        .phase_pixels("pixels", &phases, [0.1, 0.2])
        .gap(5.0)
        .sensor([4, 4], [0.1; 2])
        .build()
        .unwrap();
    let ScreenKind::Doe(doe) = &system.screens[0].kind else {
        panic!("the first screen is the element");
    };
    let pixels = doe.pixels().unwrap();
    assert_eq!((pixels.pitch, pixels.form), ([0.1, 0.2], PixelForm::Box));
    assert_eq!(pixels.values[[1, 2]], Complex64::cis(phases[[1, 2]]));
}

/// What a builder says once it has a sensor too.
fn refusal(parts: impl Fn(SystemBuilder) -> SystemBuilder) -> String {
    let builder = parts(SystemBuilder::new(0.5e-3)).gap(1.0);
    let built = builder.sensor([4, 4], [1e-3; 2]).build();
    built.unwrap_err().to_string()
}

#[test]
fn what_is_wrong_is_one_clear_error() {
    let stop = |builder: SystemBuilder| builder.stop(Aperture::disc(1.0));
    let small =
        |value: Complex64| pixel_layer(Array2::from_elem((2, 2), value), 0.1, PixelForm::Box);
    for (found, expected) in [
        (
            refusal(|b| stop(b).gap(-1.0)),
            "gap 1: found a distance of -1 mm, expected zero or more: no mirror has turned the light back",
        ),
        (
            refusal(|b| stop(b).surface(10.0, 1.5, 3.0).surface(0.0, 1.0, 3.0)),
            "surface 2: found a curvature of inf per mm, expected a radius that is not zero; infinite for a plane",
        ),
        (
            refusal(|b| stop(b).mirror(-2.0, 3.0)),
            "mirror 1: found an aperture at (3.000000, 0.000000) mm, where the surface does not exist, expected an \
             aperture all over which it exists",
        ),
        (
            refusal(|b| b.stop(Aperture::disc(-1.0))),
            "stop 1: found a radius of the aperture of -1 mm, expected one above zero",
        ),
        (
            refusal(|b| b.phase_pixels("p", &Array2::zeros((2, 2)), [0.0, 1.0])),
            "element 'p': found a pitch of 0 mm, expected one above zero",
        ),
        (
            refusal(|b| {
                b.element(
                    "e",
                    Shape::Plane,
                    element(small(Complex64::new(f64::NAN, 0.0)), Aperture::OPEN),
                )
            }),
            "element 'e': found a pixel of NaN+0i, expected finite transmissions",
        ),
        (
            refusal(|b| stop(b.beam_radius(1.0))),
            "stop 1: found a beam radius of 1 mm, though this part meets the light first, expected no beam radius: \
             the aperture of this part limits the light",
        ),
        (
            refusal(|b| b),
            "sensor 1: found a sensor as the only part, expected at least one part before the sensor",
        ),
        (
            refusal(|b| stop(b).gap(1.0).sensor([2, 2], [1.0; 2])),
            "gap 2: found a part behind the sensor, expected the sensor as the last part",
        ),
        (
            refusal(|b| stop(b.collimated([1.5, 1.0]))),
            "light: found angles of [1.5, 1.0] rad, expected angles whose sines' squares add up to less than one",
        ),
    ] {
        assert_eq!(found, expected);
    }
}

#[test]
fn glasses_are_known_by_name_and_wavelength() {
    let found = refusal(|b| b.surface(10.0, "N-BK77", 3.0));
    assert!(
        found.starts_with("surface 1: found no glass is named 'N-BK77'"),
        "{found}"
    );
    let far = SystemBuilder::new(0.1).surface(10.0, "N-BK7", 3.0).build();
    let found = far.unwrap_err().to_string();
    assert!(found.contains("found a wavelength of 100 µm"), "{found}");
    let none = SystemBuilder::new(0.5e-3).stop(Aperture::disc(1.0)).build();
    let expected = "end: found no sensor, expected one as the last part";
    assert_eq!(none.unwrap_err().to_string(), expected);
}
