//! However a run ends, its files are complete, and nothing hidden stays.

use std::fs::{self, OpenOptions};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use raylet::file::result::result_folder::ResultFolder;

use crate::stage::{SCENE, Stage, complaint, names};

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

/// Sends a signal, such as INT; a program that has ended does not mind.
#[cfg(unix)]
fn send(signal: &str, child: &Child) {
    let target = child.id().to_string();
    let sent = Command::new("kill")
        .args([&format!("-{signal}"), &target])
        .output();
    assert!(sent.is_ok());
}

#[cfg(unix)]
#[test]
fn a_long_run_ends_within_a_second() {
    // Hours of direct sum.
    let lens = SCENE.find("[[element]]\nkind = \"lens\"").unwrap();
    let camera = SCENE.find("[[element]]\nkind = \"sensor\"").unwrap();
    let free = format!("{}{}", &SCENE[..lens], &SCENE[camera..]);
    let stage = Stage::new(&free.replace("pixels = [48, 40]", "pixels = [4000, 4000]"));
    let before = stage.names();
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let mut run = start(
            &stage,
            &[
                "reference",
                "scene.toml",
                "--method",
                "rayleigh-sommerfeld",
                "--most-hours",
                "1e9",
                "--out",
                "new/out",
            ],
        );
        sleep(Duration::from_millis(500));
        assert!(
            run.try_wait().unwrap().is_none(),
            "the run is too short for this test"
        );
        let clock = Instant::now();
        send(signal, &run);
        assert_eq!(run.wait().unwrap().code(), Some(code), "{signal}");
        assert!(
            clock.elapsed() < Duration::from_secs(1),
            "{:?}",
            clock.elapsed()
        );
        assert_eq!(stage.names(), before);
    }
}

#[cfg(unix)]
#[test]
fn whenever_it_is_interrupted_results_are_whole_or_absent() {
    let stage = Stage::new(SCENE);
    let before = stage.names();
    let clock = Instant::now();
    start(&stage, &["simulate", "scene.toml", "--out", "a/b"])
        .wait()
        .unwrap();
    let whole = clock.elapsed();

    // Moments from the start to a little after the end.
    let moments = 20;
    for moment in 0..moments {
        if stage.join("a").exists() && moment % 2 == 0 {
            fs::remove_dir_all(stage.join("a")).unwrap();
        }
        let mut run = start(&stage, &["simulate", "scene.toml", "--out", "a/b"]);
        sleep(whole * moment * 6 / (5 * moments));
        send("INT", &run);
        run.wait().unwrap();
        let mut found = stage.names();
        if let Some(at) = found.iter().position(|name| name == "a") {
            assert_eq!(names(&stage.join("a")), ["b"]);
            ResultFolder::read(&stage.join("a/b")).unwrap();
            found.remove(at);
        }
        assert_eq!(found, before, "moment {moment}");
    }
}

#[test]
fn four_runs_at_once_leave_one_whole_result() {
    let stage = Stage::new(SCENE);
    let arguments = ["simulate", "scene.toml", "--out", "a/out"];
    let mut runs: Vec<Child> = (0..4).map(|_| start(&stage, &arguments)).collect();
    let codes: Vec<Option<i32>> = runs
        .iter_mut()
        .map(|run| run.wait().unwrap().code())
        .collect();
    assert!(codes.contains(&Some(0)), "{codes:?}");
    assert!(
        codes.iter().all(|code| matches!(code, Some(0 | 2))),
        "{codes:?}"
    );
    ResultFolder::read(&stage.join("a/out")).unwrap();
    assert_eq!(names(&stage.join("a")), ["out"]);
    assert_eq!(stage.names(), ["a", "phase.npy", "scene.toml"]);
}

#[test]
fn missing_folders_are_made_with_the_result() {
    let stage = Stage::new(SCENE);
    fs::create_dir(stage.join("a µ b")).unwrap();
    fs::rename(stage.join("scene.toml"), stage.join("a µ b/ß 1.toml")).unwrap();
    let phase = "phase = \"../phase.npy\"";
    let text = SCENE.replace("phase = \"phase.npy\"", phase);
    fs::write(stage.join("a µ b/ß 1.toml"), &text).unwrap();
    let run = || stage.raylet(&["simulate", "a µ b/ß 1.toml", "--out", "new/ö ü/out/"]);
    let output = run();
    assert!(output.status.success(), "{}", complaint(&output));
    ResultFolder::read(&stage.join("new/ö ü/out")).unwrap();

    // A run that fails leaves no folders.
    fs::remove_dir_all(stage.join("new")).unwrap();
    let dark = text.replace("pitch_um = 5\n", "pitch_um = 5\ndecenter_mm = [300, 0]\n");
    fs::write(stage.join("a µ b/ß 1.toml"), dark).unwrap();
    assert_eq!(run().status.code(), Some(2));
    assert_eq!(stage.names(), ["a µ b", "phase.npy"]);
}

#[cfg(unix)]
#[test]
fn links_are_not_replaced() {
    let stage = Stage::new(SCENE);
    fs::create_dir(stage.join("real")).unwrap();
    std::os::unix::fs::symlink("real", stage.join("link")).unwrap();
    std::os::unix::fs::symlink("nowhere", stage.join("loose")).unwrap();
    for (out, message) in [
        ("link", "symbolic link"),
        ("link/", "symbolic link"),
        ("loose", "symbolic link"),
        ("loose/out", "loose"),
    ] {
        let output = stage.raylet(&["simulate", "scene.toml", "--out", out]);
        assert_eq!(output.status.code(), Some(2), "{out}");
        assert!(
            complaint(&output).contains(message),
            "{}",
            complaint(&output)
        );
    }

    // Through a link is fine.
    let output = stage.raylet(&["simulate", "scene.toml", "--out", "link/out"]);
    assert!(output.status.success(), "{}", complaint(&output));
    ResultFolder::read(&stage.join("real/out")).unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn deaf_listeners_are_no_panic() {
    let stage = Stage::new(SCENE);
    let full = || Stdio::from(OpenOptions::new().write(true).open("/dev/full").unwrap());
    let run = |arguments: &[&str], out: Stdio, err: Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_raylet"));
        let command = command.current_dir(stage.path()).args(arguments);
        command.stdout(out).stderr(err).output().unwrap()
    };

    // A full disk behind standard output is an error; one behind standard error cannot be reported.
    let output = run(&["schema"], full(), Stdio::piped());
    assert_eq!(output.status.code(), Some(2));
    assert!(complaint(&output).starts_with("error: cannot write to standard output"));
    assert!(
        run(&["simulate", "scene.toml"], Stdio::piped(), full())
            .status
            .success()
    );
    assert_eq!(
        run(&["simulate", "none.toml"], full(), full())
            .status
            .code(),
        Some(2)
    );

    // A reader that has gone away is no failure.
    let mut child = Command::new(env!("CARGO_BIN_EXE_raylet"))
        .arg("schema")
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}
