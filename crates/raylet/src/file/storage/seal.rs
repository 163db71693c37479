//! How raylet recognises the folders that it wrote: their document lists every file with its size and checksum, and
//! holds a checksum of itself.
//!
//! raylet does not replace a folder that has an additional or a changed entry.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use serde::{Deserialize, Serialize};

/// The start of the line that holds a document's checksum, which is its last.
const MARK: &str = "  \"checksum\": \"raylet ";

/// What replaces the eight digits of the checksum while it is computed, and what follows them.
const BLANK: &str = "00000000";
const END: &str = "\"\n}\n";

/// Documents that raylet writes are smaller.
const LARGEST: u64 = 64 << 20;

/// Size and checksum of a file's content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Checksum {
    /// Its length.
    pub bytes: u64,
    /// CRC-32 of all of it (ISO 3309, as in zip files).
    pub crc32: u32,
}

/// A file as a document lists it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Entry {
    file: String,
    bytes: u64,
    crc32: String,
}

/// The list in a document.
#[derive(Deserialize)]
struct List {
    written: Vec<Entry>,
}

/// The document of a folder that raylet wrote, and the files that it lists.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sealed {
    document: String,
    entries: Vec<Entry>,
}

impl Checksum {
    /// That of these bytes.
    pub(crate) fn of(content: &[u8]) -> Self {
        Self {
            bytes: content.len() as u64,
            crc32: crc32fast::hash(content),
        }
    }

    /// That of a regular file; none of anything else, such as a link, a folder or a pipe.
    ///
    /// # Errors
    /// An error of the file system.
    pub(crate) fn of_file(path: &Path) -> io::Result<Option<Self>> {
        if !fs::symlink_metadata(path)?.is_file() {
            return Ok(None);
        }
        Self::of_rest(&mut File::open(path)?).map(Some)
    }

    /// That of what is left to read of a file.
    ///
    /// # Errors
    /// An error of the file system.
    pub(crate) fn of_rest(file: &mut File) -> io::Result<Self> {
        let mut hasher = crc32fast::Hasher::new();
        let (mut buffer, mut bytes) = (vec![0; 1 << 16], 0);
        loop {
            let count = match file.read(&mut buffer) {
                Ok(0) => break,
                Ok(count) => count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            hasher.update(buffer.get(..count).unwrap_or_default());
            bytes += count as u64;
        }
        Ok(Self {
            bytes,
            crc32: hasher.finalize(),
        })
    }
}

impl Entry {
    fn is_of(&self, content: Checksum) -> bool {
        self.bytes == content.bytes && self.crc32 == format!("{:08x}", content.crc32)
    }
}

/// A JSON object with the list of a folder's other files, and its own checksum at the end; none for a text that is no
/// object.
pub(crate) fn sealed(document: &str, files: &[(String, Checksum)]) -> Option<String> {
    let open = document.trim_end().strip_suffix('}')?.trim_end();
    let comma = if open.ends_with('{') { "" } else { "," };
    let entry = |(file, content): &(String, Checksum)| {
        let entry = Entry {
            file: file.clone(),
            bytes: content.bytes,
            crc32: format!("{:08x}", content.crc32),
        };
        serde_json::to_string(&entry).ok()
    };
    let entries: Vec<String> = files.iter().map(entry).collect::<Option<_>>()?;
    let list = match entries.is_empty() {
        true => String::from("[]"),
        false => format!("[\n    {}\n  ]", entries.join(",\n    ")),
    };
    let start = format!("{open}{comma}\n  \"written\": {list},\n{MARK}");
    let sum = own_checksum(&start);
    Some(format!("{start}{sum:08x}{END}"))
}

/// The checksum of a document that is this before its digits.
fn own_checksum(start: &str) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    for part in [start, BLANK, END] {
        hasher.update(part.as_bytes());
    }
    hasher.finalize()
}

/// The files that a document lists; none if raylet did not write it, or somebody changed it since.
fn entries(document: &str) -> Option<Vec<Entry>> {
    let head = document.strip_suffix(END)?;
    let (start, digits) = head.split_at_checked(head.len().checked_sub(BLANK.len())?)?;
    let genuine = start.ends_with(MARK) && digits == format!("{:08x}", own_checksum(start));
    let list = genuine.then(|| serde_json::from_str::<List>(document).ok())??;

    // A name leads nowhere else.
    let plain = |entry: &Entry| !entry.file.contains(['/', '\\']) && !entry.file.starts_with('.');
    list.written.iter().all(plain).then_some(list.written)
}

impl Sealed {
    /// What the document of this name lists; none if it is not there, or not as raylet wrote it.
    pub(crate) fn read(folder: &Path, document: &str) -> Option<Self> {
        let path = folder.join(document);
        let kind = fs::symlink_metadata(&path).ok()?;
        if !kind.is_file() || kind.len() > LARGEST {
            return None;
        }
        Some(Self {
            document: document.to_owned(),
            entries: entries(&fs::read_to_string(path).ok()?)?,
        })
    }

