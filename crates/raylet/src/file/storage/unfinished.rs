//! What this process keeps on the disk only while it works: drafts, locks, and folders made for them.
//!
//! A program that is about to end can remove all of it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::file::storage::seal::Sealed;

/// Name of the new file or folder inside the hidden folder of a draft.
pub(crate) const NEW: &str = "new";

/// Name of the replaced file or folder inside the hidden folder, until the new one is in place.
pub(crate) const OLD: &str = "old";

/// Name of the note in a draft with the place to which the replaced file or folder belongs.
pub(crate) const PLACE: &str = "place";

/// Name of the lock that says whose draft it is.
pub(crate) const OWNER: &str = "owner";

/// A file or folder that is removed when the work is done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Trace {
    /// The hidden folder of a draft.
    Draft(PathBuf),
    /// A lock.
    Lock(PathBuf),
    /// A folder that was made, which is removed if it is empty.
    Folder(PathBuf),
}

/// All unfinished files and folders of this process. Code that changes the disk holds the list while it does so.
static UNFINISHED: Mutex<Vec<Trace>> = Mutex::new(Vec::new());

/// While this is held, nothing is written.
#[derive(Debug)]
pub struct Standstill {
    _list: MutexGuard<'static, Vec<Trace>>,
}

/// The list, to be held while the disk is changed.
pub(crate) fn unfinished() -> MutexGuard<'static, Vec<Trace>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes everything unfinished and lets nothing more be written: for a program that is about to end.
pub fn abandon() -> Standstill {
    let mut list = unfinished();
    for trace in list.drain(..).rev() {
        trace.remove();
    }
    Standstill { _list: list }
}

impl Trace {
    /// Removes it. Whatever cannot be removed stays for the next start.
    pub(crate) fn remove(&self) {
        match self {
            Trace::Draft(folder) => {
                clear(folder);
                let _ = fs::remove_file(folder.join(OWNER));
                let _ = fs::remove_dir(folder);
            }
            Trace::Lock(file) => {
                let _ = fs::remove_file(file);
            }
            Trace::Folder(folder) => {
                let _ = fs::remove_dir(folder);
            }
        }
    }
}

/// Removes the content of a draft but for its owner's name: whole results file by file as their document lists them,
/// and what was not finished. Anything else stays.
pub(crate) fn clear(folder: &Path) {
    for name in [NEW, OLD] {
        let thing = folder.join(name);
        let Ok(kind) = fs::symlink_metadata(&thing) else {
            continue;
        };
        let sealed = Sealed::find(&thing);
        if let Some(sealed) = sealed {
            let _ = sealed.remove(&thing);
        } else if kind.is_file() {
            let _ = fs::remove_file(&thing);
        } else if name == NEW {
            remove_files(&thing);
        }
        let _ = fs::remove_dir(&thing);
    }
    let _ = fs::remove_file(folder.join(PLACE));
}

/// Removes the files right inside a folder.
fn remove_files(folder: &Path) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file())) {
        let _ = fs::remove_file(entry.path());
    }
}
