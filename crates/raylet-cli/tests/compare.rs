//! `raylet compare` on small fields.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use ndarray::{Array1, Array3};
use num_complex::Complex64;
use raylet::file::arrays::npz::Fields;

/// Writes a Gaussian spot of 1/e² radius 0.1 mm on 41 × 41 samples, times a factor.
fn write(path: &Path, factor: Complex64, half: f64) {
    let axis = Array1::linspace(-half, half, 41);
    let spot = |(_, j, i): (usize, usize, usize)| {
        factor * (-(axis[i] * axis[i] + axis[j] * axis[j]) / 0.01).exp()
    };
    let fields = Fields {
        field: Array3::from_shape_fn((2, 41, 41), spot),
        wavelength_um: Array1::from(vec![0.5, 0.6]),
        x_mm: axis.clone(),
        y_mm: axis,
    };
    fields.write_npz(fs::File::create(path).unwrap()).unwrap();
}

/// Runs `raylet compare` in a folder.
fn compare(room: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_raylet"))
        .current_dir(room)
        .arg("compare")
        .args(arguments)
        .output()
        .unwrap()
}

#[test]
fn numbers_are_printed_and_written() {
    let room = tempfile::tempdir().unwrap();
    fs::create_dir(room.path().join("run")).unwrap();
    let factor = Complex64::from_polar(0.5, 0.25);
    write(&room.path().join("run/field.npz"), factor, 0.4);
    write(&room.path().join("reference.npz"), Complex64::ONE, 0.4);
    for _ in 0..2 {
        let output = compare(room.path(), &["run", "reference.npz", "--out", "out"]);
        let text = String::from_utf8(output.stdout).unwrap();
        let errors = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{errors}");
        assert!(
            text.contains("Wavelength 0.6 µm") && text.contains("Total"),
            "{text}"
        );
        assert!(text.contains("0.500000 · exp(+0.250000 i)"), "{text}");
        assert!(text.contains("(NCC)   1.000000000\n"), "{text}");
    }

    // The second took the place of the first.
    let document = fs::read_to_string(room.path().join("out/compare.json")).unwrap();
    let document: serde_json::Value = serde_json::from_str(&document).unwrap();
    let exact = (factor - 1.0).norm();
    for place in ["/total", "/channels/0", "/channels/1"] {
        let found = document.pointer(place).unwrap();
        assert!((found["field_error"].as_f64().unwrap() - exact).abs() < 1e-12);
        assert!(found["shape_error"].as_f64().unwrap() < 1e-12);
        // w √(2 ln 2), within the accuracy of straight lines between 0.02 mm steps.
        let width = found["a"]["fwhm_um"][0].as_f64().unwrap();
        assert!((width - 117.741).abs() < 0.5, "{width}");
    }
    assert_eq!(document["channels"][1]["wavelength_um"], 0.6);
    let picture = fs::read(room.path().join("out/compare.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    let names = fs::read_dir(room.path()).unwrap();
    assert_eq!(names.count(), 3);
}

#[test]
fn what_cannot_be_compared_is_reported() {
    let room = tempfile::tempdir().unwrap();
    write(&room.path().join("a.npz"), Complex64::ONE, 0.4);
    write(&room.path().join("wider.npz"), Complex64::ONE, 0.5);
    let refusal = |arguments: &[&str]| {
        let output = compare(room.path(), arguments);
        assert_eq!(output.status.code(), Some(2));
        assert!(output.stdout.is_empty());
        String::from_utf8(output.stderr).unwrap()
    };
    let grids = refusal(&["a.npz", "wider.npz", "--out", "out"]);
    assert!(
        grids.contains("x_mm[0] = -0.5") && grids.contains("-0.4 as in a.npz"),
        "{grids}"
    );
    assert!(!room.path().join("out").exists());
    let missing = refusal(&["a.npz", "none.npz"]);
    assert!(missing.contains("none.npz"), "{missing}");

    // Results are not replaced by a comparison.
    fs::create_dir(room.path().join("run")).unwrap();
    fs::write(room.path().join("run/result.json"), "{}").unwrap();
    let refused = refusal(&["a.npz", "a.npz", "--out", "run"]);
    assert!(refused.contains("compare.json to replace"), "{refused}");
}
