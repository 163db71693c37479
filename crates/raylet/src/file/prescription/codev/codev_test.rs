//! Tests: whole CODE V files by hand, their axes, apertures, glasses, phases, relations and faults.

use std::fs;
use std::path::Path;

use crate::engine::chain::simulate::simulate;
use crate::engine::plan::settings::Settings;
use crate::file::model::build::system;
use crate::file::prescription::import::{ImportChoices, ImportedLens, import_bytes};
use crate::file::prescription::optiland_test::{folder, landing};
use crate::file::prescription::scene_light::shift_sensor;
use crate::file::scene::element::Element;
use crate::file::scene::illumination::Illumination;
use crate::file::scene::material::Material;
use crate::file::scene::surface_shape::Shape;
use crate::math::vec3::Vec3;
use crate::wave::grid::metrics::field_error;

/// The beginning of a file with radii.
const HEAD: &str = "RDM; LEN; TITLE 'a'\nEPD 2\nDIM M\nWL 500\nYAN 0\nSO 0 1e13\n";

fn chosen(text: &str, choices: &ImportChoices) -> ImportedLens {
    let lens = import_bytes(text.as_bytes(), Path::new("a.seq"), choices);
    lens.unwrap_or_else(|fault| panic!("{fault}\n{text}"))
}

fn imported(text: &str) -> ImportedLens {
    chosen(text, &ImportChoices::default())
}

fn refused(text: &str) -> String {
    let lens = import_bytes(
        text.as_bytes(),
        Path::new("a.seq"),
        &ImportChoices::default(),
    );
    lens.expect_err(text).to_string()
}

/// The first element behind the stop of a file with these surfaces.
fn part(surfaces: &str) -> Element {
    let lens = imported(&format!("{HEAD}S 0 5\nSTO\n{surfaces}SI 0 0\n"));
    lens.scene.element.into_iter().nth(1).unwrap()
}

/// Frames of the second screen and the sensor: where they stand and look.
fn frames(surfaces: &str) -> [(Vec3, Vec3); 2] {
    let lens = imported(&format!("{HEAD}S 0 5\nSTO\n{surfaces}SI 0 0\n"));
    // The sensor stands on the axis, not under the chief ray.
    let made = system(&shift_sensor(lens.scene, [0.0; 2]), 0).unwrap();
    let at = |i: usize| {
        let frame = made.screens[i].frame;
        (frame.origin, frame.z)
    };
    [at(1), at(made.screens.len() - 1)]
}

fn near(found: (Vec3, Vec3), origin: Vec3, axis: Vec3) {
    assert!((found.0 - origin).norm() < 1e-12, "{found:?} {origin:?}");
    assert!((found.1 - axis).norm() < 1e-12, "{found:?} {axis:?}");
}

const ALONG: Vec3 = Vec3::new(0.0, 0.0, 1.0);

#[test]
fn tilts_keep_signs_and_order() {
    let [a, b, c] = [10f64, -20.0, 30.0].map(f64::to_radians);
    // ADE and BDE are left-handed, CDE is right-handed: the first turns z towards y.
    let about_x = |v: Vec3| {
        Vec3::new(
            v.x,
            v.y * a.cos() + v.z * a.sin(),
            -v.y * a.sin() + v.z * a.cos(),
        )
    };
    let about_y = |v: Vec3| {
        Vec3::new(
            v.x * b.cos() - v.z * b.sin(),
            v.y,
            v.x * b.sin() + v.z * b.cos(),
        )
    };
    let about_z = |v: Vec3| {
        Vec3::new(
            v.x * c.cos() - v.y * c.sin(),
            v.x * c.sin() + v.y * c.cos(),
            v.z,
        )
    };
    let inner = |v: Vec3| about_x(about_y(about_z(v)));
    let tilt = "XDE 0.5; YDE -0.25; ZDE 1.5; ADE 10; BDE -20; CDE 30\n";
    let start = Vec3::new(0.5, -0.25, 6.5);

    // A basic tilt moves all that follows.
    let [own, sensor] = frames(&format!("S 0 8\nCIR 3\n{tilt}"));
    near(own, start, inner(ALONG));
    near(sensor, start + inner(ALONG) * 8.0, inner(ALONG));

    // DAR returns behind the surface; REV takes back the tilt of the surface before.
    let [own, sensor] = frames(&format!("S 0 8\nCIR 3\n{tilt}DAR\n"));
    near(own, start, inner(ALONG));
    near(sensor, Vec3::new(0.0, 0.0, 13.0), ALONG);
    let [own, sensor] = frames(&format!("S 0 0\nCIR 3\n{tilt}S 0 8\n{tilt}REV\n"));
    near(own, start, inner(ALONG));
    near(sensor, Vec3::new(0.0, 0.0, 13.0), ALONG);

    // A mirror whose axis bends with the light: its normal is turned towards +y, the light goes to −y.
    let [_, sensor] = frames("S 0 -30 REFL\nCIR 3\nADE 45; BEN\n");
    assert!(
        (sensor.0 - Vec3::new(0.0, -30.0, 5.0)).norm() < 1e-12,
        "{sensor:?}"
    );
}

