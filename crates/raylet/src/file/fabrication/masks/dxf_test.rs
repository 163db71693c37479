//! Tests: files of the format DXF hold the shapes of those of the format GDSII.

use std::path::Path;

use ndarray::Array2;

use crate::file::arrays::array::BorrowedArray;
use crate::file::fabrication::export::{ExportSource, export_element};
use crate::file::fabrication::export_choices::{ExportChoices, Masks, Quantity};
use crate::file::fabrication::gds::gds_shapes::{Drawn, gds_shapes, moved};
use crate::file::fabrication::masks::dxf_writer::DxfFile;
use crate::file::fabrication::masks::mask_file::MaskFile;
use crate::file::fabrication::masks::mask_plan::{MaskLayer, MaskPlan};
use crate::optics::pixels::active_area::ActiveArea;

/// An entity: its kind, and its groups of a code and a value.
type Entity = (String, Vec<(u32, String)>);

/// All entities of a file, in lines of codes and values.
fn entities(text: &str) -> Vec<Entity> {
    let lines: Vec<&str> = text.lines().collect();
    let mut found: Vec<Entity> = Vec::new();
    for pair in lines.chunks_exact(2) {
        let (code, value) = (pair[0].parse().unwrap(), pair[1].to_owned());
        match (code, found.last_mut()) {
            (0, _) => found.push((value, Vec::new())),
            (999, _) => {}
            (_, last) => last.unwrap().1.push((code, value)),
        }
    }
    assert!(lines.len().is_multiple_of(2));
    assert_eq!(found.last().unwrap().0, "EOF");
    found
}

/// The value of a group.
fn value((kind, groups): &Entity, code: u32) -> &str {
    let group = groups.iter().find(|group| group.0 == code);
    &group.unwrap_or_else(|| panic!("{code} of {kind}")).1
}

/// A place in nm.
fn nm(entity: &Entity, code: u32) -> i64 {
    let um: f64 = value(entity, code).parse().unwrap();
    let nm = um * 1000.0;
    assert!((nm - nm.round()).abs() < 1e-6);
    nm.round() as i64
}

/// The shapes of the drawing, with the number of their layer in place of its name.
fn dxf_shapes(text: &str) -> Vec<Drawn> {
    let (mut block, mut drawing): (Vec<Drawn>, Vec<Drawn>) = (Vec::new(), Vec::new());
    let mut in_block = false;
    for entity in entities(text) {
        match entity.0.as_str() {
            "BLOCK" => in_block = true,
            "ENDBLK" => in_block = false,
            "SOLID" => {
                // The third corner is the one across from the second.
                let at = [10, 11, 13, 12].map(|code| [nm(&entity, code), nm(&entity, code + 10)]);
                let layer = value(&entity, 8).parse().unwrap();
                let list = if in_block { &mut block } else { &mut drawing };
                list.push((layer, 0, at.to_vec()));
            }
            "INSERT" => {
                let [columns, rows] = [70, 71].map(|code| value(&entity, code).parse().unwrap());
                for row in 0..rows {
                    for column in 0..columns {
                        let at = [
                            nm(&entity, 10) + column * nm(&entity, 44),
                            nm(&entity, 20) + row * nm(&entity, 45),
                        ];
                        drawing.extend(block.iter().map(|shape| moved(shape, at)));
                    }
                }
            }
            _ => {}
        }
    }
    drawing.sort();
    drawing
}

fn exported(path: &Path, values: &Array2<f64>, choices: &ExportChoices) -> Vec<u8> {
    let source = ExportSource::Array(BorrowedArray::Real(values.view()));
    export_element(source, path, choices).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn dxf_files_hold_the_shapes_of_gdsii_files() {
    let room = tempfile::tempdir().unwrap();
    let (gds, dxf) = (room.path().join("a.gds"), room.path().join("a.dxf"));
    let patterns: [fn(usize, usize) -> usize; 2] = [
        |y, x| (7 * y * y + 3 * x * x + x * y) % 4,
        |y, x| (y % 3 + 2 * (x % 4)) % 4,
    ];
    for pattern in patterns {
        let values = Array2::from_shape_fn((30, 48), |(y, x)| pattern(y, x) as f64);
        for masks in [Masks::Each, Masks::Binary, Masks::Dose] {
            let choices = ExportChoices {
                pitch_um: Some([0.3, 1.001]),
                quantity: Quantity::Level,
                levels: Some(4),
                masks,
                ..ExportChoices::default()
            };
            let text = exported(&dxf, &values, &choices);
            let found = dxf_shapes(std::str::from_utf8(&text).unwrap());
            // The name is the level, which a file of doses has as its data type.
            let mut expected = gds_shapes(&exported(&gds, &values, &choices));
            for (layer, data_type, _) in &mut expected {
                if masks == Masks::Dose {
                    (*layer, *data_type) = (*data_type, 0);
                }
            }
            expected.sort();
            assert_eq!(found, expected, "{masks:?}");
        }
    }
}

#[test]
fn outlines_are_closed_lines_on_their_own_layers() {
    let choices = ExportChoices {
        aperture_layer: Some(90),
        database_unit_nm: 0.1,
        ..ExportChoices::default()
    };
    let cells = ([1.0; 2], ActiveArea::WHOLE);
    let plan = MaskPlan::new(Path::new("a.dxf"), [2, 2], cells, 4, &choices).unwrap();
    let mut out = Vec::new();
    let mut file = DxfFile::new(&mut out, &plan).unwrap();
    file.structure("A").unwrap();
    for data_type in [0, 1] {
        let layer = MaskLayer {
            layer: 90,
            data_type,
        };
        file.polygon(layer, &[[0, 0], [12_345, 0], [-3, 7]])
            .unwrap();
    }
    file.end().unwrap();
    let entities = entities(std::str::from_utf8(&out).unwrap());
    let lines = entities.iter().filter(|one| one.0 == "POLYLINE");
    let layers: Vec<&str> = lines
        .map(|line| {
            assert_eq!(value(line, 70), "1");
            value(line, 8)
        })
        .collect();
    assert_eq!(layers, ["APERTURE", "APERTURE_1"]);
    let corners = entities.iter().filter(|one| one.0 == "VERTEX");
    let xs: Vec<&str> = corners.map(|corner| value(corner, 10)).collect();
    assert_eq!(xs, ["0", "1.2345", "-0.0003", "0", "1.2345", "-0.0003"]);
}
