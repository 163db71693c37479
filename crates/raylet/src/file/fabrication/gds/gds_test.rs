//! Tests: mask files that are written are read back, cell by cell, and by the bytes of the format.

use std::f64::consts::TAU;
use std::io::Cursor;
use std::path::Path;

use ndarray::{Array2, array};

use crate::file::arrays::array::BorrowedArray;
use crate::file::fabrication::export::{ExportSource, export_element};
use crate::file::fabrication::export_choices::{ExportChoices, Masks, Quantity};
use crate::file::fabrication::export_report::ExportReport;
use crate::file::fabrication::gds::gds_reader::{read_masks, read_stream};
use crate::file::fabrication::gds::gds_record::{kind, longs, real, shorts, text, write_record};

/// Random levels below a number.
fn random(size: [usize; 2], levels: u64, seed: u64) -> Array2<f64> {
    let mut number = seed;
    Array2::from_shape_fn((size[1], size[0]), |_| {
        number = number
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((number >> 33) % levels) as f64
    })
}

/// Choices for numbers of levels.
fn levels(count: u32, masks: Masks) -> ExportChoices {
    ExportChoices {
        pitch_um: Some([0.5, 0.75]),
        quantity: Quantity::Level,
        levels: Some(count),
        masks,
        ..ExportChoices::default()
    }
}

/// Exports an array to a new file of a folder.
pub(crate) fn exported(path: &Path, values: &Array2<f64>, choices: &ExportChoices) -> ExportReport {
    let source = ExportSource::Array(BorrowedArray::Real(values.view()));
    export_element(source, path, choices).unwrap()
}

/// The levels that are read back, as an array.
pub(crate) fn read(path: &Path, size: [usize; 2], choices: &ExportChoices) -> Array2<f64> {
    let choices = ExportChoices {
        size: Some(size),
        ..choices.clone()
    };
    let read = read_masks(path, &choices).unwrap();
    let values = read.levels.into_iter().map(f64::from).collect();
    Array2::from_shape_vec((size[1], size[0]), values).unwrap()
}

#[test]
fn what_is_written_is_read_back() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.gds");
    for (seed, size) in [[1, 1], [7, 5], [33, 18], [64, 64]].into_iter().enumerate() {
        for masks in [Masks::Each, Masks::Binary, Masks::Dose] {
            let choices = levels(8, masks);
            let values = random(size, 8, seed as u64);
            let report = exported(&path, &values, &choices);
            assert_eq!(read(&path, size, &choices), values, "{masks:?} {size:?}");
            assert_eq!(report.numbers["rounding_largest"], 0.0);
        }
    }
    // Nothing but the files of the last export is there.
    assert_eq!(std::fs::read_dir(room.path()).unwrap().count(), 2);
}

#[test]
fn repeated_tiles_are_references() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.gds");
    let tile = random([6, 4], 4, 5);
    let values = Array2::from_shape_fn((40, 90), |(y, x)| tile[[y % 4, x % 6]]);
    for masks in [Masks::Each, Masks::Binary, Masks::Dose] {
        let choices = levels(4, masks);
        let report = exported(&path, &values, &choices);
        assert_eq!(report.numbers["repeats"], 150.0);
        assert!(std::fs::metadata(&path).unwrap().len() < 4000);
        assert_eq!(read(&path, [90, 40], &choices), values);
    }
    // What is the same along y is drawn as long rectangles, of one period along x.
    let stripes = Array2::from_shape_fn((40, 90), |(_, x)| f64::from(x % 9 < 4));
    let report = exported(&path, &stripes, &levels(2, Masks::Each));
    assert_eq!(report.numbers["repeats"], 10.0);
    assert_eq!(report.numbers["rectangles"], 1.0);
    assert_eq!(read(&path, [90, 40], &levels(2, Masks::Each)), stripes);
}

