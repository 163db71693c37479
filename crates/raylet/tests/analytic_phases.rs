//! Analytic phases off centre, polynomials and holograms of two points, as scenes state them: their light comes to a focus.

use std::path::Path;

use raylet::engine::chain::linearised_system::LinearisedSystem;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::system::System;
use raylet::wave::grid::field::Field;

/// The field 20 mm behind an element of 0.4 mm radius with this layer, and of what lights it.
fn field(source: &str, layer: &str) -> Field {
    let text = format!(
        "version = 1\nwavelength_um = 0.5\nsource = {source}\n\
         [[element]]\nkind = \"doe\"\nthickness_mm = 20.0\naperture = {{ disc = {{ radius_mm = 0.4 }} }}\n\
         [[element.layer]]\n{layer}\n\
         [[element]]\nkind = \"sensor\"\npixels = [61, 61]\npitch_um = 5.0\n"
    );
    let scene = Scene::parse(&text, Path::new("phases.toml")).unwrap();
    let system = build::system(&scene, 0).unwrap();
    simulate(&system, &Settings::default(), &|_| {})
        .unwrap()
        .field
}

/// The relative distance of two fields.
fn distance(a: &Field, b: &Field) -> f64 {
    let pairs = a.values.iter().zip(&b.values);
    let off: f64 = pairs.map(|(a, b)| (a - b).norm_sqr()).sum();
    (off / b.values.iter().map(|b| b.norm_sqr()).sum::<f64>()).sqrt()
}

const PLANE: &str = "{ kind = \"plane\" }";

/// A lens 0.1 mm off centre focuses there: the field is that of a hologram of the point in its focus. At 0.04 of slope it differs
/// by no more than the fourth order of the path, which the hologram has as well.
#[test]
fn a_lens_off_centre_is_the_hologram_of_its_focus() {
    let lens = field(
        PLANE,
        "kind = \"lens\"\nfocal_length_mm = 20.0\ncentre_mm = [0.1, -0.05]",
    );
    let hologram = field(
        PLANE,
        "kind = \"two_point\"\nobject = { point_mm = [0.1, -0.05, 20.0] }",
    );
    // The hologram's phase is zero on the axis, that of the lens at its centre.
    let brightest = |field: &Field| {
        let all = field.values.indexed_iter();
        let most = all.max_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr()));
        most.map(|(at, value)| (at, *value)).unwrap()
    };
    let ((at, here), (there, other)) = (brightest(&lens), brightest(&hologram));
    assert_eq!((at, there), ((20, 50), (20, 50)));
    let turned = Field {
        values: &hologram.values * (here / other),
        ..hologram
    };
    let error = distance(&turned, &lens);
    assert!(error < 1e-3, "{error:e}");
}

/// A hologram turns the light of its reference into that of its object: lit from a point, it sends light to another.
#[test]
fn a_hologram_sends_the_light_of_one_point_to_another() {
    let from = "{ kind = \"point\", position_mm = [0.5, 0.0, -30.0] }";
    let found = field(
        from,
        "kind = \"two_point\"\nobject = { point_mm = [-0.05, 0.1, 20.0] }\nreference = { point_mm = [0.5, 0.0, -30.0] }",
    );
    let by_lens = field(
        PLANE,
        "kind = \"two_point\"\nobject = { point_mm = [-0.05, 0.1, 20.0] }",
    );
    // The reference's amplitude is one at the vertex and falls by 1 % over the element.
    let error = distance(&found, &by_lens);
    assert!(error < 1e-2, "{error:e}");
    let straight = field(
        PLANE,
        "kind = \"two_point\"\nobject = { point_mm = [-0.05, 0.1, 20.0] }\nreference = { angle_deg = [0, 0] }",
    );
    assert_eq!(straight.values, by_lens.values);
}

/// x² + y² as a polynomial is a radial phase; turned by a right angle, x³ is y³.
#[test]
fn polynomials_are_what_they_say() {
    let radial = field(
        PLANE,
        "kind = \"radial\"\nnorm_radius_mm = 0.4\ncoefficients = [-40.0]",
    );
    let polynomial = field(
        PLANE,
        "kind = \"xy\"\nnorm_radius_mm = 0.4\nterms = [{ x = 2, coefficient = -40.0 }, { y = 2, coefficient = -40.0 }]",
    );
    assert!(distance(&polynomial, &radial) < 1e-9);
    let cubic = |terms: &str| {
        field(
            PLANE,
            &format!("kind = \"xy\"\nnorm_radius_mm = 0.4\n{terms}"),
        )
    };
    let along_y = cubic("terms = [{ y = 3, coefficient = 30.0 }]");
    let turned = cubic("terms = [{ x = 3, coefficient = 30.0 }]\nrotation_deg = 90");
    assert!(distance(&turned, &along_y) < 1e-9);
}

/// A hologram turns light of a point 0.17 mm before it, at a numerical aperture of 0.5, into that of a point 1 mm behind it; a lens
/// does so with aberrations. Local bands agree with the angular spectrum, and no more light arrives than came.
#[test]
fn light_of_a_near_point_goes_by_local_bands_as_by_whole_fields() {
    let hologram = "kind = \"two_point\"\nreference = { point_mm = [0, 0, -0.17] }\nobject = { point_mm = [0, 0, 1.0] }";
    let lens = "kind = \"lens\"\nfocal_length_mm = 0.17";
    for layer in [hologram, lens] {
        let text = format!(
            "version = 1\nwavelength_um = 0.55\nsource = {{ kind = \"point\", position_mm = [0, 0, -0.17] }}\n\
             [[element]]\nkind = \"doe\"\nthickness_mm = 1.0\naperture = {{ disc = {{ radius_mm = 0.1 }} }}\n\
             [[element.layer]]\n{layer}\n\
             [[element]]\nkind = \"sensor\"\npixels = [48, 48]\npitch_um = 1.0\n"
        );
        let scene = Scene::parse(&text, Path::new("near.toml")).unwrap();
        let system = build::system(&scene, 0).unwrap();
        let by = |method| {
            let settings = Settings {
                method,
                ..Settings::default()
            };
            simulate(&system, &settings, &|_| {}).unwrap()
        };
        let found = by(Method::LocalBands);
        let error = distance(&found.field, &by(Method::Auto).field);
        let share = found.hops[0].tally.landed.unwrap();
        assert!(error < 5e-4 && share < 1.0, "{layer}: {error:e} {share}");
    }
}

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
