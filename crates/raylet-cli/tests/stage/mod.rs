//! A folder with small scenes, and the program to run in it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A pixelated element, a lens and a sensor: one hop by beamlets, small enough for tests.
pub(crate) const SCENE: &str = r#"version = 1
title = "Small"
wavelength_um = 0.7

[source]
kind = "plane"

[[element]]
kind = "doe"
name = "pixels"
thickness_mm = 1
aperture = { disc = { radius_mm = 0.09 } }
[[element.layer]]
kind = "pixels"
pitch_um = 6
phase = "phase.npy"

[[element]]
kind = "lens"
name = "L"
thickness_mm = 8
[[element.surface]]
radius_mm = 5
thickness_mm = 1
glass = "N-BK7"
semi_aperture_mm = 1
[[element.surface]]
semi_aperture_mm = 1

[[element]]
kind = "sensor"
name = "camera"
pixels = [48, 40]
pitch_um = 5
"#;

/// A temporary folder with `scene.toml` and `phase.npy`.
pub(crate) struct Stage {
    room: tempfile::TempDir,
}

impl Stage {
    pub(crate) fn new(scene: &str) -> Self {
        let room = tempfile::tempdir().unwrap();
        let phase = ndarray::Array2::from_shape_fn((30, 30), |(y, x)| {
            ((x * x + 3 * y * y + 5 * x * y) % 7) as f64 * 0.9
        });
        ndarray_npy::write_npy(room.path().join("phase.npy"), &phase).unwrap();
        fs::write(room.path().join("scene.toml"), scene).unwrap();
        Self { room }
    }

    pub(crate) fn path(&self) -> &Path {
        self.room.path()
    }

    pub(crate) fn join(&self, name: &str) -> PathBuf {
        self.room.path().join(name)
    }

    /// Runs the program in the folder.
    pub(crate) fn raylet(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_raylet"))
            .current_dir(self.path())
            .args(arguments)
            .output()
            .unwrap()
    }

    /// Names of everything in the folder.
    pub(crate) fn names(&self) -> Vec<String> {
        names(self.path())
    }
}

/// Names of everything in a folder, in order.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// What a program said on standard error.
pub(crate) fn complaint(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}