/// A parabola of focal length 88.9 mm turns parallel light by 90° into one point, which lies aside in the image of the file.
#[test]
fn an_off_axis_parabola_has_its_focus() {
    let bytes = fs::read(folder().join("CODV_35571.seq")).unwrap();
    let lens = import_bytes(&bytes, Path::new("a.seq"), &ImportChoices::default()).unwrap();
    for start in [[0.0, 0.0], [9.0, 0.0], [0.0, -9.0], [5.0, 6.0]] {
        let [x, y] = landing(&lens, start, ALONG);
        assert!(x.hypot(y + 88.9) < 1e-11, "{start:?}: {x} {y}");
    }
}

#[test]
fn apertures_have_their_shape_and_place() {
    let contains = |records: &str, at: [f64; 2]| match part(&format!("S 0 50\n{records}\n")) {
        Element::Stop(stop) => stop.aperture.optics().contains(at[0], at[1]),
        other => panic!("{other:?}"),
    };
    for (records, inside, outside) in [
        ("CIR 2", [1.9, 0.0], [2.1, 0.0]),
        ("CIR 2; ADY 1", [0.0, 2.9], [0.0, -1.1]),
        ("CIR 4; CIR OBS L'a' 1", [1.1, 0.0], [0.9, 0.0]),
        ("CIR 4; CIR HOL 1; ADX HOL 2", [0.5, 0.0], [1.5, 0.0]),
        ("REX 1; REY 2", [0.9, 1.9], [1.1, 0.0]),
        ("REX 1; REY 2; ARO 90", [1.9, 0.9], [0.0, 1.1]),
        ("ELX 1; ELY 2", [0.0, 1.99], [1.01, 0.0]),
        ("ELX 1; ELY 2; ARO 90", [1.99, 0.0], [0.0, 1.01]),
        ("CIR 2; CIR EDG 1", [1.5, 0.0], [2.1, 0.0]),
    ] {
        assert!(contains(records, inside), "{records}");
        assert!(!contains(records, outside), "{records}");
    }
}

