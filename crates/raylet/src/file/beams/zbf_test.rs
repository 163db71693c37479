//! Tests: beam files byte by byte, and fields that are written and read back.

use std::fs;
use std::path::Path;

use ndarray::{Array1, Array2, Array3, Axis};
use num_complex::Complex64;

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npz::Fields;
use crate::file::beams::zbf_fields::{BeamChoices, read_zbf};
use crate::file::beams::zbf_header::{Header, Pilot};
use crate::file::beams::zbf_reader::{Beam, read_stream};
use crate::file::beams::zbf_writer::BeamPlan;
use crate::file::result::comparison::Side;
use crate::file::result::conversion::{ConversionChoices, convert_field};

/// More than any of these files takes.
pub(crate) const LIMIT: MemoryLimit = MemoryLimit {
    bytes: 1 << 20,
    set_by: "--limit",
};

/// Sample (x, y) of a pattern without symmetry; Ey is twice as large.
fn pattern(x: u32, y: u32) -> Complex64 {
    Complex64::new(f64::from(x) + 10.0 * f64::from(y), 0.5 + f64::from(x * y))
}

/// A beam file written number by number: the layouts of version 1, and of version 0 with 10 and 11 numbers.
pub(crate) fn bytes_of(layout: usize, size: [u32; 2], polarised: bool, unit: u32) -> Vec<u8> {
    let [nx, ny] = size;
    let version = u32::from(layout == 20);
    let mut bytes = Vec::new();
    for whole in [version, nx, ny, u32::from(polarised), unit, 4, 5, 6, 7] {
        bytes.extend(whole.to_le_bytes());
    }
    let numbers: &[f64] = match layout {
        20 => &[0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 5e-4, 1.5, 0.9, 0.8],
        10 => &[0.25, 0.5, 1.0, 2.0, 5e-4, 4.0, 5.0, 6.0, 3.0, 1.5],
        _ => &[0.25, 0.5, 1.0, 2.0, 5e-4, 3.0],
    };
    let mut numbers = numbers.to_vec();
    numbers.resize(layout, 7.0);
    for factor in [1.0, 2.0].iter().take(if polarised { 2 } else { 1 }) {
        for y in 0..ny {
            for x in 0..nx {
                let e = pattern(x, y) * factor;
                numbers.extend([e.re, e.im]);
            }
        }
    }
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    bytes
}

fn read(bytes: &[u8], second: bool) -> Result<Beam, (String, String)> {
    read_stream(bytes, bytes.len() as u64, second, LIMIT)
}

#[test]
fn every_layout_unit_and_component_is_read() {
    let mm = [1.0, 10.0, 25.4, 1000.0];
    for layout in [20, 10, 11] {
        for (unit, mm) in (0..).zip(mm) {
            for (polarised, second) in [(false, false), (true, false), (true, true)] {
                let case = format!("{layout} {unit} {polarised} {second}");
                let beam = read(&bytes_of(layout, [4, 3], polarised, unit), second).unwrap();
                let factor = if second { 2.0 } else { 1.0 };
                let wanted =
                    Array2::from_shape_fn((3, 4), |(y, x)| pattern(x as u32, y as u32) * factor);
                assert_eq!(beam.samples, wanted, "{case}");
                let header = &beam.header;
                assert_eq!(header.step_mm, [0.25 * mm, 0.5 * mm], "{case}");
                assert_eq!(header.wavelength_mm, 5e-4 * mm, "{case}");
                assert_eq!(header.index, if layout == 11 { 1.0 } else { 1.5 });
                let along = |z: f64, rayleigh: f64, waist: f64| Pilot {
                    z: z * mm,
                    rayleigh: rayleigh * mm,
                    waist: waist * mm,
                };
                let y = match layout {
                    11 => along(1.0, 2.0, 3.0),
                    _ => along(4.0, 5.0, 6.0),
                };
                assert_eq!(header.pilot, [along(1.0, 2.0, 3.0), y], "{case}");
                let power: f64 = wanted.iter().map(Complex64::norm_sqr).sum();
                let other = match (polarised, second) {
                    (false, _) => 0.0,
                    (true, false) => 4.0 * power,
                    (true, true) => power / 4.0,
                };
                assert!((beam.other_power - other).abs() < 1e-9 * power, "{case}");
            }
        }
    }
}

