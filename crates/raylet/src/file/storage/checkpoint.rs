//! Checkpoints of a run: a file that is whole or not there, and the one before it.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;
use crate::file::storage::hidden::{Hidden, unwritable};
use crate::file::storage::own_file::Replace;
use crate::file::storage::parent_folders::{named, sync};
use crate::file::storage::seal::Checksum;

/// What a user may go on from.
const EXPECTED: &str = "the checkpoint of an earlier run";

/// Bytes of one byte of text that JSON escapes, and of what stands around description and state.
const ESCAPED: u64 = 6;
const FRAME: u64 = 64;

/// The two files of a run's checkpoints.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checkpoints {
    newest: PathBuf,
    before: PathBuf,
    /// What the run's numbers depend on: another run's checkpoint is none of this one.
    description: String,
    /// The most bytes that a checkpoint of the run has.
    longest: u64,
}

/// A state that was read from a checkpoint.
#[derive(Debug)]
pub struct Restored<T> {
    /// The state.
    pub state: T,
    /// The fault of the newest file, if the one before it was read instead.
    pub warning: Option<String>,
}

/// What stands where a checkpoint should be.
#[derive(Clone, Copy, PartialEq, Eq)]
enum FileState {
    Nothing,
    Torn,
    Whole,
}

impl Checkpoints {
    /// The checkpoints in `folder` of the run with this description, whose state takes at most `state_bytes` as text. A
    /// longer file is refused before it is read.
    pub fn within(folder: &Path, description: &str, state_bytes: u64) -> Self {
        let described = ESCAPED * description.len() as u64;
        Self {
            newest: folder.join("checkpoint.json"),
            before: folder.join("checkpoint.before.json"),
            description: description.to_owned(),
            longest: described.saturating_add(state_bytes).saturating_add(FRAME),
        }
    }

    /// Checks, for a run from its start, that nothing but checkpoints will be replaced.
    ///
    /// # Errors
    /// Other files of their names.
    pub fn claim(&self, replace: Replace) -> Result<(), Fault> {
        for path in [&self.newest, &self.before] {
            if let (FileState::Torn, Replace::Own) = (found_at(path)?, replace) {
                let found = "a file that is not a whole checkpoint of raylet";
                let fault = Fault::of_file(path, found, "no file, or a checkpoint");
                return Err(fault.hint("move it away, or let it be replaced (--overwrite)"));
            }
        }
        Ok(())
    }

    /// Writes a checkpoint; the last one is kept beside it. At any moment one of the two is whole, on the disk too.
    ///
    /// # Errors
    /// An error of the file system.
    pub fn write<T: Serialize>(&self, state: &T) -> Result<(), Fault> {
        let refuse = |error: io::Error| unwritable(&self.newest, &error);
        let body = serde_json::to_string(&(&self.description, state));
        let body = body.map_err(|error| refuse(io::Error::other(error)))?;
        let text = format!("{}\n{body}", checksum(&body));
        let fresh = Hidden::beside(&self.newest)?;
        fresh.write(None, text.as_bytes()).map_err(refuse)?;

        // A torn one does not take the place of the whole one before it.
        if found_at(&self.newest)? == FileState::Whole {
            fs::rename(&self.newest, &self.before).map_err(refuse)?;
            sync(self.folder()).map_err(refuse)?;
        }
        fresh.reveal(&self.newest, &|_| Ok(()))
    }

    /// The last checkpoint that is whole, if `check` finds nothing wrong with it.
    ///
    /// # Errors
    /// No checkpoint, none that is whole, one of another run, or what `check` says was found in it.
    pub fn read<T: DeserializeOwned>(
        &self,
        check: impl FnOnce(&T) -> Result<(), String>,
    ) -> Result<Restored<T>, Fault> {
        let newest = found_at(&self.newest)?;
        let wrong = match newest {
            FileState::Whole => {
                let state = self.state(&self.newest, check)?;
                return Ok(Restored {
                    state,
                    warning: None,
                });
            }
            FileState::Torn => "torn",
            FileState::Nothing => "missing",
        };
        let (path, found) = match (newest, found_at(&self.before)?) {
            (_, FileState::Whole) => {
                let state = self.state(&self.before, check)?;
                let (newest, before) = (self.newest.display(), self.before.display());
                let warning = format!(
                    "the newest checkpoint is {wrong} ({newest}); going on from the one before it ({before})"
                );
                return Ok(Restored {
                    state,
                    warning: Some(warning),
                });
            }
            (FileState::Nothing, FileState::Nothing) => (&self.newest, "no such file"),
            (FileState::Nothing, _) => (&self.before, "a torn file"),
            _ => (&self.newest, "a torn file"),
        };
        Err(Fault::of_file(path, found, EXPECTED))
    }

