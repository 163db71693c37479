//! Analytic phases off centre, polynomials and holograms of two points, as scenes state them: their light comes to a focus.

use std::path::Path;

use num_complex::Complex64;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::wave::grid::field::Field;

/// The field 20 mm behind an element of 0.4 mm radius with this layer, and of what lights it.
fn field(source: &str, layer: &str) -> Field {
    field_behind(source, "aperture = { disc = { radius_mm = 0.4 } }", layer)
}

/// The field 20 mm behind an element with these keys and this layer, and of what lights it.
fn field_behind(source: &str, keys: &str, layer: &str) -> Field {
    let text = format!(
        "version = 1\nwavelength_um = 0.5\nsource = {source}\n\
         [[element]]\nkind = \"doe\"\nthickness_mm = 20.0\n{keys}\n\
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

/// Light is linear: a sum with complex weights gives the sum of the fields of its terms, times the weights. A term alone is what its
/// layer is; only the nodes differ.
#[test]
fn complex_weights_are_factors_on_fields() {
    let (lens, grating) = (
        "kind = \"lens\"\nfocal_length_mm = 20.0",
        "kind = \"grating\"\nperiod_um = 200.0",
    );
    let term = |layer: &str| format!("[{{ {} }}]", layer.replace('\n', ", "));
    let terms = format!("terms = [{}, {}]", term(lens), term(grating));
    let weighted = |weights: &str| {
        field(
            PLANE,
            &format!("kind = \"sum\"\nweights = [{weights}]\n{terms}"),
        )
    };
    let (a, b) = (weighted("1, 0"), weighted("0, 1"));
    for (term, layer) in [(&a, lens), (&b, grating)] {
        let error = distance(term, &field(PLANE, layer));
        assert!(error < 1e-6, "{layer}: {error:e}");
    }
    let sum = weighted("0.5, [0.3, -0.8]");
    let expected = Field {
        values: &a.values * Complex64::from(0.5) + &b.values * Complex64::new(0.3, -0.8),
        ..a
    };
    let error = distance(&sum, &expected);
    assert!(error < 1e-9, "{error:e}");
}

/// A layer off centre and turned, in an aperture about its centre, is an element off centre and turned; their nodes differ, so both
/// have errors of their own.
#[test]
fn placed_layers_are_those_of_placed_elements() {
    let point = "object = { point_mm = [0.05, -0.02, 25.0] }";
    let lens = "kind = \"lens\", focal_length_mm = 25.0";
    let folded = "orders = [0, 1], wavelength_um = 0.45";
    let layers: [(&str, String); 11] = [
        (
            "radial_table",
            String::from("radius_mm = [0, 0.1, 0.2, 0.4], phase_rad = [0, -4, -12, 3]"),
        ),
        ("grating", String::from("period_um = 150.0")),
        ("lens", String::from("focal_length_mm = 25.0")),
        ("axicon", String::from("angle_deg = 0.5")),
        ("vortex", String::from("charge = 2")),
        (
            "radial",
            String::from("norm_radius_mm = 0.3, coefficients = [-20.0, 3.0]"),
        ),
        (
            "zernike",
            String::from("norm_radius_mm = 0.4, coefficients = [0, 1, 2, 3, 4, 1, 2, -3]"),
        ),
        (
            "xy",
            String::from(
                "norm_radius_mm = 0.3, terms = [{ x = 3, coefficient = 9 }, { y = 1, coefficient = 5 }]",
            ),
        ),
        ("two_point", String::from(point)),
        ("kinoform", format!("{folded}, layer = [{{ {lens} AXES }}]")),
        (
            "sum",
            format!("terms = [[{{ {lens} AXES }}], [{{ kind = \"vortex\", charge = 1 AXES }}]]"),
        ),
    ];
    for (kind, keys) in layers {
        let axes = ", centre_mm = [0.1, -0.06], rotation_deg = 30.0";
        let layer = |axes: &str| {
            let inside = keys.contains("AXES");
            let keys = keys.replace(" AXES", axes);
            let table = format!(
                "kind = \"{kind}\", {keys}{}",
                if inside { "" } else { axes }
            );
            format!("kind = \"sum\"\nterms = [[{{ {table} }}]]")
        };
        let rim = "aperture = { disc = { radius_mm = 0.15, centre_mm = [0.1, -0.06] } }";
        let placed = field_behind(PLANE, rim, &layer(axes));
        let moved = "decenter_mm = [0.1, -0.06]\ntilt_deg = [0, 0, 30]\naperture = { disc = { radius_mm = 0.15 } }";
        let element = field_behind(PLANE, moved, &layer(""));
        let error = distance(&placed, &element);
        assert!(error < 1e-3, "{kind}: {error:e}");
    }
}

/// Samples of a phase of the radius in mm, as a layer by a table up to 0.4 mm.
fn table(samples: u32, phase: impl Fn(f64) -> f64) -> String {
    let radii: Vec<f64> = (0..samples)
        .map(|i| 0.4 * f64::from(i) / f64::from(samples - 1))
        .collect();
    let phases: Vec<f64> = radii.iter().map(|r| phase(*r)).collect();
    format!("kind = \"radial_table\"\nradius_mm = {radii:?}\nphase_rad = {phases:?}")
}

/// A table of an aspheric phase gives the field of the phase, but for the error of the spline, 5/384 h⁴ φ⁗: with 0.025 and
/// 0.0125 mm from one sample to the next at most 1e-3 and 6e-5 rad here, and less in the mean.
#[test]
fn a_table_is_what_it_was_sampled_from() {
    let exact = field(
        PLANE,
        "kind = \"radial\"\nnorm_radius_mm = 0.4\ncoefficients = [-50.0, 9.0]",
    );
    let error = |samples| {
        let phase = |r: f64| {
            let u = (r / 0.4).powi(2);
            (9.0 * u - 50.0) * u
        };
        distance(&field(PLANE, &table(samples, phase)), &exact)
    };
    let (coarse, fine) = (error(17), error(33));
    assert!(coarse < 1e-3 && fine < 6e-5, "{coarse:e} {fine:e}");
}

/// With the phase −k(√(r² + f²) − f) all ways to the focus are equal, so Rayleigh and Sommerfeld's integral there has a closed
/// form: U = −ikf e^{ikf} (ln(R/f) + (i/k)(1/f − 1/R)), with R the way from the edge.
#[test]
fn a_table_of_a_lens_has_its_focus() {
    let (k, f) = (std::f64::consts::TAU / 0.5e-3, 20.0f64);
    let phase = |r: f64| -k * (r * r / ((r * r + f * f).sqrt() + f));
    let found = field(PLANE, &table(41, phase)).values[[30, 30]];
    let edge = 0.4f64.hypot(f);
    let inside = Complex64::new((edge / f).ln(), (1.0 / f - 1.0 / edge) / k);
    let exact = Complex64::new(0.0, -k * f) * Complex64::cis(k * f) * inside;
    let error = (found - exact).norm() / exact.norm();
    assert!(error < 1e-4, "{error:e}");
}
