//! `raylet design`: what it finds, and that nothing is lost when it is stopped.

use std::fs;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use ndarray::Array2;

use crate::stage::{SCENE, Stage, complaint};

/// The small scene with a picture of two dots and a bar, sought with a variable distance.
fn stage(design: &str) -> Stage {
    let sized = SCENE.replace(
        "phase = \"phase.npy\"",
        "phase = \"found.npy\"\nsize = [30, 30]",
    );
    let task = "[hologram]\ntarget = \"picture.png\"\nelement = \"pixels\"\nsize_mm = [0.2, 0.2]\n";
    let stage = Stage::new(&format!("{sized}{task}[design]\n{design}"));
    let picture = Array2::from_shape_fn((20, 20), |(j, i)| {
        let dot = |y: usize, x: usize| j.abs_diff(y) < 3 && i.abs_diff(x) < 3;
        f64::from(u8::from(
            dot(13, 5) || dot(13, 14) || (j == 5 && i.abs_diff(10) < 7),
        ))
    });
    raylet::file::arrays::image::write_gray16(
        stage.join("picture.png"),
        picture.view(),
        [0.0, 1.0],
    )
    .unwrap();
    stage
}

/// The number behind a word in what the program said.
fn number(text: &str, word: &str) -> f64 {
    let rest = text.split(word).nth(1).unwrap();
    rest.split_whitespace().next().unwrap().parse().unwrap()
}

#[test]
fn phases_are_found_and_simulate_agrees() {
    let stage = stage("iterations = 30\n");
    let run = stage.raylet(&["design", "scene.toml", "--out", "course"]);
    assert!(run.status.success(), "{}", complaint(&run));
    let said = String::from_utf8(run.stdout).unwrap();
    assert!(number(&said, "NCC ") > 0.85, "{said}");
    for file in ["found.npy", "course/design.png", "course/course.csv"] {
        assert!(stage.join(file).exists(), "{file}");
    }

    // The loss falls from iteration to iteration.
    let course = fs::read_to_string(stage.join("course/course.csv")).unwrap();
    let losses: Vec<f64> = course
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(2).unwrap().parse().unwrap())
        .collect();
    assert!(losses.len() > 20 && losses.windows(2).all(|pair| pair[1] <= pair[0]));
    let simulated = stage.raylet(&["simulate", "scene.toml", "--out", "seen"]);
    assert!(simulated.status.success(), "{}", complaint(&simulated));
}

/// Two elements cannot leave their designs in one file.
#[test]
fn each_element_needs_a_file_of_its_own() {
    let element = SCENE.split("[[element]]").nth(1).unwrap();
    let sought = element.replace(
        "phase = \"phase.npy\"",
        "phase = \"found.npy\"\nsize = [30, 30]",
    );
    let twin = sought.replace("\"pixels\"\nthick", "\"twin\"\nthick");
    let both = format!("[[element]]{sought}[[element]]{twin}");
    let scene = SCENE.replacen(&format!("[[element]]{element}"), &both, 1);
    let task = "[hologram]\ntarget = \"picture.png\"\nelement = \"pixels\"\nsize_mm = [0.2, 0.2]\n[design]\n\
                [[design.element]]\nname = \"pixels\"\n[[design.element]]\nname = \"twin\"\n";
    let stage = stage("");
    fs::write(stage.join("scene.toml"), format!("{scene}{task}")).unwrap();
    let run = stage.raylet(&["design", "scene.toml"]);
    let message = complaint(&run);
    assert_eq!(run.status.code(), Some(2), "{message}");
    assert!(
        message.contains("element[1].layer[0].phase: found found.npy, where the design of `element[0].layer[0].phase`"),
        "{message}"
    );
}

/// Starts a design, or goes on with it, and kills it so long after its next checkpoint.
fn kill(stage: &Stage, more: &[&str], later: Duration) {
    let checkpoint = || fs::read(stage.join("out/design/checkpoint.json")).ok();
    let before = checkpoint();
    let is_new = |found: &Vec<u8>| before.as_ref() != Some(found);
    let mut child = Command::new(env!("CARGO_BIN_EXE_raylet"))
        .current_dir(stage.path())
        .args(["design", "scene.toml"])
        .args(more)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let start = Instant::now();
    let mut written = false;
    while !written && start.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(2));
        written = checkpoint().as_ref().is_some_and(is_new);
    }
    sleep(later);
    child.kill().unwrap();
    let status = child.wait().unwrap();
    assert!(written, "no new checkpoint: {status}");

    // A signal leaves no code; a run that has ended, or was refused, has one.
    let killed = match cfg!(unix) {
        true => status.code().is_none(),
        false => !status.success(),
    };
    assert!(killed, "it ended before it was killed: {status}");
}

/// How long after a checkpoint a run is killed: at once, and between two of them.
const MOMENTS: [Duration; 3] = [
    Duration::ZERO,
    Duration::from_millis(30),
    Duration::from_millis(80),
];

/// What a run leaves that was killed three times and went on, the same to the bit as a run that was not.
fn stopped_and_resumed(task: &str, files: &[&str]) -> Stage {
    let whole = stage(task);
    let run = whole.raylet(&["design", "scene.toml", "--threads", "1"]);
    assert!(run.status.success(), "{}", complaint(&run));

    let broken = stage(task);
    for (time, later) in MOMENTS.into_iter().enumerate() {
        let more: &[&str] = if time == 0 { &[] } else { &["--resume"] };
        kill(&broken, more, later);
    }
    let resumed = broken.raylet(&["design", "scene.toml", "--resume"]);
    assert!(resumed.status.success(), "{}", complaint(&resumed));
    for file in files {
        let read = |stage: &Stage| fs::read(stage.join(file)).unwrap();
        assert!(read(&whole) == read(&broken), "{file}");
    }
    broken
}

