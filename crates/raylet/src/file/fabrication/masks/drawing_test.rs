//! Tests: apertures, gaps and the bias of an etch in mask files, against a picture in database units, and read back.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::{Path, PathBuf};

use ndarray::Array2;

use crate::file::arrays::array::BorrowedArray;
use crate::file::fabrication::export::{ExportSource, export_element};
use crate::file::fabrication::export_choices::{ExportChoices, Masks, Quantity};
use crate::file::fabrication::gds::gds_reader::read_masks;
use crate::file::fabrication::gds::gds_shapes::{Drawn, gds_shapes};
use crate::file::fabrication::gds::gds_test::{exported, read};

const ALL: [Masks; 3] = [Masks::Each, Masks::Binary, Masks::Dose];

/// Random levels below 4 of blocks of cells.
fn random(size: [usize; 2], block: usize) -> Array2<f64> {
    let mut number = 7_u64;
    let blocks = Array2::from_shape_fn((size[1].div_ceil(block), size[0].div_ceil(block)), |_| {
        number = number
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((number >> 33) % 4) as f64
    });
    Array2::from_shape_fn((size[1], size[0]), |(y, x)| blocks[[y / block, x / block]])
}

/// Cells of 10 x 14 database units on four levels.
fn choices(masks: Masks) -> ExportChoices {
    ExportChoices {
        pitch_um: Some([0.01, 0.014]),
        quantity: Quantity::Level,
        levels: Some(4),
        masks,
        overwrite: true,
        ..ExportChoices::default()
    }
}

/// Half the width of a picture in database units.
const HALF: i64 = 120;

/// What is drawn on each layer, as pictures of one square a database unit.
fn picture(shapes: &[Drawn]) -> BTreeMap<(u16, u16), Array2<bool>> {
    let mut pictures = BTreeMap::new();
    for (layer, data_type, corners) in shapes {
        let side = 2 * HALF as usize;
        let picture = (pictures.entry((*layer, *data_type)))
            .or_insert_with(|| Array2::from_elem((side, side), false));
        for y in corners[0][1]..corners[2][1] {
            for x in corners[0][0]..corners[2][0] {
                picture[[(y + HALF) as usize, (x + HALF) as usize]] = true;
            }
        }
    }
    pictures
}

/// The picture in which each square is on if all, or any, within a distance along x and y are on.
fn moved(picture: &Array2<bool>, distance: i64, all: bool) -> Array2<bool> {
    let (ny, nx) = picture.dim();
    let on = |y: i64, x: i64| {
        let inside = (0..ny as i64).contains(&y) && (0..nx as i64).contains(&x);
        inside && picture[[y as usize, x as usize]]
    };
    Array2::from_shape_fn((ny, nx), |(y, x)| {
        let near = -distance..=distance;
        let mut places = near.clone().flat_map(|v| near.clone().map(move |u| [v, u]));
        let mut is_on = |[v, u]: [i64; 2]| on(y as i64 + v, x as i64 + u);
        match all {
            true => places.all(&mut is_on),
            false => places.any(&mut is_on),
        }
    })
}

#[test]
fn an_etch_moves_the_edges_of_whole_patterns() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.gds");
    for (size, block) in [([14, 9], 1), ([14, 9], 2), ([1, 1], 1), ([12, 12], 3)] {
        let values = random(size, block);
        for masks in ALL {
            exported(&path, &values, &choices(masks));
            let plain = picture(&gds_shapes(&fs::read(&path).unwrap()));
            for units in [1_i64, 3, -1, -4] {
                let biased = ExportChoices {
                    etch_bias_um: units as f64 * 1e-3,
                    ..choices(masks)
                };
                exported(&path, &values, &biased);
                let shapes = gds_shapes(&fs::read(&path).unwrap());
                let made = picture(&shapes);
                for (layer, plain) in &plain {
                    let expected = moved(plain, units.abs(), units > 0);
                    assert!(
                        made[layer] == expected,
                        "{masks:?} {size:?} {units} {layer:?}"
                    );
                }
                assert_eq!(made.len(), plain.len());
                assert_eq!(read(&path, size, &biased), values, "{masks:?} {units}");
            }
        }
    }
}

#[test]
fn rectangles_of_one_layer_do_not_overlap() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.gds");
    let values = random([14, 9], 2);
    for units in [3, -3] {
        let biased = ExportChoices {
            etch_bias_um: f64::from(units) * 1e-3,
            ..choices(Masks::Each)
        };
        exported(&path, &values, &biased);
        let shapes = gds_shapes(&fs::read(&path).unwrap());
        let area = |(_, _, at): &Drawn| (at[2][0] - at[0][0]) * (at[2][1] - at[0][1]);
        let drawn: i64 = shapes.iter().map(area).sum();
        let seen = picture(&shapes).into_values().flatten().filter(|on| *on);
        assert_eq!(drawn as usize, seen.count());
    }
}

