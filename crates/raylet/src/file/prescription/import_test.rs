//! Tests: whole Zemax files by hand, their axes, apertures, fields, glasses and faults.

use std::path::Path;

use crate::file::model::build::system;
use crate::file::prescription::import::{ImportChoices, ImportedLens, import_bytes, import_lens};
use crate::file::prescription::optiland_test::folder;
use crate::file::prescription::scene_text::concise_toml;
use crate::file::prescription::shapes_test::{file, imported, refused};
use crate::file::scene::element::Element;
use crate::file::scene::illumination::Illumination;
use crate::file::scene::material::Material;
use crate::file::scene::scene_file::Scene;
use crate::math::vec3::Vec3;

/// A thin-walled system: a header, then surfaces as they stand here.
fn system_of(header: &str, surfaces: &str) -> String {
    let waves = "WAVM 1 0.5 1\nWAVM 2 0.6 1\nPWAV 1\n";
    format!("MODE SEQ\nUNIT MM X W X CM MR CPMM\n{header}\n{waves}{surfaces}")
}

const IDEAL: &str = "SURF 0\n  DISZ INFINITY\nSURF 1\n  DISZ 7\nSURF 2\n  STOP\n  DISZ 10\n  DIAM 1.7 1\nSURF 3\n  TYPE PARAXIAL\n  \
    PARM 1 50\n  PARM 2 1\n  DISZ 50\n  DIAM 4 1\nSURF 4\n  DISZ 0\n";

fn at_field(text: &str, field: usize) -> ImportedLens {
    let choices = ImportChoices {
        field,
        ..ImportChoices::default()
    };
    let lens = import_bytes(text.as_bytes(), Path::new("a.zmx"), &choices);
    lens.unwrap_or_else(|fault| panic!("{fault}"))
}

fn stop_radius(scene: &Scene) -> f64 {
    let stop = scene.element.iter().find_map(|element| match element {
        Element::Stop(stop) if stop.name.as_deref() == Some("stop") => stop.aperture.disc.as_ref(),
        _ => None,
    });
    stop.unwrap().radius_mm
}

#[test]
fn every_kind_of_aperture_sets_the_stop() {
    let half_angle = 0.1f64.asin();
    let near = IDEAL.replace("INFINITY", "30");
    for (record, surfaces, expected) in [
        ("ENPD 3", IDEAL, 1.5),
        ("FNUM 20 0", IDEAL, 1.25),
        ("FNUM 20 1", IDEAL, 1.25),
        ("FLOA", IDEAL, 1.7),
        ("OBNA 0.1 0", near.as_str(), 37.0 * half_angle.tan()),
        ("OBNA 2 1", near.as_str(), 37.0 * 2f64.to_radians().tan()),
    ] {
        let text = system_of(&format!("{record}\nFTYP 0 0 1 2\nXFLN 0\nYFLN 0"), surfaces);
        let lens = imported(&text);
        let found = stop_radius(&lens.scene);
        assert!(
            (found - expected).abs() < 1e-12,
            "{record}: {found} {expected}"
        );
    }
}

#[test]
fn fields_are_directions_or_points_as_they_are_written() {
    // Tangents of both angles are slopes; the scene has the sines of its angles as direction cosines.
    let angles = system_of("ENPD 3\nFTYP 0 0 2 2\nXFLN 0 3\nYFLN 0 4", IDEAL);
    let Illumination::Plane(plane) = at_field(&angles, 2).scene.source else {
        panic!("no plane wave");
    };
    let [p, q] = plane.angle_deg.map(|angle| angle.to_radians().sin());
    let r = (1.0 - p * p - q * q).sqrt();
    assert!((p / r - 3f64.to_radians().tan()).abs() < 1e-14);
    assert!((q / r - 4f64.to_radians().tan()).abs() < 1e-14);

    // An ideal lens has its chief ray through the middle of the stop; the image is at the height f tan θ.
    let images = system_of("ENPD 3\nFTYP 2 0 1 2\nXFLN 1\nYFLN -2", IDEAL);
    let Illumination::Plane(plane) = imported(&images).scene.source else {
        panic!("no plane wave");
    };
    let [p, q] = plane.angle_deg.map(|angle| angle.to_radians().sin());
    let r = (1.0 - p * p - q * q).sqrt();
    assert!((p / r - 1.0 / 50.0).abs() < 1e-14 && (q / r + 2.0 / 50.0).abs() < 1e-14);

    // The point stands before the first surface; angles are those at the entrance pupil, 7 mm behind it.
    let near = IDEAL.replace("INFINITY", "30");
    for (kind, field, expected) in [
        (1, "XFLN 1.5\nYFLN -2", [1.5, -2.0, -37.0]),
        (
            0,
            "XFLN 0\nYFLN 5",
            [0.0, -37.0 * 5f64.to_radians().tan(), -37.0],
        ),
    ] {
        let text = system_of(&format!("ENPD 3\nFTYP {kind} 0 1 2\n{field}"), &near);
        let Illumination::Point(point) = imported(&text).scene.source else {
            panic!("no point");
        };
        for (found, expected) in point.position_mm.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{:?}", point.position_mm);
        }
    }
}

