//! Elements and stops in one place act as one.

use std::path::Path;

use raylet::engine::chain::linearised_system::LinearisedSystem;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::system::System;

/// Elements in one place are one element with the layers of both: the same field bit by bit, and the same gradient by the pixels,
/// which comes with the element that has them.
#[test]
fn elements_in_one_place_are_their_product() {
    let mask = "[[element.layer]]\nkind = \"pixels\"\npitch_um = 10\nsize = [40, 40]\n";
    let lens = "[[element.layer]]\nkind = \"lens\"\nfocal_length_mm = 20\n";
    let aperture = "aperture = { disc = { radius_mm = 0.18 } }\n";
    let wide = "aperture = { disc = { radius_mm = 0.4 } }\n";
    let system = |elements: &str| {
        let text = format!(
            "version = 1\nwavelength_um = 0.5\nsource = {{ kind = \"plane\" }}\n{elements}\
             [[element]]\nkind = \"sensor\"\npixels = [16, 16]\npitch_um = 5.0\n"
        );
        let scene = Scene::parse(&text, Path::new("place.toml")).unwrap();
        build::system(&scene, 0).unwrap()
    };
    let start = "[[element]]\nkind = \"doe\"\nthickness_mm";
    let one = system(&format!("{start} = 20\n{aperture}{mask}{lens}"));
    let two = system(&format!(
        "{start} = 0\n{wide}{mask}{start} = 20\n{aperture}{lens}"
    ));
    let swapped = system(&format!(
        "[[element]]\nkind = \"stop\"\nthickness_mm = 0\n{aperture}{start} = 0\n{wide}{lens}{start} = 20\n{wide}{mask}"
    ));
    for method in [Method::Auto, Method::LocalBands] {
        let settings = Settings {
            method,
            ..Settings::default()
        };
        let of = |system: &System| {
            let linearised = LinearisedSystem::new(system, &[], &settings).unwrap();
            let passed = linearised.forward(system).unwrap();
            let field = passed.field.values.clone();
            let gradient = linearised.adjoint(system, &[], &passed, &field).unwrap();
            (field, gradient.pixels)
        };
        let (expected, by_pixels) = of(&one);
        for (given, holder) in [(&two, 0), (&swapped, 2)] {
            let (found, pixels) = of(given);
            assert_eq!(found, expected);
            assert_eq!(pixels.iter().flatten().count(), 1);
            let (found, expected) = (pixels[holder].as_ref(), by_pixels[0].as_ref());
            let pairs = found.unwrap().iter().zip(expected.unwrap());
            let off: f64 = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(off < 1e-12, "{off:e}");
        }
    }
}
