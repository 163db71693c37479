//! Checkpoints of a run: a file that is whole or not there, and the one before it.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::file::fault::Fault;
use crate::file::hidden::unwritable;

/// The two files of a run's checkpoints.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checkpoints {
    newest: PathBuf,
    before: PathBuf,
    /// What the run's numbers depend on: another run's checkpoint is none of this one.
    description: String,
}

/// What was read.
#[derive(Debug)]
pub struct Restored<T> {
    /// The state.
    pub state: T,
    /// Whether the newest file was torn and the one before it was taken.
    pub older: bool,
}

impl Checkpoints {
    /// Those in a folder, of the run that is so described.
    pub fn within(folder: &Path, description: &str) -> Self {
        Self {
            newest: folder.join("checkpoint.json"),
            before: folder.join("checkpoint.before.json"),
            description: description.to_owned(),
        }
    }

    /// Writes a checkpoint; the last one is kept beside it.
    ///
    /// # Errors
    /// What the file system said.
    pub fn write<T: Serialize>(&self, state: &T) -> Result<(), Fault> {
        let refuse = |error: std::io::Error| unwritable(&self.newest, &error);
        let body = serde_json::to_string(&(&self.description, state));
        let body = body.map_err(|error| refuse(std::io::Error::other(error)))?;
        let text = format!("{:08x}\n{body}", crc32fast::hash(body.as_bytes()));
        let write = || {
            if let Some(folder) = self.newest.parent() {
                fs::create_dir_all(folder)?;
            }
            let fresh = self.newest.with_extension("fresh");
            fs::write(&fresh, text)?;
            if self.newest.exists() {
                fs::rename(&self.newest, &self.before)?;
            }
            fs::rename(&fresh, &self.newest)
        };
        write().map_err(refuse)
    }

    /// The last checkpoint that is whole.
    ///
    /// # Errors
    /// No checkpoint, none that is whole, or one of another run.
    pub fn read<T: DeserializeOwned>(&self) -> Result<Restored<T>, Fault> {
        let expected = "the checkpoint of an earlier run";
        let mut torn = false;
        for path in [&self.newest, &self.before] {
            let Ok(text) = fs::read_to_string(path) else {
                continue;
            };
            let whole = text
                .split_once('\n')
                .filter(|(sum, body)| *sum == format!("{:08x}", crc32fast::hash(body.as_bytes())));
            let Some((_, body)) = whole else {
                torn = true;
                continue;
            };
            let (description, state): (String, T) = serde_json::from_str(body)
                .map_err(|error| Fault::of_file(path, error.to_string(), expected))?;
            if description != self.description {
                let found = "a checkpoint of another scene or of other settings";
                return Err(Fault::of_file(path, found, "that of this one"));
            }
            return Ok(Restored { state, older: torn });
        }
        let found = if torn { "a torn file" } else { "no such file" };
        Err(Fault::of_file(&self.newest, found, expected))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use crate::file::checkpoint::Checkpoints;

    #[test]
    fn torn_files_give_way_to_the_one_before() {
        let room = tempfile::tempdir().unwrap();
        let files = Checkpoints::within(&room.path().join("run"), "this scene");
        let none = files.read::<Vec<u32>>().unwrap_err().to_string();
        assert!(none.contains("no such file"), "{none}");
        files.write(&vec![1, 2]).unwrap();
        files.write(&vec![3, 4]).unwrap();
        let read = files.read::<Vec<u32>>().unwrap();
        assert_eq!((read.state, read.older), (vec![3, 4], false));

        // Torn anywhere, the newest is not taken for whole.
        let newest = room.path().join("run/checkpoint.json");
        let text = fs::read(&newest).unwrap();
        for length in 0..text.len() {
            fs::write(&newest, &text[..length]).unwrap();
            let read = files.read::<Vec<u32>>().unwrap();
            assert_eq!((read.state, read.older), (vec![1, 2], true), "{length}");
        }
        fs::remove_file(room.path().join("run/checkpoint.before.json")).unwrap();
        let torn = files.read::<Vec<u32>>().unwrap_err().to_string();
        assert!(torn.contains("a torn file"), "{torn}");
    }

    #[test]
    fn other_runs_are_refused() {
        let room = tempfile::tempdir().unwrap();
        let files = |description| Checkpoints::within(room.path(), description);
        files("one").write(&7).unwrap();
        let told = files("another").read::<u32>().unwrap_err().to_string();
        assert!(told.contains("another scene"), "{told}");
    }
}
