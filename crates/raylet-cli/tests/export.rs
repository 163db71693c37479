//! `raylet export` of a small element.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Runs `raylet export` in a folder.
fn export(room: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_raylet"))
        .current_dir(room)
        .arg("export")
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A scene with a lens of 40 µm as a formula.
const SCENE: &str = "version = 1\nwavelength_um = 0.5\n[source]\nkind = \"plane\"\n\
                     [[element]]\nkind = \"doe\"\nname = \"lens\"\nthickness_mm = 1\n\
                     aperture = { disc = { radius_mm = 0.02 } }\n\
                     [[element.layer]]\nkind = \"radial\"\nnorm_radius_mm = 0.02\ncoefficients = [-9.0]\n\
                     [[element]]\nkind = \"sensor\"\npixels = [4, 4]\npitch_um = 5\n";

#[test]
fn masks_are_written_and_read_back() {
    let room = tempfile::tempdir().unwrap();
    fs::write(room.path().join("scene.toml"), SCENE).unwrap();
    let given = ["scene.toml", "--pitch-um", "1", "--levels", "8"];
    let done = export(room.path(), &[&given[..], &["-o", "lens.gds"]].concat());
    assert!(done.status.success(), "{}", text(&done.stderr));
    let report = text(&done.stdout);
    for words in [
        "40 x 40 of 1 x 1 µm",
        "8 of 0.785398 rad",
        "Written to lens.gds",
    ] {
        assert!(report.contains(words), "{report}");
    }

    // The array of the element on levels, and that of its masks.
    let done = export(room.path(), &[&given[..], &["-o", "made.npy"]].concat());
    assert!(done.status.success(), "{}", text(&done.stderr));
    let back = [
        "lens.gds",
        "--pitch-um",
        "1",
        "--levels",
        "8",
        "--size",
        "40,40",
    ];
    let done = export(room.path(), &[&back[..], &["-o", "back.npy"]].concat());
    assert!(done.status.success(), "{}", text(&done.stderr));
    let read = |name: &str| fs::read(room.path().join(name)).unwrap();
    assert_eq!(read("made.npy"), read("back.npy"));

    // What somebody changed is not replaced.
    fs::write(room.path().join("made.npy"), "mine").unwrap();
    let done = export(room.path(), &[&given[..], &["-o", "made.npy"]].concat());
    assert_eq!(done.status.code(), Some(2));
    assert!(text(&done.stderr).contains("--overwrite"));
}

#[test]
fn refusals_name_the_choice() {
    let room = tempfile::tempdir().unwrap();
    fs::write(room.path().join("scene.toml"), SCENE).unwrap();
    for (arguments, words) in [
        (&["scene.toml", "-o", "a.gds"][..], "pitch_um"),
        (&["scene.toml", "-o", "a.oas", "--pitch-um", "1"], ".gds"),
        (
            &[
                "scene.toml",
                "-o",
                "a.gds",
                "--pitch-um",
                "0.3335",
                "--levels",
                "4",
            ],
            "--database-unit-nm 0.5",
        ),
        (&["scene.toml", "-o", "a.stl", "--pitch-um", "1"], "--index"),
    ] {
        let done = export(room.path(), arguments);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}");
        let message = text(&done.stderr);
        assert!(message.contains(words), "{arguments:?}: {message}");
    }
}
