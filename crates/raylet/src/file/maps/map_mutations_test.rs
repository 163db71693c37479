//! Tests: altered arrays, pictures, maps and fields give values or an error with their file, and never end otherwise.
//!
//! `RAYLET_MUTATIONS=100000 cargo test -p raylet --lib mutated_maps` makes a long run.

use std::fs;
use std::path::Path;

use ndarray::Array2;

use crate::file::arrays::array::Array;
use crate::file::arrays::image::{read_gray, write_gray16};
use crate::file::arrays::memory::MemoryLimit;
use crate::file::beams::field_file::FieldFormat;
use crate::file::maps::array_file::read_array;
use crate::file::maps::map_file::{Fill, MapChoices, read_map};
use crate::file::maps::maps_test::{LIMIT, fields, fits_bytes, hdf5_bytes, tiff_bytes, zygo_bytes};
use crate::file::storage::own_file::{OwnFile, Replace};
use crate::fixtures::mutations::{Numbers, altered_bytes, mutation_count};

/// Mutations of an ordinary run, of each kind of file.
const MUTATIONS: u64 = 300;

/// Bytes near the start of a file, where half of the places are.
const HEAD: usize = 400;

/// Reads altered copies of a file again and again.
fn endure(name: &str, bytes: &[u8], read: impl Fn(&Path, &mut Numbers) -> Result<(), String>) {
    let count = mutation_count(MUTATIONS);
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join(name);
    let mut good = 0;
    for seed in 0..count {
        let mut numbers = Numbers(seed);
        fs::write(&path, altered_bytes(bytes, HEAD, &mut numbers)).unwrap();
        match read(&path, &mut numbers) {
            Ok(()) => good += 1,
            Err(message) => {
                assert!(message.contains(name), "{name} seed {seed}: {message}");
                assert!(message.len() < 5000, "{name} seed {seed}");
            }
        }
    }
    assert!(good > 0, "{name}: none of {count} could be read");
}

/// Reads a file as a map, and as the array of a key of a scene.
fn map(path: &Path, numbers: &mut Numbers) -> Result<(), String> {
    let choices = MapChoices {
        key: None,
        fill: [None, Some(Fill::Nearest), Some(Fill::Value(0.0))][numbers.below(3)],
        limit: LIMIT,
    };
    let field = ["height_um", "phase", "samples"][numbers.below(3)];
    if let Ok(array) = read_array(path, None, field, LIMIT.bytes) {
        assert!(array.values.borrowed().check(field).is_ok());
    }
    let map = read_map(path, &choices).map_err(|fault| fault.to_string())?;
    assert!(map.values.bytes() <= LIMIT.bytes);
    assert!(
        map.pitch_um
            .is_none_or(|pitch| pitch.iter().all(|step| *step > 0.0))
    );
    Ok(())
}

#[test]
fn mutated_maps_of_metropro() {
    endure("a.dat", &zygo_bytes(0x881B_036F, 1, 0, [5, 4]), map);
    endure("a.dat", &zygo_bytes(0x881B_0371, 0, 2, [5, 4]), map);
}

#[test]
fn mutated_maps_of_zemax() {
    let grid = "! a grid\n3 2 0.05 0.05 0 0 0\n1 0 0 0\n2 0 0 0\n3\n4\n5 0 0 0 0\n6 0.5 0 0 0\n";
    endure("a.dat", grid.as_bytes(), map);
}

#[test]
fn mutated_maps_of_tiff() {
    endure("a.tif", &tiff_bytes(), map);
}

#[test]
fn mutated_maps_of_fits() {
    endure("a.fits", &fits_bytes(), map);
}

#[test]
fn mutated_maps_of_hdf5() {
    endure("a.h5", &hdf5_bytes(), map);
}

#[test]
fn mutated_maps_of_numpy() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.npy");
    let values = Array2::from_shape_fn((4, 5), |(y, x)| (10 * y + x) as f64);
    ndarray_npy::write_npy(&path, &values).unwrap();
    endure("a.npy", &fs::read(&path).unwrap(), map);
    let path = room.path().join("a.npz");
    let mut writer = ndarray_npy::NpzWriter::new_compressed(fs::File::create(&path).unwrap());
    writer.add_array("height_um", &values).unwrap();
    writer.add_array("phase", &values).unwrap();
    writer.finish().unwrap();
    endure("a.npz", &fs::read(&path).unwrap(), map);
}

#[test]
fn mutated_maps_of_png() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.png");
    let values = Array2::from_shape_fn((4, 5), |(y, x)| (5 * y + x) as f64 / 20.0);
    write_gray16(&path, values.view(), [0.0, 1.0]).unwrap();
    endure("a.png", &fs::read(&path).unwrap(), |path, _| {
        let limit = MemoryLimit::of_settings(LIMIT.bytes);
        let picture = read_gray(path, limit).map_err(|error| error.to_string())?;
        assert!(Array::Real(picture).bytes() <= LIMIT.bytes);
        Ok(())
    });
}

#[test]
fn mutated_maps_of_fields() {
    let room = tempfile::tempdir().unwrap();
    for name in ["f.fits", "f.h5", "f.npz"] {
        let path = room.path().join(name);
        let format = FieldFormat::of(&path).unwrap();
        let file = OwnFile::claim(&path, Replace::Own).unwrap();
        format.write(&file, &fields()).unwrap();
        drop(file);
        endure(name, &fs::read(&path).unwrap(), |path, _| {
            let read = format
                .read(path, LIMIT)
                .map_err(|fault| fault.to_string())?;
            assert!(read.check_for(path).is_ok());
            Ok(())
        });
    }
}
