//! Output folders that appear whole or not at all.
//!
//! Everything is written into a hidden folder beside the target, which takes the target's name at the end. One run at
//! a time writes to a target.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use crate::file::decode::fault::Fault;
use crate::file::storage::hidden::{Exchange, Hidden, PREFIX, unwritable};
use crate::file::storage::lock::{Lock, LockError};
use crate::file::storage::parent_folders::{below, exchange, standing};
use crate::file::storage::seal::{Checksum, Sealed, sealed};
use crate::file::storage::sweep::{LOCK, sweep_around};

/// The file by which a folder of results is known.
pub(crate) const RESULT_FILE: &str = "result.json";

/// The file by which a folder of a comparison is known.
pub const COMPARISON_FILE: &str = "compare.json";

/// The picture of a comparison.
pub const COMPARISON_PICTURE: &str = "compare.png";

/// Longest part of a target's name in the name of its lock, in bytes: file systems allow 255.
const LONGEST: usize = 180;

/// The name of a folder that may be written: checked and held, not yet made.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    mark: &'static str,
    _lock: Lock,
}

/// A folder that is being filled. Dropped before [`Draft::publish`], it leaves nothing behind.
#[derive(Debug)]
pub struct Draft<'t> {
    target: &'t OutputFolder,
    hidden: Hidden,
    files: Vec<(String, Checksum)>,
}

impl OutputFolder {
    /// Checks that a folder of results may be written here: nothing is here, or an empty folder, or an
    /// earlier result, and the folder around it can be written or made. Until it is dropped a hidden lock
    /// stands beside it.
    ///
    /// # Errors
    /// A path without a name, something else that stands here, another run that writes here, or a folder
    /// around that cannot be written.
    pub fn claim(path: &Path) -> Result<Self, Fault> {
        Self::claim_as(path, RESULT_FILE)
    }

    /// [`OutputFolder::claim`] for a folder of another kind, recognised by the file `mark`. A folder of one kind does
    /// not replace a folder of another.
    ///
    /// # Errors
    /// As [`OutputFolder::claim`].
    pub fn claim_as(path: &Path, mark: &'static str) -> Result<Self, Fault> {
        // A slash at the end would make a link of the same name seem the folder it leads to.
        let path: PathBuf = path.components().collect();
        if path.file_name().is_none() {
            return Err(refusal(&path, mark, "a path without a name"));
        }
        sweep_around(&path);
        check_occupant(&path, mark, &path)?;
        Hidden::beside(&path)?;
        let target = Self {
            _lock: hold(&path)?,
            path,
            mark,
        };
        Ok(target)
    }

    /// Path of the folder, which may not exist yet.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// An empty hidden folder beside the target.
    ///
    /// # Errors
    /// The folder around cannot be written.
    pub fn draft(&self) -> Result<Draft<'_>, Fault> {
        let hidden = Hidden::beside(&self.path)?;
        hidden
            .make_folder()
            .map_err(|error| unwritable(&self.path, &error))?;
        Ok(Draft {
            target: self,
            hidden,
            files: Vec::new(),
        })
    }
}

/// The lock of something that will be at a path: a hidden file beside it, or beside the first of its folders that is
/// not there yet.
///
/// # Errors
/// Another run that holds it, or a folder around that cannot be written.
pub(crate) fn hold(path: &Path) -> Result<Lock, Fault> {
    let around = standing(path);
    let name = below(&around, path).to_string_lossy();
    let plain = |c: char| if matches!(c, '/' | '\\') { '+' } else { c };
    let mut name: String = name.chars().map(plain).collect();
    if name.len() > LONGEST {
        name = format!("{:08x}", crc32fast::hash(name.as_bytes()));
    }
    let lock = Lock::take(&around.join(format!("{PREFIX}{name}{LOCK}")));
    lock.map_err(|error| match error {
        LockError::Held(holder) => {
            let expected = "a place that no other run writes";
            Fault::of_file(path, holder.to_string(), expected)
        }
        LockError::Io(error) => Fault::of_file(&around, error.to_string(), "a folder to lock"),
    })
}

/// The fault of a target.
fn refusal(path: &Path, mark: &str, found: &str) -> Fault {
    let expected = format!("a new name, an empty folder, or one with a {mark} to replace");
    Fault::of_file(path, found, expected)
}

