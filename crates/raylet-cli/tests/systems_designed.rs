//! `raylet design` and `raylet gradcheck` of systems: several elements, losses, wavelengths and fields.

mod refusal;
mod stage;

use std::fs;

use ndarray::{Array2, Array3, Axis};
use num_complex::Complex64;
use raylet::file::image::write_gray16;

use crate::refusal::{none_of, wrong};
use crate::stage::{SCENE, Stage, complaint};

/// Two elements in free space at two wavelengths; `LAYER` is what is designed of the first.
const TWO: &str = r#"version = 1
wavelength_um = [0.6, 0.5]
source = { kind = "plane" }

[[element]]
kind = "doe"
name = "first"
thickness_mm = 0.4
aperture = { disc = { radius_mm = 0.04 } }
LAYER
[[element]]
kind = "doe"
name = "second"
thickness_mm = 0.4
aperture = { disc = { radius_mm = 0.04 } }
[[element.layer]]
kind = "pixels"
pitch_um = 4
size = [20, 20]
phase = "second.npy"

[[element]]
kind = "sensor"
name = "camera"
pixels = [24, 20]
pitch_um = 4

[design]
iterations = 8
[[design.element]]
name = "first"
FREE
[[design.element]]
name = "second"
start = "random"
LOSS
"#;

const PIXELS: &str = "[[element.layer]]\nkind = \"pixels\"\npitch_um = 4\nsize = [20, 20]\n";
const PHASE: &str = "phase = \"first.npy\"\n";
const PICTURE: &str = "picture = \"picture.png\"\nsize_mm = [0.05, 0.05]\n";

/// A folder with the two elements and a picture.
fn two(layer: &str, free: &str, loss: &str) -> Stage {
    let text = TWO.replace("LAYER", layer).replace("FREE", free);
    with_picture(&text.replace("LOSS", loss))
}

fn with_picture(text: &str) -> Stage {
    let stage = Stage::new(text);
    let picture = Array2::from_shape_fn((10, 10), |(j, i)| {
        f64::from(u8::from(j == 2 || i == 6 || (j > 6 && i < 4)))
    });
    write_gray16(stage.join("picture.png"), picture.view(), [0.0, 1.0]).unwrap();
    stage
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
fn whatever_is_free_has_its_gradient() {
    let sum = "[[element.layer]]\nkind = \"sum\"\nweights = [1.0, 0.8]\nterms = [[{ kind = \"pixels\", pitch_um = 4, \
               size = [20, 20], phase = \"a.npy\" }], [{ kind = \"pixels\", pitch_um = 4, size = [20, 20], \
               phase = \"a.npy\" }]]\n";
    let height = "[[element.layer]]\nkind = \"height\"\npitch_um = 4\nsize = [20, 20]\nheight_um = \"h.npy\"\n\
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
        for (line, apart) in apart(&two(&layer, free, &loss)) {
            assert!(apart < 1e-7, "{free}: {line}");
        }
    }
}

#[test]
fn whatever_is_wanted_has_its_gradient() {
    let fields =
        "[[design.field]]\nangle_deg = [0.0, 0.0]\n[[design.field]]\nangle_deg = [2.0, -1.0]\n";
    for loss in [
        format!("kind = \"mse\"\n{PICTURE}care = \"outline\"\nmask = \"picture.png\"\n"),
        format!("kind = \"mse\"\nscale = 0.5\n{PICTURE}"),
        format!("kind = \"overlap\"\nfield = [1]\n{PICTURE}"),
        format!(
            "kind = \"efficiency\"\n{PICTURE}[[design.loss]]\nkind = \"efficiency\"\nat_mm = [[0.0, 0.01]]\nradius_mm = 0.01\nwavelength_um = [0.5]\n"
        ),
        String::from(
            "kind = \"encircled_energy\"\nat_mm = [[0.01, 0.0], [-0.02, 0.01]]\nradius_mm = 0.008\nweight = 3\n",
        ),
        String::from(
            "kind = \"spot\"\nat_mm = [[0.01, 0.0], [-0.02, 0.01]]\nsharing = \"log\"\nevenness = 0.3\nfocal_length_mm = 0.6\n",
        ),
    ] {
        let loss = format!("{fields}[[design.loss]]\n{loss}");
        let stage = two(&format!("{PIXELS}{PHASE}"), "start = \"random\"", &loss);
        for (line, apart) in apart(&stage) {
            assert!(apart < 1e-7, "{loss}: {line}");
        }
    }
}