#[test]
fn gaps_are_on_level_0() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.gds");
    let tile = random([6, 4], 1);
    let values = Array2::from_shape_fn((8, 18), |(y, x)| tile[[y % 4, x % 6]]);
    for masks in ALL {
        // 0.36 of the area is 0.6 of each side: 6 x 8 of 10 x 14 units, as 1.4 of 2.8 are rounded to 3.
        let apart = ExportChoices {
            fill: Some(0.36),
            ..choices(masks)
        };
        let report = exported(&path, &values, &apart);
        assert_eq!(report.numbers["repeats"], 6.0);
        assert!(
            report.to_string().contains("0.006 x 0.008 µm each"),
            "{report}"
        );
        assert_eq!(read(&path, [18, 8], &apart), values, "{masks:?}");
        let made = picture(&gds_shapes(&fs::read(&path).unwrap()));
        let on = |level: f64| match masks {
            Masks::Binary => 0,
            _ => values.iter().filter(|value| **value == level).count() * 6 * 8,
        };
        let count = |layer| made[&layer].iter().filter(|on| **on).count();
        match masks {
            Masks::Each => assert_eq!(count((2, 0)), on(2.0)),
            Masks::Dose => assert_eq!(count((1, 2)), on(2.0)),
            // The first mask etches levels 0 and 1, and so gaps.
            Masks::Binary => {
                let stay = values.iter().filter(|value| **value > 1.0).count() * 48;
                assert_eq!(count((1, 0)), 180 * 112 - stay);
            }
        }
    }
    let message = {
        let unsized_file = ExportChoices {
            fill: Some(0.36),
            ..choices(Masks::Each)
        };
        read_masks(&path, &unsized_file).unwrap_err().to_string()
    };
    assert!(message.contains("size"), "{message}");
}

/// A scene of an element of pixels on four levels, with an aperture.
fn scene(room: &Path, aperture: &str, pixels: &str, rest: &str) -> PathBuf {
    let path = room.join("scene.toml");
    let text = format!(
        "version = 1\nwavelength_um = 0.5\n[source]\nkind = \"plane\"\n[[element]]\nkind = \"doe\"\nname = \"plate\"\n\
         thickness_mm = 5\naperture = {aperture}\n[[element.layer]]\nkind = \"pixels\"\npitch_um = [2, 3]\n{pixels}\n\
         [[element]]\nkind = \"sensor\"\npixels = [4, 4]\npitch_um = 5\n{rest}"
    );
    fs::write(&path, text).unwrap();
    path
}

const RING: &str = "{ disc = { radius_mm = 0.02 }, blocked = [{ disc = { radius_mm = 0.005, centre_mm = [0.004, 0] } }] }";

/// Whether the centre of a cell of 30 x 16 is in that aperture.
fn is_open(y: usize, x: usize) -> bool {
    let (u, v) = (2.0 * x as f64 - 29.0, 3.0 * y as f64 - 22.5);
    u.hypot(v) <= 20.0 && (u - 4.0).hypot(v) > 5.0
}

#[test]
fn cells_outside_of_the_aperture_are_on_level_0() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.gds");
    let levels = random([30, 16], 1);
    ndarray_npy::write_npy(room.path().join("p.npy"), &(&levels * (0.5 * PI))).unwrap();
    let scene = scene(room.path(), RING, "phase = \"p.npy\"", "");
    let open = Array2::from_shape_fn((16, 30), |(y, x)| f64::from(u8::from(is_open(y, x))));
    let closed = open.iter().filter(|open| **open == 0.0).count() as f64;
    assert!(closed > 50.0);
    for masks in ALL {
        let usual = ExportChoices {
            masks,
            overwrite: true,
            ..ExportChoices::default()
        };
        let report = export_element(ExportSource::File(&scene), &path, &usual).unwrap();
        assert_eq!(report.numbers["closed_cells"], closed);
        let given = ExportChoices {
            pitch_um: Some([2.0, 3.0]),
            levels: Some(4),
            ..usual.clone()
        };
        assert_eq!(read(&path, [30, 16], &given), &levels * &open, "{masks:?}");

        // As it looks from the other side, and all of it.
        let other = ExportChoices {
            mirror: true,
            ..usual.clone()
        };
        export_element(ExportSource::File(&scene), &path, &other).unwrap();
        let mut turned = &levels * &open;
        turned.invert_axis(ndarray::Axis(1));
        assert_eq!(read(&path, [30, 16], &given), turned, "{masks:?}");
        let whole = ExportChoices {
            whole_grid: true,
            ..usual
        };
        let report = export_element(ExportSource::File(&scene), &path, &whole).unwrap();
        assert!(report.lost.iter().any(|lost| lost.contains("aperture")));
        assert_eq!(read(&path, [30, 16], &given), levels, "{masks:?}");
    }
    // Values are zero.
    let path = room.path().join("a.npy");
    let usual = ExportChoices::default();
    export_element(ExportSource::File(&scene), &path, &usual).unwrap();
    let made: Array2<f64> = ndarray_npy::read_npy(&path).unwrap();
    assert_eq!(made, &levels * &open * (0.5 * PI));
}

