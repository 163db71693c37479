//! Nothing that raylet did not write is lost: files of others, results in use, and files of killed runs.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use ndarray::Array2;
use raylet::file::result::result_folder::ResultFolder;

use crate::stage::{SCENE, Stage, complaint, names};

/// The small scene with a hologram and a design, and the name of the file for the phase.
fn sought(phase: &str) -> Stage {
    let named = format!("phase = \"{phase}\"\nsize = [30, 30]");
    let hologram = "[hologram]\ntarget = \"picture.png\"\nelement = \"pixels\"\n\
        size_mm = [0.2, 0.2]\niterations = 2\n[design]\niterations = 2\n";
    let stage = Stage::new(&(SCENE.replace("phase = \"phase.npy\"", &named) + hologram));
    let picture = Array2::from_shape_fn((9, 9), |(y, x)| f64::from(u8::from(x < 3 || y == 5)));
    let file = stage.join("picture.png");
    raylet::file::arrays::image::write_gray16(file, picture.view(), [0.0, 1.0]).unwrap();
    stage
}

/// Asserts that a run was refused, in words that hold these pieces.
fn refused(stage: &Stage, arguments: &[&str], says: &[&str]) {
    let run = stage.raylet(arguments);
    let message = complaint(&run);
    assert_eq!(run.status.code(), Some(2), "{arguments:?}: {message}");
    assert_eq!(message.matches("error:").count(), 1, "{message}");
    for piece in says {
        assert!(
            message.contains(piece),
            "{arguments:?} should say {piece}: {message}"
        );
    }
}

fn succeeds(stage: &Stage, arguments: &[&str]) {
    let run = stage.raylet(arguments);
    assert!(run.status.success(), "{arguments:?}: {}", complaint(&run));
}

/// Starts the program without waiting for it.
fn start(stage: &Stage, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_raylet"))
        .current_dir(stage.path())
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Waits for something to come true.
fn wait_for(what: &str, is_true: impl Fn() -> bool) {
    let clock = Instant::now();
    while !is_true() {
        assert!(clock.elapsed() < Duration::from_secs(60), "no {what}");
        sleep(Duration::from_millis(2));
    }
}

#[test]
fn folders_with_hidden_entries_are_not_replaced() {
    let stage = Stage::new(SCENE);
    let files = [".ssh/id", ".DS_Store", "result.json", "more/field.npz"];
    for (number, file) in files.iter().enumerate() {
        let out = format!("t{number}");
        let path = stage.join(&out).join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "{}").unwrap();
        let name = file.split('/').next().unwrap();
        for verb in ["simulate", "reference"] {
            let message = format!(
                "such as {}",
                if name == "result.json" {
                    "a result"
                } else {
                    name
                }
            );
            refused(
                &stage,
                &[verb, "scene.toml", "--out", &out],
                &[&out, &message],
            );
        }
        assert_eq!(fs::read_to_string(path).unwrap(), "{}");
    }

    // In a result of raylet's too.
    succeeds(&stage, &["simulate", "scene.toml", "--out", "out"]);
    fs::create_dir(stage.join("out/.ssh")).unwrap();
    fs::write(stage.join("out/.ssh/id"), "key").unwrap();
    refused(
        &stage,
        &["simulate", "scene.toml", "--out", "out"],
        &["such as .ssh"],
    );
    assert_eq!(
        fs::read_to_string(stage.join("out/.ssh/id")).unwrap(),
        "key"
    );
    fs::remove_dir_all(stage.join("out/.ssh")).unwrap();
    fs::write(stage.join("out/sensor.png"), "mine").unwrap();
    refused(
        &stage,
        &["simulate", "scene.toml", "--out", "out"],
        &["such as sensor.png"],
    );
    fs::remove_file(stage.join("out/sensor.png")).unwrap();
    succeeds(&stage, &["simulate", "scene.toml", "--out", "out"]);
}