/// Where the last element stands and looks, behind a coordinate break with all its numbers.
fn turned(order: u8) -> (Vec3, Vec3) {
    let turn = format!(
        "SURF 2\n  TYPE COORDBRK\n  PARM 1 0.5\n  PARM 2 -0.25\n  PARM 3 10\n  PARM 4 -20\n  PARM 5 30\n  PARM 6 {order}\n  DISZ 8\n"
    );
    let surfaces = format!(
        "SURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  DISZ 5\n{turn}SURF 3\n  CLAP 0 9\n  DISZ 2\nSURF 4\n  DISZ 0\n"
    );
    let text = system_of("ENPD 3\nFTYP 0 0 1 2\nXFLN 0\nYFLN 0", &surfaces);
    let made = system(&imported(&text).scene, 0).unwrap();
    let frame = made.screens[1].frame;
    (frame.origin, frame.z)
}

#[test]
fn coordinate_breaks_keep_signs_and_order() {
    let [x, y, z] = [10f64, -20.0, 30.0].map(f64::to_radians);
    // Right-handed turns about fixed axes, as matrices on columns.
    let about_x = |v: Vec3| {
        Vec3::new(
            v.x,
            v.y * x.cos() - v.z * x.sin(),
            v.y * x.sin() + v.z * x.cos(),
        )
    };
    let about_y = |v: Vec3| {
        Vec3::new(
            v.x * y.cos() + v.z * y.sin(),
            v.y,
            -v.x * y.sin() + v.z * y.cos(),
        )
    };
    let about_z = |v: Vec3| {
        Vec3::new(
            v.x * z.cos() - v.y * z.sin(),
            v.x * z.sin() + v.y * z.cos(),
            v.z,
        )
    };
    let (shift, along) = (Vec3::new(0.5, -0.25, 0.0), Vec3::new(0.0, 0.0, 1.0));
    let start = Vec3::new(0.0, 0.0, 5.0);

    // Shift, then x, new y, new z: the last turn comes first for a vector on the new axes.
    let inner = |v: Vec3| about_x(about_y(about_z(v)));
    let (origin, axis) = turned(0);
    assert!((axis - inner(along)).norm() < 1e-14);
    assert!((origin - (start + shift + inner(along) * 8.0)).norm() < 1e-13);

    // Turns about z, new y, new x, then the shift along the new axes.
    let outer = |v: Vec3| about_z(about_y(about_x(v)));
    let (origin, axis) = turned(1);
    assert!((axis - outer(along)).norm() < 1e-14);
    assert!((origin - (start + outer(shift) + outer(along) * 8.0)).norm() < 1e-13);
}

/// A fold mirror at 45°: the light goes to +y behind it for positive tilts about x.
#[test]
fn mirrors_turn_the_light_back() {
    let turn = "  TYPE COORDBRK\n  PARM 3 45\n";
    let surfaces = format!(
        "SURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  DISZ 20\nSURF 2\n{turn}SURF 3\n  GLAS MIRROR 0 0 1.5 40\n  DIAM 5 1\n\
         SURF 4\n{turn}  DISZ -30\nSURF 5\n  DISZ 0\n"
    );
    let text = system_of("ENPD 3\nFTYP 0 0 1 2\nXFLN 0\nYFLN 0", &surfaces);
    let made = system(&imported(&text).scene, 0).unwrap();
    let sensor = made.screens.last().unwrap().frame;
    assert!(
        (sensor.origin - Vec3::new(0.0, 30.0, 20.0)).norm() < 1e-13,
        "{:?}",
        sensor.origin
    );
}

