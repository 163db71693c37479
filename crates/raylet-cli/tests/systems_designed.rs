//! `raylet design` and `raylet gradcheck` of systems: several elements, losses, wavelengths and fields.

use std::fs;

use ndarray::{Array2, Array3, Axis};
use num_complex::Complex64;
use raylet::file::arrays::image::write_gray16;

use crate::stage::{SCENE, Stage, complaint};

/// Two elements in free space; `LAYER` is what is designed of the first. The target error leaves few plane waves:
/// gradients are exact for those that there are.
const TWO: &str = r#"version = 1
wavelength_um = [WAVELENGTHS]
source = { kind = "plane" }

[settings]
target_error = 1e-2

[[element]]
kind = "doe"
name = "first"
thickness_mm = 0.1
aperture = { disc = { radius_mm = 0.01 } }
LAYER
[[element]]
kind = "doe"
name = "second"
thickness_mm = 0.1
aperture = { disc = { radius_mm = 0.01 } }
[[element.layer]]
kind = "pixels"
pitch_um = 2
size = [10, 10]
phase = "second.npy"

[[element]]
kind = "sensor"
name = "camera"
pixels = [12, 10]
pitch_um = 2

[design]
iterations = 4
[[design.element]]
name = "first"
FREE
[[design.element]]
name = "second"
start = "random"
LOSS
"#;

const PIXELS: &str = "[[element.layer]]\nkind = \"pixels\"\npitch_um = 2\nsize = [10, 10]\n";
const PHASE: &str = "phase = \"first.npy\"\n";
const PICTURE: &str = "picture = \"picture.png\"\nsize_mm = [0.015, 0.015]\n";

/// A folder with the two elements and a picture.
fn two(wavelengths: &str, layer: &str, free: &str, loss: &str) -> Stage {
    let text = TWO.replace("WAVELENGTHS", wavelengths);
    let text = text.replace("LAYER", layer).replace("FREE", free);
    let stage = Stage::new(&text.replace("LOSS", loss));
    let picture = Array2::from_shape_fn((10, 10), |(j, i)| f64::from(u8::from(is_lit(j, i))));
    write_gray16(stage.join("picture.png"), picture.view(), [0.0, 1.0]).unwrap();
    stage
}

/// Whether a cell of the picture is lit: rows and columns in pairs, for pixels that lie between two.
fn is_lit(j: usize, i: usize) -> bool {
    matches!(j, 2 | 3) || matches!(i, 6 | 7) || (j > 7 && i < 4)
}

/// How far gradients and differences are apart, line by line.
fn apart(stage: &Stage) -> Vec<(String, f64)> {
    let run = stage.raylet(&["gradcheck", "scene.toml"]);
    assert!(run.status.success(), "{}", complaint(&run));
    let said = String::from_utf8(run.stdout).unwrap();
    let lines = said
        .lines()
        .skip(2)
        .filter(|line| !line.starts_with("differences"));
    let line = |line: &str| {
        let last = line.split_whitespace().last().unwrap();
        (line.to_owned(), last.parse().unwrap())
    };
    lines.map(line).collect()
}

#[test]
fn whatever_is_free_has_its_gradient_slow() {
    let sum = "[[element.layer]]\nkind = \"sum\"\nweights = [1.0, 0.8]\nterms = [[{ kind = \"pixels\", pitch_um = 2, \
               size = [10, 10], phase = \"a.npy\" }], [{ kind = \"pixels\", pitch_um = 2, size = [10, 10], \
               phase = \"a.npy\" }]]\n";
    let height = "[[element.layer]]\nkind = \"height\"\npitch_um = 2\nsize = [10, 10]\nheight_um = \"h.npy\"\n\
                  glass = \"N-BK7\"\n";
    let both = format!("{PIXELS}{PHASE}amplitude = \"t.npy\"\nfill = 0.9\n");
    let alone = format!("{PIXELS}amplitude = \"t.npy\"\n");
    let loss = format!("[[design.loss]]\nkind = \"likeness\"\n{PICTURE}");
    for (layer, free) in [
        (
            format!("{PIXELS}{PHASE}"),
            "block = 2\nblur = 1.5\nsmoothness = 0.1\nstart = \"random\"",
        ),
        (alone, "free = \"amplitude\""),
        (both, "free = \"both\"\nstart = \"random\""),
        (sum.to_owned(), "free = \"two_phase\""),
        (
            height.to_owned(),
            "free = \"height\"\nstart = \"random\"\nhighest_um = 2.5",
        ),
    ] {
        let wavelengths = if free.contains("height") {
            "0.6, 0.5"
        } else {
            "0.6"
        };
        for (line, apart) in apart(&two(wavelengths, &layer, free, &loss)) {
            assert!(apart < 1e-7, "{free}: {line}");
        }
    }
}

