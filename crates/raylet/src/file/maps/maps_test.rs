//! Tests: maps byte by byte, and what is refused.

use std::fs;
use std::io::Cursor;

use hdf5_pure::{AttrValue, FileBuilder};
use ndarray::{Array1, Array2, Array3, Axis, array};
use num_complex::Complex64;
use tiff::encoder::{TiffEncoder, colortype};

use crate::file::arrays::array::Array;
use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npz::Fields;
use crate::file::beams::fits_fields::write_fits;
use crate::file::beams::hdf5_fields::write_hdf5;
use crate::file::maps::array_file::read_array;
use crate::file::maps::map_file::{Fill, MapChoices, read_map};
use crate::file::maps::measured_map::MeasuredMap;

/// More than any of these files takes.
pub(crate) const LIMIT: MemoryLimit = MemoryLimit {
    bytes: 1 << 20,
    set_by: "--limit",
};

/// A file of MetroPro with `pictures` of intensity; the sample (x, y) from the top left is 1000 (10 y + x), and the
/// last one is missing.
pub(crate) fn zygo_bytes(mark: u32, resolution: u16, pictures: u16, [nx, ny]: [u16; 2]) -> Vec<u8> {
    let length: u32 = if mark == 0x881B_0371 { 4096 } else { 834 };
    let mut bytes = vec![0; length as usize];
    let mut put = |at: usize, what: &[u8]| bytes[at..at + what.len()].copy_from_slice(what);
    put(0, &mark.to_be_bytes());
    put(4, &1u16.to_be_bytes());
    put(6, &length.to_be_bytes());
    for (at, whole) in [
        (52, 3),
        (54, 2),
        (56, pictures),
        (68, nx),
        (70, ny),
        (218, resolution),
    ] {
        put(at, &u16::to_be_bytes(whole));
    }
    for (at, real) in [(164, 0.5f32), (168, 6.328e-7), (176, 1.0), (184, 2e-4)] {
        put(at, &real.to_be_bytes());
    }
    bytes.extend(vec![7; 2 * 3 * 2 * usize::from(pictures)]);
    for y in 0..i32::from(ny) {
        for x in 0..i32::from(nx) {
            let last = (x, y) == (i32::from(nx) - 1, i32::from(ny) - 1);
            let stored = if last {
                2_147_483_640
            } else {
                1000 * (10 * y + x)
            };
            bytes.extend(stored.to_be_bytes());
        }
    }
    // Without pictures the header says no size of one.
    if pictures == 0 {
        bytes[52..56].fill(0);
    }
    bytes
}

/// A picture of 5 × 4 samples of 16 bits in two strips.
pub(crate) fn tiff_bytes() -> Vec<u8> {
    let samples: Vec<u16> = (0..20).map(|i| 1000 + i).collect();
    let mut bytes = Vec::new();
    let mut encoder = TiffEncoder::new(Cursor::new(&mut bytes)).unwrap();
    let mut picture = encoder.new_image::<colortype::Gray16>(5, 4).unwrap();
    picture.rows_per_strip(2).unwrap();
    picture.write_data(&samples).unwrap();
    bytes
}

/// A FITS file of some cards and data.
fn fits_of(cards: &[&str], data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for card in cards.iter().chain(&["END"]) {
        bytes.extend(format!("{card:<80}").bytes());
    }
    bytes.resize(bytes.len().next_multiple_of(2880), b' ');
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(2880), 0);
    bytes
}

/// An image of 3 × 2 whole numbers 0 … 5, each meant as 10 + 2 n nm; number 4 is missing.
pub(crate) fn fits_bytes() -> Vec<u8> {
    let cards = [
        "SIMPLE  =                    T / FITS",
        "BITPIX  =                   16",
        "NAXIS   =                    2",
        "NAXIS1  =                    3",
        "NAXIS2  =                    2",
        "BSCALE  =                2.0D0",
        "BZERO   =                 10.0",
        "BLANK   =                    4",
        "BUNIT   = 'nm      '           / it''s a unit",
        "CDELT1  =                0.002",
        "CDELT2  =                0.003",
        "CUNIT1  = 'mm'",
        "CUNIT2  = 'mm'",
    ];
    let data: Vec<u8> = (0..6i16).flat_map(i16::to_be_bytes).collect();
    fits_of(&cards, &data)
}

