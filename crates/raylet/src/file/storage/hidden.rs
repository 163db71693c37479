//! Files and folders that are written under a hidden name, and take their own name when they are complete.
//!
//! A hidden folder stands beside the final place, or beside the first folder of its path that does not exist yet, so
//! that the last step is a rename. It holds a lock, by which a later run sees whether it was left by a killed one.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::file::decode::fault::Fault;
use crate::file::storage::lock::{Lock, LockError};
use crate::file::storage::parent_folders::{below, exchange, make, named, standing, sync, unmake};
use crate::file::storage::unfinished::{NEW, OLD, OWNER, PLACE, Trace, clear, unfinished};

/// The start of every hidden name.
pub(crate) const PREFIX: &str = ".raylet-";

/// A run that looks for what others left may remove a draft before its owner is known.
const TRIES: u32 = 10;

/// A hidden folder with room for one new thing, removed when dropped.
#[derive(Debug)]
pub struct Hidden {
    folder: PathBuf,
    owner: Option<Lock>,
}

/// Decides whether the file or folder at a path may be replaced: the error is the reason against it.
pub(crate) type ReplaceCheck<'a> = &'a dyn Fn(&Path) -> Result<(), Fault>;

/// Writes the content of a new file.
pub(crate) type Fill<'a> = &'a dyn Fn(&mut File) -> io::Result<()>;

/// Exchanges two paths in one atomic step; `false` where the file system cannot.
pub(crate) type Exchange<'a> = &'a dyn Fn(&Path, &Path) -> io::Result<bool>;

impl Hidden {
    /// A hidden folder for what will be at `path`.
    ///
    /// # Errors
    /// The folder around it cannot be written, or what is in the way of it is no folder.
    pub fn beside(path: &Path) -> Result<Self, Fault> {
        let around = standing(path);
        let refuse = |error: io::Error| {
            // The name of the hidden folder, at the end, says nothing to the user.
            let message = error.to_string();
            let found = message.split(" at path ").next().unwrap_or_default();
            Fault::of_file(&around, found, "a folder that can be written")
        };
        let mut swept = io::Error::from(io::ErrorKind::NotFound);
        for _ in 0..TRIES {
            let mut list = unfinished();
            let folder = tempfile::Builder::new()
                .prefix(PREFIX)
                .tempdir_in(&around)
                .map_err(refuse)?
                .keep();
            list.push(Trace::Draft(folder.clone()));
            drop(list);
            let mut hidden = Self {
                folder,
                owner: None,
            };
            match Lock::take(&hidden.folder.join(OWNER)) {
                Ok(owner) => {
                    hidden.owner = Some(owner);
                    return Ok(hidden);
                }
                Err(LockError::Io(error)) if error.kind() == io::ErrorKind::NotFound => {
                    swept = error;
                }
                Err(error) => return Err(refuse(io::Error::other(error))),
            }
        }
        Err(refuse(swept))
    }

    /// Where the new thing, a file or a folder, is for now.
    fn path(&self) -> PathBuf {
        self.folder.join(NEW)
    }

    /// Makes the new thing a folder.
    ///
    /// # Errors
    /// An error of the file system.
    pub fn make_folder(&self) -> io::Result<()> {
        let _list = unfinished();
        fs::create_dir(self.path())
    }

    /// Writes the new thing, or the file of this name in it, and waits until it is on the disk.
    ///
    /// # Errors
    /// An error of the file system.
    pub fn write(&self, name: Option<&str>, content: &[u8]) -> io::Result<()> {
        self.fill(name, &|file| file.write_all(content)).map(drop)
    }

    /// The same with what `fill` writes, of which no copy is held; returns where the file is for now.
    ///
    /// # Errors
    /// An error of `fill` or of the file system.
    pub(crate) fn fill(&self, name: Option<&str>, fill: Fill) -> io::Result<PathBuf> {
        let _list = unfinished();
        let path = match name {
            Some(name) => self.path().join(name),
            None => self.path(),
        };
        write_through(&path, fill)?;
        Ok(path)
    }

    /// Writes the new thing, a file, with what takes long: a program that is interrupted does not wait for it.
    ///
    /// # Errors
    /// An error of `fill` or of the file system.
    pub(crate) fn fill_long(
        &self,
        fill: impl FnOnce(&mut File) -> io::Result<()>,
    ) -> io::Result<PathBuf> {
        let path = self.path();
        let list = unfinished();
        let mut file = File::create(&path)?;
        drop(list);
        fill(&mut file)?;
        file.sync_all()?;
        Ok(path)
    }

    /// Gives the new thing its name, in folders that are made where they are missing, if `check` allows what stands
    /// there then to be replaced. An earlier folder of that name is removed, file by file as its document lists them.
    ///
    /// # Errors
    /// An error of `check` or of the file system; then nothing is changed.
    pub fn reveal(self, path: &Path, check: ReplaceCheck) -> Result<(), Fault> {
        self.reveal_by(&exchange, path, check)
    }

    /// [`Hidden::reveal`] with a given function that exchanges two folders.
    pub(crate) fn reveal_by(
        self,
        swap: Exchange,
        path: &Path,
        check: ReplaceCheck,
    ) -> Result<(), Fault> {
        let list = unfinished();
        let mut made = Vec::new();
        let outcome = make(path, &mut made)
            .map_err(|error| unwritable(path, &error))
            .and_then(|()| check(path))
            .and_then(|()| self.take_place(swap, path, check));
        if outcome.is_err() {
            unmake(&made);
        }
        drop(list);
        outcome
    }