#[test]
fn apertures_have_their_shape_and_place() {
    let surfaces = |records: &str| {
        format!(
            "SURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  DISZ 5\nSURF 2\n  DIAM 4 1\n{records}  DISZ 50\nSURF 3\n  DISZ 0\n"
        )
    };
    let contains = |records: &str, at: [f64; 2]| {
        let text = system_of("ENPD 3\nFTYP 0 0 1 2\nXFLN 0\nYFLN 0", &surfaces(records));
        let Some(Element::Stop(stop)) = imported(&text).scene.element.into_iter().nth(1) else {
            panic!("no second stop");
        };
        stop.aperture.optics().contains(at[0], at[1])
    };
    for (records, inside, outside) in [
        ("  CLAP 0 2\n", [1.9, 0.0], [2.1, 0.0]),
        ("  CLAP 1 2\n", [1.1, 0.0], [0.9, 0.0]),
        ("  OBSC 0 1\n", [1.1, 0.0], [0.9, 0.0]),
        ("  OBSC 0 1\n", [3.9, 0.0], [4.1, 0.0]),
        ("  SQAP 1 2\n", [0.9, 1.9], [1.1, 0.0]),
        ("  SQOB 1 2\n", [1.1, 0.0], [0.9, 1.9]),
        ("  ELAP 1 2\n", [0.0, 1.99], [1.01, 0.0]),
        ("  ELOB 1 2\n", [1.01, 0.0], [0.0, 1.99]),
        ("  CLAP 0 1\n  OBDC 2 -1\n", [2.9, -1.0], [0.5, 0.0]),
    ] {
        assert!(
            contains(records, inside) && !contains(records, outside),
            "{records}"
        );
    }
}

#[test]
fn glasses_are_found_stated_or_refused() {
    let glass = |record: &str| {
        let lens = imported(&file("MM", &format!("  CURV 0.1\n  GLAS {record}\n")));
        match lens.scene.element.into_iter().next() {
            Some(Element::Surface(surface)) => surface.glass.unwrap(),
            other => panic!("{other:?}"),
        }
    };
    let named = |name: &str| Material::Named(name.to_owned());
    assert_eq!(glass("N-BK7 0 0 1.5 40 0 0"), named("SCHOTT:N-BK7"));
    assert_eq!(glass("BK7 0 0 0 0"), named("SCHOTT:N-BK7"));
    let code = |material: Material| match material {
        Material::Own(own) => (own.index, own.nd, own.vd),
        other => panic!("{other:?}"),
    };
    assert_eq!(
        code(glass("___BLANK 1 0 1.62 36.3 0")),
        (None, Some(1.62), Some(36.3))
    );
    assert_eq!(code(glass("___BLANK 1 0 1.5 0 0")), (Some(1.5), None, None));
    assert_eq!(
        code(glass("QZ-99 0 0 1.601 50.3")),
        (None, Some(1.601), Some(50.3))
    );
    let (_, nd, vd) = code(glass("517642"));
    assert!((nd.unwrap() - 1.517).abs() < 1e-12 && (vd.unwrap() - 64.2).abs() < 1e-12);

    for record in ["N-BK77", "N-BK77 0 0 1.5 40", "N-BK77 0 0 0 0"] {
        let message = refused(&file("MM", &format!("  CURV 0.1\n  GLAS {record}\n")));
        assert!(
            message.starts_with("a.zmx:15:3: found the unknown glass N-BK77"),
            "{message}"
        );
        assert!(message.contains("SCHOTT:N-BK7"), "{message}");
    }
}

#[test]
fn glasses_are_replaced_on_request() {
    let text = file("MM", "  CURV 0.1\n  GLAS QZ-99\n");
    let glasses = [("QZ-99".to_owned(), "N-SF6".to_owned())].into();
    let choices = ImportChoices {
        glasses,
        ..ImportChoices::default()
    };
    let lens = import_bytes(text.as_bytes(), Path::new("a.zmx"), &choices).unwrap();
    assert!(
        lens.report
            .to_string()
            .contains("Glass QZ-99: SCHOTT:N-SF6 in its place")
    );
}