/// Every loss at once, at two wavelengths and from two fields: gradients add up, and a wrong one shows in the sum.
#[test]
fn every_loss_has_its_gradient() {
    let fields =
        "[[design.field]]\nangle_deg = [0.0, 0.0]\n[[design.field]]\nangle_deg = [2.0, -1.0]\n";
    let losses = [
        format!(
            "kind = \"mse\"\nweight = 1000\n{PICTURE}care = \"outline\"\nmask = \"picture.png\"\n"
        ),
        format!("kind = \"mse\"\nscale = 0.5\n{PICTURE}"),
        format!("kind = \"overlap\"\nfield = [1]\n{PICTURE}"),
        format!("kind = \"efficiency\"\n{PICTURE}"),
        String::from(
            "kind = \"efficiency\"\nat_mm = [[0.0, 0.005]]\nradius_mm = 0.005\nwavelength_um = [0.5]\n",
        ),
        String::from(
            "kind = \"encircled_energy\"\nat_mm = [[0.005, 0.0], [-0.01, 0.005]]\nradius_mm = 0.004\nweight = 3\n",
        ),
        String::from(
            "kind = \"spot\"\nat_mm = [[0.005, 0.0], [-0.01, 0.005]]\nsharing = \"log\"\nevenness = 0.3\nfocal_length_mm = 0.6\n",
        ),
    ];
    let losses = losses.map(|loss| format!("[[design.loss]]\n{loss}"));
    let parts = format!("{fields}{}", losses.concat());
    let layer = format!("{PIXELS}{PHASE}");
    let stage = two("0.6, 0.5", &layer, "start = \"random\"", &parts);
    for (line, apart) in apart(&stage) {
        assert!(apart < 1e-7, "{line}");
    }
}

/// A coefficient of an aspheric surface and one of an analytic profile, a radius and a tilt, for a spot.
#[test]
fn numbers_of_the_system_are_designed() {
    let radial = "size = [15, 15]\n[[element.layer]]\nkind = \"radial\"\nnorm_radius_mm = 0.09\ncoefficients = [0.5, 0.1]";
    let lens = SCENE
        .replace(
            "pitch_um = 6\nphase = \"phase.npy\"",
            &format!("pitch_um = 12\n{radial}"),
        )
        .replace("radius_mm = 5\n", "radius_mm = 5\naspheric = [0.001]\n")
        .replace("name = \"L\"\n", "name = \"L\"\ntilt_deg = [0.5, 0, 0]\n")
        .replace("[48, 40]\npitch_um = 5", "[24, 20]\npitch_um = 10")
        .replace(
            "[source]",
            "[settings]\ntarget_error = 1e-2\ncorrection = \"off\"\nfootprint_threshold = 1e-11\n[source]",
        );
    let paths = [
        ("element[1].surface[0].aspheric[0]", 0.2),
        ("element[0].layer[1].coefficients[1]", 0.3),
        ("element[1].surface[0].radius_mm", 0.01),
        ("element[1].tilt_deg[0]", 0.1),
    ];
    let variable = |(path, scale): (&str, f64)| {
        format!("[[design.variable]]\npath = \"{path}\"\nscale = {scale}\n")
    };
    let variables: String = paths.map(variable).concat();
    let text = format!(
        "{lens}[design]\niterations = 4\n[[design.loss]]\nkind = \"spot\"\nat_mm = [[0.005, 0.005]]\n\
         focal_length_mm = 9.5\n{variables}"
    );
    let stage = Stage::new(&text);
    for (line, apart) in apart(&stage) {
        assert!(apart < 1e-6, "{line}");
    }
    let run = stage.raylet(&["design", "scene.toml"]);
    assert!(run.status.success(), "{}", complaint(&run));
    let course = fs::read_to_string(stage.join("out/design/course.csv")).unwrap();
    let losses: Vec<f64> = course
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(2).unwrap().parse().unwrap())
        .collect();
    assert!(losses.last().unwrap() < &losses[0], "{course}");
    let record = ".scene.designed.toml.raylet";
    let left = [
        record,
        "out",
        "phase.npy",
        "scene.designed.toml",
        "scene.toml",
    ];
    assert_eq!(stage.names(), left);
}