    /// Removes the checkpoints, and their folder if nothing else is in it.
    ///
    /// # Errors
    /// An error of the file system.
    pub fn remove(&self) -> Result<(), Fault> {
        for path in [&self.newest, &self.before] {
            if found_at(path)? == FileState::Whole {
                fs::remove_file(path).map_err(|error| unwritable(path, &error))?;
            }
        }
        let _ = fs::remove_dir(self.folder());
        Ok(())
    }

    fn folder(&self) -> &Path {
        named(self.newest.parent().unwrap_or(&self.newest))
    }

    fn state<T: DeserializeOwned>(
        &self,
        path: &Path,
        check: impl FnOnce(&T) -> Result<(), String>,
    ) -> Result<T, Fault> {
        let refuse = |found: String| Fault::of_file(path, found, EXPECTED);
        let bytes = fs::metadata(path).map_or(0, |metadata| metadata.len());
        if bytes > self.longest {
            let expected = format!("{EXPECTED}, of at most {} bytes", self.longest);
            return Err(Fault::of_file(path, format!("{bytes} bytes"), &expected));
        }
        let text = regular_file::read_text(path, self.longest).map_err(refuse)?;
        let body = text.split_once('\n').map_or("", |(_, body)| body);
        let (description, state): (String, T) =
            serde_json::from_str(body).map_err(|error| refuse(error.to_string()))?;
        if description != self.description {
            let found = "a checkpoint of another scene or of other settings";
            return Err(Fault::of_file(path, found, "that of this one"));
        }
        check(&state).map_err(|found| Fault::of_file(path, found, EXPECTED))?;
        Ok(state)
    }
}

/// Bytes of the line with the checksum, its end included.
const LINE: usize = 9;

fn checksum(body: &str) -> String {
    format!("{:08x}", crc32fast::hash(body.as_bytes()))
}

/// Judges what stands where a checkpoint should be, without reading it into memory: it may have any size. Anything but
/// a whole one is torn, whatever its bytes are.
fn found_at(path: &Path) -> Result<FileState, Fault> {
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(FileState::Nothing),
        Ok(kind) if !kind.is_file() => {
            return Err(Fault::of_file(
                path,
                "something that is not a file",
                EXPECTED,
            ));
        }
        _ => {}
    }
    let whole = is_whole(path);
    match whole.map_err(|error| Fault::of_file(path, error.to_string(), EXPECTED))? {
        true => Ok(FileState::Whole),
        false => Ok(FileState::Torn),
    }
}