/// A packed array of 3 × 4 heights in nm whose rows fall, with its axes.
pub(crate) fn hdf5_bytes() -> Vec<u8> {
    let mut file = FileBuilder::new();
    let heights: Vec<f32> = (0..12).map(|i| i as f32).collect();
    let array = file.create_dataset("height");
    array.with_f32_data(&heights).with_shape(&[3, 4]);
    array.with_chunks(&[2, 2]).with_deflate(6);
    array.set_attr("units", AttrValue::String(String::from("nm")));
    file.create_dataset("x_mm")
        .with_f64_data(&[0.0, 0.5, 1.0, 1.5]);
    file.create_dataset("y_mm")
        .with_f64_data(&[0.25, 0.0, -0.25]);
    file.finish().unwrap()
}

/// Fields of two wavelengths on a grid of 4 × 3.
pub(crate) fn fields() -> Fields {
    Fields {
        field: Array3::from_shape_fn((2, 3, 4), |(k, y, x)| {
            Complex64::new((100 * k + 10 * y + x) as f64 / 3.0, -(x as f64) / 7.0)
        }),
        x_mm: Array1::from_iter((0..4).map(|x| f64::from(x) / 3.0 - 0.1)),
        y_mm: Array1::from_iter((0..3).map(|y| f64::from(y) / 7.0 + 0.2)),
        wavelength_um: Array1::from(vec![0.5, 0.633]),
    }
}

fn write(name: &str, bytes: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join(name);
    fs::write(&path, bytes).unwrap();
    (room, path)
}

fn read(name: &str, bytes: &[u8], fill: Option<Fill>) -> Result<MeasuredMap, String> {
    let (_room, path) = write(name, bytes);
    let choices = MapChoices {
        key: None,
        fill,
        limit: LIMIT,
    };
    read_map(&path, &choices).map_err(|fault| fault.to_string())
}

fn of_scene(name: &str, bytes: &[u8], field: &str) -> Result<Array, String> {
    let (_room, path) = write(name, bytes);
    let read = read_array(&path, None, field, LIMIT.bytes);
    read.map(|array| Array::clone(&array.values))
        .map_err(|fault| fault.to_string())
}

fn real(map: MeasuredMap) -> Array2<f64> {
    match map.values {
        Array::Real(values) => values,
        Array::Complex(values) => panic!("{values}"),
    }
}

/// Heights are S O λ / R times what is stored; the top row comes last.
#[test]
fn every_version_of_metropro_is_read() {
    for (mark, resolution, unit) in [
        (0x881B_036F, 0, 4096.0),
        (0x881B_0370, 1, 32768.0),
        (0x881B_0371, 2, 131_072.0),
    ] {
        for pictures in [0, 1, 3] {
            let bytes = zygo_bytes(mark, resolution, pictures, [3, 2]);
            let map = read("a.dat", &bytes, None).unwrap();
            assert_eq!(map.unit.as_deref(), Some("m"));
            let pitch = map.pitch_um.unwrap();
            assert!((pitch[0] - 200.0).abs() < 1e-4 && pitch[0] == pitch[1]);
            let values = real(map);
            let stored = array![[10.0, 11.0, 12.0], [0.0, 1.0, 2.0]];
            let lost = [0, 2];
            assert!(values[lost].is_nan());
            for (at, stored) in stored.indexed_iter().filter(|(at, _)| *at != (0, 2)) {
                let expected = 1000.0 * stored * 0.5 * f64::from(6.328e-7f32) / unit;
                assert!((values[at] - expected).abs() < 1e-20, "{at:?}");
            }
        }
    }
}

#[test]
fn missing_samples_are_filled_or_refused() {
    let bytes = zygo_bytes(0x881B_036F, 1, 1, [3, 2]);
    let refusal = of_scene("a.dat", &bytes, "height_um").unwrap_err();
    assert!(
        refusal.contains("1 missing samples of 6, the first at [0, 2]"),
        "{refusal}"
    );
    let filled = real(read("a.dat", &bytes, Some(Fill::Value(0.5))).unwrap());
    assert_eq!(filled[[0, 2]], 0.5);
    let filled = real(read("a.dat", &bytes, Some(Fill::Nearest)).unwrap());
    // Of two that are as near, that of its own column.
    assert_eq!(filled[[0, 2]], filled[[1, 2]]);
}