    /// That of whatever document of raylet lies in a folder.
    pub(crate) fn find(folder: &Path) -> Option<Self> {
        let names = fs::read_dir(folder).ok()?.flatten();
        let mut names = names.filter_map(|entry| entry.file_name().into_string().ok());
        names.find_map(|name| {
            let is_document = name.ends_with(".json");
            is_document.then(|| Self::read(folder, &name)).flatten()
        })
    }

    /// An entry of the folder, hidden ones included, that raylet did not write, or that was changed since.
    ///
    /// # Errors
    /// An error of the file system.
    pub(crate) fn stranger(&self, folder: &Path) -> io::Result<Option<String>> {
        for found in fs::read_dir(folder)? {
            let name = found?.file_name().to_string_lossy().into_owned();
            if name == self.document {
                continue;
            }
            let Some(entry) = self.entries.iter().find(|entry| entry.file == name) else {
                return Ok(Some(name));
            };
            let content = Checksum::of_file(&folder.join(&name))?;
            if !content.is_some_and(|content| entry.is_of(content)) {
                return Ok(Some(format!("{name}, which raylet did not write so")));
            }
        }
        Ok(None)
    }

    /// Removes the files of the list one by one, the document last, then the folder. Anything else stays, and with it
    /// the folder.
    ///
    /// # Errors
    /// An error of the file system.
    pub(crate) fn remove(&self, folder: &Path) -> io::Result<()> {
        for entry in &self.entries {
            let path = folder.join(&entry.file);
            match fs::symlink_metadata(&path) {
                Ok(kind) if kind.is_file() && kind.len() == entry.bytes => fs::remove_file(path)?,
                _ => {}
            }
        }
        fs::remove_file(folder.join(&self.document))?;
        fs::remove_dir(folder)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use crate::file::storage::seal::{Checksum, Sealed, sealed};

    const DOCUMENT: &str = "result.json";

    /// A folder with two files and a document.
    fn write(folder: &Path) -> String {
        let files = ["field.npz", "sensor.png"];
        let list = files.map(|name| {
            fs::write(folder.join(name), name).unwrap();
            (name.to_owned(), Checksum::of(name.as_bytes()))
        });
        let text = sealed("{\n  \"version\": 1\n}\n", &list).unwrap();
        fs::write(folder.join(DOCUMENT), &text).unwrap();
        text
    }

    #[test]
    fn whatever_is_not_as_it_was_written_is_found() {
        let room = tempfile::tempdir().unwrap();
        let text = write(room.path());
        let found = || {
            Sealed::read(room.path(), DOCUMENT)
                .unwrap()
                .stranger(room.path())
                .unwrap()
        };
        assert_eq!(found(), None);
        for stranger in [".ssh", "notes.txt", "..."] {
            fs::create_dir(room.path().join(stranger)).unwrap();
            assert_eq!(found().unwrap(), stranger);
            fs::remove_dir(room.path().join(stranger)).unwrap();
        }
        fs::write(room.path().join("sensor.png"), "sensor.pnG").unwrap();
        assert!(found().unwrap().starts_with("sensor.png, "));
        #[cfg(unix)]
        {
            fs::rename(room.path().join("field.npz"), room.path().join("away")).unwrap();
            std::os::unix::fs::symlink("away", room.path().join("field.npz")).unwrap();
            fs::remove_file(room.path().join("sensor.png")).unwrap();
            assert!(found().is_some());
        }

        // A document with a changed byte, or without a seal, is not recognised.
        for at in 0..text.len() {
            let mut bytes = text.clone().into_bytes();
            bytes[at] ^= 1;
            fs::write(room.path().join(DOCUMENT), bytes).unwrap();
            assert_eq!(Sealed::read(room.path(), DOCUMENT), None, "{at}");
        }
        for other in ["", "{}", "{\"files\": [\"notes.txt\"]}", "[1]"] {
            fs::write(room.path().join(DOCUMENT), other).unwrap();
            assert_eq!(Sealed::find(room.path()), None);
        }
    }

    #[test]
    fn only_what_is_listed_is_removed() {
        let room = tempfile::tempdir().unwrap();
        let folder = room.path().join("out");
        fs::create_dir(&folder).unwrap();
        write(&folder);
        fs::write(folder.join("late.txt"), "mine").unwrap();
        assert!(Sealed::find(&folder).unwrap().remove(&folder).is_err());
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_file(folder.join("late.txt")).unwrap();
        write(&folder);
        Sealed::find(&folder).unwrap().remove(&folder).unwrap();
        assert!(!folder.exists());
    }

    #[test]
    fn names_that_lead_elsewhere_are_nobodys() {
        let room = tempfile::tempdir().unwrap();
        for name in ["../notes.txt", "a/b", ".ssh"] {
            let list = [(name.to_owned(), Checksum::of(b""))];
            fs::write(room.path().join(DOCUMENT), sealed("{}", &list).unwrap()).unwrap();
            assert_eq!(Sealed::find(room.path()), None, "{name}");
        }
        assert!(sealed("[]", &[]).is_none());
        assert!(sealed("{}", &[]).unwrap().starts_with("{\n  \"written\""));
    }
}
