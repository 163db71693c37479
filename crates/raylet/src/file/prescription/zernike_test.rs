//! Tests: Zernike surfaces and phases of Zemax and CODE V files, against their formulas and what OpticStudio stored.

use std::f64::consts::TAU;
use std::path::Path;

use crate::file::prescription::import::{ImportChoices, ImportedLens, import_bytes};
use crate::file::prescription::shapes_test::{GLASS, agree, conic, file, imported, refused, sag};
use crate::file::scene::element::Element;
use crate::file::scene::layer::Layer;
use crate::optics::zernike::ZernikeSum;

/// A coefficient of each polynomial: 1/(j + 1) with alternating signs, in thousandths.
fn coefficient(number: i32) -> f64 {
    1e-3 / f64::from(number + 1) * if number % 2 == 0 { 1.0 } else { -1.0 }
}

/// Extra data of a series of so many terms with these coefficients.
fn terms(count: i32, radius: f64) -> String {
    let list = (1..=count).map(|j| format!("  XDAT {} {}\n", j + 2, coefficient(j)));
    format!(
        "  XDAT 1 {count}\n  XDAT 2 {radius}\n{}",
        list.collect::<String>()
    )
}

/// Standard polynomials 1 to 14 as OpticStudio prints them in its lists of coefficients.
fn standard(number: i32, p: f64, a: f64) -> f64 {
    let (c, s) = (|m: f64| (m * a).cos(), |m: f64| (m * a).sin());
    let root = f64::sqrt;
    match number {
        1 => 1.0,
        2 => root(4.0) * p * c(1.0),
        3 => root(4.0) * p * s(1.0),
        4 => root(3.0) * (2.0 * p.powi(2) - 1.0),
        5 => root(6.0) * p.powi(2) * s(2.0),
        6 => root(6.0) * p.powi(2) * c(2.0),
        7 => root(8.0) * (3.0 * p.powi(3) - 2.0 * p) * s(1.0),
        8 => root(8.0) * (3.0 * p.powi(3) - 2.0 * p) * c(1.0),
        9 => root(8.0) * p.powi(3) * s(3.0),
        10 => root(8.0) * p.powi(3) * c(3.0),
        11 => root(5.0) * (6.0 * p.powi(4) - 6.0 * p.powi(2) + 1.0),
        12 => root(10.0) * (4.0 * p.powi(4) - 3.0 * p.powi(2)) * c(2.0),
        13 => root(10.0) * (4.0 * p.powi(4) - 3.0 * p.powi(2)) * s(2.0),
        _ => root(10.0) * p.powi(4) * c(4.0),
    }
}

/// Fringe polynomials 1 to 9.
fn fringe(number: i32, p: f64, a: f64) -> f64 {
    let (c, s) = (|m: f64| (m * a).cos(), |m: f64| (m * a).sin());
    match number {
        1 => 1.0,
        2 => p * c(1.0),
        3 => p * s(1.0),
        4 => 2.0 * p.powi(2) - 1.0,
        5 => p.powi(2) * c(2.0),
        6 => p.powi(2) * s(2.0),
        7 => (3.0 * p.powi(3) - 2.0 * p) * c(1.0),
        8 => (3.0 * p.powi(3) - 2.0 * p) * s(1.0),
        _ => 6.0 * p.powi(4) - 6.0 * p.powi(2) + 1.0,
    }
}

/// The sum of coefficients times polynomials at (x, y).
fn sum(count: i32, radius: f64, [x, y]: [f64; 2], of: fn(i32, f64, f64) -> f64) -> f64 {
    let (p, a) = (x.hypot(y) / radius, y.atan2(x));
    (1..=count).map(|j| coefficient(j) * of(j, p, a)).sum()
}

const POINTS: [[f64; 2]; 4] = [[0.7, 0.0], [0.0, -0.9], [0.6, 0.8], [-1.3, 0.4]];

