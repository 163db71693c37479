//! The .npy files that a scene names for the results of a search: phases, amplitudes, heights.

use std::path::Path;

use ndarray::Array2;
use ndarray_npy::{WriteNpyError, WriteNpyExt};

use crate::file::decode::fault::Fault;
use crate::file::scene::scene_file::Scene;
use crate::file::storage::hidden::unwritable;
use crate::file::storage::own_file::{OwnFile, Replace, is_within};

/// The name of a .npy file that may be written: checked and held, not yet made.
#[derive(Debug)]
pub struct PhaseFile {
    file: OwnFile,
}

/// The permission of the user for writing files that a scene names.
#[derive(Clone, Copy, Debug)]
pub struct Allowed<'a> {
    /// Which existing files may be replaced.
    pub replace: Replace,
    /// Whether they may be in any folder.
    pub outside: bool,
    /// A folder where they may be, besides the scene's own.
    pub out: Option<&'a Path>,
}

impl PhaseFile {
    /// Checks that an array may be written here; an earlier one of raylet's may stand here.
    ///
    /// # Errors
    /// Another kind of name, a folder or a file that may not be replaced, another run that writes here, or a folder
    /// around that cannot be written.
    pub fn claim(path: &Path, replace: Replace) -> Result<Self, Fault> {
        if path.extension().is_none_or(|extension| extension != "npy") {
            let found = match path.extension() {
                Some(extension) => format!("the extension `{}`", extension.display()),
                None => String::from("no extension"),
            };
            return Err(Fault::of_file(path, found, "a file name ending in .npy"));
        }
        let file = OwnFile::claim(path, replace)?;
        Ok(Self { file })
    }

    /// [`PhaseFile::claim`] for a file that a scene names in `field`. It has to be in the scene's folder or in another
    /// one that the user names.
    ///
    /// # Errors
    /// As [`PhaseFile::claim`]; a file outside of these folders.
    pub fn of_scene(
        scene: &Scene,
        field: &str,
        path: &Path,
        allowed: Allowed,
    ) -> Result<Self, Fault> {
        let own = scene.origin.beside(Path::new(""));
        let own = if own.as_os_str().is_empty() {
            Path::new(".")
        } else {
            &own
        };
        let folders = [Some(own), allowed.out].into_iter().flatten();
        let is_inside = folders.into_iter().any(|folder| is_within(path, folder));
        if !is_inside && !allowed.outside {
            let found = format!("{}, outside of the scene's folder", path.display());
            let expected = "a file in the scene's folder or in --out";
            let fault = scene.fault(field, found, expected);
            return Err(fault.hint("--allow-outside lets it be written there"));
        }
        Self::claim(path, allowed.replace)
    }

    /// Path of the file, which may not exist yet.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Writes float64 [y, x].
    ///
    /// # Errors
    /// A value that is not finite, or an error of the file system.
    pub fn write(&self, phase: &Array2<f64>) -> Result<(), Fault> {
        if let Some((at, value)) = phase.indexed_iter().find(|(_, value)| !value.is_finite()) {
            let found = format!("{value} at {at:?} of the array to be written");
            return Err(Fault::of_file(self.path(), found, "finite values only"));
        }
        let bytes =
            npy(phase).map_err(|error| unwritable(self.path(), &std::io::Error::other(error)))?;
        self.file.write(&bytes)
    }
}

/// The bytes of a .npy file of float64 [y, x], of phases in radians.
///
/// # Errors
/// When the array cannot be encoded.
pub fn npy(phase: &Array2<f64>) -> Result<Vec<u8>, WriteNpyError> {
    let mut bytes = Vec::new();
    phase.write_npy(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use ndarray::array;

    use crate::file::arrays::phase_file::PhaseFile;
    use crate::file::storage::own_file::Replace;

    #[test]
    fn places_are_checked_before_and_made_after() {
        let room = tempfile::tempdir().unwrap();
        fs::create_dir(room.path().join("folder.npy")).unwrap();
        for (name, words) in [
            ("phase.npz", "extension `npz`"),
            ("phase", "no extension"),
            ("folder.npy", "a folder"),
        ] {
            let fault = PhaseFile::claim(&room.path().join(name), Replace::Own).unwrap_err();
            assert!(fault.to_string().contains(words), "{fault}");
        }
        let place = room.path().join("new/folder/phase.npy");
        let claimed = PhaseFile::claim(&place, Replace::Own).unwrap();
        assert!(!room.path().join("new").exists());
        claimed.write(&array![[1.0]]).unwrap();
        assert!(place.is_file());
        drop(claimed);
        assert_eq!(fs::read_dir(room.path()).unwrap().count(), 2);
    }
}