/// The smallest x and y come first; the sample n/2 is at zero; amplitudes are conjugate, over √(dx dy).
#[test]
fn a_beam_becomes_a_field() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.zbf");
    fs::write(&path, bytes_of(20, [4, 2], true, 1)).unwrap();
    let (fields, report) = read_zbf(&path, BeamChoices::default(), LIMIT).unwrap();
    assert_eq!(fields.x_mm.to_vec(), [-5.0, -2.5, 0.0, 2.5]);
    assert_eq!(fields.y_mm.to_vec(), [-5.0, 0.0]);
    assert!((fields.wavelength_um[0] - 7.5).abs() < 1e-14);
    let scale = (2.5f64 * 5.0).sqrt();
    for ((_, y, x), u) in fields.field.indexed_iter() {
        let wanted = pattern(x as u32, y as u32).conj() / scale;
        assert!((u - wanted).norm() < 1e-14, "{x} {y}");
    }
    assert!((report.numbers["share_left_out"] - 0.8).abs() < 1e-15);
    assert!(report.to_string().contains("Ey, with 80 %"), "{report}");

    // The same file for a comparison.
    let side = Side::read(&path, LIMIT).unwrap();
    assert_eq!(side.fields, fields);
    assert!(side.left_out.iter().any(|text| text.contains("Ey")));
}

/// A point source behind the waist of a pilot beam: its wave is a constant on the sphere.
#[test]
fn the_reference_sphere_is_added_on_request() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.zbf");
    let header = |z: [f64; 2]| Header {
        pilot: z.map(|z| Pilot {
            z,
            rayleigh: 1.0,
            waist: 0.1,
        }),
        index: 1.5,
        ..Header::parse(&bytes_of(20, [4, 2], false, 0), 196 + 128).unwrap()
    };
    let write = |z| {
        let mut bytes = header(z).to_bytes();
        bytes.extend((0..8).flat_map(|_| [1f64, 0.0]).flat_map(f64::to_le_bytes));
        fs::write(&path, bytes).unwrap();
    };
    let sphere = |sphere| {
        let second = false;
        read_zbf(&path, BeamChoices { second, sphere }, LIMIT)
    };
    for radius in [20.0f64, -20.0] {
        write([radius; 2]);
        let (plain, report) = sphere(false).unwrap();
        assert!(report.to_string().contains("--sphere"), "{report}");
        let (added, _) = sphere(true).unwrap();
        for ((k, y, x), u) in added.field.indexed_iter() {
            let distance = (400.0 + plain.x_mm[x].powi(2) + plain.y_mm[y].powi(2)).sqrt() - 20.0;
            let phase = radius.signum() * std::f64::consts::TAU / 5e-4 * distance;
            let wanted = plain.field[[k, y, x]] * Complex64::cis(phase);
            assert!((u - wanted).norm() < 1e-9, "{x} {y}");
        }
    }
    // A plane within the Rayleigh range; spheres that differ.
    write([0.5; 2]);
    assert_eq!(sphere(true).unwrap().0, sphere(false).unwrap().0);
    write([20.0, 21.0]);
    assert!(sphere(true).unwrap_err().to_string().contains("--sphere"));
}

/// Two channels of unlike patterns on samples of `step` mm, which lie off the axis.
fn fields(size: [usize; 2], step: [f64; 2]) -> Fields {
    let axis = |n: usize, step: f64| -> Array1<f64> {
        (0..n)
            .map(|i| 1.0 + (i as f64 - (n - 1) as f64 / 2.0) * step)
            .collect()
    };
    Fields {
        field: Array3::from_shape_fn((2, size[1], size[0]), |(k, y, x)| {
            (1.0 + k as f64) * Complex64::new(0.1 + x as f64 / 7.0, y as f64 / 3.0 - 1.0)
        }),
        x_mm: axis(size[0], step[0]),
        y_mm: axis(size[1], step[1]),
        wavelength_um: Array1::from(vec![0.5, 0.6]),
    }
}

/// √(dx dy) is a power of two here, by which amplitudes are scaled without rounding.
#[test]
fn what_is_written_reads_back_bit_equal() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.zbf");
    for (size, rounding) in [([32, 64], 0.0), ([5, 36], 0.0), ([6, 33], 3e-16)] {
        let step = if rounding == 0.0 {
            [0.125; 2]
        } else {
            [0.1, 0.3]
        };
        let given = fields(size, step);
        let plan = BeamPlan::new(&path, &given, 1).unwrap();
        let mut bytes = Vec::new();
        plan.write(&mut bytes).unwrap();
        fs::write(&path, &bytes).unwrap();
        let (back, report) = read_zbf(&path, BeamChoices::default(), LIMIT).unwrap();
        assert!(
            report.to_string().contains("relative to a plane"),
            "{report}"
        );

        // Zeros lie around; the sample at or behind the middle of the field is that at zero.
        let padded = size.map(|n| n.max(32).next_power_of_two());
        assert_eq!(back.field.dim(), (1, padded[1], padded[0]));
        let [left, below] = [0, 1].map(|a| padded[a] / 2 - size[a] / 2);
        for ((_, y, x), u) in back.field.indexed_iter() {
            let inside = y.checked_sub(below).zip(x.checked_sub(left));
            let wanted = inside.and_then(|(y, x)| given.field.get([1, y, x]).copied());
            let wanted = wanted.unwrap_or_default();
            assert!((u - wanted).norm() <= rounding * wanted.norm(), "{x} {y}");
        }
        let middle = plan.report().numbers["middle_x_mm"];
        assert_eq!(middle, given.x_mm[size[0] / 2]);
        assert!((back.x_mm[left] - (given.x_mm[0] - middle)).abs() < 1e-12);
        let power = plan.report().numbers["power"];
        let file = read(&bytes, false).unwrap();
        let sum: f64 = file.samples.iter().map(Complex64::norm_sqr).sum();
        assert!((sum - power).abs() < 1e-12 * power);

        // The bytes of a beam that was read are the same again.
        let same = BeamPlan::new(&path, &back, 0).unwrap();
        let mut again = Vec::new();
        same.write(&mut again).unwrap();
        if rounding == 0.0 {
            assert_eq!(again[196..], bytes[196..]);
        }
    }
}

