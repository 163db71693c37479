//! The .npy file of a hologram's phase, which appears whole or not at all.

use std::path::{Path, PathBuf};

use ndarray::Array2;
use ndarray_npy::{WriteNpyError, WriteNpyExt};

use crate::file::fault::Fault;
use crate::file::hidden::{Hidden, unwritable};

/// The name of a .npy file that may be written: checked, not yet made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PhaseFile {
    path: PathBuf,
}

impl PhaseFile {
    /// Checks that an array may be written here; an earlier file may stand here. Nothing is left on the
    /// disk.
    ///
    /// # Errors
    /// Another kind of file, a folder of that name, or a folder around that cannot be written.
    pub fn claim(path: &Path) -> Result<Self, Fault> {
        if path.extension().is_none_or(|extension| extension != "npy") {
            let found = match path.extension() {
                Some(extension) => format!("the extension `{}`", extension.display()),
                None => String::from("no extension"),
            };
            return Err(Fault::of_file(path, found, "a file name ending in .npy"));
        }
        refuse_folder(path)?;
        Hidden::beside(path)?;
        Ok(Self {
            path: path.to_path_buf(),
        })
    }

    /// Where the file will be.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes float64 [y, x].
    ///
    /// # Errors
    /// What the file system said.
    pub fn write(&self, phase: &Array2<f64>) -> Result<(), Fault> {
        let bytes =
            npy(phase).map_err(|error| unwritable(&self.path, &std::io::Error::other(error)))?;
        let hidden = Hidden::beside(&self.path)?;
        hidden
            .write(None, &bytes)
            .map_err(|error| unwritable(&self.path, &error))?;
        hidden.reveal(&self.path, || refuse_folder(&self.path))
    }
}

/// The bytes of a .npy file of float64 [y, x].
///
/// # Errors
/// What the packing said.
pub fn npy(phase: &Array2<f64>) -> Result<Vec<u8>, WriteNpyError> {
    let mut bytes = Vec::new();
    phase.write_npy(&mut bytes)?;
    Ok(bytes)
}

fn refuse_folder(path: &Path) -> Result<(), Fault> {
    match path.is_dir() {
        true => Err(Fault::of_file(path, "a folder", "the name of a file")),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use ndarray::array;

    use crate::file::phase_file::PhaseFile;

    #[test]
    fn places_are_checked_before_and_made_after() {
        let room = tempfile::tempdir().unwrap();
        fs::create_dir(room.path().join("folder.npy")).unwrap();
        for (name, told) in [
            ("phase.npz", "extension `npz`"),
            ("phase", "no extension"),
            ("folder.npy", "a folder"),
        ] {
            let fault = PhaseFile::claim(&room.path().join(name)).unwrap_err();
            assert!(fault.to_string().contains(told), "{fault}");
        }
        let place = room.path().join("new/folder/phase.npy");
        let claimed = PhaseFile::claim(&place).unwrap();
        assert_eq!(fs::read_dir(room.path()).unwrap().count(), 1);
        claimed.write(&array![[1.0]]).unwrap();
        assert!(place.is_file());
    }
}
