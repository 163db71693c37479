//! `raylet import` on a public lens file.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const LENS: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../scenes/prescriptions/lens1.zmx"
);

/// Runs `raylet import` in a folder.
fn import(room: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_raylet"))
        .current_dir(room)
        .arg("import")
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn the_scene_is_written_once_and_the_report_printed() {
    let room = tempfile::tempdir().unwrap();
    let done = import(room.path(), &[LENS, "-o", "lens.toml", "--field", "2"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    let report = text(&done.stdout);
    assert!(
        report.contains("focal length (mm)                   24.990670"),
        "{report}"
    );
    let scene = fs::read_to_string(room.path().join("lens.toml")).unwrap();
    assert!(
        scene.starts_with("# Imported from lens1.zmx, field 2.\nversion = 1\n"),
        "{scene}"
    );
    let checked = Command::new(env!("CARGO_BIN_EXE_raylet"))
        .current_dir(room.path())
        .args(["check", "lens.toml"])
        .output()
        .unwrap();
    assert!(checked.status.success(), "{}", text(&checked.stderr));

    // What somebody changed is not replaced.
    fs::write(room.path().join("lens.toml"), "mine").unwrap();
    let done = import(room.path(), &[LENS, "-o", "lens.toml"]);
    assert_eq!(done.status.code(), Some(2));
    assert!(text(&done.stderr).contains("--overwrite"));
    assert_eq!(
        fs::read_to_string(room.path().join("lens.toml")).unwrap(),
        "mine"
    );
}

#[test]
fn without_a_file_the_scene_is_printed() {
    let room = tempfile::tempdir().unwrap();
    let done = import(room.path(), &[LENS]);
    assert!(text(&done.stdout).contains("[[element]]"));
    assert!(text(&done.stderr).starts_with("Read lens1.zmx: 9 surfaces"));
    assert_eq!(fs::read_dir(room.path()).unwrap().count(), 0);
}

#[test]
fn bad_requests_are_refused() {
    let room = tempfile::tempdir().unwrap();
    for (arguments, words) in [
        (
            &[LENS, "--field", "4"][..],
            "found 3 fields, and field 4 requested",
        ),
        (&["nothing.zmx"], "nothing.zmx: found"),
        (
            &["lens.len"],
            "a lens file of OpticStudio (.zmx) or CODE V (.seq)",
        ),
        (&[LENS, "--configuration", "2"], "configuration 2 requested"),
        (&[LENS, "--glasses", "none.agf"], "none.agf: found"),
        (&[LENS, "--glass", "N-SK16"], "expected NAME=GLASS"),
        (
            &[LENS, "--glass", "N-SK16=XYZ9"],
            "no glass is named 'XYZ9'",
        ),
    ] {
        let done = import(room.path(), arguments);
        assert_eq!(done.status.code(), Some(2));
        assert!(text(&done.stderr).contains(words), "{}", text(&done.stderr));
    }
}

#[test]
fn glasses_come_from_a_catalogue_of_the_user() {
    let room = tempfile::tempdir().unwrap();
    let glass = "NM N-SK16 2 0 1.6 60 0 1\nCD 1.5 0.01 0 0 0 0\nLD 0.3 2.5\n";
    fs::write(room.path().join("own.agf"), glass).unwrap();
    let done = import(room.path(), &[LENS, "--glasses", "own.agf"]);
    let report = text(&done.stderr);
    assert!(
        report.contains("Glass N-SK16: line 1 of own.agf"),
        "{report}"
    );
    assert!(text(&done.stdout).contains("sellmeier"));
}
