//! Bad input to `raylet compare`: one message that names the file, exit code 2, nothing written.

use std::fs;
use std::io::Cursor;

use ndarray::{Array, Array1, Array3, Axis, Dimension};
use ndarray_npy::{NpzWriter, WritableElement};
use num_complex::{Complex32, Complex64};
use raylet::file::arrays::npz::Fields;

use crate::refusal::{none_of, wrong};
use crate::stage::{SCENE, Stage};

/// A small field with light in it.
fn fields() -> Fields {
    Fields {
        field: Array3::from_shape_fn((1, 4, 5), |(_, y, x)| {
            Complex64::new(1.0 + x as f64, y as f64)
        }),
        x_mm: Array1::linspace(-0.2, 0.2, 5),
        y_mm: Array1::linspace(-0.15, 0.15, 4),
        wavelength_um: Array1::from(vec![0.5]),
    }
}

/// The small field, altered.
fn altered(change: impl FnOnce(&mut Fields)) -> Vec<u8> {
    let mut fields = fields();
    change(&mut fields);
    let mut file = Cursor::new(Vec::new());
    fields.write_npz(&mut file).unwrap();
    file.into_inner()
}

/// The small field's archive with another field, or none.
fn packed<T: WritableElement, D: Dimension>(field: Option<Array<T, D>>) -> Vec<u8> {
    let mut writer = NpzWriter::new(Cursor::new(Vec::new()));
    let Fields {
        x_mm,
        y_mm,
        wavelength_um,
        ..
    } = fields();
    for (name, axis) in [
        ("x_mm", x_mm),
        ("y_mm", y_mm),
        ("wavelength_um", wavelength_um),
    ] {
        writer.add_array(name, &axis).unwrap();
    }
    if let Some(field) = field {
        writer.add_array("field", &field).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

#[test]
fn files_that_cannot_be_used_are_refused() {
    let whole = altered(|_| {});
    let mut corrupt = whole.clone();
    corrupt[150] ^= 0xff;
    let single = fields()
        .field
        .mapv(|u| Complex32::new(u.re as f32, u.im as f32));
    let flat = fields().field.index_axis_move(Axis(0), 0);
    let cases: [(&str, Vec<u8>, &[&str]); 17] = [
        ("empty", Vec::new(), &["archive"]),
        ("text", b"not an archive".to_vec(), &["archive"]),
        ("half", whole[..whole.len() / 2].to_vec(), &["archive"]),
        ("corrupt", corrupt, &["`field`", "complex128"]),
        (
            "lacking",
            packed::<f64, ndarray::Ix1>(None),
            &["`field`", "complex128"],
        ),
        ("single", packed(Some(single)), &["`field`", "complex128"]),
        (
            "real",
            packed(Some(fields().field.mapv(|u| u.re))),
            &["`field`", "complex128"],
        ),
        ("flat", packed(Some(flat)), &["`field`", "three axes"]),
        (
            "nan",
            altered(|f| f.field[[0, 1, 2]].re = f64::NAN),
            &["NaN", "(0, 1, 2)", "finite"],
        ),
        (
            "inf",
            altered(|f| f.field[[0, 1, 2]].im = f64::INFINITY),
            &["(0, 1, 2)", "finite"],
        ),
        (
            "huge",
            altered(|f| f.field *= Complex64::new(1e300, 0.0)),
            &["`field`", "below 1e60"],
        ),
        (
            "lost",
            altered(|f| f.x_mm[1] = f64::NAN),
            &["`x_mm`", "ascending"],
        ),
        (
            "turned",
            altered(|f| f.y_mm.invert_axis(Axis(0))),
            &["`y_mm`", "ascending"],
        ),
        (
            "uneven",
            altered(|f| f.x_mm[1] += 0.01),
            &["`x_mm`", "unequal steps"],
        ),
        (
            "dim",
            altered(|f| f.wavelength_um[0] = f64::NAN),
            &["NaN", "`wavelength_um`"],
        ),
        (
            "negative",
            altered(|f| f.wavelength_um[0] = -0.5),
            &["-0.5", "`wavelength_um`"],
        ),
        (
            "short",
            altered(|f| f.x_mm = Array1::linspace(0.0, 1.0, 4)),
            &["`field`", "[1, 4, 4]"],
        ),
    ];
    let stage = Stage::new(SCENE);
    fs::write(stage.join("good.npz"), &whole).unwrap();
    for (name, bytes, says) in cases {
        let file = format!("{name}.npz");
        fs::write(stage.join(&file), bytes).unwrap();
        let says: Vec<&str> = [file.as_str(), "expected"]
            .iter()
            .chain(says)
            .copied()
            .collect();
        none_of([
            wrong(
                &stage,
                &["compare", "good.npz", &file, "--out", "out"],
                &says,
            ),
            wrong(&stage, &["compare", &file, "good.npz"], &says),
            wrong(&stage, &["compare", &file, &file], &says),
        ]);
    }
}

#[test]
fn fields_that_do_not_match_are_refused() {
    let wider = |f: &mut Fields| f.x_mm.mapv_inplace(|x| 1.5 * x);
    let two = |f: &mut Fields| {
        f.field = ndarray::concatenate![Axis(0), f.field, f.field];
        f.wavelength_um = Array1::from(vec![0.5, 0.6]);
    };
    let fewer = |f: &mut Fields| {
        f.field = f.field.slice_axis(Axis(2), (..3).into()).to_owned();
        f.x_mm = f.x_mm.slice_axis(Axis(0), (..3).into()).to_owned();
    };
    let cases: [(Vec<u8>, &[&str]); 4] = [
        (altered(wider), &["x_mm[0]", "-0.3", "-0.2 as in good.npz"]),
        (
            altered(|f| f.wavelength_um[0] = 0.6),
            &["wavelength_um[0] = 0.6", "0.5 as in good.npz"],
        ),
        (
            altered(two),
            &["2 wavelengths of 4 × 5", "1 wavelengths of 4 × 5"],
        ),
        (altered(fewer), &["4 × 3 samples", "4 × 5 samples"]),
    ];
    let stage = Stage::new(SCENE);
    fs::write(stage.join("good.npz"), altered(|_| {})).unwrap();
    for (bytes, says) in cases {
        fs::write(stage.join("other.npz"), bytes).unwrap();
        let says: Vec<&str> = ["other.npz"].iter().chain(says).copied().collect();
        none_of([wrong(
            &stage,
            &["compare", "good.npz", "other.npz", "--out", "out"],
            &says,
        )]);
    }
}

#[test]
fn sizes_are_held_to_the_limit() {
    let stage = Stage::new(SCENE);
    fs::write(stage.join("good.npz"), altered(|_| {})).unwrap();
    let compare = ["compare", "good.npz", "good.npz"];
    // One field fits, not two.
    let says = ["good.npz", "--memory-limit-mb", "MB"];
    let limited = |limit| [&compare[..], &["--memory-limit-mb", limit]].concat();
    none_of([wrong(&stage, &limited("0.0015"), &says)]);
    assert_eq!(stage.raylet(&limited("0.0016")).status.code(), Some(0));
    for bad in ["0", "-1", "nan", "inf", "much"] {
        none_of([wrong(&stage, &limited(bad), &["--memory-limit-mb"])]);
    }
}

#[test]
fn places_are_checked() {
    let stage = Stage::new(SCENE);
    for folder in ["bare", "run"] {
        fs::create_dir(stage.join(folder)).unwrap();
    }
    fs::write(stage.join("run/field.npz"), altered(|_| {})).unwrap();
    fs::write(
        stage.join("run/result.json"),
        "{\"files\": [\"field.npz\"]}",
    )
    .unwrap();
    let cases: [(&[&str], &[&str]); 6] = [
        (&["run", "none"], &["none", "No such file"]),
        (&["none", "run"], &["none", "No such file"]),
        (&["run", "bare"], &["bare/field.npz", "No such file"]),
        (&["run", "scene.toml"], &["scene.toml", "archive"]),
        (&["run", "run", "--out", "run"], &["run", "compare.json"]),
        (
            &["run", "run", "--out", "scene.toml"],
            &["scene.toml", "not a folder"],
        ),
    ];
    none_of(cases.map(|(more, says)| wrong(&stage, &[&["compare"], more].concat(), says)));
}