/// Whether a file begins with a line that is the checksum of the rest.
fn is_whole(path: &Path) -> io::Result<bool> {
    let mut file = File::open(path)?;
    let mut line = [0; LINE];
    match file.read_exact(&mut line) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(false),
        other => other?,
    }
    // Of most other files this line says it already.
    let [digits @ .., b'\n'] = &line else {
        return Ok(false);
    };
    if !digits.iter().all(u8::is_ascii_hexdigit) {
        return Ok(false);
    }
    let rest = Checksum::of_rest(&mut file)?;
    Ok(digits[..] == *format!("{:08x}", rest.crc32).as_bytes())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use crate::file::decode::fault::Fault;
    use crate::file::storage::checkpoint::{Checkpoints, Restored};
    use crate::file::storage::own_file::Replace;

    /// Bytes of the largest state.
    const ROOM: u64 = 100;

    fn read(files: &Checkpoints) -> Result<Restored<Vec<u32>>, Fault> {
        files.read(|_| Ok(()))
    }

    #[test]
    fn torn_files_give_way_to_the_one_before() {
        let room = tempfile::tempdir().unwrap();
        let files = Checkpoints::within(&room.path().join("run"), "this scene", ROOM);
        let none = read(&files).unwrap_err().to_string();
        assert!(none.contains("no such file"), "{none}");
        files.write(&vec![1, 2]).unwrap();
        files.write(&vec![3, 4]).unwrap();
        let found = read(&files).unwrap();
        assert_eq!((found.state, found.warning), (vec![3, 4], None));

        // Torn anywhere, or no text at all, the newest is not taken for whole.
        let newest = room.path().join("run/checkpoint.json");
        let text = fs::read(&newest).unwrap();
        let mut torn: Vec<Vec<u8>> = (0..text.len()).map(|n| text[..n].to_vec()).collect();
        torn.push(vec![0xff, 0xfe, 0, 0x80]);
        for bytes in torn {
            fs::write(&newest, &bytes).unwrap();
            let found = read(&files).unwrap();
            assert_eq!(found.state, [1, 2], "{bytes:?}");
            let message = found.warning.unwrap();
            assert!(message.contains("newest checkpoint is torn ("), "{message}");
            assert!(
                message.contains("going on from the one before it"),
                "{message}"
            );
        }

        // The next one leaves the whole one in its place; a file that is not there is reported as that.
        files.write(&vec![5]).unwrap();
        fs::remove_file(&newest).unwrap();
        let found = read(&files).unwrap();
        assert_eq!(found.state, [1, 2]);
        assert!(found.warning.unwrap().contains("is missing ("));
        fs::write(room.path().join("run/checkpoint.before.json"), [0xff]).unwrap();
        let torn = read(&files).unwrap_err().to_string();
        assert!(
            torn.contains("checkpoint.before.json: found a torn file"),
            "{torn}"
        );
        assert_eq!(fs::read_dir(room.path().join("run")).unwrap().count(), 1);
    }

    #[test]
    fn other_runs_are_refused() {
        let room = tempfile::tempdir().unwrap();
        let files = |description| Checkpoints::within(room.path(), description, ROOM);
        files("one").write(&7).unwrap();
        let read = files("another").read(|_: &u32| Ok(()));
        let message = read.unwrap_err().to_string();
        assert!(message.contains("another scene"), "{message}");
        let read = files("one").read(|found: &u32| Err(format!("{found} iterations")));
        let message = read.unwrap_err().to_string();
        assert!(
            message.contains("checkpoint.json: found 7 iterations"),
            "{message}"
        );
    }

    #[test]
    fn files_that_are_too_long_are_refused_unread() {
        let room = tempfile::tempdir().unwrap();
        let files = |bytes| Checkpoints::within(room.path(), "one", bytes);
        files(ROOM).write(&vec![7_u32; 1000]).unwrap();
        let message = read(&files(ROOM)).unwrap_err().to_string();
        assert!(
            message.contains(
                "found 2018 bytes, expected the checkpoint of an earlier run, of at most 182 bytes"
            ),
            "{message}"
        );
        assert_eq!(read(&files(10_000)).unwrap().state.len(), 1000);
    }

    #[test]
    fn other_files_stay() {
        let room = tempfile::tempdir().unwrap();
        let files = Checkpoints::within(room.path(), "one", ROOM);
        files.claim(Replace::Own).unwrap();
        for name in ["checkpoint.json", "checkpoint.before.json"] {
            let path = room.path().join(name);
            fs::write(&path, "{\"mine\": 1}").unwrap();
            let message = files.claim(Replace::Own).unwrap_err().to_string();
            assert!(message.contains(name), "{message}");
            files.claim(Replace::Any).unwrap();
            files.remove().unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), "{\"mine\": 1}");
            fs::remove_file(path).unwrap();
        }
        files.write(&1).unwrap();
        files.write(&2).unwrap();
        files.claim(Replace::Own).unwrap();
        files.remove().unwrap();
        assert!(!room.path().exists());
    }
}