#[test]
fn arrays_of_others_are_not_replaced() {
    for verb in ["hologram", "design"] {
        let stage = sought("data.npy");
        fs::write(stage.join("data.npy"), "mine").unwrap();
        let run = [verb, "scene.toml"];
        refused(&stage, &run, &["data.npy", "did not write", "--overwrite"]);
        assert_eq!(fs::read_to_string(stage.join("data.npy")).unwrap(), "mine");
        assert!(!stage.join("out").exists());
        succeeds(&stage, &[verb, "scene.toml", "--overwrite"]);

        // Twice in a row, and with the record of the file that was written.
        succeeds(&stage, &run);
        succeeds(&stage, &["simulate", "scene.toml"]);
        let phase: Array2<f64> = ndarray_npy::read_npy(stage.join("data.npy")).unwrap();
        ndarray_npy::write_npy(stage.join("data.npy"), &(phase + 1e-9)).unwrap();
        refused(&stage, &run, &["changed since"]);
    }

    // Files that the user names are no exception, nor are those of a design's folder.
    let stage = sought("data.npy");
    fs::write(stage.join("other.npy"), "mine").unwrap();
    let other = ["hologram", "scene.toml", "--out", "other.npy"];
    refused(&stage, &other, &["other.npy", "did not write"]);
    for file in ["course.csv", "design.png", "checkpoint.json"] {
        fs::create_dir(stage.join("run")).unwrap();
        fs::write(stage.join("run").join(file), "mine").unwrap();
        refused(&stage, &["design", "scene.toml", "--out", "run"], &[file]);
        assert_eq!(names(&stage.join("run")), [file]);
        fs::remove_dir_all(stage.join("run")).unwrap();
    }
    let scene = fs::read_to_string(stage.join("scene.toml")).unwrap();
    let variable = "[[design.variable]]\npath = \"element[1].thickness_mm\"\n";
    fs::write(stage.join("scene.toml"), scene + variable).unwrap();
    fs::write(stage.join("scene.designed.toml"), "mine").unwrap();
    refused(&stage, &["design", "scene.toml"], &["scene.designed.toml"]);
    assert_eq!(
        fs::read_to_string(stage.join("scene.designed.toml")).unwrap(),
        "mine"
    );
}

#[test]
fn arrays_go_outside_only_if_allowed() {
    let elsewhere = tempfile::tempdir().unwrap();
    let absolute = elsewhere.path().join("data.npy");
    let absolute = absolute.to_str().unwrap();
    for phase in [
        absolute,
        "../raylet-test-outside.npy",
        "new/../../raylet-test-outside.npy",
    ] {
        let stage = sought(phase);
        for verb in ["hologram", "design"] {
            let says = [
                "layer[0].phase",
                "outside of the scene's folder",
                "--allow-outside",
            ];
            refused(&stage, &[verb, "scene.toml"], &says);
        }
        assert_eq!(stage.names(), ["phase.npy", "picture.png", "scene.toml"]);
    }
    let stage = sought(absolute);
    assert_eq!(names(elsewhere.path()).len(), 0);
    succeeds(&stage, &["hologram", "scene.toml", "--allow-outside"]);
    fs::write(absolute, "mine").unwrap();
    refused(
        &stage,
        &["hologram", "scene.toml", "--allow-outside"],
        &["did not write"],
    );

    // What the user names may be anywhere, and the folder of a design is as good as the scene's.
    let out = elsewhere.path().join("own.npy");
    succeeds(
        &stage,
        &["hologram", "scene.toml", "--out", out.to_str().unwrap()],
    );
    fs::remove_file(absolute).unwrap();
    succeeds(
        &stage,
        &[
            "design",
            "scene.toml",
            "--out",
            elsewhere.path().to_str().unwrap(),
        ],
    );
}

#[cfg(unix)]
#[test]
fn one_run_at_a_time_writes_to_a_place() {
    let stage = sought("found.npy");
    let scene = fs::read_to_string(stage.join("scene.toml")).unwrap();
    let long = scene.replace(
        "[design]\niterations = 2",
        "[design]\niterations = 100000\ncheckpoint = 1",
    );
    fs::write(stage.join("long.toml"), &long).unwrap();
    let mut first = start(&stage, &["design", "long.toml", "--out", "run"]);
    wait_for("checkpoint", || stage.join("run/checkpoint.json").exists());
    let process = format!("process {} on ", first.id());
    refused(
        &stage,
        &["design", "scene.toml", "--out", "run"],
        &["run: found ", &process],
    );
    refused(
        &stage,
        &["design", "scene.toml", "--out", "run", "--resume"],
        &[&process],
    );

    // The file that both name is held too.
    refused(
        &stage,
        &["design", "scene.toml", "--out", "two"],
        &["found.npy", &process],
    );
    refused(
        &stage,
        &["hologram", "scene.toml"],
        &["found.npy", &process],
    );
    assert!(!stage.join("two").exists());

    // Killed, it holds nothing any more, and the next run removes what it has left.
    first.kill().unwrap();
    first.wait().unwrap();
    assert!(names(&stage.join("run")).contains(&String::from(".raylet-run.lock")));
    succeeds(&stage, &["design", "scene.toml", "--out", "run"]);
    let hidden = |names: Vec<String>| {
        let left = |name: &String| name.starts_with(".raylet-");
        names.into_iter().filter(left).count()
    };
    assert_eq!(hidden(names(&stage.join("run"))) + hidden(stage.names()), 0);
}