/// An L whose long arm is along y and whose short arm is along +x at the smallest y.
#[test]
fn rows_grow_with_y_and_mirrors_turn_x() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.gds");
    let letter = array![[1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let choices = levels(2, Masks::Each);
    exported(&path, &letter, &choices);
    let bytes = std::fs::read(&path).unwrap();
    // The first rectangle that is complete is the short arm's row: x from −750 to 250 nm, y from −1125 to −375 nm.
    let xy = bytes
        .windows(4)
        .position(|four| four == [0, 44, 0x10, 0x03])
        .unwrap();
    let number = |i: usize| {
        let four = bytes[xy + 4 + 4 * i..][..4].try_into().unwrap();
        i32::from_be_bytes(four)
    };
    let corners: Vec<i32> = (0..10).map(number).collect();
    let expected = [-750, -1125, 250, -1125, 250, -375, -750, -375, -750, -1125];
    assert_eq!(corners, expected);

    let mirrored = ExportChoices {
        mirror: true,
        overwrite: true,
        ..choices.clone()
    };
    exported(&path, &letter, &mirrored);
    let turned = array![[0.0, 1.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]];
    assert_eq!(read(&path, [3, 3], &choices), turned);
}

#[test]
fn phases_are_rounded_and_come_back_as_phases() {
    let room = tempfile::tempdir().unwrap();
    let (path, back) = (room.path().join("a.gds"), room.path().join("a.npy"));
    let phases = Array2::from_shape_fn((9, 8), |(y, x)| 0.37 * x as f64 - 1.1 * y as f64);
    let choices = ExportChoices {
        pitch_um: Some([1.0; 2]),
        levels: Some(16),
        ..ExportChoices::default()
    };
    let report = exported(&path, &phases, &choices);
    let rms = report.numbers["rounding_rms"];
    // Evenly spread phases are off by a step / √12.
    assert!(
        (0.8..1.2).contains(&(rms / (TAU / 16.0 / 12.0_f64.sqrt()))),
        "{rms}"
    );
    let choices = ExportChoices {
        size: Some([8, 9]),
        ..choices
    };
    export_element(ExportSource::File(&path), &back, &choices).unwrap();
    let made: Array2<f64> = ndarray_npy::read_npy(&back).unwrap();
    for (made, phase) in made.iter().zip(&phases) {
        let turns = (made - phase) / TAU;
        assert!((turns - turns.round()).abs() <= 1.0 / 32.0 + 1e-12);
    }
    // The same file again, bit by bit.
    let first = std::fs::read(&path).unwrap();
    exported(&path, &phases, &choices);
    assert_eq!(std::fs::read(&path).unwrap(), first);
}

/// A file with one structure of these elements.
fn library(elements: &[(u16, Vec<u8>)]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut add = |kind: u16, data: &[u8]| write_record(&mut out, kind, data).unwrap();
    add(kind::HEADER, &shorts(&[600]));
    add(kind::BGNLIB, &shorts(&[0; 12]));
    add(kind::LIBNAME, &text("A"));
    add(kind::UNITS, &[real(1e-3), real(1e-9)].concat());
    add(kind::BGNSTR, &shorts(&[0; 12]));
    add(kind::STRNAME, &text("TOP"));
    for (kind, data) in elements {
        add(*kind, data);
    }
    add(kind::ENDSTR, &[]);
    add(kind::ENDLIB, &[]);
    out
}

/// The records of a polygon on layer 1, in µm.
fn polygon(corners: &[i32]) -> Vec<(u16, Vec<u8>)> {
    let corners: Vec<i32> = corners.iter().map(|at| 1000 * at).collect();
    vec![
        (kind::BOUNDARY, Vec::new()),
        (kind::LAYER, shorts(&[1])),
        (kind::DATATYPE, shorts(&[0])),
        (kind::XY, longs(&corners)),
        (kind::ENDEL, Vec::new()),
    ]
}

fn read_bytes(bytes: Vec<u8>, size: Option<[usize; 2]>) -> Result<Vec<u16>, String> {
    let choices = ExportChoices {
        pitch_um: Some([1.0; 2]),
        size,
        ..ExportChoices::default()
    };
    let read = read_stream(Cursor::new(bytes), Path::new("a.gds"), &choices, 1 << 20);
    read.map(|read| read.levels)
        .map_err(|fault| fault.to_string())
}

#[test]
fn joined_polygons_are_filled() {
    // A frame of one cell's width with a slit, as programs write a shape with a hole.
    let frame = [
        0, 0, 4, 0, 4, 3, 0, 3, 0, 1, 1, 1, 1, 2, 3, 2, 3, 1, 0, 1, 0, 0,
    ];
    let found = read_bytes(library(&polygon(&frame)), None).unwrap();
    assert_eq!(found, [1, 1, 1, 1, 1, 0, 0, 1, 1, 1, 1, 1]);
}

#[test]
fn shapes_off_the_grid_are_refused() {
    let refusal = |corners: &[i32], size| read_bytes(library(&polygon(corners)), size).unwrap_err();
    let slanted = refusal(&[0, 0, 2, 0, 0, 2, 0, 0], None);
    assert!(slanted.starts_with("a.gds") && slanted.contains("slanted"));
    let outside = refusal(&[0, 0, 5, 0, 5, 1, 0, 1, 0, 0], Some([4, 4]));
    assert!(outside.contains("off the grid"), "{outside}");
    // Half a cell aside: cells of an odd number begin at half a pitch.
    assert!(refusal(&[0, 0, 1, 0, 1, 1, 0, 1, 0, 0], Some([3, 3])).contains("off the grid"));
    let empty = read_bytes(library(&[]), None).unwrap_err();
    assert!(empty.contains("no shape"), "{empty}");
}

#[test]
fn structures_without_end_are_refused() {
    let reference = vec![
        (kind::SREF, Vec::new()),
        (kind::SNAME, text("TOP")),
        (kind::XY, longs(&[0, 0])),
        (kind::ENDEL, Vec::new()),
    ];
    let message = read_bytes(library(&reference), Some([2, 2])).unwrap_err();
    assert!(message.contains("no structure that holds"), "{message}");
    let turned = vec![
        (kind::SREF, Vec::new()),
        (kind::SNAME, text("B")),
        (kind::ANGLE, real(90.0).to_vec()),
        (kind::XY, longs(&[0, 0])),
        (kind::ENDEL, Vec::new()),
    ];
    let message = read_bytes(library(&turned), None).unwrap_err();
    assert!(message.contains("turned"), "{message}");
    let cut = library(&polygon(&[0, 0, 1, 0, 1, 1, 0, 1, 0, 0]));
    for end in 0..cut.len() {
        assert!(read_bytes(cut[..end].to_vec(), None).is_err(), "{end}");
    }
}
