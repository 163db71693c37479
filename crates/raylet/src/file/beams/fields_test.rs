//! Tests: fields that are written and read back.

use std::fs;

use ndarray::{Array1, Axis};

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npz::Fields;
use crate::file::beams::field_file::FieldFormat;
use crate::file::beams::fits_fields::write_fits;
use crate::file::beams::zbf_fields::BeamChoices;
use crate::file::maps::maps_test::fields;
use crate::file::result::conversion::{ConversionChoices, convert_field};
use crate::file::storage::own_file::{OwnFile, Replace};

const LIMIT: MemoryLimit = MemoryLimit {
    bytes: 1 << 20,
    set_by: "--limit",
};

/// One wavelength of fields.
fn first(fields: &Fields) -> Fields {
    Fields {
        field: fields.field.select(Axis(0), &[0]),
        wavelength_um: fields.wavelength_um.select(Axis(0), &[0]),
        ..fields.clone()
    }
}

/// Every bit, of one wavelength and of two.
#[test]
fn fields_come_back_as_they_were() {
    let room = tempfile::tempdir().unwrap();
    for name in ["a.fits", "a.fit", "a.h5", "a.hdf5", "a.npz"] {
        let path = room.path().join(name);
        let format = FieldFormat::of(&path).unwrap();
        for given in [fields(), first(&fields())] {
            let file = OwnFile::claim(&path, Replace::Own).unwrap();
            format.write(&file, &given).unwrap();
            drop(file);
            let read = format.read(&path, LIMIT).unwrap();
            assert_eq!(read, given, "{name}");
            let bits = |fields: &Fields| -> Vec<[u64; 2]> {
                let each = fields.field.iter();
                each.map(|u| [u.re.to_bits(), u.im.to_bits()]).collect()
            };
            assert_eq!(bits(&read), bits(&given), "{name}");
        }
    }
}

/// From each format to each other.
#[test]
fn fields_are_converted() {
    let room = tempfile::tempdir().unwrap();
    let names = ["a.npz", "b.fits", "c.h5", "d.npz"];
    let given = fields();
    let file = fs::File::create(room.path().join(names[0])).unwrap();
    given.write_npz(file).unwrap();
    let choices = ConversionChoices {
        wavelength: None,
        beam: BeamChoices::default(),
        overwrite: false,
        limit: LIMIT,
    };
    for pair in names.windows(2) {
        let [source, target] = [room.path().join(pair[0]), room.path().join(pair[1])];
        convert_field(&source, &target, &choices).unwrap();
        let read = FieldFormat::of(&target).unwrap().read(&target, LIMIT);
        assert_eq!(read.unwrap(), given, "{pair:?}");
    }
    let fault = convert_field(
        &room.path().join("a.npz"),
        &room.path().join("a.bmp"),
        &choices,
    );
    let message = fault.unwrap_err().to_string();
    assert!(message.contains(".zbf, .npz, .fits or .h5"), "{message}");
}

/// Without the extensions, positions and wavelength come from the header, as other programs write it.
#[test]
fn fits_headers_say_where_samples_are() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.fits");
    let given = first(&fields());
    let mut bytes = Vec::new();
    write_fits(&given, &mut bytes).unwrap();
    bytes.truncate(2 * 2880);
    fs::write(&path, &bytes).unwrap();
    let read = FieldFormat::Fits.read(&path, LIMIT).unwrap();
    let near = |a: &Array1<f64>, b: &Array1<f64>| (a - b).iter().all(|d| d.abs() < 1e-14);
    assert_eq!(read.field, given.field);
    assert!(
        near(&read.x_mm, &given.x_mm) && near(&read.y_mm, &given.y_mm),
        "{read:?}"
    );
    assert!(near(&read.wavelength_um, &given.wavelength_um));

    // A scale alone, in metres: the samples lie about the middle.
    let text = String::from_utf8_lossy(&bytes[..2880]).replace("CDELT", "CDOLT");
    let alone = [text.as_bytes(), &bytes[2880..]].concat();
    fs::write(&path, alone).unwrap();
    let read = FieldFormat::Fits.read(&path, LIMIT).unwrap();
    let half = 0.5;
    assert!((read.x_mm[0] + half).abs() < 1e-14 && (read.x_mm[3] - half).abs() < 1e-14);
}

#[test]
fn files_without_a_field_are_refused() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.fits");
    let mut bytes = Vec::new();
    write_fits(&first(&fields()), &mut bytes).unwrap();
    let text = String::from_utf8_lossy(&bytes[..2880]);
    for (from, to, words) in [
        ("Real part", "Intensity", "no image of a complex field"),
        ("SIMPLE  =", "SIMPLE  :", "at byte 0"),
        (
            "BITPIX  =                  -64",
            "BITPIX  =                  -63",
            "BITPIX",
        ),
        (
            "NAXIS   =                    3",
            "NAXIS   =                    2",
            "axes",
        ),
    ] {
        let bad = text.replace(from, to);
        fs::write(&path, [bad.as_bytes(), &bytes[2880..]].concat()).unwrap();
        let fault = FieldFormat::Fits.read(&path, LIMIT).unwrap_err();
        let message = fault.to_string();
        assert!(message.contains(words), "{message}");
    }
    bytes.truncate(2880 + 40);
    fs::write(&path, &bytes).unwrap();
    let fault = FieldFormat::Fits.read(&path, LIMIT).unwrap_err();
    assert!(
        fault.to_string().contains("40 bytes behind byte 2880"),
        "{fault}"
    );
}
