//! Tests: reliefs, pictures, tables and grid files of asymmetric elements, read back.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::Path;

use ndarray::{Array2, array};
use num_complex::Complex64;

use crate::file::arrays::array::BorrowedArray;
use crate::file::arrays::image::read_gray;
use crate::file::arrays::memory::MemoryLimit;
use crate::file::fabrication::export::{ExportSource, export_element};
use crate::file::fabrication::export_choices::{ExportChoices, Quantity, Top};
use crate::file::fabrication::export_report::ExportReport;
use crate::file::fabrication::height_image::GreyScale;
use crate::file::prescription::import::{ImportChoices, import_bytes};
use crate::file::scene::element::Element;
use crate::file::scene::layer::Layer;

/// Heights in µm of which no two rows or columns are alike.
fn heights() -> Array2<f64> {
    Array2::from_shape_fn((5, 7), |(y, x)| ((3 * x + 5 * y) % 8) as f64 * 0.125)
}

fn choices(quantity: Quantity) -> ExportChoices {
    ExportChoices {
        pitch_um: Some([2.0, 3.0]),
        quantity,
        ..ExportChoices::default()
    }
}

fn exported(path: &Path, values: &Array2<f64>, choices: &ExportChoices) -> ExportReport {
    let source = ExportSource::Array(BorrowedArray::Real(values.view()));
    export_element(source, path, choices).unwrap()
}

/// The message with which an export is refused.
fn refusal(path: &Path, values: &Array2<f64>, choices: &ExportChoices) -> String {
    let source = ExportSource::Array(BorrowedArray::Real(values.view()));
    export_element(source, path, choices)
        .unwrap_err()
        .to_string()
}

type Corner = [u32; 3];

/// The volume of a file of triangles, whose edges each belong to two of them in opposite directions.
fn closed_volume(bytes: &[u8]) -> f64 {
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
    assert_eq!(bytes.len(), 84 + 50 * count);
    let mut edges: HashMap<[Corner; 2], i32> = HashMap::new();
    let mut volume = 0.0;
    for triangle in bytes[84..].chunks_exact(50) {
        let number = |i: usize| f32::from_le_bytes(triangle[4 * i..][..4].try_into().unwrap());
        let corner = |i: usize| [0, 1, 2].map(|a| f64::from(number(3 + 3 * i + a)));
        let [a, b, c] = [corner(0), corner(1), corner(2)];
        let cross = |u: [f64; 3], v: [f64; 3]| {
            [
                u[1] * v[2] - u[2] * v[1],
                u[2] * v[0] - u[0] * v[2],
                u[0] * v[1] - u[1] * v[0],
            ]
        };
        let across = cross(b, c);
        volume += (a[0] * across[0] + a[1] * across[1] + a[2] * across[2]) / 6.0;

        // The normal is that of the corners.
        let way = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
        let normal = cross(way(b), way(c));
        let along: f64 = (0..3).map(|i| normal[i] * f64::from(number(i))).sum();
        assert!(along > 0.0, "{a:?} {b:?} {c:?}");
        let bits = |p: [f64; 3]| p.map(|x| (x as f32 + 0.0).to_bits());
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (from, to) = (bits(from), bits(to));
            assert_ne!(from, to);
            let entry = edges.entry(if from < to { [from, to] } else { [to, from] });
            // The first use of an edge counts 1 and 16 by direction: 17 is one of each.
            *entry.or_default() += if from < to { 1 } else { 16 };
        }
    }
    assert!(edges.values().all(|uses| *uses == 17));
    volume
}

#[test]
fn stairs_are_closed_and_have_their_volume() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.stl");
    let heights = heights();
    let choices = ExportChoices {
        base_um: 4.0,
        micrometres: true,
        ..choices(Quantity::Height)
    };
    let report = exported(&path, &heights, &choices);
    let bytes = fs::read(&path).unwrap();
    let expected = 6.0 * (heights.sum() + 4.0 * heights.len() as f64);
    let volume = closed_volume(&bytes);
    // Where four walls meet, in (1/64)² of a cell, the mean of two corners stands for that of four.
    assert!(
        (volume / expected - 1.0).abs() < 1e-4,
        "{volume} {expected}"
    );
    assert_eq!(
        report.numbers["triangles"] as usize,
        (bytes.len() - 84) / 50
    );

    // In mm, and of one cell: a box.
    let usual = ExportChoices {
        micrometres: false,
        ..choices
    };
    exported(&path, &array![[1.0]], &usual);
    let volume = closed_volume(&fs::read(&path).unwrap());
    assert!((volume / 30e-9 - 1.0).abs() < 1e-6, "{volume}");
    assert!(refusal(&path, &array![[-4.0]], &usual).contains("base_um"));
    let walls = ExportChoices {
        wall_um: Some(2.0),
        ..usual
    };
    assert!(refusal(&path, &heights, &walls).contains("wall_um"));
}

