//! Tests: altered mask files and arrays give cells or an error with their file, and never end otherwise.
//!
//! `RAYLET_MUTATIONS=100000 cargo test -p raylet --lib mutated` makes a long run.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use ndarray::Array2;

use crate::file::arrays::array::BorrowedArray;
use crate::file::fabrication::cell_rows::Part;
use crate::file::fabrication::export::{ExportSource, export_element};
use crate::file::fabrication::export_choices::{ExportChoices, Masks, Quantity};
use crate::file::fabrication::gds::gds_reader::read_stream;
use crate::file::fabrication::npy_rows::npy_rows;
use crate::fixtures::mutations::{Numbers, altered_bytes, mutation_count};

/// Mutations of an ordinary run.
const MUTATIONS: u64 = 3000;

/// Bytes before the shapes of a mask file, about, and before the values of an array.
const HEAD: usize = 128;

/// Mask files of a random and of a repeated pattern.
fn masks(folder: &Path) -> Vec<Vec<u8>> {
    let path = folder.join("a.gds");
    let mut files = Vec::new();
    for masks in [Masks::Each, Masks::Binary, Masks::Dose] {
        for period in [12, 3] {
            let values = Array2::from_shape_fn((12, 12), |(y, x)| {
                ((7 * (y % period) + 3 * (x % period) * (x % period)) % 4) as f64
            });
            let choices = ExportChoices {
                pitch_um: Some([1.0; 2]),
                quantity: Quantity::Level,
                levels: Some(4),
                masks,
                ..ExportChoices::default()
            };
            let source = ExportSource::Array(BorrowedArray::Real(values.view()));
            export_element(source, &path, &choices).unwrap();
            files.push(fs::read(&path).unwrap());
        }
    }
    files
}

#[test]
fn mutated_mask_files_give_cells_or_an_error() {
    let room = tempfile::tempdir().unwrap();
    let files = masks(room.path());
    let mut good = 0;
    for seed in 0..mutation_count(MUTATIONS) {
        let mut numbers = Numbers(seed);
        let bytes = altered_bytes(&files[numbers.below(files.len())], HEAD, &mut numbers);
        let choices = ExportChoices {
            pitch_um: Some([1.0; 2]),
            masks: [Masks::Each, Masks::Binary, Masks::Dose][numbers.below(3)],
            levels: [None, Some(2), Some(4)][numbers.below(3)],
            size: [None, Some([12, 12])][numbers.below(2)],
            etch_bias_um: [0.0, 0.0, 0.0, 0.2][numbers.below(4)],
            aperture_layer: [None, Some(2)][numbers.below(8) / 7],
            ..ExportChoices::default()
        };
        match read_stream(Cursor::new(bytes), Path::new("a.gds"), &choices, 1 << 20) {
            Ok(read) => {
                assert_eq!(
                    read.levels.len(),
                    read.size[0] * read.size[1],
                    "seed {seed}"
                );
                assert!(
                    read.levels.iter().all(|level| *level < read.count),
                    "seed {seed}"
                );
                good += 1;
            }
            Err(fault) => {
                let message = fault.to_string();
                assert!(message.starts_with("a.gds"), "seed {seed}: {message}");
                assert!(message.len() < 5000, "seed {seed}");
            }
        }
    }
    assert!(
        good > mutation_count(MUTATIONS) / 20,
        "{good} of {}",
        mutation_count(MUTATIONS)
    );
}

#[test]
fn mutated_arrays_give_rows_or_an_error() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.npy");
    ndarray_npy::write_npy(&path, &Array2::<f32>::zeros((6, 5))).unwrap();
    let file = fs::read(&path).unwrap();
    for seed in 0..mutation_count(MUTATIONS) / 3 {
        let mut numbers = Numbers(seed);
        fs::write(&path, altered_bytes(&file, HEAD, &mut numbers)).unwrap();
        match npy_rows(&path, None, Part::Phase, 1.0) {
            Ok(mut read) => {
                let [nx, ny] = read.rows.size();
                assert!(nx * ny <= 1000, "seed {seed}");
                let mut row = vec![0.0; nx];
                (0..ny).for_each(|y| read.rows.row(y, &mut row).unwrap());
            }
            Err(fault) => assert!(fault.to_string().contains("a.npy"), "seed {seed}: {fault}"),
        }
    }
}