#[test]
fn maps_of_metropro_that_cannot_be_used() {
    let good = zygo_bytes(0x881B_036F, 1, 1, [3, 2]);
    let refusal = |at: usize, bytes: &[u8], key: &str| {
        let mut bad = good.clone();
        bad[at..at + bytes.len()].copy_from_slice(bytes);
        of_scene("a.dat", &bad, key).unwrap_err()
    };
    for (at, bytes, words) in [
        (0, &[1, 2, 3, 4][..], "0x01020304 at byte 0"),
        (0, b"1234", "expected"),
        (6, &[0, 0, 1, 0], "a header of 256 bytes"),
        (218, &[0, 3], "resolution 3 in byte 218"),
        (68, &[0, 0], "0 x 2 heights"),
        (168, &[0x7f, 0xc0, 0, 0], "wavelength in m NaN"),
        (232, &[0, 1], "sign 1 in byte 232"),
        (68, &[0xff, 0xff], "bytes, expected"),
    ] {
        let message = refusal(at, bytes, "height_um");
        assert!(message.contains(words), "{message}");
    }
    let message = of_scene("a.dat", &good, "phase").unwrap_err();
    assert!(message.contains("values in `m`"), "{message}");
    let empty = of_scene("a.dat", &[], "phase").unwrap_err();
    assert!(empty.contains("no lines"), "{empty}");
}

/// The top row of a picture comes last; numbers are as they are stored.
#[test]
fn pictures_are_read_from_the_top() {
    let values = real(read("a.tif", &tiff_bytes(), None).unwrap());
    let expected = Array2::from_shape_fn((4, 5), |(y, x)| (1000 + 5 * (3 - y) + x) as f64);
    assert_eq!(values, expected);
    assert_eq!(
        of_scene("a.tiff", &tiff_bytes(), "phase"),
        Ok(Array::Real(expected))
    );

    // Numbers of 32 bits, some of them missing.
    let mut bytes = Vec::new();
    let mut encoder = TiffEncoder::new(Cursor::new(&mut bytes)).unwrap();
    let samples = [0.25f32, f32::NAN, -1.5, 1e-3];
    encoder
        .write_image::<colortype::Gray32Float>(2, 2, &samples)
        .unwrap();
    let values = real(read("a.tif", &bytes, None).unwrap());
    assert!(values[[1, 1]].is_nan());
    assert_eq!(values[[0, 1]], f64::from(1e-3f32));
    let refusal = of_scene("a.tif", &bytes, "phase").unwrap_err();
    assert!(refusal.contains("1 missing samples of 4"), "{refusal}");
}

#[test]
fn pictures_that_cannot_be_used() {
    let mut colours = Vec::new();
    let mut encoder = TiffEncoder::new(Cursor::new(&mut colours)).unwrap();
    encoder
        .write_image::<colortype::RGB8>(1, 1, &[1, 2, 3])
        .unwrap();
    let refusal = read("a.tif", &colours, None).unwrap_err();
    assert!(refusal.contains("a picture of kind RGB(8)"), "{refusal}");
    assert!(read("a.tif", b"no picture", None).is_err());

    // Two pictures: a user has to say which is meant.
    let mut both = Vec::new();
    let mut encoder = TiffEncoder::new(Cursor::new(&mut both)).unwrap();
    encoder.write_image::<colortype::Gray8>(1, 1, &[1]).unwrap();
    encoder.write_image::<colortype::Gray8>(1, 1, &[2]).unwrap();
    let map = read("a.tif", &both, None).unwrap();
    assert_eq!(map.doubts.len(), 1);
    assert!(
        of_scene("a.tif", &both, "phase")
            .unwrap_err()
            .contains("several pictures")
    );
}

/// The first row is at the smallest y; BZERO + BSCALE n in the unit of BUNIT.
#[test]
fn images_of_fits_are_read_from_the_bottom() {
    let map = read("a.fits", &fits_bytes(), None).unwrap();
    assert_eq!(map.unit.as_deref(), Some("nm"));
    assert_eq!(map.pitch_um, Some([2.0, 3.0]));
    let values = real(map);
    assert_eq!(values.row(0).to_vec(), [10.0, 12.0, 14.0]);
    assert!(values[[1, 1]].is_nan());
    let (_room, path) = write("a.fits", &fits_bytes());
    let refusal = read_array(&path, Some("OPD"), "height_um", 1000).unwrap_err();
    assert!(refusal.to_string().contains("no image `OPD`"), "{refusal}");
    let whole = String::from_utf8_lossy(&fits_bytes()).replace("BLANK ", "BLANC ");
    let heights = of_scene("a.fits", whole.as_bytes(), "height_um").unwrap();
    let expected = array![[0.01, 0.012, 0.014], [0.016, 0.018, 0.02]];
    match heights {
        Array::Real(heights) => assert!((heights - expected).iter().all(|d| d.abs() < 1e-17)),
        Array::Complex(values) => panic!("{values}"),
    }
}