#[test]
fn smooth_surfaces_pass_through_the_centres_of_cells() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.stl");
    // A slope: the volume over the rectangle of the centres is that of its mean height.
    let slope = Array2::from_shape_fn((5, 7), |(y, x)| 0.1 * x as f64 + 0.05 * y as f64);
    let smooth = ExportChoices {
        top: Top::Smooth,
        base_um: 1.0,
        micrometres: true,
        ..choices(Quantity::Height)
    };
    exported(&path, &slope, &smooth);
    let expected = 12.0 * 12.0 * (1.0 + 0.3 + 0.1);
    let volume = closed_volume(&fs::read(&path).unwrap());
    assert!(
        (volume / expected - 1.0).abs() < 1e-6,
        "{volume} {expected}"
    );
}

#[test]
fn pictures_have_plus_y_at_the_top_and_a_scale() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.png");
    let heights = heights();
    for (bits, most) in [(8, 255.0), (16, 65_535.0)] {
        let choices = ExportChoices {
            bits,
            ..choices(Quantity::Height)
        };
        exported(&path, &heights, &choices);
        let text = fs::read_to_string(room.path().join("a.png.toml")).unwrap();
        let scale: GreyScale = toml::from_str(&text).unwrap();
        assert_eq!(
            (scale.pixels, scale.pitch_um, scale.bits),
            ([7, 5], [2.0, 3.0], bits)
        );
        assert!(scale.orientation.contains("top row is +y"), "{text}");
        // What is read has y upwards too.
        let limit = MemoryLimit::of_settings(1 << 20);
        let grey = read_gray(&path, limit).unwrap();
        for (grey, height) in grey.iter().zip(&heights) {
            let found = scale.offset + scale.per_grey * grey * most;
            assert!((found - height).abs() <= 0.5 * scale.per_grey + 1e-9);
        }
    }
    // Levels have a whole number of grey levels each.
    let choices = ExportChoices {
        bits: 8,
        levels: Some(4),
        ..choices(Quantity::Phase)
    };
    let phases = array![[0.0, 0.5 * PI], [PI, -0.5 * PI]];
    let report = exported(&path, &phases, &choices);
    assert!((report.numbers["per_grey"] - 0.5 * PI / 85.0).abs() < 1e-12);
    let grey = read_gray(&path, MemoryLimit::of_settings(1 << 20)).unwrap();
    assert_eq!(
        grey.mapv(|g| (g * 255.0).round()),
        array![[0.0, 85.0], [170.0, 255.0]]
    );
}

#[test]
fn tables_and_grid_files_say_where_values_are() {
    let room = tempfile::tempdir().unwrap();
    let (csv, dat) = (room.path().join("a.csv"), room.path().join("a.dat"));
    let heights = heights();
    exported(&csv, &heights, &choices(Quantity::Height));
    let text = fs::read_to_string(&csv).unwrap();
    let mut lines = text.lines();
    let head = "height in µm; y_mm \\ x_mm,-0.006,-0.004,-0.002,0,0.002,0.004,0.006";
    assert_eq!(lines.next(), Some(head));
    for (line, (y, row)) in lines.zip([-6e-3, -3e-3, 0.0, 3e-3, 6e-3].iter().zip(heights.rows())) {
        let numbers: Vec<f64> = line.split(',').map(|n| n.parse().unwrap()).collect();
        assert_eq!((numbers[0], &numbers[1..]), (*y, row.as_slice().unwrap()));
    }

    // The first point is at −x and +y; sags are in mm.
    exported(&dat, &heights, &choices(Quantity::Height));
    let text = fs::read_to_string(&dat).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("7 5 0.002 0.003 0 0 0"));
    let sags: Vec<f64> = lines
        .map(|line| {
            let numbers: Vec<f64> = line.split(' ').map(|n| n.parse().unwrap()).collect();
            assert_eq!(numbers[1..], [0.0; 4]);
            numbers[0]
        })
        .collect();
    let expected: Vec<f64> = (0..5)
        .rev()
        .flat_map(|y| heights.row(y).mapv(|h| 1e-3 * h).to_vec())
        .collect();
    assert_eq!(sags, expected);

    // Phases stay in rad, and jumps are reported.
    let phases = heights.mapv(|h| TAU * h);
    let report = exported(&dat, &phases, &choices(Quantity::Phase));
    assert!(report.lost.iter().any(|lost| lost.contains("whole turns")));
    let text = fs::read_to_string(&dat).unwrap();
    let first: f64 = text
        .lines()
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    assert_eq!(first, phases[[4, 0]]);
    let few = Array2::zeros((4, 4));
    assert!(refusal(&dat, &few, &choices(Quantity::Phase)).contains("at least 5 x 5"));
}

