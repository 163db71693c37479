//! Tests: grids of values inside Zemax files, and as files that scenes name.

use std::fs;
use std::path::Path;

use ndarray::Array2;

use crate::file::arrays::array::BorrowedArray;
use crate::file::fabrication::export::{ExportSource, export_element};
use crate::file::fabrication::export_choices::{ExportChoices, Quantity};
use crate::file::prescription::shapes_test::{GLASS, agree, conic, file, imported, refused};
use crate::file::scene::element::Element;
use crate::file::scene::scene_file::Scene;

/// Records of a grid with these steps, whose values are a function of x and y: rows from the top, each from the left.
fn grid([nx, ny]: [usize; 2], [dx, dy]: [f64; 2], value: impl Fn(f64, f64) -> f64) -> String {
    let mut text = format!("  GDAT {nx} {ny} {dx} {dy} 0.0 0.0\n");
    for row in 0..ny {
        let y = (0.5 * (ny - 1) as f64 - row as f64) * dy;
        for column in 0..nx {
            let x = (column as f64 - 0.5 * (nx - 1) as f64) * dx;
            text += &format!("  GARR {} {:e} 1 2 3 0\n", row * nx + column, value(x, y));
        }
    }
    text
}

/// A polynomial that a bicubic spline has itself, without a symmetry that would hide a swapped axis.
fn cubic(x: f64, y: f64) -> f64 {
    1e-3 * (x - 2.0 * y + 0.5 * x * x * y + 0.1 * y * y * y) + 4e-3 * y * y
}