#[cfg(unix)]
#[test]
fn results_have_one_writer_at_a_time() {
    // Hours of direct sum.
    let lens = SCENE.find("[[element]]\nkind = \"lens\"").unwrap();
    let camera = SCENE.find("[[element]]\nkind = \"sensor\"").unwrap();
    let free = format!("{}{}", &SCENE[..lens], &SCENE[camera..]);
    let stage = Stage::new(&free.replace("pixels = [48, 40]", "pixels = [4000, 4000]"));
    let endless = ["reference", "scene.toml", "--method", "rayleigh-sommerfeld"];
    let more = ["--most-hours", "1e9", "--out", "a/out"];
    let mut first = start(&stage, &[&endless[..], &more[..]].concat());
    wait_for("lock", || stage.join(".raylet-a+out.lock").exists());
    let process = format!("process {} on ", first.id());
    let second = ["simulate", "scene.toml", "--out", "a/out"];
    refused(&stage, &second, &["a/out: found ", &process]);
    first.kill().unwrap();
    first.wait().unwrap();
    fs::write(stage.join("scene.toml"), SCENE).unwrap();
    succeeds(&stage, &second);
    ResultFolder::read(&stage.join("a/out")).unwrap();
    assert_eq!(stage.names(), ["a", "phase.npy", "scene.toml"]);
}

/// A file that grows beyond `ulimit -f` is an ordinary error, and nothing half-written stays.
#[cfg(unix)]
#[test]
fn limits_of_file_size_are_errors() {
    let stage = sought("found.npy");
    let before = stage.names();
    for arguments in [
        "simulate scene.toml --out out",
        "hologram scene.toml",
        "design scene.toml --out run",
    ] {
        let scene = fs::read_to_string(stage.join("scene.toml")).unwrap();
        if arguments.starts_with("simulate") {
            fs::write(stage.join("scene.toml"), SCENE).unwrap();
        }
        let run = Command::new("sh")
            .current_dir(stage.path())
            .args(["-c", &format!("ulimit -f 4; exec \"$RAYLET\" {arguments}")])
            .env("RAYLET", env!("CARGO_BIN_EXE_raylet"))
            .output()
            .unwrap();
        let message = complaint(&run);
        assert_eq!(run.status.code(), Some(2), "{arguments}: {message}");
        assert!(message.contains("File too large"), "{arguments}: {message}");
        fs::write(stage.join("scene.toml"), scene).unwrap();
        assert_eq!(stage.names(), before, "{arguments}");
    }
}

/// Whatever a killed run leaves in hiding, the next one removes; the result is whole at any moment.
#[cfg(unix)]
#[test]
fn what_killed_runs_leave_is_removed_by_the_next() {
    let stage = Stage::new(SCENE);
    let arguments = ["simulate", "scene.toml", "--out", "out"];
    let clock = Instant::now();
    succeeds(&stage, &arguments);
    let whole = clock.elapsed();
    let mut left = 0;
    for moment in 0..8 {
        let mut run = start(&stage, &arguments);
        sleep(whole * moment / 7);
        run.kill().unwrap();
        run.wait().unwrap();
        ResultFolder::read(&stage.join("out")).unwrap();
        let names = stage.names();
        left += names.iter().filter(|n| n.starts_with(".raylet-")).count();
    }
    assert!(left > 0, "no killed run left anything");
    succeeds(&stage, &arguments);
    assert_eq!(stage.names(), ["out", "phase.npy", "scene.toml"]);
}
