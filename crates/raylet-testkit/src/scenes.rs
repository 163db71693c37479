//! Scene files of the repository.

use std::path::{Path, PathBuf};

use raylet::engine::plan::settings::Settings;
use raylet::file::decode::fault::Fault;
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::optics::system::System;

/// The folder `scenes` of the repository.
pub fn scene_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

/// The file of a scene by its name in that folder, such as `paper/system1`.
pub fn scene_path(name: &str) -> PathBuf {
    scene_folder().join(format!("{name}.toml"))
}

/// The system at the first wavelength of such a scene, and how it is run.
///
/// # Errors
/// When the file or an array beside it cannot be read.
pub fn scene_system(name: &str) -> Result<(System, Settings), Fault> {
    let scene = Scene::read(&scene_path(name))?;
    Ok((build::system(&scene, 0)?, build::settings(&scene)))
}
