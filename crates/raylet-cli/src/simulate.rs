//! `raylet simulate SCENE`: the field on the sensor, with pictures and numbers.

use std::path::PathBuf;

use clap::Args;
use raylet::engine::simulate::simulate;
use raylet::file::build;
use raylet::file::scene::Scene;

use crate::failure::Failure;

/// Carries the light of a scene to its sensor.
#[derive(Args)]
pub(crate) struct Simulate {
    /// The scene file.
    scene: PathBuf,
}

impl Simulate {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let scene = Scene::read(&self.scene)?;
        let settings = build::settings(&scene);
        for channel in 0..scene.wavelength_um.len() {
            let system = build::system(&scene, channel)?;
            simulate(&system, &settings, &|_| {})?;
        }
        Ok(())
    }
}
