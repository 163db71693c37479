//! Tests: surfaces of Zemax files by hand, against the formulas of their types.

use std::path::Path;

use crate::file::prescription::import::{ImportChoices, ImportedLens, import_bytes};
use crate::file::scene::element::Element;
use crate::file::scene::layer::Layer;
use crate::file::scene::surface_shape::SurfaceShape;

/// A file with these records of its first surface, which is its stop, in front of glass; lengths in `unit`.
pub(crate) fn file(unit: &str, records: &str) -> String {
    format!(
        "MODE SEQ\nUNIT {unit} X W X CM MR CPMM\nENPD 2\nFTYP 0 0 1 1 0 0 0\nXFLN 0\nYFLN 0\nWAVM 1 0.5 1\nPWAV 1\n\
         SURF 0\n  TYPE STANDARD\n  DISZ INFINITY\nSURF 1\n  STOP\n{records}  DISZ 3\n  DIAM 1.5 1\n\
         SURF 2\n  TYPE STANDARD\n  CURV 0\n  DISZ 40\n  DIAM 2 1\nSURF 3\n  TYPE STANDARD\n  DISZ 0\n"
    )
}

/// The lens of a text.
pub(crate) fn imported(text: &str) -> ImportedLens {
    let lens = import_bytes(
        text.as_bytes(),
        Path::new("a.zmx"),
        &ImportChoices::default(),
    );
    lens.unwrap_or_else(|fault| panic!("{fault}\n{text}"))
}

/// The message of a text that is refused.
pub(crate) fn refused(text: &str) -> String {
    let lens = import_bytes(
        text.as_bytes(),
        Path::new("a.zmx"),
        &ImportChoices::default(),
    );
    lens.unwrap_err().to_string()
}

/// The height of the first surface of a file at (x, y) in mm.
pub(crate) fn sag(unit: &str, records: &str, [x, y]: [f64; 2]) -> f64 {
    let lens = imported(&file(unit, records));
    let keys: Option<SurfaceShape<'_>> = match lens.scene.element.first() {
        Some(Element::Surface(surface)) => Some(surface.surface_shape()),
        Some(Element::Doe(doe)) => Some(doe.surface_shape()),
        _ => None,
    };
    keys.unwrap().optics(None).unwrap().sag(x, y).unwrap()
}

pub(crate) const GLASS: &str = "  GLAS N-BK7 0 0 1.5 40\n";

pub(crate) fn conic(curvature: f64, constant: f64, r2: f64) -> f64 {
    curvature * r2 / (1.0 + (1.0 - (1.0 + constant) * curvature * curvature * r2).sqrt())
}

#[track_caller]
pub(crate) fn agree(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() < 1e-13 * expected.abs().max(1.0),
        "{found} {expected}"
    );
}

const POINTS: [[f64; 2]; 3] = [[0.7, 0.0], [0.0, -0.9], [0.6, 0.8]];

#[test]
fn powers_of_the_radius_have_their_coefficients() {
    let base = format!("  CURV 0.1\n  CONI -0.6\n{GLASS}");
    let parameters: String = (1..=8)
        .map(|i| format!("  PARM {i} {}\n", 1e-3 / f64::from(i)))
        .collect();
    let extra: String = (1..=5)
        .map(|i| format!("  XDAT {} {}\n", i + 2, 2e-3 / f64::from(i)))
        .collect();
    let extra = format!("  XDAT 1 5\n  XDAT 2 1.25\n{extra}");
    for at in POINTS {
        let r2: f64 = at[0] * at[0] + at[1] * at[1];
        let ground = conic(0.1, -0.6, r2);
        let sum = |step: i32, scale: f64, count: i32, radius: f64| -> f64 {
            let term = |i: i32| scale / f64::from(i) * (r2.sqrt() / radius).powi(step * i);
            (1..=count).map(term).sum()
        };
        for (kind, records, expected) in [
            ("STANDARD", "", 0.0),
            ("EVENASPH", parameters.as_str(), sum(2, 1e-3, 8, 1.0)),
            ("ODDASPHE", parameters.as_str(), sum(1, 1e-3, 8, 1.0)),
            ("XASPHERE", extra.as_str(), sum(2, 2e-3, 5, 1.25)),
            ("XOSPHERE", extra.as_str(), sum(1, 2e-3, 5, 1.25)),
        ] {
            let records = format!("  TYPE {kind}\n{base}{records}");
            agree(sag("MM", &records, at), ground + expected);
        }
    }
}

