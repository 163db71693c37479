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
            "a lens file of OpticStudio (.zmx, .zar) or CODE V (.seq)",
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

/// A grid inside the file goes to an array beside the scene, which is then as good as any other.
#[test]
fn grids_are_arrays_beside_the_scene() {
    let room = tempfile::tempdir().unwrap();
    let points: String = (0..49)
        .map(|i| format!("  GARR {i} {} 0 0 0 0\n", f64::from(i) * 0.1))
        .collect();
    let lens = format!(
        "MODE SEQ\nUNIT MM X W X CM MR CPMM\nENPD 2\nFTYP 0 0 1 1\nXFLN 0\nYFLN 0\nWAVM 1 0.5 1\nPWAV 1\n\
         SURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  TYPE GRID_PHA\n  PARM 0 1\n  GDAT 7 7 0.5 0.5 0 0\n{points}\
         \x20 DISZ 10\n  DIAM 1.2\nSURF 2\n  TYPE PARAXIAL\n  PARM 1 50\n  DISZ 50\n  DIAM 2\nSURF 3\n  DISZ 0\n"
    );
    fs::write(room.path().join("grid.zmx"), lens).unwrap();
    let done = import(room.path(), &["grid.zmx"]);
    assert_eq!(done.status.code(), Some(2));
    let message = text(&done.stderr);
    assert!(
        message.contains("grid.zmx: found a grid of values"),
        "{message}"
    );

    let done = import(room.path(), &["grid.zmx", "-o", "lens.toml"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    assert!(text(&done.stdout).contains("Array in grid_surface1.npy"));
    let checked = Command::new(env!("CARGO_BIN_EXE_raylet"))
        .current_dir(room.path())
        .args(["check", "lens.toml"])
        .output()
        .unwrap();
    assert!(checked.status.success(), "{}", text(&checked.stderr));

    // An array that somebody else wrote is not replaced, and the scene stays as it was.
    fs::write(room.path().join("grid_surface1.npy"), "mine").unwrap();
    let done = import(room.path(), &["grid.zmx", "-o", "lens.toml"]);
    assert_eq!(done.status.code(), Some(2));
    assert!(
        text(&done.stderr).contains("grid_surface1.npy"),
        "{}",
        text(&done.stderr)
    );
}