/// Refuses anything but an empty folder or one of the same kind with nothing else in it. What stands at `place` is
/// reported as that of `path`.
fn check_occupant(path: &Path, mark: &str, place: &Path) -> Result<(), Fault> {
    let refuse = |found: &str| Err(refusal(path, mark, found));
    let kind = match fs::symlink_metadata(place) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return refuse(&error.to_string()),
        Ok(kind) => kind,
    };
    if kind.is_symlink() {
        return refuse("a symbolic link");
    }
    if !kind.is_dir() {
        return refuse("something that is not a folder");
    }
    match stranger(place, mark) {
        Ok(None) => Ok(()),
        Ok(Some(name)) => refuse(&format!("a folder with other files in it, such as {name}")),
        Err(error) => refuse(&error.to_string()),
    }
}

/// Something in a folder, hidden or not, that no run says it wrote as it is now.
fn stranger(place: &Path, mark: &str) -> io::Result<Option<String>> {
    if let Some(sealed) = Sealed::read(place, mark) {
        return sealed.stranger(place);
    }
    let mut names = Vec::new();
    for entry in fs::read_dir(place)? {
        names.push(entry?.file_name().to_string_lossy().into_owned());
    }
    // Without a document of its own nothing here is raylet's.
    let stranger = names.iter().find(|name| *name != mark);
    let unsealed = || format!("a {mark} which raylet did not write so");
    Ok(match names.iter().any(|name| name == mark) {
        true => Some(unsealed()),
        false => stranger.cloned(),
    })
}

