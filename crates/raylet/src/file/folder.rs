//! Output folders that appear whole or not at all.
//!
//! Everything is written into a hidden folder beside the target, which takes the target's name at the end.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::file::fault::Fault;

/// The file by which a folder of results is known.
pub const RESULT_FILE: &str = "result.json";

/// The file by which a folder of a comparison is known.
pub const COMPARISON_FILE: &str = "compare.json";

/// The name of a folder that may be written: checked, not yet made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    path: PathBuf,
    mark: &'static str,
}

/// A folder that is being filled. Dropped before [`Draft::publish`], it leaves nothing behind.
#[derive(Debug)]
pub struct Draft {
    target: Target,
    draft: TempDir,
}

impl Target {
    /// Checks that a folder of results may be written here: nothing is here, or an empty folder, or an
    /// earlier result, and the folder around it can be written. Nothing is left on the disk.
    ///
    /// # Errors
    /// Something else stands here, or the folder around cannot be written.
    pub fn claim(path: &Path) -> Result<Self, Fault> {
        Self::claim_as(path, RESULT_FILE)
    }

    /// The same for a folder that is known by another file, so that no kind replaces another.
    ///
    /// # Errors
    /// Something else stands here, or the folder around cannot be written.
    pub fn claim_as(path: &Path, mark: &'static str) -> Result<Self, Fault> {
        let target = Self {
            path: path.to_path_buf(),
            mark,
        };
        target.check_occupant()?;
        target.draft()?;
        Ok(target)
    }

    /// Where the folder will be.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// An empty hidden folder beside the target.
    ///
    /// # Errors
    /// The folder around cannot be written.
    pub fn draft(&self) -> Result<Draft, Fault> {
        let around = around(&self.path);
        let draft = tempfile::Builder::new()
            .prefix(".raylet-")
            .tempdir_in(&around)
            .map_err(|error| {
                let expected = "an existing folder that can be written";
                Fault::of_file(&around, error.to_string(), expected)
            })?;
        Ok(Draft {
            target: self.clone(),
            draft,
        })
    }

    /// Refuses anything but an empty folder or one of the same kind.
    fn check_occupant(&self) -> Result<(), Fault> {
        let path = self.path();
        let refuse = |found: &str| {
            Err(Fault::of_file(
                path,
                found,
                format!(
                    "a new name, an empty folder, or one with a {} to replace",
                    self.mark
                ),
            ))
        };
        let kind = match fs::symlink_metadata(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return match path.file_name() {
                    Some(_) => Ok(()),
                    None => refuse("a path without a name"),
                };
            }
            Err(error) => return refuse(&error.to_string()),
            Ok(kind) => kind,
        };
        if !kind.is_dir() {
            return refuse("something that is not a folder");
        }
        let mut entries = match fs::read_dir(path) {
            Ok(entries) => entries,
            Err(error) => return refuse(&error.to_string()),
        };
        if path.join(self.mark).is_file() || entries.next().is_none() {
            return Ok(());
        }
        refuse("a folder with other files in it")
    }
}

impl Draft {
    /// Where files are written for now.
    pub fn path(&self) -> &Path {
        self.draft.path()
    }

    /// Writes one file.
    ///
    /// # Errors
    /// What the file system said.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<(), Fault> {
        let path = self.draft.path().join(name);
        fs::write(&path, content)
            .map_err(|error| self.refusal(&error, &self.target.path.join(name)))
    }

    /// Gives the folder its name; an earlier result of that name is replaced.
    ///
    /// # Errors
    /// Something else has come to stand there, or what the file system said; then nothing is changed.
    pub fn publish(self) -> Result<(), Fault> {
        self.target.check_occupant()?;
        let path = self.target.path();
        let fail = |error: &io::Error| self.refusal(error, path);
        open_to_readers(self.draft.path()).map_err(|error| fail(&error))?;

        // An earlier result steps aside, and comes back if the new one cannot take its place.
        let around = around(path);
        let aside = tempfile::Builder::new()
            .prefix(".raylet-old-")
            .tempdir_in(&around)
            .map_err(|error| fail(&error))?;
        let old = aside.path().join("result");
        let occupied = path.exists();
        if occupied {
            fs::rename(path, &old).map_err(|error| fail(&error))?;
        }
        if let Err(error) = fs::rename(self.draft.path(), path) {
            if occupied {
                fs::rename(&old, path).map_err(|error| fail(&error))?;
            }
            return Err(fail(&error));
        }
        Ok(())
    }

    fn refusal(&self, error: &io::Error, path: &Path) -> Fault {
        Fault::of_file(path, error.to_string(), "a place that can be written")
    }
}

/// The folder that a path lies in.
fn around(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

/// Temporary folders are private; results are as open as other new folders.
#[cfg(unix)]
fn open_to_readers(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    // A new folder inside shows what the user's mask allows.
    let sample = path.join("mode");
    fs::create_dir(&sample)?;
    let mode = fs::metadata(&sample)?.permissions().mode();
    fs::remove_dir(&sample)?;
    fs::set_permissions(path, fs::Permissions::from_mode(mode))
}

#[cfg(not(unix))]
fn open_to_readers(_path: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use crate::file::folder::{COMPARISON_FILE, RESULT_FILE, Target};

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
        let target = Target::claim(&out).unwrap();
        assert!(names().is_empty());
        let draft = target.draft().unwrap();
        draft.write(RESULT_FILE, b"{}").unwrap();
        assert!(!out.exists());
        drop(draft);
        assert!(names().is_empty());

        // A second result replaces the first as a whole.
        for name in ["first", "second"] {
            let draft = Target::claim(&out).unwrap().draft().unwrap();
            draft.write(RESULT_FILE, b"{}").unwrap();
            draft.write(name, b"").unwrap();
            draft.publish().unwrap();
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
        Target::claim(&out).unwrap();
        fs::write(out.join("diary.txt"), "mine").unwrap();
        let fault = Target::claim(&out).unwrap_err().to_string();
        assert!(fault.contains("other files"), "{fault}");
        let file = out.join("diary.txt");
        assert!(Target::claim(&file).is_err());
        assert!(Target::claim(&file.join("below")).is_err());
        assert!(Target::claim(&room.path().join("no/where")).is_err());

        // A comparison does not replace results.
        let results = room.path().join("results");
        fs::create_dir(&results).unwrap();
        fs::write(results.join(RESULT_FILE), "{}").unwrap();
        Target::claim(&results).unwrap();
        assert!(Target::claim_as(&results, COMPARISON_FILE).is_err());
        assert_eq!(fs::read_to_string(file).unwrap(), "mine");
    }
}