#[test]
fn products_of_powers_have_their_order() {
    let powers: [[i32; 2]; 9] = [
        [1, 0],
        [0, 1],
        [2, 0],
        [1, 1],
        [0, 2],
        [3, 0],
        [2, 1],
        [1, 2],
        [0, 3],
    ];
    let extra: String = (1..=9)
        .map(|i| format!("  XDAT {} {}\n", i + 2, 1e-3 * f64::from(i)))
        .collect();
    let records = format!("  TYPE XPOLYNOM\n  CURV 0.05\n{GLASS}  XDAT 1 9\n  XDAT 2 2\n{extra}");
    for at in POINTS {
        let [x, y] = at.map(|a| a / 2.0);
        let terms = (1..)
            .zip(powers)
            .map(|(i, [p, q])| 1e-3 * f64::from(i) * x.powi(p) * y.powi(q));
        let r2 = at[0] * at[0] + at[1] * at[1];
        agree(
            sag("MM", &records, at),
            conic(0.05, 0.0, r2) + terms.sum::<f64>(),
        );
    }
}

#[test]
fn surfaces_with_two_curvatures_keep_their_axes() {
    let biconic =
        format!("  TYPE BICONICX\n  CURV 0.1\n  CONI -0.5\n  PARM 1 20\n  PARM 2 0.3\n{GLASS}");
    let cylinder = format!(
        "  TYPE TOROIDAL\n  CURV 0.1\n  CONI -0.5\n  PARM 1 0\n  PARM 3 1e-3\n  PARM 4 -2e-4\n{GLASS}"
    );
    let toroid = format!("  TYPE TOROIDAL\n  CURV 0.1\n  PARM 1 20\n  PARM 3 1e-3\n{GLASS}");
    // A term of y² beside a parabola, and one without a curvature.
    let parabola = format!("  TYPE TOROIDAL\n  CURV 0.06\n  CONI -1\n  PARM 2 0.02\n{GLASS}");
    let square = format!("  TYPE TOROIDAL\n  PARM 2 0.05\n{GLASS}");
    for [x, y] in POINTS {
        agree(sag("MM", &parabola, [x, y]), 0.05 * y * y);
        agree(sag("MM", &square, [x, y]), 0.05 * y * y);
        let both = 0.05 * x * x + 0.1 * y * y;
        let root = 1.0 - 1.3 * 0.0025 * x * x - 0.5 * 0.01 * y * y;
        agree(sag("MM", &biconic, [x, y]), both / (1.0 + root.sqrt()));
        let straight = conic(0.1, -0.5, y * y) + 1e-3 * y.powi(4) - 2e-4 * y.powi(6);
        agree(sag("MM", &cylinder, [x, y]), straight);

        // The curve over y, turned about an axis 20 mm behind the vertex.
        let curve = conic(0.1, 0.0, y * y) + 1e-3 * y.powi(4);
        agree(
            sag("MM", &toroid, [x, y]),
            20.0 - ((20.0 - curve).powi(2) - x * x).sqrt(),
        );
    }
}

/// A lens of half the size written in centimetres, inches and metres: the sag scales with the unit.
#[test]
fn every_number_has_its_unit() {
    let coefficients = "  PARM 1 0.01\n  PARM 2 0.02\n  PARM 3 0.003\n";
    let extended = "  XDAT 1 2\n  XDAT 2 0.9\n  XDAT 3 0.01\n  XDAT 4 0.02\n";
    for (kind, records) in [
        ("EVENASPH", coefficients),
        ("ODDASPHE", coefficients),
        ("XASPHERE", extended),
        ("XPOLYNOM", extended),
        ("TOROIDAL", "  PARM 1 7\n  PARM 3 0.01\n"),
        ("BICONICX", "  PARM 1 7\n  PARM 2 0.2\n"),
    ] {
        let records = format!("  TYPE {kind}\n  CURV 0.1\n{GLASS}{records}");
        let expected = sag("MM", &records, [0.3, 0.4]);
        for (unit, mm) in [("CM", 10.0), ("IN", 25.4), ("METER", 1000.0)] {
            let found = sag(unit, &records, [0.3 * mm, 0.4 * mm]);
            assert!(
                (found / mm - expected).abs() < 1e-12,
                "{kind} {unit}: {found} {expected}"
            );
        }
    }
}