impl Draft<'_> {
    /// Writes one file.
    ///
    /// # Errors
    /// An error of the file system.
    pub fn write(&mut self, name: &str, content: &[u8]) -> Result<(), Fault> {
        self.put(name, content)?;
        self.files.push((name.to_owned(), Checksum::of(content)));
        Ok(())
    }

    /// Lets `fill` write one file, however large: no copy of it is held.
    ///
    /// # Errors
    /// An error of `fill` or of the file system.
    pub fn fill(
        &mut self,
        name: &str,
        fill: &dyn Fn(&mut File) -> io::Result<()>,
    ) -> Result<(), Fault> {
        let written = self.hidden.fill(Some(name), fill);
        let content = written.and_then(|path| Checksum::of_file(&path));
        let refuse = |error: &io::Error| unwritable(&self.target.path.join(name), error);
        let content = content.map_err(|error| refuse(&error))?;
        let content =
            content.ok_or_else(|| refuse(&io::Error::other("something that is no file")))?;
        self.files.push((name.to_owned(), content));
        Ok(())
    }

    /// Writes the document by which the folder is known, a JSON object, with a list of all files and their checksums.
    /// Then the folder gets its name, in folders that are made where they are missing; an earlier result of that name
    /// is replaced.
    ///
    /// # Errors
    /// Something else has come to stand there, or an error of the file system; then nothing is changed.
    pub fn publish(self, document: &str) -> Result<(), Fault> {
        self.publish_by(&exchange, document)
    }

    /// The same with another way to let folders change places.
    pub(crate) fn publish_by(self, swap: Exchange, document: &str) -> Result<(), Fault> {
        let OutputFolder { path, mark, .. } = self.target;
        let Some(text) = sealed(document, &self.files) else {
            return Err(Fault::of_file(&path.join(mark), "no JSON object", "one"));
        };
        self.put(mark, text.as_bytes())?;
        let check = |place: &Path| check_occupant(path, mark, place);
        self.hidden.reveal_by(swap, path, &check)
    }

    fn put(&self, name: &str, content: &[u8]) -> Result<(), Fault> {
        let written = self.hidden.write(Some(name), content);
        written.map_err(|error| unwritable(&self.target.path.join(name), &error))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use crate::file::storage::folder::{COMPARISON_FILE, OutputFolder, RESULT_FILE};

    /// Publishes a folder with one file.
    fn publish(out: &Path, name: &str) {
        let target = OutputFolder::claim(out).unwrap();
        let mut draft = target.draft().unwrap();
        draft.write(name, name.as_bytes()).unwrap();
        draft.publish("{\"version\": 1}").unwrap();
    }

    #[test]
    fn nothing_shows_before_the_end() {
        let room = tempfile::tempdir().unwrap();
        let out = room.path().join("out");
        let names = || -> Vec<String> {
            let entries = fs::read_dir(room.path()).unwrap();
            entries
                .map(|e| e.unwrap().file_name().into_string().unwrap())
                .collect()
        };
        let target = OutputFolder::claim(&out).unwrap();
        assert_eq!(names(), [".raylet-out.lock"]);
        let draft = target.draft().unwrap();
        assert!(!out.exists());
        drop(draft);
        drop(target);
        assert!(names().is_empty());

        // A second result replaces the first as a whole.
        for name in ["first", "second"] {
            publish(&out, name);
            assert!(out.join(name).exists());
            assert_eq!(names(), ["out"]);
        }
        assert!(!out.join("first").exists());
    }

    #[test]
    fn strangers_are_left_alone() {
        let room = tempfile::tempdir().unwrap();
        let out = room.path().join("out");
        fs::create_dir(&out).unwrap();
        OutputFolder::claim(&out).unwrap();
        fs::write(out.join("diary.txt"), "mine").unwrap();
        let refusal = |path: &Path| OutputFolder::claim(path).unwrap_err().to_string();
        let fault = refusal(&out);
        assert!(
            fault.contains("other files") && fault.contains("diary.txt"),
            "{fault}"
        );
        let file = out.join("diary.txt");
        assert!(OutputFolder::claim(&file).is_err());
        assert!(OutputFolder::claim(&file.join("below")).is_err());
        for nameless in [".", "..", "/", "", "out/.."] {
            let fault = refusal(nameless.as_ref());
            assert!(fault.contains("without a name"), "{nameless}: {fault}");
        }
        assert_eq!(fs::read_to_string(file).unwrap(), "mine");

        // A comparison does not replace results, and nothing replaces what only has their names.
        let results = room.path().join("results");
        publish(&results, "field.npz");
        assert!(OutputFolder::claim_as(&results, COMPARISON_FILE).is_err());
        let seeming = room.path().join("seeming");
        fs::create_dir(&seeming).unwrap();
        fs::write(seeming.join(RESULT_FILE), "{\"files\": [\"field.npz\"]}").unwrap();
        let fault = refusal(&seeming);
        assert!(fault.contains("did not write so"), "{fault}");
    }

    /// Whatever a user has put beside earlier results, hidden or not, or changed in them, stays.
    #[test]
    fn results_with_anything_else_are_left_alone() {
        let room = tempfile::tempdir().unwrap();
        for name in [".DS_Store", ".ssh/id", "notes.txt", "more/a", "field.npz"] {
            let out = room.path().join("out");
            publish(&out, "field.npz");
            let file = out.join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(&file, "mine").unwrap();
            let fault = OutputFolder::claim(&out).unwrap_err().to_string();
            let first = name.split('/').next().unwrap();
            assert!(fault.contains(&format!("such as {first}")), "{fault}");
            assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
            fs::remove_dir_all(out).unwrap();
        }

        // So does what comes while the run goes on.
        let out = room.path().join("out");
        for name in [".ssh", "field.npz"] {
            publish(&out, "field.npz");
            let target = OutputFolder::claim(&out).unwrap();
            let draft = target.draft().unwrap();
            fs::write(out.join(name), "mine").unwrap();
            assert!(draft.publish("{}").is_err());
            assert_eq!(fs::read_to_string(out.join(name)).unwrap(), "mine");
            fs::remove_dir_all(&out).unwrap();
        }
    }

    #[test]
    fn one_run_at_a_time_writes_to_a_place() {
        let room = tempfile::tempdir().unwrap();
        for name in ["out", "new/folder/out", &"long".repeat(60)] {
            let out = room.path().join(name);
            let first = OutputFolder::claim(&out).unwrap();
            let fault = OutputFolder::claim(&out).unwrap_err().to_string();
            let process = format!("process {}", std::process::id());
            assert!(fault.contains(&process), "{fault}");
            let other = OutputFolder::claim(&room.path().join("other")).unwrap();
            drop((first, other));
            OutputFolder::claim(&out).unwrap();
        }
        assert_eq!(fs::read_dir(room.path()).unwrap().count(), 0);
    }
}
