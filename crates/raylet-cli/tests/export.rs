//! `raylet export` of a small element.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use ndarray::{Array2, Array3};
use ndarray_npy::NpzReader;
use num_complex::Complex64;
use raylet::file::arrays::image::write_gray16;

use crate::stage::{SCENE as SMALL, Stage, complaint};

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
        (&["scene.toml", "-o", "a.cif", "--pitch-um", "1"], ".gds"),
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

/// What leaves without a stated number of levels, within an aperture whose edges are those of cells, read back and simulated, gives the field of the designed scene.
#[test]
fn a_designed_element_comes_back_from_its_masks() {
    let stage = Stage::new(&format!(
        "{}[hologram]\ntarget = \"picture.png\"\nelement = \"pixels\"\nsize_mm = [0.2, 0.2]\n[design]\niterations = 4\n\
         [[design.element]]\nname = \"pixels\"\nlevels = 8\nblock = 2\n",
        SMALL
            .replace(
                "phase = \"phase.npy\"",
                "phase = \"found.npy\"\nsize = [30, 30]"
            )
            .replace(
                "disc = { radius_mm = 0.09 }",
                "rectangle = { width_mm = 0.156, height_mm = 0.132 }"
            )
    ));
    let picture = Array2::from_shape_fn((20, 20), |(y, x)| f64::from(u8::from(y + x < 15)));
    let file = stage.join("picture.png");
    write_gray16(file, picture.view(), [0.0, 1.0]).unwrap();
    let run = |line: &[&str]| {
        let done = stage.raylet(line);
        assert!(done.status.success(), "{line:?}: {}", complaint(&done));
        String::from_utf8(done.stdout).unwrap()
    };
    run(&["design", "scene.toml", "--out", "course"]);
    for masks in ["each", "binary", "dose"] {
        let kind = ["--masks", masks, "--overwrite"];
        let said = run(&[&["export", "scene.toml", "-o", "a.gds"][..], &kind].concat());
        assert!(said.contains("8 of 0.785398 rad each"), "{said}");
        assert!(
            said.contains("328 cells with their centre outside"),
            "{said}"
        );
        let back = [
            "export",
            "a.gds",
            "-o",
            "back.npy",
            "--pitch-um",
            "6",
            "--size",
            "30,30",
            "--levels",
            "8",
        ];
        run(&[&back[..], &kind].concat());
        let scene = fs::read_to_string(stage.join("scene.toml")).unwrap();
        let (scene, _) = scene.split_once("[hologram]").unwrap();
        fs::write(
            stage.join("made.toml"),
            scene.replace("found.npy", "back.npy"),
        )
        .unwrap();
        run(&["simulate", "scene.toml", "--out", "designed"]);
        run(&["simulate", "made.toml", "--out", "made"]);
        let [designed, made] = ["designed", "made"].map(|folder| {
            let file = stage.join(folder).join("field.npz");
            let mut archive = NpzReader::new(fs::File::open(file).unwrap()).unwrap();
            let field: Array3<Complex64> = archive.by_name("field").unwrap();
            field
        });
        let largest = designed.iter().fold(0.0_f64, |most, u| most.max(u.norm()));
        for (a, b) in designed.iter().zip(&made) {
            assert!((a - b).norm() < 1e-12 * largest, "{masks}: {a} {b}");
        }
    }
}