#[test]
fn phases_become_heights() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.npy");
    let phases = array![[0.0, 0.5 * PI, PI], [-0.5 * PI, 7.0, 3.0]];
    let glass = ExportChoices {
        as_height: true,
        index: Some(1.5),
        wavelength_um: Some(0.5),
        ..choices(Quantity::Phase)
    };
    let made = |choices: &ExportChoices| -> Array2<f64> {
        exported(&path, &phases, choices);
        ndarray_npy::read_npy(&path).unwrap()
    };
    // λ / (n − 1) = 1 µm for a whole wave.
    let expected = phases.mapv(|phase: f64| (phase / TAU).rem_euclid(1.0));
    assert!(
        (made(&glass) - &expected)
            .iter()
            .all(|off| off.abs() < 1e-12)
    );
    // Where the medium around is denser, what was high is low.
    let groove = ExportChoices {
        index: Some(1.0),
        ambient_index: Some(1.5),
        ..glass.clone()
    };
    let turned = phases.mapv(|phase: f64| (-phase / TAU).rem_euclid(1.0));
    assert!(
        (made(&groove) - &turned)
            .iter()
            .all(|off| off.abs() < 1e-12)
    );
    let unknown = ExportChoices {
        index: None,
        ..glass.clone()
    };
    let message = refusal(&path, &phases, &unknown);
    assert!(
        message.contains("index") && message.contains("--depth-um"),
        "{message}"
    );
    // Four levels of it.
    let levels = ExportChoices {
        levels: Some(4),
        ..glass
    };
    let quarters = array![[0.0, 0.25, 0.5], [0.75, 0.0, 0.5]];
    assert!(
        (made(&levels) - quarters)
            .iter()
            .all(|off: &f64| off.abs() < 1e-12)
    );
}

#[test]
fn coefficients_are_read_by_the_reader_of_lens_files() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.txt");
    let phases = Array2::from_shape_fn((100, 100), |(y, x)| {
        let at = |i: usize| (i as f64 - 49.5) * 2e-3;
        let t = (at(x).powi(2) + at(y).powi(2)) / 0.01;
        (-20.0 * t + 2.0 * t * t).rem_euclid(TAU)
    });
    let choices = ExportChoices {
        pitch_um: Some([2.0; 2]),
        terms: 2,
        ..ExportChoices::default()
    };
    exported(&path, &phases, &choices);
    let text = fs::read_to_string(&path).unwrap();
    let surface = text.split("(diffraction order 1):\n").nth(1).unwrap();
    let lens = format!(
        "VERS 140124 0 0\nMODE SEQ\nUNIT MM X W X CM MR CPMM\nENPD 0.2\nFTYP 0 0 1 1 0 0 0\nWAVM 1 0.5 1\nPWAV 1\n\
         SURF 0\n  TYPE STANDARD\n  DISZ INFINITY\nSURF 1\n  STOP\n{surface}  DISZ 5\n  DIAM 0.1\nSURF 2\n  \
         TYPE STANDARD\n  DISZ 0\n  DIAM 1\n"
    );
    let lens = import_bytes(
        lens.as_bytes(),
        Path::new("a.zmx"),
        &ImportChoices::default(),
    )
    .unwrap();
    let layers = lens
        .scene
        .element
        .into_iter()
        .filter_map(|element| match element {
            Element::Doe(doe) => Some(doe.layer),
            _ => None,
        });
    let [Layer::Radial(radial)] = &layers.flatten().collect::<Vec<_>>()[..] else {
        panic!("no radial phase");
    };
    assert_eq!(radial.norm_radius_mm, 0.1);
    for (found, expected) in radial.coefficients.iter().zip([-20.0, 2.0]) {
        assert!((found - expected).abs() < 1e-9, "{found}");
    }
}

/// A scene with an element of the pixels of a file.
fn scene(room: &Path, layer: &str) -> std::path::PathBuf {
    let path = room.join("scene.toml");
    let text = format!(
        "version = 1\nwavelength_um = 0.5\n[source]\nkind = \"plane\"\n[[element]]\nkind = \"doe\"\nname = \"plate\"\n\
         thickness_mm = 5\naperture = {{ rectangle = {{ width_mm = 0.04, height_mm = 0.02 }} }}\n[[element.layer]]\n{layer}\n\
         [[element]]\nkind = \"sensor\"\npixels = [4, 4]\npitch_um = 5\n"
    );
    fs::write(&path, text).unwrap();
    path
}