#[test]
fn surfaces_are_even_aspheres_with_polynomials() {
    let asphere: String = (1..=8)
        .map(|i| format!("  PARM {i} {}\n", 1e-3 / f64::from(i)))
        .collect();
    let base = format!("  CURV 0.1\n  CONI -0.6\n{GLASS}  PARM 0 1\n{asphere}");
    for at in POINTS {
        let r2 = at[0] * at[0] + at[1] * at[1];
        let even: f64 = (1..=8).map(|i| 1e-3 / f64::from(i) * r2.powi(i)).sum();
        let ground = conic(0.1, -0.6, r2) + even;
        let standards = format!("  TYPE SZERNSAG\n{base}{}", terms(14, 1.7));
        agree(
            sag("MM", &standards, at),
            ground + sum(14, 1.7, at, standard),
        );
        let fringes = format!("  TYPE FZERNSAG\n{base}{}", terms(9, 1.7));
        agree(sag("MM", &fringes, at), ground + sum(9, 1.7, at, fringe));
        // Without terms nothing is left but the asphere.
        let none = format!("  TYPE FZERNSAG\n{base}  XDAT 1 8\n  XDAT 2 0\n");
        agree(sag("MM", &none, at), ground);

        // The same lens of half the size in inches has half of every height.
        let inches = at.map(|a| a * 25.4);
        agree(
            sag("IN", &standards, inches) / 25.4,
            sag("MM", &standards, at),
        );
    }
}

#[test]
fn codev_has_the_same_fringe_surfaces() {
    let coefficients: String = (1..=9)
        .map(|j| format!("SCO C{} {}\n", j + 3, coefficient(j)))
        .collect();
    for radius in ["SCO NRADIUS 1.7", "SCO C3 1.7"] {
        let text = format!(
            "RDM; LEN\nEPD 2\nDIM M\nWL 500\nYAN 0\nSO 0 1e13\nS 10 3 NBK7_SCHOTT\nSTO\nCIR 1.5\n\
             SPS ZFR; SCO K -0.6\n{radius}\n{coefficients}S 0 40\nSI 0 0\n"
        );
        let lens = import_bytes(
            text.as_bytes(),
            Path::new("a.seq"),
            &ImportChoices::default(),
        );
        let lens = lens.unwrap_or_else(|fault| panic!("{fault}"));
        let Some(Element::Surface(surface)) = lens
            .scene
            .element
            .iter()
            .find(|element| matches!(element, Element::Surface(one) if one.shape.is_some()))
        else {
            panic!("{:?}", lens.scene.element);
        };
        let shape = surface.surface_shape().optics(None).unwrap();
        for at in POINTS {
            let r2 = at[0] * at[0] + at[1] * at[1];
            let expected = conic(0.1, -0.6, r2) + sum(9, 1.7, at, fringe);
            agree(shape.sag(at[0], at[1]).unwrap(), expected);
        }
    }
}

/// Defocus has the power of the sphere with its curvature, by the elements of the scene as by the unfolded axis.
#[test]
fn curvatures_of_polynomials_count_in_first_order() {
    let focal_lengths = |records: &str| {
        let report = imported(&file("MM", &format!("{GLASS}{records}"))).report;
        ["focal length (mm)", "focal length, axis unfolded (mm)"].map(|name| report.number(name))
    };
    let sphere = focal_lengths("  TYPE STANDARD\n  CURV 0.05\n").map(Option::unwrap);
    // √3 · 2 a/ρ² r² and √6 a/ρ² (x² − y²): half the curvature along y each.
    let [a, b] = [
        0.0125 * 4.0 / (2.0 * 3f64.sqrt()),
        -0.0125 * 4.0 / 6f64.sqrt(),
    ];
    let zernike = format!(
        "  TYPE SZERNSAG\n  PARM 0 1\n  XDAT 1 6\n  XDAT 2 2\n  XDAT 6 {a}\n  XDAT 8 {b}\n"
    );
    let mixed = format!("{zernike}  CURV 0.01\n  PARM 1 -0.005\n");
    for records in [&zernike, &mixed] {
        let found = focal_lengths(records);
        // A lens without symmetry has no focal length by its elements.
        let unfolded = found[1].unwrap();
        assert!(
            (unfolded / sphere[1] - 1.0).abs() < 1e-12,
            "{found:?} {sphere:?}"
        );
    }
    let square = focal_lengths(
        "  TYPE SZERNSAG\n  PARM 1 0.01\n  XDAT 1 1\n  XDAT 2 2\n  XDAT 3 1e-3\n  CURV 0.03\n",
    );
    let found = square[1].unwrap();
    assert!(
        (found / sphere[1] - 1.0).abs() < 1e-9,
        "{square:?} {sphere:?}"
    );
}