#[test]
fn sags_are_an_asphere_with_a_spline() {
    let base = format!("  TYPE GRID_SAG\n  CURV 0.05\n  CONI -0.6\n  PARM 2 1e-3\n{GLASS}");
    for (unit, mm) in [("MM", 1.0), ("IN", 25.4)] {
        let records = format!("{base}{}", grid([9, 7], [0.5, 0.75], cubic));
        let text = file(unit, &records);
        let lens = imported(&text);
        let Some(Element::Surface(surface)) = lens
            .scene
            .element
            .iter()
            .find(|element| matches!(element, Element::Surface(_)))
        else {
            panic!("{:?}", lens.scene.element);
        };
        let keys = surface.surface_shape();
        let [only] = &lens.arrays[..] else {
            panic!("{:?}", lens.arrays);
        };
        assert_eq!(only.file, Path::new("a_surface1.npy"));
        let shape = keys.optics(Some(only.values.view())).unwrap();
        for [x, y] in [[0.0, 0.0], [0.3, -0.4], [-1.1, 0.9]] {
            let r2 = x * x + y * y;
            let expected = conic(0.05, -0.6, r2) + 1e-3 * r2 * r2 + cubic(x, y);
            let found = shape.sag(x * mm, y * mm).unwrap() / mm;
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }
}

/// The curvature of a grid counts, and its report says what the spline is.
#[test]
fn grids_have_power() {
    let square = |_: f64, y: f64| 0.025 * y * y;
    let records = format!("  TYPE GRID_SAG\n{GLASS}{}", grid([7, 7], [0.6; 2], square));
    let report = imported(&file("MM", &records)).report;
    let toroid = format!("  TYPE TOROIDAL\n  CURV 0.05\n{GLASS}");
    let expected = imported(&file("MM", &toroid)).report;
    let name = "focal length, axis unfolded (mm)";
    let (found, expected) = (report.number(name).unwrap(), expected.number(name).unwrap());
    assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    let text = report.to_string();
    assert!(text.contains("its grid is a bicubic spline"), "{text}");

    let phase = |x: f64, y: f64| -100.0 / 4.0 * (x * x + y * y);
    let records = format!(
        "  TYPE GRID_PHA\n  PARM 0 1\n{}",
        grid([7, 7], [0.6; 2], phase)
    );
    let report = imported(&file("MM", &records)).report;
    let expected = std::f64::consts::PI * 4.0 / (100.0 * 0.5e-3);
    for name in [name, "focal length (mm)"] {
        let found = report.number(name).unwrap();
        assert!((found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
    }
}

#[test]
fn phases_keep_order_place_and_middle() {
    let records = grid([5, 6], [0.9, 0.8], cubic).replace(" 0.0 0.0\n", " 0.25 -0.5\n");
    let lens = imported(&file(
        "MM",
        &format!("  TYPE GRID_PHA\n  PARM 0 -2\n{records}"),
    ));
    let [only] = &lens.arrays[..] else {
        panic!("{:?}", lens.arrays);
    };
    assert_eq!(only.field, "element[0].layer[0].phase");
    assert_eq!(only.values.dim(), (6, 5));
    // Row 0 has the smallest y.
    agree(only.values[[0, 4]], -2.0 * cubic(1.8, -2.0));
    agree(only.values[[5, 0]], -2.0 * cubic(-1.8, 2.0));
    let text = lens.scene.to_toml().unwrap();
    assert!(text.contains("centre_mm = [0.25, -0.5]"), "{text}");
}

#[test]
fn faults_and_gaps_are_said() {
    let good = grid([5, 5], [1.0; 2], cubic);
    let sag = |records: &str| file("MM", &format!("  TYPE GRID_SAG\n{GLASS}{records}"));
    for (text, found) in [
        (sag(""), "a grid of 0 × 0 points with 0 values"),
        (
            sag(&good.replace("GDAT 5 5", "GDAT 5 6")),
            "a grid of 5 × 6 points with 25 values",
        ),
        (
            sag(&good.replace("5 5 1 1", "5 5 0 1")),
            "steps of 0 and 1 mm",
        ),
        (
            sag(&good.replace("GARR 7", "GARR 8")),
            "point 8, expected point 7",
        ),
        (
            sag(&good.replace("0.0 0.0\n", "0.5 0.0\n")),
            "a grid with its middle at [0.5, 0.0] mm",
        ),
        (
            sag(&format!("{good}  PARM 1 0.1\n")),
            "a coefficient of r² beside a grid",
        ),
        (
            sag(&format!("{good}  XDAT 1 1\n  XDAT 2 1\n  XDAT 3 1\n")),
            "Zernike terms beside a grid",
        ),
        (
            file("MM", &format!("  TYPE GRID_PHA\n  PARM 1 2\n{good}")),
            "parameter 1 = 2 on a surface of type GRID_PHA",
        ),
        (
            file("MM", &format!("  TYPE GRID_PHA\n  PARM 0 0\n{good}")),
            "a diffraction order of 0 as parameter 0",
        ),
        (
            file("MM", &format!("  TYPE EVENASPH\n{good}")),
            "a grid (GDAT) on a surface of type EVENASPH",
        ),
        // Light that passes beside the grid.
        (sag(&grid([5, 5], [0.2; 2], cubic)), "in the scene"),
    ] {
        let message = refused(&text);
        assert!(message.starts_with("a.zmx:"), "{message}");
        assert!(message.contains(found), "{message}");
    }
    let gap = good.replacen(" 1 2 3 0\n", " 1 2 3 1\n", 1);
    let lens = imported(&sag(&gap));
    assert_eq!(lens.arrays[0].values[[4, 0]], 0.0);
    let sentence = "Surface 1: points of its grid are without data (1), and zero in the scene.";
    assert!(lens.report.warnings.iter().any(|text| text == sentence));
}

const SCENE: &str = "version = 1\nwavelength_um = 0.5\nsource.kind = 'plane'\n[[element]]\nkind = 'doe'\nthickness_mm = 10\n\
    aperture = { disc = { radius_mm = 0.1 } }\n[[element.layer]]\nkind = 'phase_grid'\npitch_um = [50, 75]\nphase = 'a.dat'\n\
    [[element]]\nkind = 'sensor'\npixels = [2, 2]\npitch_um = 1\n";

const LAYER: &str =
    "[[element.layer]]\nkind = 'phase_grid'\npitch_um = [50, 75]\nphase = 'a.dat'\n";

const SURFACE: &str = "shape = { kind = 'grid', pitch_um = [50, 75], height_um = 'a.dat' }\n\
    [[element.layer]]\nkind = 'vortex'\ncharge = 1\n";

/// A grid of Zemax where a scene names an array.
#[test]
fn scenes_take_grids_of_zemax_as_arrays() {
    let room = tempfile::tempdir().unwrap();
    let mut text = String::from("6 5 0.05 0.075 0 0 0\n");
    for i in 0..30 {
        text += &format!("{} 0 0 0 0\n", f64::from(i) / 7.0);
    }
    let place = room.path().join("scene.toml");
    let load = |scene: &str, grid: &str| {
        fs::write(room.path().join("a.dat"), grid).unwrap();
        Scene::parse(scene, &place).unwrap().load()
    };
    let scene = load(SCENE, &text).unwrap();
    let values = scene.arrays.real("element[0].layer[0].phase").unwrap();
    assert_eq!((values[[4, 0]], values[[0, 5]]), (0.0, 29.0 / 7.0));

    // The same in inches is refused: the scene has another pitch.
    for (scene, grid, found) in [
        (SCENE, text.replacen("0.075 0 ", "0.075 2 ", 1), "µm apart"),
        (
            SCENE,
            text.replacen("0 0 0\n", "0 1 0\n", 1),
            "a grid with its middle at [1.0, 0.0] mm",
        ),
        (
            SCENE,
            text.replacen("0 0 0 0\n", "0 0 0 1\n", 1),
            "1 missing samples of 30, the first at [4, 0]",
        ),
        (
            SCENE,
            text.replacen("6 5", "6 6", 1),
            "30 points, expected 6 × 6",
        ),
    ] {
        let message = load(scene, &grid).unwrap_err().to_string();
        assert!(message.contains(found), "{message}");
        assert!(message.contains("a.dat"), "{message}");
    }

    // Heights of a surface are in µm in a scene, in the unit of the file there.
    let heights = text.lines().skip(1).map(|line| {
        let value: f64 = line.split(' ').next().unwrap().parse().unwrap();
        format!("{} 0 0 0\n", 1e-6 * value)
    });
    let heights = format!("6 5 0.05 0.075 1 0 0\n{}", heights.collect::<String>());
    let surface = SCENE
        .replace(LAYER, SURFACE)
        .replace("[50, 75]", "[500, 750]");
    let scene = load(&surface, &heights).unwrap();
    let values = scene.arrays.real("element[0].shape.height_um").unwrap();
    assert!((values[[0, 5]] / (29.0 / 7.0 * 1e-2) - 1.0).abs() < 1e-14);
}

/// What an export writes is read back with every digit.
#[test]
fn exported_grids_come_back() {
    let room = tempfile::tempdir().unwrap();
    let values = Array2::from_shape_fn((5, 6), |(y, x)| ((3 * x + 5 * y) % 8) as f64 / 7.0);
    for (quantity, text, field) in [
        (Quantity::Phase, SCENE.to_owned(), "layer[0].phase"),
        (
            Quantity::Height,
            SCENE.replace(LAYER, SURFACE),
            "shape.height_um",
        ),
    ] {
        let choices = ExportChoices {
            pitch_um: Some([50.0, 75.0]),
            quantity,
            ..ExportChoices::default()
        };
        let source = ExportSource::Array(BorrowedArray::Real(values.view()));
        export_element(source, &room.path().join("a.dat"), &choices).unwrap();
        let scene = Scene::parse(&text, &room.path().join("scene.toml")).unwrap();
        let scene = scene.load().unwrap();
        let found = scene.arrays.real(&format!("element[0].{field}")).unwrap();
        for (found, expected) in found.iter().zip(&values) {
            // Heights go through mm and back.
            let within = if quantity == Quantity::Phase {
                0.0
            } else {
                3e-16
            };
            assert!((found - expected).abs() <= within, "{found} {expected}");
        }
    }
}