#[test]
fn files_are_converted_by_their_names() {
    let room = tempfile::tempdir().unwrap();
    let at = |name: &str| room.path().join(name);
    let given = fields([32, 32], [0.125; 2]);
    given
        .write_npz(fs::File::create(at("field.npz")).unwrap())
        .unwrap();
    let choices = |wavelength| ConversionChoices {
        wavelength,
        beam: BeamChoices::default(),
        overwrite: false,
        limit: LIMIT,
    };
    let convert = |from: &Path, to: &str, n| convert_field(from, &at(to), &choices(n));

    // A folder of results, one wavelength of it, and back.
    let several = convert(room.path(), "a.zbf", None).unwrap_err();
    assert!(several.to_string().contains("--wavelength"), "{several}");
    assert!(convert(room.path(), "a.zbf", Some(3)).is_err());
    let report = convert(room.path(), "a.zbf", Some(2)).unwrap();
    assert!(report.to_string().contains("0.6 µm"), "{report}");
    convert(&at("a.zbf"), "b.npz", None).unwrap();
    let back = Fields::read(&at("b.npz"), LIMIT).unwrap();
    assert_eq!(
        back.field.index_axis(Axis(0), 0),
        given.field.index_axis(Axis(0), 1)
    );
    convert(&at("field.npz"), "one.npz", Some(1)).unwrap();
    let one = Fields::read(&at("one.npz"), LIMIT).unwrap();
    assert_eq!(one.wavelength_um.to_vec(), [0.5]);
    assert!(convert(&at("field.npz"), "a.txt", None).is_err());
    fs::write(at("mine.zbf"), "mine").unwrap();
    let kept = convert(&at("field.npz"), "mine.zbf", Some(1)).unwrap_err();
    assert!(kept.to_string().contains("mine.zbf"), "{kept}");
}

#[test]
fn wrong_files_are_refused() {
    for layout in [20, 10, 11] {
        let good = bytes_of(layout, [4, 3], true, 0);
        for end in 0..good.len() {
            // Without its last number, a file with the longer header of version 0 is as long as one with the shorter.
            if (layout, end) == (11, good.len() - 8) {
                continue;
            }
            assert!(read(&good[..end], false).is_err(), "{end}");
        }
        assert!(read(&[&good[..], &[0]].concat(), false).is_err());
    }

    // Sizes are compared with the length of the file, and with the limit, before anything is taken.
    let mut huge = bytes_of(20, [4, 3], false, 0);
    huge[4..12].copy_from_slice(&[0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0x7f]);
    let (found, expected) = read(&huge, false).unwrap_err();
    assert!(found.contains("388 bytes") && expected.contains("2147483647"));
    let samples = 1u64 << 34;
    let mut long = bytes_of(20, [1 << 17, 0], false, 0);
    long[8..12].copy_from_slice(&(1u32 << 17).to_le_bytes());
    let (found, expected) = read_stream(&long[..], 196 + 16 * samples, false, LIMIT).unwrap_err();
    assert!(
        found.contains("MB") && expected.contains("--limit"),
        "{found}"
    );

    // Each part of the header.
    let refusal = |place: usize, value: &[u8]| {
        let mut bytes = bytes_of(20, [4, 3], false, 0);
        bytes[place..place + value.len()].copy_from_slice(value);
        let (found, expected) = read(&bytes, false).unwrap_err();
        format!("{found}; {expected}")
    };
    for (place, value, words) in [
        (0, 2u32, "version 0 or 1"),
        (4, 0, "0 x 3 samples"),
        (8, u32::MAX, "-1 samples"),
        (12, 2, "polarised: 2"),
        (16, 4, "unit 4"),
    ] {
        let message = refusal(place, &value.to_le_bytes());
        assert!(message.contains(words), "{message}");
    }
    for (place, value) in [(36, 0.0), (44, -1.0), (100, f64::NAN), (108, f64::INFINITY)] {
        assert!(refusal(place, &f64::to_le_bytes(value)).contains("1e-12 to 1e12"));
    }
    let (found, _) = read(&bytes_of(20, [4, 3], false, 0), true).unwrap_err();
    assert!(found.contains("without polarisation"));
}
