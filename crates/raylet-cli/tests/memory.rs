//! Memory limits hold for whole runs: the pictures and files at the end do not pass them by.
#![cfg(unix)]

use std::fs::File;
use std::process::{Command, Output};

use crate::stage::{SCENE, Stage};

/// A stop before a sensor of 4 million pixels, whose field takes 64 MB.
const LARGE: &str = r#"version = 1
wavelength_um = 0.5
settings.memory_limit_mb = 130
[source]
kind = "plane"
[[element]]
kind = "stop"
thickness_mm = 1
aperture = { disc = { radius_mm = 0.02 } }
[[element]]
kind = "sensor"
pixels = [2000, 2000]
pitch_um = 0.05
"#;

/// Runs the program with an address space of this many kilobytes. One thread and one arena of the allocator reserve
/// little beyond what they use.
fn within(stage: &Stage, kilobytes: u32, arguments: &str) -> Output {
    Command::new("sh")
        .current_dir(stage.path())
        .args([
            "-c",
            &format!("ulimit -v {kilobytes}; exec \"$RAYLET\" {arguments}"),
        ])
        .env("RAYLET", env!("CARGO_BIN_EXE_raylet"))
        .env("RAYON_NUM_THREADS", "1")
        .env("MALLOC_ARENA_MAX", "1")
        .output()
        .unwrap()
}

/// The input is refused, with a message that holds these words.
fn assert_refused(run: &Output, words: &str) {
    let message = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(2), "{message}");
    assert!(message.contains(words), "{message}");
}

/// The run once took four times its field, and the comparison three times both fields.
#[test]
fn results_and_comparisons_keep_to_the_memory_limit() {
    let stage = Stage::new(LARGE);
    let run = within(&stage, 230_000, "simulate scene.toml --out out");
    assert!(run.status.success(), "{run:?}");
    let compare = "compare out out --memory-limit-mb 257 --out comparison";
    let run = within(&stage, 360_000, compare);
    assert!(run.status.success(), "{run:?}");
}

/// Less memory than the field and its pictures take is refused before the run.
#[test]
fn fields_that_do_not_fit_are_refused() {
    let stage = Stage::new(&LARGE.replace("= 130", "= 127"));
    let run = within(&stage, 230_000, "simulate scene.toml --out out");
    assert_refused(&run, "takes 128.000 MB with its pictures");
}

/// A picture with a colour profile of 200 MB of zeros, packed into 200 kB, and an archive with 400,000 members.
#[test]
fn what_files_hold_beside_their_values_takes_no_memory() {
    let hologram =
        "[hologram]\ntarget = \"picture.png\"\nsize_mm = [0.05, 0.05]\nelement = \"pixels\"\n";
    let few = SCENE.replace("phase.npy\"", "found.npy\"\nsize = [10, 10]");
    let stage = Stage::new(&format!("{few}{hologram}"));
    let mut info = png::Info::with_size(8, 8);
    info.icc_profile = Some(vec![0; 200_000_000].into());
    let picture = File::create(stage.join("picture.png")).unwrap();
    let encoder = png::Encoder::with_info(picture, info).unwrap();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[7; 64]).unwrap();
    writer.finish().unwrap();
    let run = within(&stage, 150_000, "hologram scene.toml");
    assert!(run.status.success(), "{run:?}");

    // As the phase of an element.
    let stage = Stage::new(&SCENE.replace("phase.npy", "many.npz"));
    let mut archive = zip::ZipWriter::new(File::create(stage.join("many.npz")).unwrap());
    for number in 0..400_000 {
        let options = zip::write::SimpleFileOptions::default();
        archive
            .start_file(format!("{number}.npy"), options)
            .unwrap();
    }
    archive.finish().unwrap();
    let run = within(&stage, 150_000, "check scene.toml");
    assert_refused(&run, "a list of members longer than");
}

/// Pixels so large that all light falls between their centres: the result says that it is dark.
#[test]
fn a_dark_sensor_is_a_warning() {
    let dark = LARGE
        .replace("[2000, 2000]", "[4, 4]")
        .replace("0.05", "1e5");
    let stage = Stage::new(&dark);
    let run = within(&stage, 230_000, "simulate scene.toml --out out");
    assert!(run.status.success(), "{run:?}");
    let said = String::from_utf8_lossy(&run.stdout);
    let warned = "warning: λ = 0.5 µm: no light comes to the centre";
    assert!(said.lines().any(|line| line.starts_with(warned)), "{said}");
}