#[test]
fn an_aperture_beside_the_cells_is_refused() {
    let room = tempfile::tempdir().unwrap();
    ndarray_npy::write_npy(room.path().join("p.npy"), &Array2::<f64>::zeros((4, 4))).unwrap();
    let far = "{ disc = { radius_mm = 0.01, centre_mm = [1, 0] } }";
    let scene = scene(room.path(), far, "phase = \"p.npy\"", "");
    let usual = ExportChoices::default();
    let path = room.path().join("a.csv");
    let refused = export_element(ExportSource::File(&scene), &path, &usual).unwrap_err();
    assert!(refused.to_string().contains("--whole-grid"), "{refused}");
}

#[test]
fn the_outline_is_drawn_on_its_own_layer() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.gds");
    let levels = random([30, 16], 1);
    ndarray_npy::write_npy(room.path().join("p.npy"), &(&levels * (0.5 * PI))).unwrap();
    let placed = "phase = \"p.npy\"\ncentre_mm = [0.001, 0]\nrotation_deg = 90";
    let scene = scene(room.path(), RING, placed, "");
    let drawn = ExportChoices {
        aperture_layer: Some(100),
        whole_grid: true,
        ..ExportChoices::default()
    };
    let report = export_element(ExportSource::File(&scene), &path, &drawn).unwrap();
    assert!(report.numbers["outline_error_nm"] <= 1.5);
    let shapes = gds_shapes(&fs::read(&path).unwrap());
    let outlines: Vec<&Drawn> = shapes.iter().filter(|shape| shape.0 == 100).collect();
    assert_eq!(outlines.len(), 2);
    // On axes that are shifted by 1 µm along x and turned by 90 degrees, the origin is at (0, 1 µm), and the place of the
    // obstruction at (0, −3 µm).
    for (outline, (data_type, y, radius)) in outlines.iter().zip([(0, 1e3, 2e4), (1, -3e3, 5e3)]) {
        assert_eq!(outline.1, data_type);
        for [u, v] in &outline.2 {
            let off = (*u as f64).hypot(*v as f64 - y) - radius;
            assert!(off.abs() < 0.75, "{off}");
        }
        assert!(outline.2.len() > 100);
    }
    // The reader leaves the layer out.
    let given = ExportChoices {
        pitch_um: Some([2.0, 3.0]),
        levels: Some(4),
        ..drawn.clone()
    };
    assert_eq!(read(&path, [30, 16], &given), levels);
    let refuse = |choices: ExportChoices| {
        let refused = export_element(ExportSource::File(&scene), &path, &choices);
        let refused = refused.unwrap_err().to_string();
        assert!(refused.contains("aperture_layer"), "{refused}");
    };
    refuse(ExportChoices {
        aperture_layer: Some(3),
        ..drawn.clone()
    });
    let refused = export_element(
        ExportSource::Array(BorrowedArray::Real(levels.view())),
        &path,
        &ExportChoices {
            pitch_um: Some([2.0; 2]),
            quantity: Quantity::Level,
            ..drawn
        },
    );
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("aperture_layer"), "{refused}");
}

/// Levels, gaps and heights that the scene states are taken without a choice.
#[test]
fn scenes_state_levels_and_gaps() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.gds");
    // Only levels 0 and 2 of four: alone they look like two levels.
    let phases = Array2::from_shape_fn((16, 30), |(y, x)| PI * ((x + y * y) % 2) as f64);
    ndarray_npy::write_npy(room.path().join("p.npy"), &phases).unwrap();
    let wide = "{ rectangle = { width_mm = 1, height_mm = 1 } }";
    let design = "[design]\n[[design.element]]\nname = \"plate\"\nlevels = 4\n[[design.loss]]\nkind = \"spot\"\n\
                  at_mm = [[0, 0]]\n";
    let numbers = |pixels: &str, rest: &str| {
        let scene = scene(room.path(), wide, pixels, rest);
        let usual = ExportChoices::default();
        export_element(ExportSource::File(&scene), &path, &usual).unwrap()
    };
    let plain = numbers("phase = \"p.npy\"", "");
    let stated = numbers("phase = \"p.npy\"", design);
    assert_eq!(
        [plain.numbers["levels"], stated.numbers["levels"]],
        [2.0, 4.0]
    );
    let given = ExportChoices {
        pitch_um: Some([2.0, 3.0]),
        ..ExportChoices::default()
    };
    assert_eq!(read(&path, [30, 16], &given), &phases * (4.0 / TAU));
    let gaps = numbers("phase = \"p.npy\"\nfill = 0.81\nrest = \"flat\"", design);
    assert!(gaps.to_string().contains("1.8 x 2.7 µm each"), "{gaps}");
    assert!(!gaps.to_string().contains("gaps between"), "{gaps}");
    let dark = numbers("phase = \"p.npy\"\nfill = 0.81", design);
    assert!(dark.to_string().contains("dark"), "{dark}");
}