    fn take_place(&self, swap: Exchange, path: &Path, check: ReplaceCheck) -> Result<(), Fault> {
        let refuse = |error: io::Error| unwritable(path, &error);
        let new = self.path();
        let is_folder = |path: &Path| fs::symlink_metadata(path).is_ok_and(|kind| kind.is_dir());
        if is_folder(&new) {
            sync(&new).map_err(refuse)?;
        }
        if !is_folder(path) {
            // A file gives way to a file at one stroke.
            fs::rename(&new, path).map_err(refuse)?;
        } else if swap(&new, path).map_err(refuse)? {
            // The earlier folder is in the draft now, and is checked again: another process may have changed it.
            if let Err(fault) = check(&new) {
                swap(&new, path).map_err(refuse)?;
                return Err(fault);
            }
            fs::rename(&new, self.folder.join(OLD)).map_err(refuse)?;
        } else {
            self.set_aside(path, check)?;
        }
        sync(named(path.parent().unwrap_or(path))).map_err(refuse)
    }

    /// Two steps where there is no single one: the earlier folder steps aside, and comes back if the new one cannot
    /// take its place. Between the two there is neither; a note of where it stood lets the next run put it back.
    fn set_aside(&self, path: &Path, check: ReplaceCheck) -> Result<(), Fault> {
        let refuse = |error: io::Error| unwritable(path, &error);
        let around = self.folder.parent().map(named).unwrap_or(&self.folder);
        let place = below(around, path).as_os_str().as_encoded_bytes();
        write_through(&self.folder.join(PLACE), &|file| file.write_all(place)).map_err(refuse)?;
        sync(&self.folder).map_err(refuse)?;
        let old = self.folder.join(OLD);
        fs::rename(path, &old).map_err(refuse)?;
        let outcome = check(&old).and_then(|()| fs::rename(self.path(), path).map_err(refuse));
        if outcome.is_err() {
            fs::rename(&old, path).map_err(refuse)?;
        }
        outcome
    }
}

impl Drop for Hidden {
    fn drop(&mut self) {
        let list = unfinished();
        clear(&self.folder);
        drop(list);
        drop(self.owner.take());
        let mut list = unfinished();
        let own = Trace::Draft(self.folder.clone());
        if let Some(at) = list.iter().position(|trace| *trace == own) {
            list.remove(at);
            let _ = fs::remove_dir(&self.folder);
        }
    }
}

/// The fault of a place that cannot be written.
pub(crate) fn unwritable(path: &Path, error: &io::Error) -> Fault {
    Fault::of_file(path, error.to_string(), "a place that can be written")
}

/// Fills a file, and waits until it is on the disk.
fn write_through(path: &Path, fill: Fill) -> io::Result<()> {
    let mut file = File::create(path)?;
    fill(&mut file)?;
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use crate::file::decode::fault::Fault;
    use crate::file::storage::hidden::Hidden;

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
        let refuse = |_: &Path| Err(Fault::of_file(&place, "a stranger", "nobody"));
        assert!(hidden.reveal(&place, &refuse).is_err());
        assert_eq!(count(room.path()), 0);
        let hidden = Hidden::beside(&place).unwrap();
        hidden.write(None, b"whole").unwrap();
        hidden.reveal(&place, &|_| Ok(())).unwrap();
        assert_eq!(fs::read_to_string(&place).unwrap(), "whole");
        assert_eq!(count(room.path()), 1);
    }

    #[test]
    fn a_file_in_the_way_is_reported() {
        let room = tempfile::tempdir().unwrap();
        fs::write(room.path().join("file"), "").unwrap();
        for place in ["file/out", "file/a/out"] {
            let fault = Hidden::beside(&room.path().join(place)).unwrap_err();
            let message = fault.to_string();
            assert!(
                message.contains("file: found ") && !message.contains(".raylet"),
                "{message}"
            );
        }
    }

    /// A folder that is refused, at the first look or when it has changed places, is as it was.
    #[test]
    fn refused_folders_come_back() {
        for can_swap in [true, false] {
            for refused_at in [1, 2] {
                let room = tempfile::tempdir().unwrap();
                let out = room.path().join("out");
                fs::create_dir(&out).unwrap();
                fs::write(out.join("late.txt"), "mine").unwrap();
                let hidden = Hidden::beside(&out).unwrap();
                hidden.make_folder().unwrap();
                hidden.write(Some("field.npz"), b"new").unwrap();
                let looks = std::cell::Cell::new(0);
                let check = |path: &Path| {
                    looks.set(looks.get() + 1);
                    match looks.get() < refused_at {
                        true => Ok(()),
                        false => Err(Fault::of_file(path, "a stranger", "nobody")),
                    }
                };
                let swap = |one: &Path, other: &Path| match can_swap {
                    true => crate::file::storage::parent_folders::exchange(one, other),
                    false => Ok(false),
                };
                assert!(hidden.reveal_by(&swap, &out, &check).is_err());
                assert_eq!(fs::read_to_string(out.join("late.txt")).unwrap(), "mine");
                assert_eq!((count(&out), count(room.path())), (1, 1));
            }
        }
    }
}