#[test]
fn unknown_surfaces_are_planes_on_request() {
    let text = file("MM", "  TYPE IRREGULA\n  CURV 0.1\n  GLAS N-BK7\n");
    let choices = ImportChoices {
        skip_unknown: true,
        ..ImportChoices::default()
    };
    let lens = import_bytes(text.as_bytes(), Path::new("a.zmx"), &choices).unwrap();
    let Some(Element::Surface(surface)) = lens.scene.element.first() else {
        panic!("no surface");
    };
    assert_eq!(surface.radius_mm, None);
    assert!(lens.report.warnings[0].contains("a surface of type IRREGULA"));
}

/// A part of a good file, what stands in its place, and how the message begins.
const FAULTS: [(&str, &str, &str); 17] = [
    (
        "MODE SEQ",
        "MODE NSC",
        "a.zmx:1:6: found a file of mode NSC",
    ),
    ("UNIT MM", "UNIT FT", "a.zmx:2:6: found lengths in FT"),
    ("ENPD 2", "ENPD nan", "a.zmx:3:6: found nan"),
    ("ENPD 2", "ENPD 0", "a.zmx:3:6: found ENPD 0"),
    ("ENPD 2\n", "", "a.zmx: found no aperture of the system"),
    ("FTYP 0", "FTYP 9", "a.zmx:4:6: found fields of kind 9"),
    (
        "FTYP 0 0 1 1",
        "FTYP 0 0 1e300 1",
        "a.zmx:4:10: found 1e300",
    ),
    (
        "WAVM 1 0.5",
        "WAVM 1 500",
        "a.zmx: found a wavelength of 500 µm",
    ),
    ("WAVM 1 0.5", "WAVM 1e9 0.5", "a.zmx:7:6: found 1e9"),
    (
        "PWAV 1",
        "PWAV 3",
        "a.zmx: found wavelength 3 of 1 as primary",
    ),
    ("CURV 0.1", "CURV inf", "a.zmx:14:8: found inf"),
    ("CURV 0.1", "CURV", "a.zmx:14:3: found CURV with 0 values"),
    (
        "CURV 0.1",
        "CURV 5",
        "a.zmx:12:1: found in the scene semi_aperture_mm: 1,",
    ),
    ("  STOP\n", "", "a.zmx: found no stop"),
    (
        "DISZ 3",
        "DISZ INFINITY",
        "a.zmx:12:1: found an infinite thickness behind surface 1",
    ),
    (
        "DISZ INFINITY",
        "DISZ -5",
        "a.zmx:9:1: found an object -5 mm before",
    ),
    ("CURV 0.1", "PARM 1e12 3", "a.zmx:14:8: found 1e12"),
];

#[test]
fn faults_name_the_line() {
    let good = file("MM", "  CURV 0.1\n  GLAS N-BK7\n");
    for (from, to, start) in FAULTS {
        let message = refused(&good.replacen(from, to, 1));
        assert!(message.starts_with(start), "{message}");
    }
    assert!(refused("").contains("found 0 surfaces"));
    let fields = ImportChoices {
        field: 2,
        ..ImportChoices::default()
    };
    let message = import_bytes(good.as_bytes(), Path::new("a.zmx"), &fields).unwrap_err();
    assert!(
        message
            .to_string()
            .contains("1 field, and field 2 requested")
    );
}

#[test]
fn concise_text_is_the_same_scene() {
    for records in [
        "  CURV 0.1\n  GLAS N-BK7\n",
        "  TYPE BICONICX\n  CURV 0.1\n  PARM 1 20\n  GLAS N-BK7\n  OBSC 0 0.3\n",
        "  TYPE BINARY_2\n  PARM 0 1\n  XDAT 1 1\n  XDAT 2 2\n  XDAT 3 -100\n  GLAS N-BK7\n",
    ] {
        let scene = imported(&file("MM", records)).scene;
        let text = concise_toml(&scene, "A heading\nof two lines").unwrap();
        assert!(text.starts_with("# A heading\n# of two lines\n") && !text.contains("settings"));
        let read = Scene::parse(&text, Path::new("")).unwrap();
        assert_eq!((read.element, read.source), (scene.element, scene.source));
        assert_eq!((read.settings, read.title), (scene.settings, scene.title));
    }
}

