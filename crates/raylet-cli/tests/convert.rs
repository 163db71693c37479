//! `raylet convert` of a small field, and `raylet compare` of beam files.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Runs a verb in a folder.
fn run(room: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_raylet"))
        .current_dir(room)
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A polarised beam of 32 × 32 samples of 0.5 mm; the fourth of its power is Ey.
fn beam() -> Vec<u8> {
    let mut bytes = Vec::new();
    for whole in [1u32, 32, 32, 1, 0, 0, 0, 0, 0] {
        bytes.extend(whole.to_le_bytes());
    }
    let mut numbers = vec![0.5, 0.5, 0.0, 1.0, 0.1, 0.0, 1.0, 0.1, 5e-4, 1.0];
    numbers.resize(20, 0.0);
    for part in [1.5f64.sqrt(), 0.5f64.sqrt()] {
        for k in 0..1024 {
            let amplitude = part * f64::exp(-0.01 * f64::from((k % 32 - 12) * (k % 32 - 12)));
            numbers.extend([amplitude, 0.25 * amplitude]);
        }
    }
    bytes.extend(numbers.iter().flat_map(|number: &f64| number.to_le_bytes()));
    bytes
}

#[test]
fn a_beam_becomes_a_field_and_a_beam_again() {
    let room = tempfile::tempdir().unwrap();
    fs::write(room.path().join("a.zbf"), beam()).unwrap();
    let done = run(room.path(), &["convert", "a.zbf", "-o", "a.npz"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    let report = text(&done.stdout);
    for words in [
        "32 x 32 samples of 0.5 x 0.5 mm",
        "Ey, with 25 %",
        "Written to a.npz",
    ] {
        assert!(report.contains(words), "{report}");
    }
    let done = run(room.path(), &["convert", "a.npz", "-o", "b.zbf"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    assert!(text(&done.stdout).contains("sample 17, 17"));

    // The comparison says what it left out.
    let done = run(room.path(), &["compare", "a.zbf", "b.zbf"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    assert!(text(&done.stderr).contains("a.zbf: left out: Ey"));
    assert!(
        text(&done.stdout).contains("1.000000000"),
        "{}",
        text(&done.stdout)
    );
}

#[test]
fn refusals_name_the_file_or_the_option() {
    let room = tempfile::tempdir().unwrap();
    let bytes = beam();
    fs::write(room.path().join("a.zbf"), &bytes).unwrap();
    fs::write(room.path().join("short.zbf"), &bytes[..bytes.len() - 1]).unwrap();
    for (arguments, words) in [
        (&["a.zbf", "-o", "a.txt"][..], ".zbf, .npz, .fits or .h5"),
        (&["short.zbf", "-o", "b.npz"], "short.zbf"),
        (
            &["a.zbf", "-o", "b.npz", "--wavelength", "2"],
            "from 1 to 1",
        ),
        (
            &["a.zbf", "-o", "b.npz", "--memory-limit-mb", "0.01"],
            "--memory-limit-mb",
        ),
        (&["a.zbf", "-o", "b.npz", "--component", "z"], "--component"),
    ] {
        let done = run(room.path(), &[&["convert"], arguments].concat());
        assert_eq!(done.status.code(), Some(2), "{arguments:?}");
        let message = text(&done.stderr);
        assert!(message.contains(words), "{arguments:?}: {message}");
        assert!(!room.path().join("b.npz").exists());
    }
}