#[test]
fn arrays_of_hdf5_are_read_as_their_axes_say() {
    let map = read("a.h5", &hdf5_bytes(), None).unwrap();
    assert_eq!(
        (map.unit.as_deref(), map.pitch_um),
        (Some("nm"), Some([500.0, 250.0]))
    );
    let expected = Array2::from_shape_fn((3, 4), |(y, x)| (4 * (2 - y) + x) as f64);
    assert_eq!(real(map), expected);
    let heights = of_scene("a.h5", &hdf5_bytes(), "height_um").unwrap();
    assert_eq!(heights, Array::Real(expected * 1e-3));
    let refusal = of_scene("a.h5", b"\x89HDF\r\n\x1a\n and no more", "phase").unwrap_err();
    assert!(refusal.contains("a.h5"), "{refusal}");
}

/// Sizes that no file of this length holds are refused before memory is taken.
#[test]
fn sizes_are_held_to_the_file_and_the_limit() {
    let large = String::from_utf8_lossy(&fits_bytes()).replace("        3", "900000000");
    let refusal = read("a.fits", large.as_bytes(), None).unwrap_err();
    assert!(refusal.contains("2880 bytes behind byte 2880"), "{refusal}");
    let mut bytes = tiff_bytes();
    let width = bytes
        .windows(4)
        .position(|w| w == [0, 1, 3, 0] || w == [0, 1, 4, 0])
        .unwrap();
    bytes[width + 6..width + 10].copy_from_slice(&[0, 0, 0xff, 0x0f]);
    assert!(read("a.tif", &bytes, None).is_err());
    for (name, bytes) in [
        ("a.dat", zygo_bytes(0x881B_036F, 1, 1, [3, 2])),
        ("a.h5", hdf5_bytes()),
    ] {
        let (_room, path) = write(name, &bytes);
        let refusal = read_array(&path, None, "height_um", 40)
            .unwrap_err()
            .to_string();
        assert!(refusal.contains("settings.memory_limit_mb"), "{refusal}");
    }
}

#[test]
fn complex_samples_come_from_fields() {
    let fields = fields();
    let one = |[x, y]: [f64; 2]| Fields {
        field: fields.field.select(Axis(0), &[1]),
        wavelength_um: fields.wavelength_um.select(Axis(0), &[1]),
        x_mm: Array1::from_iter((0..4).map(|i| f64::from(i) - 1.5 + x)),
        y_mm: Array1::from_iter((0..3).map(|i| f64::from(i) - 1.0 + y)),
    };
    let files = |one: &Fields| {
        let (mut fits, mut hdf5) = (Vec::new(), Vec::new());
        write_fits(one, &mut fits).unwrap();
        write_hdf5(one, &mut hdf5).unwrap();
        [("f.fits", None, fits), ("f.h5", Some("field"), hdf5)]
    };
    let centred = one([0.0; 2]);
    let expected: Array2<Complex64> = centred.field.index_axis(Axis(0), 0).to_owned();
    for (name, key, bytes) in files(&centred) {
        let (_room, path) = write(name, &bytes);
        let samples = read_array(&path, key, "samples", 1 << 20).unwrap();
        assert_eq!(*samples.values, Array::Complex(expected.clone()), "{name}");
        assert_eq!(samples.pitch_um, Some([1000.0; 2]), "{name}");
    }

    // A source half a step beside the axis is another one; a map may lie there.
    for (name, key, bytes) in files(&one([0.0, -0.5])) {
        let (_room, path) = write(name, &bytes);
        let refusal = read_array(&path, key, "samples", 1 << 20).unwrap_err();
        let words = "middle along y is at -0.5 mm";
        assert!(refusal.to_string().contains(words), "{refusal}");
        assert!(read_array(&path, key, "transmission", 1 << 20).is_ok());
    }
    for (name, key, bytes) in files(&one([2.0, 0.0])) {
        let (_room, path) = write(name, &bytes);
        assert!(read_array(&path, key, "transmission", 1 << 20).is_err());
    }
}
