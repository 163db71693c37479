//! Files that are no regular files, or larger than allowed, are refused at once: nothing hangs, nothing fills memory.

use std::io::Write;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::refusal::{none_of, wrong};
use crate::stage::{SCENE, Stage};

/// How long a refusal may take, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(30);

/// What is wrong with a refusal that may hang: it is tried once with an eye on the clock.
fn wrong_in_time(stage: &Stage, arguments: &[&str], says: &[&str]) -> Option<String> {
    let mut child = Command::new(env!("CARGO_BIN_EXE_raylet"))
        .current_dir(stage.path())
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let clock = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if clock.elapsed() > PATIENCE {
            child.kill().unwrap();
            child.wait().unwrap();
            return Some(format!("{arguments:?} hangs"));
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    wrong(stage, arguments, says)
}

/// The scene with another file for its phase.
fn with_phase(file: &str) -> Stage {
    Stage::new(&SCENE.replace("phase.npy", file))
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused() {
    let pipe = |stage: &Stage, name: &str| {
        let made = Command::new("mkfifo").arg(stage.join(name)).status();
        assert!(made.unwrap().success());
    };
    let stage = Stage::new(SCENE);
    pipe(&stage, "pipe.toml");
    pipe(&stage, "pipe.npz");
    none_of([
        wrong_in_time(
            &stage,
            &["check", "pipe.toml"],
            &["pipe.toml", "a named pipe"],
        ),
        wrong_in_time(&stage, &["check", "/dev/zero"], &["/dev/zero", "a device"]),
        wrong_in_time(
            &stage,
            &["simulate", "/dev/zero"],
            &["/dev/zero", "a device"],
        ),
        wrong_in_time(
            &stage,
            &["compare", "pipe.npz", "pipe.npz"],
            &["a named pipe"],
        ),
    ]);

    // The same as arrays: by their own names, and behind links that end as arrays do.
    let stage = with_phase("pipe.npy");
    pipe(&stage, "pipe.npy");
    let at = "scene.toml:16:";
    none_of([wrong_in_time(
        &stage,
        &["check", "scene.toml"],
        &[at, "a named pipe"],
    )]);
    let stage = with_phase("zero.npy");
    std::os::unix::fs::symlink("/dev/zero", stage.join("zero.npy")).unwrap();
    none_of([wrong_in_time(
        &stage,
        &["check", "scene.toml"],
        &[at, "a device"],
    )]);
}

#[test]
fn large_scenes_are_refused() {
    let stage = Stage::new(SCENE);
    let large = std::fs::File::create(stage.join("large.toml")).unwrap();
    large.set_len(1_000_001).unwrap();
    let says = ["large.toml", "1 MB"];
    none_of([wrong_in_time(&stage, &["check", "large.toml"], &says)]);
}

/// Regular files of the system that wait for more are not waited for.
#[cfg(target_os = "linux")]
#[test]
fn files_that_never_end_are_refused() {
    let stage = Stage::new(SCENE);
    none_of([wrong_in_time(
        &stage,
        &["check", "/proc/kmsg"],
        &["/proc/kmsg"],
    )]);
}

/// An archive of 389 kB that holds 400 MB of zeros, under a limit of 100 MB.
#[test]
fn archives_are_held_to_the_memory_limit_by_their_headers() {
    let scene = SCENE.replace("phase.npy", "bomb.npz");
    let limit = "[settings]\nmemory_limit_mb = 100\n[source]";
    let stage = Stage::new(&scene.replace("[source]", limit));
    let file = std::fs::File::create(stage.join("bomb.npz")).unwrap();
    let mut archive = zip::ZipWriter::new(file);
    let method = zip::CompressionMethod::Deflated;
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    archive.start_file("phase.npy", options).unwrap();
    let text = "{'descr': '|u1', 'fortran_order': False, 'shape': (20000, 20000), }\n";
    archive.write_all(b"\x93NUMPY\x01\x00").unwrap();
    archive
        .write_all(&(text.len() as u16).to_le_bytes())
        .unwrap();
    archive.write_all(text.as_bytes()).unwrap();
    for _ in 0..400 {
        archive.write_all(&[0; 1_000_000]).unwrap();
    }
    archive.finish().unwrap();
    assert!(std::fs::metadata(stage.join("bomb.npz")).unwrap().len() < 500_000);
    let says = [
        "scene.toml:",
        "20000 x 20000",
        "at most 100 MB",
        "memory_limit_mb",
    ];
    none_of([wrong_in_time(&stage, &["check", "scene.toml"], &says)]);
}