/// The values and the report of the element of a scene with a layer.
fn made_of(room: &Path, layer: &str, choices: &ExportChoices) -> (Array2<f64>, ExportReport) {
    let (path, out) = (scene(room, layer), room.join("out.npy"));
    let report = export_element(ExportSource::File(&path), &out, choices).unwrap();
    (ndarray_npy::read_npy(&out).unwrap(), report)
}

#[test]
fn elements_of_scenes_are_their_layers() {
    let room = tempfile::tempdir().unwrap();
    let made = |layer: &str, choices: &ExportChoices| made_of(room.path(), layer, choices);
    let usual = ExportChoices::default();

    // Phases with a factor, and complex numbers.
    let phases = heights();
    ndarray_npy::write_npy(room.path().join("p.npy"), &phases).unwrap();
    let (found, _) = made(
        "kind = \"pixels\"\npitch_um = 2\nphase = \"p.npy\"\nphase_scale = 2",
        &usual,
    );
    assert_eq!(found, 2.0 * &phases);
    let complex = phases.mapv(|phase| Complex64::from_polar(0.5, phase));
    ndarray_npy::write_npy(room.path().join("t.npy"), &complex).unwrap();
    let layer = "kind = \"pixels\"\npitch_um = 2\ntransmission = \"t.npy\"";
    let (found, report) = made(layer, &usual);
    assert!((found - &phases).iter().all(|off| off.abs() < 1e-12));
    assert!(report.lost.iter().any(|lost| lost.contains("amplitude")));

    // Heights know their relief; formulas are taken at the centres of cells.
    let layer = "kind = \"height\"\npitch_um = 2\nheight_um = \"p.npy\"\nglass = { index = 1.5 }";
    let levels = ExportChoices {
        levels: Some(4),
        ..ExportChoices::default()
    };
    let (found, _) = made(layer, &levels);
    // A whole wave is 1 µm, and so steps are 0.25 µm.
    let expected = phases.mapv(|h: f64| (h / 0.25).round().min(3.0) * 0.25);
    assert_eq!(found, expected);
    let cells = ExportChoices {
        pitch_um: Some([4.0, 5.0]),
        ..ExportChoices::default()
    };
    let (found, _) = made(
        "kind = \"grating\"\nperiod_um = 20\ndirection_deg = 90",
        &cells,
    );
    assert_eq!(found.dim(), (4, 10));
    let expected = TAU / 20.0 * -7.5;
    assert!(
        found
            .row(0)
            .iter()
            .all(|phase| (phase - expected).abs() < 1e-9)
    );
}

/// A kinoform is its phase in the first order; other sums have no phase of their own.
#[test]
fn kinoforms_are_their_first_order() {
    let room = tempfile::tempdir().unwrap();
    let cells = choices(Quantity::Phase);
    let grating = "kind = \"grating\"\nperiod_um = 20\ndirection_deg = 30\n";
    let kinoform = |orders: &str| {
        format!("kind = \"kinoform\"\norders = {orders}\n[[element.layer.layer]]\n{grating}")
    };
    let (expected, _) = made_of(room.path(), grating, &cells);
    let (found, _) = made_of(room.path(), &kinoform("[0, 2, 1]"), &cells);
    assert_eq!(found, expected);
    let path = scene(room.path(), &kinoform("[0, 2]"));
    let source = ExportSource::File(&path);
    let refused = export_element(source, &room.path().join("a.npy"), &cells).unwrap_err();
    assert!(
        refused.to_string().contains("element[0].layer[0]"),
        "{refused}"
    );
}

#[test]
fn elements_without_cells_need_a_pitch() {
    let room = tempfile::tempdir().unwrap();
    let path = scene(room.path(), "kind = \"vortex\"\ncharge = 1");
    let refuse = |choices: &ExportChoices| {
        let out = room.path().join("out.npy");
        let source = ExportSource::File(&path);
        export_element(source, &out, choices)
            .unwrap_err()
            .to_string()
    };
    assert!(refuse(&ExportChoices::default()).contains("pitch_um"));
    let other = ExportChoices {
        element: Some(String::from("plat")),
        ..choices(Quantity::Phase)
    };
    assert!(refuse(&other).contains("plate"));
}

#[test]
fn files_of_others_stay() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.csv");
    fs::write(&path, "mine").unwrap();
    let message = refusal(&path, &heights(), &choices(Quantity::Height));
    assert!(message.contains("--overwrite"), "{message}");
    let message = refusal(
        &room.path().join("a.cif"),
        &heights(),
        &choices(Quantity::Height),
    );
    assert!(message.contains(".gds"), "{message}");
    let bad = array![[0.0, f64::NAN]];
    let message = refusal(&room.path().join("b.csv"), &bad, &choices(Quantity::Height));
    assert!(message.contains("[0, 1]"), "{message}");
    assert!(!room.path().join("b.csv").exists());
}