fn phase(lens: &ImportedLens) -> Vec<f64> {
    match lens.scene.element.first() {
        Some(Element::Doe(doe)) => match &doe.layer[..] {
            [Layer::Zernike(layer)] => layer.coefficients.clone(),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

#[test]
fn phases_are_waves_times_the_order() {
    let records = format!("  PARM 0 -2\n{}", terms(4, 1.7));
    let standard = phase(&imported(&file(
        "MM",
        &format!("  TYPE SZERNPHA\n{records}"),
    )));
    let fringe = phase(&imported(&file(
        "MM",
        &format!("  TYPE FZERNPHA\n{records}"),
    )));
    for (j, factor) in [(1, 1.0), (2, 2.0), (3, 2.0), (4, 3f64.sqrt())] {
        let place = j as usize - 1;
        agree(standard[place], -2.0 * TAU * coefficient(j));
        agree(fringe[place], -2.0 * TAU * coefficient(j) / factor);
    }
}

/// A cylindrical phase of 0.735 waves at the rim before an ideal lens of 100 mm. For this system OpticStudio stores
/// 0.04042500330309 mm as the height of its tangential rays at 100 mm, and 0.001233503369149 mm at 102 mm: this settles the unit,
/// the sign and the angle. Its ideal lens keeps tangents, that of raylet sines; so the phase alone is taken from the scene.
#[test]
fn phases_turn_rays_as_opticstudio_stored() {
    let text = "MODE SEQ\nUNIT MM X W X CM MR CPMM\nENPD 4\nFTYP 0 0 1 1\nXFLN 0\nYFLN 0\nWAVM 1 0.55 1\nPWAV 1\n\
                SURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  TYPE FZERNPHA\n  PARM 0 1\n  PARM 1 0\n  XDAT 1 9\n  XDAT 2 4\n\
                \x20 XDAT 3 0.735\n  XDAT 6 0.735\n  XDAT 7 -1.47\n  DISZ 0\n  DIAM 2\nSURF 2\n  TYPE PARAXIAL\n  PARM 1 100\n\
                \x20 DISZ 100\n  DIAM 2\nSURF 3\n  DISZ 0\n";
    let phase = ZernikeSum::new(4.0, phase(&imported(text)));
    // The phase is quadratic: a central difference is its slope.
    let slope = |at: fn(f64) -> [f64; 2]| {
        let value = |aside: f64| phase.at(at(aside)[0], at(aside)[1]);
        (value(0.5) - value(-0.5)) * 0.55e-3 / TAU
    };
    let across = slope(|aside| [aside, 2.0]);
    let sine = slope(|aside| [0.0, 2.0 + aside]);
    assert!(across.abs() < 1e-15, "{across}");
    let tangent = sine / (1.0 - sine * sine).sqrt();
    for (distance, stored) in [(100.0, 4.042_500_330_309e-2), (102.0, 1.233_503_369_149e-3)] {
        let y = 2.0 + distance * (tangent - 2.0 / 100.0);
        assert!((y - stored).abs() < 1e-12, "{y} {stored}");
    }
}

#[test]
fn terms_that_opticstudio_ends_are_warned_of() {
    let report = |records: &str| imported(&file("MM", records)).report.to_string();
    let sentence = "Surface 1: its Zernike terms go on beyond 1.2 mm from the axis";
    for (kind, flag) in [("SZERNSAG", 0), ("FZERNPHA", 1)] {
        let records = format!("  TYPE {kind}\n{GLASS}{}", terms(4, 1.2));
        assert!(report(&records).contains(sentence), "{}", report(&records));
        let beyond = format!("{records}  PARM {flag} 1\n");
        assert!(!report(&beyond).contains(sentence));
        // The surface of the file has a semi-diameter of 1.5 mm.
        let wide = format!("  TYPE {kind}\n{GLASS}{}", terms(4, 1.5));
        assert!(!report(&wide).contains("go on beyond"));
    }
}

#[test]
fn what_has_no_counterpart_is_refused() {
    let many = format!("  TYPE FZERNSAG\n{}", terms(38, 1.0));
    for (records, found) in [
        (
            many.as_str(),
            "38 Zernike terms, on surface 1, expected at most 37",
        ),
        (
            &format!("  TYPE SZERNSAG\n  PARM 10 0.5\n{}", terms(4, 1.0)),
            "Zernike terms that are shifted by [0.0, 0.5]",
        ),
        (
            &format!("  TYPE SZERNPHA\n  PARM 3 1\n{}", terms(4, 1.0)),
            "parameter 3 = 1 on a surface of type SZERNPHA",
        ),
        (
            &format!("  TYPE SZERNPHA\n  PARM 0 0.5\n{}", terms(4, 1.0)),
            "a diffraction order of 0.5 as parameter 0",
        ),
    ] {
        let message = refused(&file("MM", records));
        assert!(message.starts_with("a.zmx:14:3: found "), "{message}");
        assert!(message.contains(found), "{message}");
    }
}