#[test]
fn shapes_have_their_numbers() {
    let surface = |records: &str| match part(&format!("S 20 3 NBK7_SCHOTT\nCIR 1\n{records}\n")) {
        Element::Surface(surface) => surface,
        other => panic!("{other:?}"),
    };
    let sag = |records: &str, at: [f64; 2]| {
        let one = surface(records);
        one.surface_shape()
            .optics(None)
            .unwrap()
            .sag(at[0], at[1])
            .unwrap()
    };
    let (x, y) = (0.6, 0.8);
    let sphere = 20.0 - 399f64.sqrt();
    let conic = |k: f64, r: f64| r * r / 20.0 / (1.0 + (1.0 - (1.0 + k) * r * r / 400.0).sqrt());
    for (records, expected) in [
        ("SPH", sphere),
        ("CON; K -1", 1.0 / 40.0),
        (
            "ASP; K -0.5; A 1e-3; B 2e-4; J 3e-5",
            conic(-0.5, 1.0) + 1e-3 + 2e-4 + 3e-5,
        ),
        ("CYL", conic(0.0, y)),
        ("AAS; RDX 40; KY -1", 0.5 * (x * x / 40.0 + y * y / 20.0)),
        ("SPS ODD; SCO K -1; SCO C4 1e-3", 1.0 / 40.0 + 1e-3),
        (
            "SPS XYP; SCO C1 -1; SCO C2 1e-3; SCO C5 1e-2",
            1.0 / 40.0 + 1e-3 * x + 1e-2 * x * y,
        ),
    ] {
        let found = sag(records, [x, y]);
        let within = if records.starts_with("AAS") {
            2e-5
        } else {
            1e-14
        };
        assert!(
            (found - expected).abs() < within,
            "{records}: {found} {expected}"
        );
    }
    let Some(Shape::Toroid(toroid)) = surface("YTO; RDX 30; K -1; A 1e-4").shape else {
        panic!("no toroid");
    };
    assert_eq!(
        (toroid.radius_mm, toroid.rotation_radius_mm),
        (Some(20.0), Some(30.0))
    );
    assert_eq!((toroid.conic, toroid.aspheric), (-1.0, vec![1e-4]));
    assert!(refused(&format!("{HEAD}S 20 3 NBK7_SCHOTT\nXTO; RDX 5\nS 0 9\n")).contains("XTO"));
    assert!(refused(&format!("{HEAD}S 20 3 NBK7_SCHOTT\nCUF 0.1\nS 0 9\n")).contains("Fresnel"));
}

