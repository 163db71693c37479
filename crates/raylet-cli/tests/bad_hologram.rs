//! Bad input to `raylet hologram`: one message with an address, exit code 2, nothing written.

use std::fs;

use ndarray::Array2;
use raylet::file::arrays::image::write_gray16;

use crate::refusal::{none_of, wrong};
use crate::stage::{SCENE, Stage, complaint};

/// What stands behind the small scene.
const HOLOGRAM: &str = r#"
[hologram]
target = "picture.png"
element = "pixels"
size_mm = [0.1, 0.1]
iterations = 3
"#;

/// The small scene with a hologram to be sought.
fn scene() -> String {
    SCENE.replace("phase.npy\"", "found.npy\"\nsize = [30, 30]") + HOLOGRAM
}

/// A stage with pictures, sound and otherwise.
fn stage(scene: &str) -> Stage {
    let stage = Stage::new(scene);
    let picture = Array2::from_shape_fn((8, 8), |(y, x)| ((x + 2 * y) % 5) as f64 / 4.0);
    for (name, values) in [
        ("picture.png", picture),
        ("black.png", Array2::zeros((8, 8))),
    ] {
        write_gray16(stage.join(name), values.view(), [0.0, 1.0]).unwrap();
    }
    let whole = fs::read(stage.join("picture.png")).unwrap();
    fs::write(stage.join("half.png"), &whole[..whole.len() / 2]).unwrap();
    ndarray_npy::write_npy(stage.join("dark.npy"), &Array2::<f64>::zeros((30, 30))).unwrap();
    fs::create_dir(stage.join("folder.npy")).unwrap();
    stage
}

#[test]
fn scenes_are_refused_at_the_right_place() {
    let cases: [(&str, &str, &[&str]); 19] = [
        (
            "picture.png",
            "none.png",
            &["hologram.target", "none.png", "No such file"],
        ),
        (
            "picture.png",
            "scene.toml",
            &["hologram.target", "scene.toml", "PNG"],
        ),
        ("picture.png", "half.png", &["hologram.target", "half.png"]),
        ("picture.png", ".", &["hologram.target"]),
        ("picture.png", "black.png", &["hologram.target", "black"]),
        ("target = \"picture.png\"\n", "", &["hologram", "target"]),
        (
            "element = \"pixels\"",
            "element = \"L\"",
            &["hologram.element", "doe"],
        ),
        (
            "element = \"pixels\"",
            "element = \"pixls\"",
            &["hologram.element", "pixls"],
        ),
        ("[0.1, 0.1]", "[0.1, 0]", &["hologram.size_mm", "0"]),
        ("[0.1, 0.1]", "[nan, 0.1]", &["hologram.size_mm", "nan"]),
        ("[0.1, 0.1]", "[0.1]", &["hologram.size_mm"]),
        ("[0.1, 0.1]", "[9, 9]", &["hologram.size_mm", "9", "sensor"]),
        (
            "iterations = 3",
            "iterations = 0",
            &["hologram.iterations", "0"],
        ),
        (
            "iterations = 3",
            "iterations = -3",
            &["hologram.iterations", "-3"],
        ),
        (
            "iterations = 3",
            "iterations = inf",
            &["hologram.iterations", "inf"],
        ),
        (
            "iterations = 3",
            "iterations = 3\nsteps = 2",
            &["hologram.steps"],
        ),
        (
            "size = [30, 30]\n",
            "",
            &["element[0].layer[0]", "size = [nx, ny]"],
        ),
        (
            "size = [30, 30]",
            "size = [90000, 90000]",
            &["element[0].layer[0].size", "MB"],
        ),
        (
            "phase = \"found.npy\"",
            "phase = \"found.npy\"\namplitude = \"dark.npy\"",
            &["element[0]", "light"],
        ),
    ];
    none_of(cases.map(|(from, to, says)| {
        let text = scene();
        assert!(text.contains(from), "{from}");
        let stage = stage(&text.replacen(from, to, 1));
        let says: Vec<&str> = ["scene.toml:"].iter().chain(says).copied().collect();
        wrong(&stage, &["hologram", "scene.toml"], &says)
    }));
}

#[test]
fn what_a_scene_lacks_is_reported() {
    let lens = "[[element]]\nkind = \"lens\"";
    let stop = format!(
        "[[element]]\nkind = \"stop\"\nthickness_mm = 1\naperture = {{ disc = {{ radius_mm = 1 }} }}\n{lens}"
    );
    let camera = &SCENE[SCENE.find("[[element]]\nkind = \"sensor\"").unwrap()..];
    none_of([
        wrong(
            &stage(SCENE),
            &["hologram", "scene.toml"],
            &["scene.toml", "[hologram]"],
        ),
        wrong(
            &stage(&scene().replace(lens, &stop)),
            &["hologram", "scene.toml"],
            &["hologram.element", "no stop behind it"],
        ),
        wrong(
            &stage(&scene().replace(camera, "")),
            &["hologram", "scene.toml"],
            &["scene.toml:", "sensor"],
        ),
        wrong(
            &stage(&scene().replace("phase = \"found.npy\"\n", "")),
            &["hologram", "scene.toml"],
            &["scene.toml: found no file for the phase", "--out FILE"],
        ),
    ]);
}

#[test]
fn arguments_are_checked_before_the_work() {
    let stage = stage(&scene());
    let run = ["hologram", "scene.toml"];
    let cases: [(&[&str], &[&str]); 10] = [
        (&["--out", "phase.txt"], &["phase.txt", "`txt`", ".npy"]),
        (&["--out", "phase"], &["phase", "no extension", ".npy"]),
        (&["--out", ".npy"], &[".npy"]),
        (&["--out", "folder.npy"], &["folder.npy", "a folder"]),
        (&["--out", "picture.png/a.npy"], &["picture.png"]),
        (&["--out", "picture.png/b/a.npy"], &["picture.png"]),
        (&["--out", "/proc/a.npy"], &["/proc"]),
        (&["--iterations", "0"], &["--iterations", "0"]),
        (&["--iterations", "nan"], &["--iterations", "nan"]),
        (&["--threads", "100000"], &["--threads", "100000"]),
    ];
    none_of(cases.map(|(more, says)| wrong(&stage, &[&run[..], more].concat(), says)));
}

#[test]
fn missing_folders_are_made_for_the_phase() {
    let stage = stage(&scene());
    let output = stage.raylet(&["hologram", "scene.toml", "--out", "new/folder/p.npy"]);
    assert!(output.status.success(), "{}", complaint(&output));
    let phase: Array2<f64> = ndarray_npy::read_npy(stage.join("new/folder/p.npy")).unwrap();
    assert_eq!(phase.dim(), (30, 30));
}
