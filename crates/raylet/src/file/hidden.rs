//! What is written under a hidden name and takes its own when it is whole.
//!
//! A hidden folder stands beside the place that is meant, or beside the first of its folders that is not
//! there yet, so that the last step is a rename. A program that is told to end can sweep all of them away.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::file::fault::Fault;

/// The hidden folders that exist now. Whoever changes the disk holds the list while doing so.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A hidden folder with room for one new thing, removed when dropped.
#[derive(Debug)]
pub struct Hidden {
    folder: PathBuf,
}

/// While this is held, nothing is written.
#[derive(Debug)]
pub struct Standstill {
    _list: MutexGuard<'static, Vec<PathBuf>>,
}

/// Removes everything unfinished and lets nothing more be written: for a program that is about to end.
pub fn abandon() -> Standstill {
    let mut list = unfinished();
    for folder in list.drain(..) {
        // There is nobody left to tell of a failure.
        let _ = fs::remove_dir_all(folder);
    }
    Standstill { _list: list }
}

impl Hidden {
    /// A hidden folder for what will be at `path`.
    ///
    /// # Errors
    /// The folder around it cannot be written, or what is in the way of it is no folder.
    pub fn beside(path: &Path) -> Result<Self, Fault> {
        let around = standing(path);
        let mut list = unfinished();
        let folder = tempfile::Builder::new()
            .prefix(".raylet-")
            .tempdir_in(&around)
            .map_err(|error| {
                // The name of the hidden folder, at the end, says nothing to the user.
                let told = error.to_string();
                let found = told.split(" at path ").next().unwrap_or_default();
                Fault::of_file(&around, found, "a folder that can be written")
            })?
            .keep();
        list.push(folder.clone());
        Ok(Self { folder })
    }

    /// Where the new thing, a file or a folder, is for now.
    fn path(&self) -> PathBuf {
        self.folder.join("new")
    }

    /// Makes the new thing a folder.
    ///
    /// # Errors
    /// What the file system said.
    pub fn make_folder(&self) -> io::Result<()> {
        let _list = unfinished();
        fs::create_dir(self.path())
    }

    /// Writes the new thing, or the file of this name in it.
    ///
    /// # Errors
    /// What the file system said.
    pub fn write(&self, name: Option<&str>, content: &[u8]) -> io::Result<()> {
        let _list = unfinished();
        match name {
            Some(name) => fs::write(self.path().join(name), content),
            None => fs::write(self.path(), content),
        }
    }

    /// Gives the new thing its name, in folders that are made where they are missing, if `allowed` says so
    /// of what stands there then. An earlier folder of that name is removed.
    ///
    /// # Errors
    /// What `allowed` or the file system said; then nothing is changed.
    pub fn reveal(
        self,
        path: &Path,
        allowed: impl FnOnce() -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let list = unfinished();
        let mut made = Vec::new();
        let outcome = make_around(path, &mut made)
            .map_err(|error| unwritable(path, &error))
            .and_then(|()| allowed())
            .and_then(|()| {
                self.exchange(path)
                    .map_err(|error| unwritable(path, &error))
            });

        // Folders made for nothing go again, the innermost first; one that others use by now stays.
        if outcome.is_err() {
            for folder in made.iter().rev() {
                let _ = fs::remove_dir(folder);
            }
        }
        drop(list);
        outcome
    }

    /// An earlier folder steps aside, and comes back if the new one cannot take its place.
    fn exchange(&self, path: &Path) -> io::Result<()> {
        let old = self.folder.join("old");
        let occupied = path.is_dir();
        if occupied {
            fs::rename(path, &old)?;
        }
        if let Err(error) = fs::rename(self.path(), path) {
            if occupied {
                fs::rename(&old, path)?;
            }
            return Err(error);
        }
        Ok(())
    }
}

impl Drop for Hidden {
    fn drop(&mut self) {
        let mut list = unfinished();
        let _ = fs::remove_dir_all(&self.folder);
        list.retain(|folder| *folder != self.folder);
    }
}

/// The fault of a place that cannot be written.
pub fn unwritable(path: &Path, error: &io::Error) -> Fault {
    Fault::of_file(path, error.to_string(), "a place that can be written")
}

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The innermost folder around a path that is there already.
fn standing(path: &Path) -> PathBuf {
    let there = |folder: &&Path| fs::symlink_metadata(named(folder)).is_ok();
    let found = path.ancestors().skip(1).find(there);
    found.map_or(PathBuf::from("."), |folder| named(folder).to_path_buf())
}

/// The current folder has no name among the ancestors of a relative path.
fn named(folder: &Path) -> &Path {
    match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    }
}

/// Makes the missing folders around a path, and notes which.
fn make_around(path: &Path, made: &mut Vec<PathBuf>) -> io::Result<()> {
    let missing: Vec<&Path> = path
        .ancestors()
        .skip(1)
        .take_while(|folder| fs::symlink_metadata(named(folder)).is_err())
        .collect();
    for folder in missing.into_iter().rev() {
        match fs::create_dir(folder) {
            Ok(()) => made.push(folder.to_path_buf()),
            // Another program may be as fast.
            Err(_) if folder.is_dir() => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use crate::file::fault::Fault;
    use crate::file::hidden::Hidden;

    fn count(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn missing_folders_are_made_at_the_end_or_not_at_all() {
        let room = tempfile::tempdir().unwrap();
        let place = room.path().join("a/b/c.txt");
        let hidden = Hidden::beside(&place).unwrap();
        hidden.write(None, b"whole").unwrap();
        assert_eq!(count(room.path()), 1);
        assert!(!room.path().join("a").exists());

        // A refusal takes the folders away again.
        let refuse = || Err(Fault::of_file(&place, "a stranger", "nobody"));
        assert!(hidden.reveal(&place, refuse).is_err());
        assert_eq!(count(room.path()), 0);
        let hidden = Hidden::beside(&place).unwrap();
        hidden.write(None, b"whole").unwrap();
        hidden.reveal(&place, || Ok(())).unwrap();
        assert_eq!(fs::read_to_string(&place).unwrap(), "whole");
        assert_eq!(count(room.path()), 1);
    }

    #[test]
    fn a_file_in_the_way_is_told() {
        let room = tempfile::tempdir().unwrap();
        fs::write(room.path().join("file"), "").unwrap();
        for place in ["file/out", "file/a/out"] {
            let fault = Hidden::beside(&room.path().join(place)).unwrap_err();
            let told = fault.to_string();
            assert!(
                told.contains("file: found ") && !told.contains(".raylet"),
                "{told}"
            );
        }
    }
}