/// Inches, curvatures, a surface in several lines and remarks: the same lens as in mm.
#[test]
fn units_and_modes_give_the_same_lens() {
    let plain = "RDM\nEPD 2\nDIM M\nWL 500\nYAN 0\nS 20 3 NBK7_SCHOTT\nSTO\nCIR 2\nASP; A 1e-4; B 1e-6\nS -30 9\n";
    let inches = format!(
        "rdm n\nepd {}\ndim i\nwl 500; yan 0 ! a remark; epd 9\ns {} &\n {} nbk7_Schott\nstop\ncir {}\nasp; a {:e}; b {:e}\ns {} {}\n",
        2.0 / 25.4,
        25.4 / 20.0,
        3.0 / 25.4,
        2.0 / 25.4,
        1e-4 * 25.4f64.powi(3),
        1e-6 * 25.4f64.powi(5),
        -25.4 / 30.0,
        9.0 / 25.4
    );
    let later = "RDM\nS 1 1\nS 2 2\nEPD 2\nWL 500\nYAN 0\nRDY S1 20\nTHI S1 3\nGLA S1 NBK7_SCHOTT\nSTO S1\nCIR S1 2\nCUY S2 -0.0333333333333333333\n\
                 THI S2 9\nA S1 1e-4\nB S1 1e-6\n";
    let numbers = |text: &str| {
        let lens = imported(text);
        let direction = Vec3::new(0.0, 0.02, (1.0 - 0.02f64.powi(2)).sqrt());
        let [x, y] = landing(&lens, [0.3, 0.5], direction);
        let number = |word| lens.report.number(word).unwrap();
        [
            number("focal length (mm)"),
            number("stop radius (mm)"),
            x,
            y,
        ]
    };
    let expected = numbers(plain);
    for text in [&inches, later] {
        for (found, expected) in numbers(text).into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
}

#[test]
fn apertures_of_the_system_and_fields_are_read() {
    let surfaces = "S 0 7\nS 0 0\nSTO\nS 30 2 NBK7_SCHOTT\nS -30 30\n";
    let head = "RDM\nWL 500\nYAN 0 5\n";
    let lens = |system: &str| imported(&format!("{head}{system}\n{surfaces}"));
    let number = |lens: &ImportedLens, word| lens.report.number(word).unwrap();
    assert!((number(&lens("EPD 3"), "stop radius (mm)") - 1.5).abs() < 1e-12);
    assert!((number(&lens("FNO 5"), "working f-number") - 5.0).abs() < 1e-12);
    let sine: f64 = 0.1;
    let expected = 0.5 / sine.asin().tan();
    assert!((number(&lens("NA 0.1"), "working f-number") - expected).abs() < 1e-12);
    let expected = 37.0 * sine.asin().tan();
    assert!((number(&lens("SO 0 30\nNAO 0.1"), "stop radius (mm)") - expected).abs() < 1e-12);

    let second = ImportChoices {
        field: 2,
        ..ImportChoices::default()
    };
    let tilted = chosen(&format!("{head}EPD 3\n{surfaces}"), &second);
    let Illumination::Plane(plane) = tilted.scene.source else {
        panic!("no plane wave");
    };
    assert!((plane.angle_deg[1] - 5.0).abs() < 1e-12);
    let point = chosen(
        &format!("RDM\nWL 500\nYOB 0 2\nSO 0 30\nEPD 3\n{surfaces}"),
        &second,
    );
    let Illumination::Point(point) = point.scene.source else {
        panic!("no point");
    };
    assert!((point.position_mm[1] - 2.0).abs() < 1e-12);
}

#[test]
fn glasses_are_found_stated_or_refused() {
    let glass = |head: &str, word: &str| {
        let lens = imported(&format!(
            "{head}{HEAD}S 0 5\nSTO\nS 20 3 {word}\nCIR 1\nS 0 9\n"
        ));
        match lens.scene.element.into_iter().nth(1) {
            Some(Element::Surface(surface)) => surface.glass.unwrap(),
            other => panic!("{other:?}"),
        }
    };
    let named = |name: &str| Material::Named(name.to_owned());
    assert_eq!(glass("", "NBK7_SCHOTT"), named("SCHOTT:N-BK7"));
    assert_eq!(glass("", "SLAL8_OHARA"), named("OHARA:S-LAL8"));
    assert_eq!(glass("", "f2"), named("SCHOTT:F2"));
    let Material::Own(code) = glass("", "517000.642000") else {
        panic!("no code");
    };
    assert_eq!((code.nd, code.vd), (Some(1.517), Some(64.2)));
    let private = "PRV\nPWL 700 600 500 400\n'Q1' 1.51 1.52 1.53&\n 1.54\nEND\n";
    let Material::Own(own) = glass(private, "'Q1'") else {
        panic!("no table");
    };
    assert_eq!(own.indices, Some(vec![1.54, 1.53, 1.52, 1.51]));
    let text = format!("{HEAD}S 20 3 SK19_Schott\nS 0 9\n");
    let message = refused(&text);
    assert!(
        message.starts_with("a.seq:7:1: found the unknown glass SK19"),
        "{message}"
    );
    for name in ["SK19", "sk19_schott"] {
        let choices = ImportChoices {
            glasses: [(name.to_owned(), "SCHOTT:N-SK16".to_owned())].into(),
            ..ImportChoices::default()
        };
        let report = chosen(&text, &choices).report.to_string();
        assert!(
            report.contains("Glass SK19: SCHOTT:N-SK16 in its place"),
            "{report}"
        );
    }
}

/// Edmund 65-988: the file states where its paraxial image is, with an index that it interpolates in its own way.
#[test]
fn a_hybrid_asphere_focuses_where_its_file_says() {
    let bytes = fs::read(folder().join("CODV_65988.seq")).unwrap();
    let lens = import_bytes(&bytes, Path::new("a.seq"), &ImportChoices::default()).unwrap();
    let number = |word| lens.report.number(word).unwrap();
    let (focus, stated) = (number("back focal distance (mm)"), 12.946_031_272_72);
    assert!((focus - stated).abs() < 5e-5, "{focus}");
    assert!((number("focal length (mm)") - 15.018).abs() < 1e-3);
    let Some(Element::Doe(doe)) = lens.scene.element.first() else {
        panic!("no diffractive surface");
    };
    let Some(Material::Own(own)) = &doe.glass else {
        panic!("no glass");
    };
    let index = own.medium().unwrap().index(587.5618e-6).unwrap();
    for y in [0.5, 2.0, 4.2, 5.9] {
        let [_, found] = landing(&lens, [0.0, y], ALONG);
        assert!((found - hybrid_ray(index, y)).abs() < 1e-11, "{y}: {found}");
    }
}

/// The index of its glass at the wavelength of the phase, and where a ray at height y meets the image: a trace in one plane,
/// written out with the law of gratings, n₂ sin θ₂ = n₁ sin θ₁ + dφ/ds / k along the surface.
fn hybrid_ray(index: f64, y: f64) -> f64 {
    let (c, k) = (1.0 / 9.93, -0.71);
    let powers = [
        -0.1581980090969e-4,
        -0.277_095_174_606_899_9e-6,
        -0.1216086045095e-8,
    ];
    let root = (1.0 - (1.0 + k) * c * c * y * y).sqrt();
    let terms = |f: fn(f64, i32) -> f64| -> f64 {
        powers.iter().zip([4, 6, 8]).map(|(a, p)| a * f(y, p)).sum()
    };
    let sag = c * y * y / (1.0 + root) + terms(|y, p| y.powi(p));
    let slope = c * y / root + terms(|y, p| f64::from(p) * y.powi(p - 1));

    // Along the surface light has sin θ of its angle to the normal; the phase adds its slope by the length along the surface.
    let length = (1.0 + slope * slope).sqrt();
    let before = slope / length;
    let after = (before + 2.0 * -0.001_807_322_521_767_816 * y / length) / index;
    let normal = slope.atan();
    let direction = after.asin() - normal;

    // To the sphere behind it, whose vertex is 3.7 mm further, and through it.
    let (z0, radius) = (sag - 3.7, -48.3);
    let (sin, cos) = direction.sin_cos();
    let along = y * sin + (z0 - radius) * cos;
    let rest = y * y + (z0 - radius).powi(2) - radius * radius;
    let path = -along + (along * along - rest).sqrt();
    let (y, z) = (y + path * sin, z0 + path * cos);
    let normal = -(y / radius).asin();
    let out = (index * (direction - normal).sin()).asin() + normal;
    y + (12.946_031_272_72 - z) * out.tan()
}

/// One design with a phase on a curved front, from a file of CODE V and one of OpticStudio: A_j = 2π C_j ρ^{2j}/λ₀ times the
/// order.
fn in_both_formats() -> [ImportedLens; 2] {
    let (wave, norm, order): (f64, f64, f64) = (587.5618e-6, 2.5, 2.0);
    let coefficients = [-1.8e-3, 3e-6, -4e-8];
    let terms = (1..).zip(coefficients);
    let extra: Vec<String> = terms
        .map(|(j, c)| {
            let radians = std::f64::consts::TAU * c * norm.powi(2 * j) / wave;
            format!("  XDAT {} {radians:e}\n", j + 2)
        })
        .collect();
    let zemax = format!(
        "MODE SEQ\nUNIT MM\nENPD 4\nFTYP 0 0 1 1\nXFLN 0\nYFLN 0\nWAVM 1 0.55 1\nPWAV 1\nSURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  \
         TYPE BINARY_2\n  CURV 0.1\n  CONI -0.7\n  PARM 0 {order}\n  PARM 2 -1e-5\n  XDAT 1 3\n  XDAT 2 {norm}\n{}  GLAS N-BK7\n  DISZ 3\n  DIAM 3 1\n\
         SURF 2\n  CURV -0.02\n  DISZ 12\n  DIAM 3 1\nSURF 3\n  DISZ 0\n",
        extra.concat()
    );
    let codev = format!(
        "RDM\nEPD 4\nWL 550\nYAN 0\nS 10 3 NBK7_SCHOTT\nSTO\nCIR 3\nASP; K -0.7; A -1e-5\nDIF DOE; HOR {order}; HWL 587.5618; HCT R\n\
         HCO C1 {}; HCO C2 {}; HCO C3 {}\nS -50 12\nCIR 3\nSI 0 0\n",
        coefficients[0], coefficients[1], coefficients[2]
    );
    let theirs = import_bytes(
        zemax.as_bytes(),
        Path::new("a.zmx"),
        &ImportChoices::default(),
    )
    .unwrap();
    [imported(&codev), theirs]
}

#[test]
fn a_phase_is_that_of_a_binary_2_surface_ray_by_ray() {
    let both = in_both_formats();
    let [f, g] = (both.each_ref()).map(|lens| lens.report.number("focal length (mm)").unwrap());
    assert!((f / g - 1.0).abs() < 1e-13, "{f} {g}");
    let direction = Vec3::new(0.01, -0.02, (1.0 - 5e-4f64).sqrt());
    for start in [[0.0, 0.0], [1.9, 0.0], [0.4, -1.5]] {
        let [a, b] = both.each_ref().map(|lens| landing(lens, start, direction));
        assert!(
            (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12,
            "{start:?}: {a:?} {b:?}"
        );
    }
}

#[test]
fn a_phase_is_that_of_a_binary_2_surface_in_the_field_slow() {
    let [a, b] = in_both_formats().map(|lens| {
        let made = system(&lens.scene, 0).unwrap();
        let outcome = simulate(&made, &Settings::default(), &|_| {}).unwrap();
        outcome.field.values
    });
    let off = field_error(a.view(), b.view()).unwrap();
    assert!(off < 1e-9, "{off:e}");
}

/// The power of a phase is −2 C₁ at its wavelength, in any unit; a grating turns light by order λ/d.
#[test]
fn phases_bend_light_as_their_numbers_say() {
    for (dim, unit) in [("M", 1.0), ("I", 25.4)] {
        let text = format!(
            "RDM\nDIM {dim}\nEPD {}\nWL 500\nYAN 0\nS 0 {}\nSTO\nDIF DOE; HWL 500; HCT R; HCO C1 {}\n",
            2.0 / unit,
            50.0 / unit,
            -0.01 * unit
        );
        let focal_length = imported(&text).report.number("focal length (mm)").unwrap();
        assert!((focal_length - 50.0).abs() < 1e-10, "{focal_length}");
    }
    let text = format!("{HEAD}S 0 30\nSTO\nDIF GRT; GRO -1; GRS 0.002\n");
    let [x, y] = landing(&imported(&text), [0.0, 0.0], ALONG);
    let sine: f64 = -0.5e-3 / 2e-3;
    let expected = 30.0 * sine / (1.0 - sine * sine).sqrt();
    assert!(
        x.abs() < 1e-12 && (y - expected).abs() < 1e-11,
        "{y} {expected}"
    );
}

#[test]
fn pick_ups_solves_and_zooms_give_values() {
    let number = |lens: &ImportedLens, word| lens.report.number(word).unwrap();
    let plain = imported(&format!("{HEAD}S 30 4 NBK7_SCHOTT\nSTO\nS -60 20\n"));
    let picked = imported(&format!(
        "{HEAD}S 30 4 NBK7_SCHOTT\nSTO\nS 0 0\nPIK RDY S2 RDY S1 -2\nPIM\n"
    ));
    let f = "focal length (mm)";
    assert!((number(&plain, f) / number(&picked, f) - 1.0).abs() < 1e-13);

    // A ray near the axis meets it in the image that PIM sets, behind mirrors too.
    for surfaces in [
        "S 30 4 NBK7_SCHOTT\nSTO\nS -60 0\nPIM\n",
        "S -50 0 REFL\nSTO\nPIM\n",
    ] {
        let lens = imported(&format!("{HEAD}{surfaces}"));
        let [_, y] = landing(&lens, [0.0, 1e-4], ALONG);
        assert!(y.abs() < 1e-12, "{surfaces} {y}");
    }

    let zoom = format!(
        "{HEAD}S 30 4 NBK7_SCHOTT\nSTO\nS -60 20\nZOO 2\nZOO RDY S1 30 45\nZOO EPD 2 3\nZOO THC S1 100 100\n"
    );
    let at = |configuration| {
        let choices = ImportChoices {
            configuration,
            ..ImportChoices::default()
        };
        chosen(&zoom, &choices)
    };
    let other = imported(&format!("{HEAD}S 45 4 NBK7_SCHOTT\nSTO\nS -60 20\n"));
    assert_eq!(number(&at(None), f), number(&plain, f));
    assert_eq!(number(&at(Some(2)), f), number(&other, f));
    assert!((number(&at(Some(2)), "stop radius (mm)") - 1.5).abs() < 1e-12);
    let third = ImportChoices {
        configuration: Some(3),
        ..ImportChoices::default()
    };
    let fault = import_bytes(zoom.as_bytes(), Path::new("a.seq"), &third).unwrap_err();
    assert!(
        fault
            .to_string()
            .contains("2 configurations, and configuration 3 requested")
    );
}

/// Lines behind the head, and how the message begins.
const FAULTS: [(&str, &str); 14] = [
    ("S x 3\nS 0 9\n", "a.seq:7:3: found x"),
    (
        "S 20 3 NBK7_SCHOTT\nQQQ 5\nS 0 9\n",
        "a.seq:8:1: found the unknown command QQQ",
    ),
    (
        "S 20 3 NBK7_SCHOTT\nCIR\nS 0 9\n",
        "a.seq:8:1: found CIR with 0 values",
    ),
    (
        "S 20 3 NBK7_SCHOTT\nRET S1\nS 0 9\n",
        "a.seq:8:1: found RET, the axis of another surface",
    ),
    (
        "S 20 3 REFL\nADE 5; BDE 5; BEN\n",
        "a.seq:8:1: found BEN with more than one",
    ),
    (
        "S 20 3 NBK7_SCHOTT\nSPS ZRN\nS 0 9\n",
        "a.seq:8:5: found a special surface of kind ZRN",
    ),
    (
        "S 20 3 NBK7_SCHOTT\nDIF HOE\nS 0 9\n",
        "a.seq:8:1: found DIF HOE",
    ),
    (
        "S 20 3 NBK7_SCHOTT\nSTO S7\nS 0 9\n",
        "a.seq:8:1: found surface S7",
    ),
    (
        "S 20 3 NBK7_SCHOTT\nS 0 0\nTHI UMY 0.1\n",
        "a.seq:9:1: found a solve of THI",
    ),
    (
        "S 20 3 NBK7_SCHOTT\nPIK RDY S2\nS 0 9\n",
        "a.seq:8:1: found an unknown pick-up",
    ),
    (
        "S 20 3 NBK7_SCHOTT\nZOO 2\nZOO THI S1 1 2 3\n",
        "a.seq:9:1: found 3 values of THI",
    ),
    (
        "S 20 3 NBK7_SCHOTT\nS 0 9\nEPD 0\n",
        "a.seq:9:5: found EPD 0",
    ),
    (
        "S 20 3 NBK7_SCHOTT\nS 0 9\nREF 2\n",
        "a.seq: found wavelength 2 of 1 as reference",
    ),
    (
        "S 20 3 NBK7_SCHOTT\nS 0 9\nSO 0 -3\n",
        "a.seq:9:1: found an object -3 mm before",
    ),
];

#[test]
fn faults_name_the_line() {
    for (surfaces, start) in FAULTS {
        let message = refused(&format!("{HEAD}{surfaces}"));
        assert!(message.starts_with(start), "{message}");
    }
    assert!(refused("").contains("found no surfaces of a lens"));
    let text = format!("{HEAD}S 20 3 NBK7_SCHOTT\nQQQ 5\nS 0 9\n");
    let choices = ImportChoices {
        skip_unknown: true,
        ..ImportChoices::default()
    };
    assert!(chosen(&text, &choices).report.warnings[0].contains("QQQ"));
    let fault = import_bytes(b"", Path::new("a.len"), &ImportChoices::default()).unwrap_err();
    assert!(
        fault.to_string().contains("a file that ends with .len"),
        "{fault}"
    );
}