/// Coefficients of an aspheric surface and of an analytic profile, a radius and a tilt, for a spot.
#[test]
fn numbers_of_the_system_are_designed() {
    let lens = SCENE
        .replace("phase = \"phase.npy\"", "size = [30, 30]\n[[element.layer]]\nkind = \"radial\"\nnorm_radius_mm = 0.09\ncoefficients = [0.5, 0.1]")
        .replace("radius_mm = 5\n", "radius_mm = 5\naspheric = [0.001]\n")
        .replace("name = \"L\"\n", "name = \"L\"\ntilt_deg = [0.5, 0, 0]\n");
    let paths = [
        ("element[1].surface[0].aspheric[0]", 2.0),
        ("element[0].layer[1].coefficients[1]", 0.3),
        ("element[1].surface[0].radius_mm", 0.01),
        ("element[1].tilt_deg[0]", 0.1),
    ];
    let variable = |(path, scale): (&str, f64)| {
        format!("[[design.variable]]\npath = \"{path}\"\nscale = {scale}\n")
    };
    let variables: String = paths.map(variable).concat();
    let text = format!(
        "{lens}[design]\niterations = 12\n[[design.loss]]\nkind = \"spot\"\nat_mm = [[0.0, 0.0]]\n\
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
    assert!(losses.last().unwrap() < &(0.5 * losses[0]), "{course}");
    assert!(stage.join("scene.designed.toml").exists());
}

/// 1 − NCC² of intensities with a picture.
fn unlikeness(field: &Array2<Complex64>, picture: &Array2<f64>) -> f64 {
    let seen = field.mapv(|u| u.norm_sqr());
    let inner = |a: &Array2<f64>, b: &Array2<f64>| (a * b).sum();
    1.0 - inner(&seen, picture).powi(2) / (inner(&seen, &seen) * inner(picture, picture))
}

/// What `raylet simulate` sees of the files is what the design saw, with the dispersion of a height, levels and all.
#[test]
fn what_is_left_is_what_was_designed() {
    let height = "[[element.layer]]\nkind = \"height\"\npitch_um = 4\nsize = [20, 20]\nheight_um = \"h.npy\"\n\
                  glass = \"N-BK7\"\n";
    let both = format!(
        "{PIXELS}{PHASE}phase_scale = 6.283185307179586\namplitude = \"t.npy\"\nfill = 0.8\nrest = \"flat\"\n"
    );
    let loss = format!("[[design.loss]]\nkind = \"likeness\"\n{PICTURE}");
    let picture = Array2::from_shape_fn((20, 24), |(j, i)| {
        // The picture's cells are 5 µm wide; pixels are told by their centres.
        let cell = |n: usize, count: f64| ((n as f64 - 0.5 * (count - 1.0)) * 4.0 + 25.0) / 5.0;
        let (y, x) = (cell(j, 20.0), cell(i, 24.0));
        let inside = (0.0..10.0).contains(&y) && (0.0..10.0).contains(&x);
        let (y, x) = (y as usize, x as usize);
        f64::from(u8::from(inside && (y == 2 || x == 6 || (y > 6 && x < 4))))
    });
    for (layer, free) in [
        (height.to_owned(), "free = \"height\"\nlevels = 4"),
        (both, "free = \"both\"\nstart = \"random\""),
    ] {
        let stage = two(&layer, free, &loss);
        let run = stage.raylet(&["design", "scene.toml"]);
        assert!(run.status.success(), "{}", complaint(&run));
        let said = String::from_utf8(run.stdout).unwrap();
        let told: f64 = said
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
        assert!((mean - told).abs() < 2e-3 * told, "{free}: {mean} {told}");
    }
}

#[test]
fn bad_systems_are_told() {
    let pixels = format!("{PIXELS}{PHASE}");
    let good = format!("[[design.loss]]\nkind = \"likeness\"\n{PICTURE}");
    let spot = "[[design.loss]]\nkind = \"spot\"\nat_mm = [[0.0, 0.0]]\n";
    let circle = "[[design.loss]]\nkind = \"encircled_energy\"\nradius_mm = 0.01\n";
    let cases: Vec<(String, &str, String, Vec<&str>)> = vec![
        (
            pixels.clone(),
            "free = \"all\"",
            good.clone(),
            vec!["design.element[0].free", "two_phase"],
        ),
        (
            pixels.clone(),
            "free = \"both\"",
            good.clone(),
            vec!["element[0].layer[0]", "no file for the amplitude"],
        ),
        (
            PIXELS.to_owned(),
            "",
            good.clone(),
            vec!["element[0].layer[0]", "no file for the phase"],
        ),
        (
            pixels.clone(),
            "free = \"height\"",
            good.clone(),
            vec!["element[0].layer[0]", "kind \"height\""],
        ),
        (
            pixels.clone(),
            "free = \"two_phase\"",
            good.clone(),
            vec!["element[0].layer[0]", "kind \"sum\""],
        ),
        (
            pixels.clone(),
            "highest_um = 2",
            good.clone(),
            vec!["design.element[0].highest_um", "height"],
        ),
        (
            pixels.clone(),
            "levels = 1",
            good.clone(),
            vec!["design.element[0].levels", "at least 2"],
        ),
        (
            pixels.clone(),
            "block = 0",
            good.clone(),
            vec!["design.element[0].block", "above zero"],
        ),
        (
            pixels.clone(),
            "blur = 0.5",
            good.clone(),
            vec!["design.element[0].blur", "one or more"],
        ),
        (
            pixels.clone(),
            "smoothness = -1",
            good.clone(),
            vec!["design.element[0].smoothness", "zero or more"],
        ),
        (
            pixels.clone(),
            "start = \"spread\"",
            good.clone(),
            vec!["design.element[0].start", "[hologram]"],
        ),
        (
            pixels.clone(),
            "[[design.element]]\nname = \"first\"",
            good.clone(),
            vec!["design.element[1].name", "once"],
        ),
        (
            pixels.clone(),
            "[[design.element]]\nname = \"third\"",
            good.clone(),
            vec!["design.element[1].name", "third"],
        ),
        (
            pixels.replace("size = [20, 20]\n", ""),
            "",
            good.clone(),
            vec!["element[0].layer[0]", "size = [nx, ny]"],
        ),
        (
            format!("{pixels}amplitude = \"a.npy\"\n"),
            "",
            good.clone(),
            vec!["element[0].layer[0].amplitude", "both"],
        ),
        (
            format!("{pixels}fill = 1.5\n"),
            "",
            good.clone(),
            vec!["element[0].layer[0].fill", "up to 1"],
        ),
        (
            pixels.clone(),
            "",
            String::new(),
            vec!["hologram", "[hologram]"],
        ),
        (
            pixels.clone(),
            "",
            good.replace("likeness", "beauty"),
            vec!["design.loss[0]", "beauty", "overlap"],
        ),
        (
            pixels.clone(),
            "",
            good.replace("picture.png", "none.png"),
            vec!["design.loss[0].picture", "none.png"],
        ),
        (
            pixels.clone(),
            "",
            good.replace("size_mm = [0.05, 0.05]\n", ""),
            vec!["design.loss[0]", "one without the other"],
        ),
        (
            pixels.clone(),
            "",
            format!("{good}mask = \"none.png\"\n"),
            vec!["design.loss[0].mask", "none.png"],
        ),
        (
            pixels.clone(),
            "",
            format!("{good}weight = 0\n"),
            vec!["design.loss[0].weight", "above zero"],
        ),
        (
            pixels.clone(),
            "",
            format!("{good}field = [1]\n"),
            vec!["design.loss[0].field", "below 1"],
        ),
        (
            pixels.clone(),
            "",
            format!("{good}wavelength_um = [0.7]\n"),
            vec!["design.loss[0].wavelength_um", "0.7", "0.6"],
        ),
        (
            pixels.clone(),
            "",
            format!("{good}wavelength_um = []\n"),
            vec!["design.loss[0].wavelength_um"],
        ),
        (
            pixels.clone(),
            "",
            spot.replace("0.0, 0.0", "1.0, 0.0"),
            vec!["design.loss[0].at_mm", "off the sensor"],
        ),
        (
            pixels.clone(),
            "",
            format!("{spot}evenness = -1\n"),
            vec!["design.loss[0].evenness", "zero or more"],
        ),
        (
            pixels.clone(),
            "",
            format!("{circle}at_mm = []\n"),
            vec!["design.loss[0].at_mm", "at least one"],
        ),
        (
            pixels.clone(),
            "",
            format!("{circle}at_mm = [[2.0, 0.0]]\n"),
            vec!["design.loss[0].at_mm", "circles on the sensor"],
        ),
        (
            pixels.clone(),
            "",
            String::from("[[design.loss]]\nkind = \"efficiency\"\nradius_mm = 1\n"),
            vec!["design.loss[0]", "at_mm"],
        ),
        (
            pixels.clone(),
            "",
            format!("[[design.field]]\n{good}"),
            vec!["design.field[0]", "angle_deg"],
        ),
        (
            pixels.clone(),
            "",
            format!("[[design.field]]\nangle_deg = [95, 0]\n{good}"),
            vec!["design.field[0].angle_deg", "90"],
        ),
        (
            pixels.clone(),
            "",
            format!("[[design.field]]\nposition_mm = [0, 0, -1]\n{good}"),
            vec!["design.field[0]", "plane source"],
        ),
        (
            pixels.clone(),
            "",
            format!("{good}[[design.variable]]\npath = \"element[0].thickness_mm\"\nlowest = 1\n"),
            vec!["design.variable[0].path", "bounds"],
        ),
    ];
    none_of(cases.iter().map(|(layer, free, loss, says)| {
        let stage = two(layer, free, loss);
        let says: Vec<&str> = ["scene.toml"].iter().chain(says).copied().collect();
        wrong(&stage, &["design", "scene.toml"], &says)
    }));

    // Keys for the element of [hologram] beside lists, and nothing to design.
    let stray = |key: &str| TWO.replace("iterations = 8", key);
    let text = |text: String| {
        let text = text.replace("LAYER", &pixels).replace("FREE", "");
        with_picture(&text.replace("LOSS", &good))
    };
    none_of([
        wrong(
            &text(stray("levels = 4")),
            &["design", "scene.toml"],
            &["design.levels", "[[design.element]]"],
        ),
        wrong(
            &text(stray("start = \"flat\"")),
            &["design", "scene.toml"],
            &["design.start", "inside"],
        ),
        wrong(
            &text(stray("efficiency = 0.1")),
            &["design", "scene.toml"],
            &["design.efficiency", "[[design.loss]]"],
        ),
        wrong(
            &Stage::new(&format!("{SCENE}[design]\n")),
            &["design", "scene.toml"],
            &["design", "nothing to design"],
        ),
    ]);
}

/// A design that is told to stop leaves a checkpoint, and ends as programs end that are interrupted.
#[cfg(unix)]
#[test]
fn interrupted_designs_say_so() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    let loss = format!("[[design.loss]]\nkind = \"likeness\"\n{PICTURE}");
    let stage = two(&format!("{PIXELS}{PHASE}"), "", &loss);
    let text = fs::read_to_string(stage.join("scene.toml")).unwrap();
    let long = text.replace("iterations = 8", "iterations = 100000\ncheckpoint = 1");
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