/// Positions of a stop of radius 2 on the second surface of a lens, which is hollow or bulges, as its rim does.
#[test]
fn a_stop_on_an_inner_surface_stands_in_the_plane_of_its_rim() {
    for (curvature, sag) in [(0.1, 10.0 - 96f64.sqrt()), (-0.1, 96f64.sqrt() - 10.0)] {
        let surfaces = format!(
            "SURF 0\n  DISZ INFINITY\nSURF 1\n  GLAS N-BK7\n  DISZ 3\n  DIAM 4 1\nSURF 2\n  STOP\n  CURV {curvature}\n  \
             DISZ 5\n  DIAM 2 1\nSURF 3\n  DISZ 0\n"
        );
        let text = system_of("ENPD 4\nFTYP 0 0 1 2\nXFLN 0\nYFLN 0", &surfaces);
        let lens = imported(&text);
        assert!((stop_radius(&lens.scene) - 2.0).abs() < 1e-12);
        let made = system(&lens.scene, 0).unwrap();
        let stop = made.screens.iter().find(|screen| screen.name == "stop");
        let found = stop.unwrap().frame.origin.z + lens.first_element_mm;
        assert!((found - 3.0 - sag).abs() < 1e-12, "{found} {sag}");
        let sensor = made.screens.last().unwrap().frame.origin.z + lens.first_element_mm;
        assert!((sensor - 8.0).abs() < 1e-12);
    }
}

/// Values of the second of two configurations, and faults of those that have no counterpart.
#[test]
fn configurations_have_their_values() {
    let tail = |operands: &str| {
        format!(
            "{}MNUM 2 1\nMOFF   0   1 \"\" 0 0 0 1 1 0 0.0 \"\" 0\n{operands}",
            system_of("ENPD 3\nFTYP 0 0 1 2\nXFLN 0\nYFLN 0", IDEAL)
        )
    };
    let operands = "THIC   2   1 10 0 0 0 1 1 1 0 0 \"\" 0\nTHIC   2   2 14.5 0 0 0 1 1 1 0 0 \"\" 0\nAPER   0   2 2 0 0\nWAVE 1 2 0.7\n\
                    YFIE 1 2 5\nGLSS 3 2 \"\" 0\nFVDY 1 2 0.1\n";
    let at = |text: &str, configuration| {
        let choices = ImportChoices {
            configuration,
            ..ImportChoices::default()
        };
        import_bytes(text.as_bytes(), Path::new("a.zmx"), &choices)
    };
    let text = tail(operands);
    for (wanted, thickness, radius, wave) in [
        (None, 10.0, 1.5, 0.5),
        (Some(1), 10.0, 1.5, 0.5),
        (Some(2), 14.5, 1.0, 0.7),
    ] {
        let lens = at(&text, wanted).unwrap();
        assert_eq!(lens.scene.element[0].thickness_mm(), Some(thickness));
        assert!((stop_radius(&lens.scene) - radius).abs() < 1e-12);
        assert_eq!(lens.scene.wavelength_um, [wave]);
    }
    for (operands, wanted, found) in [
        (
            operands,
            3,
            "found 2 configurations, and configuration 3 requested",
        ),
        (
            "PRAM 2 2 1 0 0 0 1\n",
            2,
            "found the value PRAM of a configuration",
        ),
        ("THIC 9 2 1\n", 2, "found the value THIC of a configuration"),
        ("CRVT 2 2 x\n", 2, "found x of CRVT"),
    ] {
        let fault = at(&tail(operands), Some(wanted)).unwrap_err().to_string();
        assert!(fault.contains(found), "{fault}");
    }
}

/// Lens files of other projects, all that are shipped; one of them names a glass that the catalogue has under another name.
#[test]
fn every_shipped_file_is_a_scene() {
    let glasses = [("L-TIM28_MOLD".to_owned(), "OHARA:L-TIM28".to_owned())].into();
    let choices = ImportChoices {
        glasses,
        ..ImportChoices::default()
    };
    let mut count = 0;
    for entry in std::fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        let end = path.extension().unwrap().to_string_lossy().to_lowercase();
        if ["zmx", "seq"].contains(&end.as_str()) {
            let lens = import_lens(&path, &choices).unwrap_or_else(|fault| panic!("{fault}"));
            assert!(system(&lens.scene, 0).is_ok());
            count += 1;
        }
    }
    assert!(count >= 49, "{count}");
}