/// Drawn beamlets are the same again when a killed run goes on, and find a picture too.
#[test]
fn estimators_go_on_bit_for_bit_slow() {
    for estimator in [
        "{ kind = \"control_variate\", each = 24, refresh = 5 }",
        "{ kind = \"gumbel\", each = 8, temperature = 0.5 }",
    ] {
        let task = format!(
            "iterations = 24\ncheckpoint = 4\noptimizer = \"adam\"\nestimator = {estimator}\n"
        );
        let stage = stopped_and_resumed(&task, &["found.npy", "out/design/course.csv"]);
        let run = stage.raylet(&["design", "scene.toml", "--resume", "--iterations", "24"]);
        let said = String::from_utf8(run.stdout).unwrap();
        assert!(number(&said, "NCC ") > 0.6, "{said}");
    }
}

/// Killed at once after its first checkpoint and twice between later ones, a run with all threads that goes on ends
/// with the same bits as one with one thread that was never stopped.
#[test]
fn a_killed_run_goes_on_bit_for_bit_slow() {
    let task = "iterations = 24\ncheckpoint = 4\n[[design.variable]]\npath = \"element[1].thickness_mm\"\n";
    let files = ["found.npy", "scene.designed.toml", "out/design/course.csv"];
    let broken = stopped_and_resumed(task, &files);

    // The scene with the number that was found is simulated as it is.
    let simulated = broken.raylet(&["simulate", "scene.designed.toml", "--out", "seen"]);
    assert!(simulated.status.success(), "{}", complaint(&simulated));

    // Another scene does not go on from there.
    let scene = fs::read_to_string(broken.join("scene.toml")).unwrap();
    fs::write(
        broken.join("scene.toml"),
        scene.replace("thickness_mm = 8", "thickness_mm = 8.5"),
    )
    .unwrap();
    let refused = broken.raylet(&["design", "scene.toml", "--resume"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        complaint(&refused).contains("another scene"),
        "{}",
        complaint(&refused)
    );
}

#[test]
fn levels_and_blocks_are_what_is_exported() {
    let stage = stage("iterations = 40\nlevels = 4\nblock = 2\n");
    let run = stage.raylet(&["design", "scene.toml"]);
    assert!(run.status.success(), "{}", complaint(&run));
    let phase: Array2<f64> = ndarray_npy::read_npy(stage.join("found.npy")).unwrap();
    for ((j, i), value) in phase.indexed_iter() {
        let level = value / std::f64::consts::FRAC_PI_2;
        assert!((level - level.round()).abs() < 1e-12, "{value}");
        assert_eq!(*value, phase[[j / 2 * 2, i / 2 * 2]]);
    }
}

#[test]
fn bad_designs_are_reported() {
    for (design, parts) in [
        ("iterations = 0\n", ["iterations", "above zero"]),
        ("optimizer = \"newton\"\n", ["optimizer", "lbfgs"]),
        ("start = \"none\"\n", ["start", "spread"]),
        ("rate = -1\n", ["rate", "above zero"]),
        ("efficiency = -0.1\n", ["efficiency", "0"]),
        ("levels = 1\n", ["1 as number of levels", "two or more"]),
        ("rate = 0.1\n", ["design.rate", "adam"]),
        ("block = 0\n", ["block", "above zero"]),
        (
            "estimator = { kind = \"multinomial\" }\n",
            ["design.estimator", "adam or momentum"],
        ),
        (
            "optimizer = \"adam\"\nestimator = { kind = \"gumbel\", temperature = 0 }\n",
            ["design.estimator.temperature", "above zero"],
        ),
        (
            "optimizer = \"adam\"\nestimator = { kind = \"svrg\" }\n",
            ["design.estimator.kind", "control_variate"],
        ),
        (
            "optimizer = \"adam\"\nestimator = { kind = \"gumbel\", each = 0 }\n",
            ["design.estimator.each", "above zero"],
        ),
        (
            "optimizer = \"adam\"\nestimator = { kind = \"gumbel\" }\n[[design.variable]]\npath = \"element[1].thickness_mm\"\n",
            ["design.estimator", "one of the two"],
        ),
        (
            "[[design.variable]]\npath = \"element[9].thickness_mm\"\n",
            ["element[9].thickness_mm", "path of a number"],
        ),
        (
            "[[design.variable]]\npath = \"element[1].name\"\n",
            ["element[1].name", "path of a number"],
        ),
        (
            "[[design.variable]]\npath = \"element[1].surface[1].radius_mm\"\n",
            ["radius_mm", "number"],
        ),
        ("colour = 3\n", ["colour", "unknown"]),
    ] {
        let stage = stage(design);
        let before = stage.names();
        let run = stage.raylet(&["design", "scene.toml"]);
        assert_eq!(stage.names(), before, "{design}");
        let said = complaint(&run);
        assert_eq!(run.status.code(), Some(2), "{design}: {said}");
        assert!(said.contains("scene.toml"), "{said}");
        assert!(
            parts.iter().all(|part| said.contains(part)),
            "{design}: {said}"
        );
    }
    let stage = Stage::new(SCENE);
    let said = complaint(&stage.raylet(&["design", "scene.toml"]));
    assert!(said.contains("no design"), "{said}");
    let said = complaint(&stage.raylet(&["design", "scene.toml", "--resume"]));
    assert!(said.contains("no design"), "{said}");
}