fn layers(records: &str) -> Vec<Layer> {
    let lens = imported(&file("MM", records));
    match lens.scene.element.into_iter().next() {
        Some(Element::Doe(doe)) => doe.layer,
        other => panic!("{other:?}"),
    }
}

#[test]
fn phases_have_their_order_radius_and_coefficients() {
    let binary = "  XDAT 1 3\n  XDAT 2 1.2\n  XDAT 3 -40\n  XDAT 4 5\n  XDAT 5 0.25\n";
    let records =
        format!("  TYPE BINARY_2\n  CURV 0.1\n  PARM 0 2\n  PARM 2 1e-3\n{GLASS}{binary}");
    let [Layer::Radial(radial)] = &layers(&records)[..] else {
        panic!("no radial layer");
    };
    assert_eq!(radial.norm_radius_mm, 1.2);
    assert_eq!(radial.coefficients, [-80.0, 10.0, 0.5]);
    agree(sag("MM", &records, [0.6, 0.8]), conic(0.1, 0.0, 1.0) + 1e-3);

    let records = format!("  TYPE BINARY_1\n  PARM 0 -1\n{GLASS}{binary}");
    let [Layer::Polynomial(sum)] = &layers(&records)[..] else {
        panic!("no polynomial");
    };
    let terms: Vec<_> = sum
        .terms
        .iter()
        .map(|term| (term.x, term.y, term.coefficient))
        .collect();
    assert_eq!(terms, [(1, 0, 40.0), (0, 1, -5.0), (2, 0, -0.25)]);

    let records = format!("  TYPE DGRATING\n  PARM 1 0.2\n  PARM 2 -1\n{GLASS}");
    let [Layer::Grating(grating)] = &layers(&records)[..] else {
        panic!("no grating");
    };
    assert_eq!(
        (grating.period_um, grating.direction_deg, grating.order),
        (5.0, 90.0, -1)
    );
}

/// φ = A (r/ρ)² has the focal length −π ρ²/(A λ), by the elements of the scene as by the unfolded axis.
#[test]
fn negative_phases_converge() {
    let records = "  TYPE BINARY_2\n  PARM 0 1\n  XDAT 1 1\n  XDAT 2 2\n  XDAT 3 -100\n";
    let report = imported(&file("MM", records)).report;
    let expected = std::f64::consts::PI * 4.0 / (100.0 * 0.5e-3);
    for name in ["focal length (mm)", "focal length, axis unfolded (mm)"] {
        let found = report.number(name).unwrap();
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{name}: {found} {expected}"
        );
    }
}

#[test]
fn what_has_no_counterpart_is_refused_with_its_line() {
    for (records, found) in [
        (
            "  TYPE TOROIDAL\n  CURV 0.1\n  PARM 2 1e-3\n",
            "a coefficient of y² = 0.001 on a toroid",
        ),
        (
            "  TYPE TOROIDAL\n  XDAT 1 1\n  XDAT 2 1\n  XDAT 3 1\n",
            "Zernike terms",
        ),
        (
            "  TYPE XASPHERE\n  PARM 2 1\n",
            "parameter 2 = 1 on a surface of type XASPHERE",
        ),
        ("  TYPE XASPHERE\n  XDAT 1 1e9\n", "1000000000 terms"),
        (
            "  TYPE XASPHERE\n  XDAT 1 1\n  XDAT 3 1\n",
            "a norm radius of 0 mm",
        ),
        ("  TYPE PARAXIAL\n  PARM 1 0\n", "a focal length of 0 mm"),
        (
            "  TYPE DGRATING\n  PARM 2 0.5\n",
            "a diffraction order of 0.5",
        ),
        ("  TYPE CHEBYSHV\n", "a surface of type CHEBYSHV"),
    ] {
        let message = refused(&file("MM", records));
        assert!(message.starts_with("a.zmx:14:3: found "), "{message}");
        assert!(message.contains(found), "{message}");
    }
}