/// 1 − NCC² of intensities with a picture.
fn unlikeness(field: &Array2<Complex64>, picture: &Array2<f64>) -> f64 {
    let seen = field.mapv(|u| u.norm_sqr());
    let inner = |a: &Array2<f64>, b: &Array2<f64>| (a * b).sum();
    1.0 - inner(&seen, picture).powi(2) / (inner(&seen, &seen) * inner(picture, picture))
}

/// What `raylet simulate` sees of the files is what the design saw, with the dispersion of a height, levels and all.
#[test]
fn what_is_left_is_what_was_designed_slow() {
    let height = "[[element.layer]]\nkind = \"height\"\npitch_um = 2\nsize = [10, 10]\nheight_um = \"h.npy\"\n\
                  glass = \"N-BK7\"\n";
    let both = format!(
        "{PIXELS}{PHASE}phase_scale = 6.283185307179586\namplitude = \"t.npy\"\nfill = 0.8\nrest = \"flat\"\n"
    );
    let loss = format!("[[design.loss]]\nkind = \"likeness\"\n{PICTURE}");
    let picture = Array2::from_shape_fn((10, 12), |(j, i)| {
        // The picture's cells are 3 µm wide; pixels are read at their centres.
        let cell = |n: usize, count: f64| ((n as f64 - 0.5 * (count - 1.0)) * 4.0 + 15.0) / 3.0;
        let (y, x) = (cell(j, 10.0), cell(i, 12.0));
        let inside = (0.0..10.0).contains(&y) && (0.0..10.0).contains(&x);
        f64::from(u8::from(inside && is_lit(y as usize, x as usize)))
    });
    for (layer, free) in [
        (height.to_owned(), "free = \"height\"\nlevels = 4"),
        (both, "free = \"both\"\nstart = \"random\""),
    ] {
        let stage = two("0.6, 0.5", &layer, free, &loss);
        let run = stage.raylet(&["design", "scene.toml"]);
        assert!(run.status.success(), "{}", complaint(&run));
        let said = String::from_utf8(run.stdout).unwrap();
        let printed: f64 = said
            .split("loss ")
            .nth(1)
            .unwrap()
            .split(',')
            .next()
            .unwrap()
            .parse()
            .unwrap();
        let seen = stage.raylet(&["simulate", "scene.toml", "--out", "seen"]);
        assert!(seen.status.success(), "{}", complaint(&seen));
        let mut file =
            ndarray_npy::NpzReader::new(fs::File::open(stage.join("seen/field.npz")).unwrap())
                .unwrap();
        let fields: Array3<Complex64> = file.by_name("field").unwrap();
        let mean = fields
            .axis_iter(Axis(0))
            .map(|field| unlikeness(&field.to_owned(), &picture))
            .sum::<f64>()
            / 2.0;
        assert!(
            (mean - printed).abs() < 2e-3 * printed,
            "{free}: {mean} {printed}"
        );
    }
}

/// A design that is interrupted leaves a checkpoint, and ends with the exit code of interrupted programs.
#[cfg(unix)]
#[test]
fn interrupted_designs_say_so() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    let loss = format!("[[design.loss]]\nkind = \"likeness\"\n{PICTURE}");
    let stage = two("0.6", &format!("{PIXELS}{PHASE}"), "", &loss);
    let text = fs::read_to_string(stage.join("scene.toml")).unwrap();
    let long = text.replace("iterations = 4", "iterations = 100000\ncheckpoint = 1");
    fs::write(stage.join("scene.toml"), long).unwrap();
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let checkpoint = stage.join("out/design/checkpoint.json");
        let _gone = fs::remove_file(&checkpoint);
        let mut child = Command::new(env!("CARGO_BIN_EXE_raylet"))
            .current_dir(stage.path())
            .args(["design", "scene.toml"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let start = Instant::now();
        while !checkpoint.exists() && start.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(5));
        }
        let target = child.id().to_string();
        let sent = Command::new("kill")
            .args([&format!("-{signal}"), &target])
            .output();
        assert!(sent.is_ok());
        assert_eq!(child.wait().unwrap().code(), Some(code), "{signal}");
        assert!(checkpoint.exists());
    }
}
