//! The folder in which one run at a time keeps what it has, such as the checkpoints of a design.

use std::path::{Path, PathBuf};

use crate::file::decode::fault::Fault;
use crate::file::storage::hidden::{PREFIX, unwritable};
use crate::file::storage::lock::{Lock, LockError};
use crate::file::storage::parent_folders::{make, unmake};
use crate::file::storage::sweep::{LOCK, sweep};
use crate::file::storage::unfinished::{Trace, unfinished};

/// A folder that this run holds. Dropped, it goes again if it was made for the run and nothing is in it.
#[derive(Debug)]
pub struct RunFolder {
    lock: Option<Lock>,
    made: Vec<PathBuf>,
}

impl RunFolder {
    /// Makes the folder where it is missing, and takes its lock.
    ///
    /// # Errors
    /// Another run that holds it, or a folder that cannot be made or written.
    pub fn open(path: &Path) -> Result<Self, Fault> {
        let mut folder = Self {
            lock: None,
            made: Vec::new(),
        };
        let lock = path.join(format!("{PREFIX}run{LOCK}"));
        let mut list = unfinished();
        let outcome = make(&lock, &mut folder.made);
        list.extend(folder.made.iter().cloned().map(Trace::Folder));
        drop(list);
        outcome.map_err(|error| unwritable(path, &error))?;
        sweep(path);
        let lock = Lock::take(&lock).map_err(|error| match error {
            LockError::Held(holder) => {
                let expected = "a folder that no other run writes";
                Fault::of_file(path, holder.to_string(), expected)
            }
            LockError::Io(error) => unwritable(path, &error),
        })?;
        folder.lock = Some(lock);
        Ok(folder)
    }
}

impl Drop for RunFolder {
    fn drop(&mut self) {
        drop(self.lock.take());
        let mut list = unfinished();
        unmake(&self.made);
        let own = |trace: &Trace| matches!(trace, Trace::Folder(path) if self.made.contains(path));
        list.retain(|trace| !own(trace));
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use crate::file::storage::run_folder::RunFolder;

    #[test]
    fn one_run_at_a_time_and_no_folder_for_nothing() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("out/design");
        let folder = RunFolder::open(&path).unwrap();
        let message = RunFolder::open(&path).unwrap_err().to_string();
        let process = format!("process {}", std::process::id());
        assert!(
            message.contains(&process) && message.contains("no other run"),
            "{message}"
        );
        drop(folder);
        assert_eq!(fs::read_dir(room.path()).unwrap().count(), 0);

        let folder = RunFolder::open(&path).unwrap();
        fs::write(path.join("kept"), "").unwrap();
        drop(folder);
        assert_eq!(fs::read_dir(&path).unwrap().count(), 1);
        assert!(RunFolder::open(&path.join("kept")).is_err());
    }
}
