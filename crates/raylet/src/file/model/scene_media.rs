//! The materials that a scene names, as media with an index at each wavelength.

use crate::file::decode::fault::Fault;
use crate::file::scene::material::{IN_CATALOGUE, Material};
use crate::file::scene::scene_file::Scene;
use crate::optics::media::catalog;
use crate::optics::media::medium::{Medium, MediumError};

/// The index of a material of the scene at its `channel`-th wavelength; faults are reported at `path`.
///
/// # Errors
/// An unknown glass, or a wavelength outside its range.
pub(crate) fn index_at(
    scene: &Scene,
    material: &Material,
    channel: usize,
    path: &str,
) -> Result<f64, Fault> {
    let medium = medium(scene, material, path)?;
    index(scene, &medium, scene.wavelength_mm(channel)?, path)
}

/// The medium of a material.
///
/// # Errors
/// An unknown name.
pub(crate) fn medium(scene: &Scene, material: &Material, path: &str) -> Result<Medium, Fault> {
    match material {
        Material::Own(own) => {
            (own.medium()).map_err(|(found, expected)| scene.fault(path, found, expected))
        }
        Material::Named(name) => catalog::medium(name)
            .map_err(|error| scene.fault(path, error.to_string(), IN_CATALOGUE)),
    }
}

/// The index of a medium at a wavelength in mm.
///
/// # Errors
/// A wavelength at which it is not known.
pub(crate) fn index(
    scene: &Scene,
    medium: &Medium,
    wavelength: f64,
    path: &str,
) -> Result<f64, Fault> {
    medium.index(wavelength).map_err(|error| match error {
        MediumError::OutOfRange {
            name,
            wavelength_um,
            from_um,
            to_um,
        } => {
            let found = format!("{name} at a wavelength of {wavelength_um} µm");
            let expected = format!("one from {from_um} to {to_um} µm, where it is known");
            scene.fault(path, found, expected)
        }
        other => {
            let expected = "a medium that is known at the scene's wavelengths";
            scene.fault(path, other.to_string(), expected)
        }
    })
}
