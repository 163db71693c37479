//! Output folders that appear whole or not at all.
//!
//! Everything is written into a hidden folder beside the target, which takes the target's name at the end.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::file::fault::Fault;
use crate::file::hidden::{Hidden, unwritable};

/// The file by which a folder of results is known.
pub const RESULT_FILE: &str = "result.json";

/// The file by which a folder of a comparison is known.
pub const COMPARISON_FILE: &str = "compare.json";

/// The picture of a comparison.
pub const COMPARISON_PICTURE: &str = "compare.png";

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
    draft: Hidden,
}

impl Target {
    /// Checks that a folder of results may be written here: nothing is here, or an empty folder, or an
    /// earlier result, and the folder around it can be written or made. Nothing is left on the disk.
    ///
    /// # Errors
    /// A path without a name, something else that stands here, or a folder around that cannot be written.
    pub fn claim(path: &Path) -> Result<Self, Fault> {
        Self::claim_as(path, RESULT_FILE)
    }

    /// The same for a folder that is known by another file, so that no kind replaces another.
    ///
    /// # Errors
    /// The same.
    pub fn claim_as(path: &Path, mark: &'static str) -> Result<Self, Fault> {
        // A slash at the end would make a link of the same name seem the folder it leads to.
        let path = path.components().collect();
        let target = Self { path, mark };
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
        let draft = Hidden::beside(&self.path)?;
        draft
            .make_folder()
            .map_err(|error| unwritable(&self.path, &error))?;
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
        if path.file_name().is_none() {
            return refuse("a path without a name");
        }
        let kind = match fs::symlink_metadata(path) {
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
        match self.stranger() {
            Ok(None) => Ok(()),
            Ok(Some(name)) => refuse(&format!("a folder with other files in it, such as {name}")),
            Err(error) => refuse(&error.to_string()),
        }
    }

    /// Something in the folder that no earlier run says it wrote. Hidden files, which file managers leave,
    /// do not count.
    fn stranger(&self) -> io::Result<Option<String>> {
        let text = fs::read_to_string(self.path.join(self.mark)).unwrap_or_default();
        let document: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
        let mut known = vec![COMPARISON_PICTURE, self.mark];
        let files = document.get("files").and_then(|files| files.as_array());
        known.extend(files.into_iter().flatten().filter_map(|file| file.as_str()));
        for entry in fs::read_dir(&self.path)? {
            let name = entry?.file_name().to_string_lossy().into_owned();
            if !name.starts_with('.') && !known.contains(&name.as_str()) {
                return Ok(Some(name));
            }
        }
        Ok(None)
    }
}

impl Draft {
    /// Writes one file.
    ///
    /// # Errors
    /// What the file system said.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<(), Fault> {
        self.draft
            .write(Some(name), content)
            .map_err(|error| unwritable(&self.target.path.join(name), &error))
    }

    /// Gives the folder its name, in folders that are made where they are missing; an earlier result of
    /// that name is replaced.
    ///
    /// # Errors
    /// Something else has come to stand there, or what the file system said; then nothing is changed.
    pub fn publish(self) -> Result<(), Fault> {
        let Self { target, draft } = self;
        draft.reveal(target.path(), || target.check_occupant())
    }
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
            let document = format!("{{\"files\": [\"{name}\"]}}");
            draft.write(RESULT_FILE, document.as_bytes()).unwrap();
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
        assert!(
            fault.contains("other files") && fault.contains("diary.txt"),
            "{fault}"
        );
        let file = out.join("diary.txt");
        assert!(Target::claim(&file).is_err());
        assert!(Target::claim(&file.join("below")).is_err());
        for nameless in [".", "..", "/", "", "out/.."] {
            let fault = Target::claim(nameless.as_ref()).unwrap_err().to_string();
            assert!(fault.contains("without a name"), "{nameless}: {fault}");
        }

        // A comparison does not replace results.
        let results = room.path().join("results");
        fs::create_dir(&results).unwrap();
        fs::write(results.join(RESULT_FILE), "{}").unwrap();
        Target::claim(&results).unwrap();
        fs::write(results.join(".DS_Store"), "").unwrap();
        Target::claim(&results).unwrap();
        assert!(Target::claim_as(&results, COMPARISON_FILE).is_err());
        assert_eq!(fs::read_to_string(file).unwrap(), "mine");

        // Nor do results replace what a user has put beside earlier ones.
        fs::write(results.join("notes.txt"), "").unwrap();
        assert!(Target::claim(&results).is_err());
    }
}
