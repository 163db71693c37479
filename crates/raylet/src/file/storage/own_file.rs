//! Single files that raylet may replace: those that it wrote itself and that nobody has changed since.
//!
//! An array has no room for a mark of its own. Beside `phase.npy` stands a hidden record, `.phase.npy.raylet`, with the
//! size and the checksum of what raylet wrote there.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::file::decode::fault::Fault;
use crate::file::storage::folder::hold;
use crate::file::storage::hidden::{Hidden, unwritable};
use crate::file::storage::lock::Lock;
use crate::file::storage::parent_folders::{below, standing};
use crate::file::storage::seal::Checksum;
use crate::file::storage::sweep::sweep_around;

/// How a record begins, and how long it may be.
const MARK: &str = "raylet wrote ";
const LONGEST: u64 = 1 << 16;

/// Which existing files a run may replace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Replace {
    /// Only files that raylet wrote and nobody changed since.
    Own,
    /// Any file.
    Any,
}

impl Replace {
    /// All where the user allows it.
    pub fn any_if(overwrite: bool) -> Self {
        match overwrite {
            true => Self::Any,
            false => Self::Own,
        }
    }
}

/// The name of a file that may be written: checked and held, not yet made.
#[derive(Debug)]
pub struct OwnFile {
    path: PathBuf,
    replace: Replace,
    /// None in a folder that the run holds as a whole.
    _lock: Option<Lock>,
}

impl OwnFile {
    /// Checks that a file may be written here. Until it is dropped a hidden lock stands beside it.
    ///
    /// # Errors
    /// A folder of that name, a file that may not be replaced, another run that writes here, or a folder around that
    /// cannot be written.
    pub fn claim(path: &Path, replace: Replace) -> Result<Self, Fault> {
        if path.file_name().is_none() {
            return Err(Fault::of_file(path, "no name", "the name of a file"));
        }
        sweep_around(path);
        let file = Self::claim_held(path, replace)?;
        Hidden::beside(path)?;
        Ok(Self {
            _lock: Some(hold(path)?),
            ..file
        })
    }

    /// [`OwnFile::claim`] without a lock, in a folder that this run has locked already.
    ///
    /// # Errors
    /// A folder of that name, or a file that may not be replaced.
    pub fn claim_held(path: &Path, replace: Replace) -> Result<Self, Fault> {
        check_occupant(path, replace)?;
        Ok(Self {
            path: path.to_path_buf(),
            replace,
            _lock: None,
        })
    }

    /// Path of the file, which may not exist yet.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the file, which changes as a whole or not at all.
    ///
    /// # Errors
    /// Another file has come to stand there, or an error of the file system.
    pub fn write(&self, content: &[u8]) -> Result<(), Fault> {
        self.put(|draft| draft.fill(None, &|file| file.write_all(content)))
    }

    /// The same with what `fill` writes, of which no copy is in memory. A fault may be within the error of `fill`.
    ///
    /// # Errors
    /// Another file has come to stand there, an error of `fill`, or one of the file system.
    pub(crate) fn fill(&self, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), Fault> {
        self.put(|draft| draft.fill_long(fill))
    }

    /// Puts a draft in the place of the file.
    fn put(&self, write: impl FnOnce(&Hidden) -> io::Result<PathBuf>) -> Result<(), Fault> {
        let refuse = |error: io::Error| match error.downcast::<Fault>() {
            Ok(fault) => fault,
            Err(error) => unwritable(&self.path, &error),
        };
        let check = |path: &Path| check_occupant(path, self.replace);
        check(&self.path)?;

        // The record comes first, with both contents: whichever stands here if the run is killed is raylet's.
        let place = record(&self.path);
        let (file, note) = (Hidden::beside(&self.path)?, Hidden::beside(&place)?);
        let draft = write(&file).map_err(refuse)?;
        let mut contents: Vec<Checksum> = Vec::new();
        contents.extend(Checksum::of_file(&draft).map_err(refuse)?);
        contents.extend(recorded(&self.path).map_err(refuse)?);
        let text = text(&self.path, &contents);
        note.write(None, text.as_bytes()).map_err(refuse)?;
        note.reveal(&place, &|place| check_record(place, self.replace))?;
        file.reveal(&self.path, &check)
    }
}

/// Whether a path leads into a folder, links on the way followed; names that go up again from folders which are not
/// there lead nowhere.
pub(crate) fn is_within(path: &Path, folder: &Path) -> bool {
    let around = standing(path);
    let rest = below(&around, path);
    let goes_up = rest.components().any(|part| part.as_os_str() == "..");
    match (around.canonicalize(), folder.canonicalize()) {
        (Ok(around), Ok(folder)) => !goes_up && around.starts_with(folder),
        _ => false,
    }
}

/// Where the record of a file is.
fn record(path: &Path) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".raylet");
    path.with_file_name(name)
}

/// The record of a file with one of these contents.
fn text(path: &Path, contents: &[Checksum]) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut text = format!("{MARK}{name} with one of these sizes and CRC-32 checksums\n");
    for Checksum { bytes, crc32 } in contents {
        text += &format!("{bytes} {crc32:08x}\n");
    }
    text
}

/// What stands at a path, if raylet wrote it so.
fn recorded(path: &Path) -> io::Result<Option<Checksum>> {
    let place = record(path);
    let is_record = |kind: fs::Metadata| kind.is_file() && kind.len() <= LONGEST;
    if !fs::symlink_metadata(&place).is_ok_and(is_record) {
        return Ok(None);
    }
    let text = fs::read_to_string(place).unwrap_or_default();
    if !text.starts_with(MARK) || fs::symlink_metadata(path).is_err() {
        return Ok(None);
    }
    let found = Checksum::of_file(path)?;
    let is_listed = |Checksum { bytes, crc32 }: &Checksum| {
        let line = format!("{bytes} {crc32:08x}");
        text.lines().skip(1).any(|listed| listed == line)
    };
    Ok(found.filter(is_listed))
}

/// Refuses what may not be replaced.
fn check_occupant(path: &Path, replace: Replace) -> Result<(), Fault> {
    let refuse = |found: &str| Err(Fault::of_file(path, found, "the name of a file"));
    let kind = match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return check_record(&record(path), replace);
        }
        Err(error) => return Err(unwritable(path, &error)),
        Ok(kind) => kind,
    };
    if kind.is_dir() {
        return refuse("a folder");
    }
    if !kind.is_file() && !kind.is_symlink() {
        return refuse("something that is not a file");
    }
    let own = recorded(path).map_err(|error| unwritable(path, &error))?;
    match (replace, own) {
        (Replace::Any, _) | (_, Some(_)) => check_record(&record(path), replace),
        (Replace::Own, None) => Err(foreign(path)),
    }
}

/// Refuses a file of the user's in the place of a record.
fn check_record(place: &Path, replace: Replace) -> Result<(), Fault> {
    let is_ours = match fs::symlink_metadata(place) {
        Err(_) => true,
        Ok(kind) if kind.is_dir() => return Err(foreign(place)),
        Ok(kind) if !kind.is_file() || kind.len() > LONGEST => false,
        Ok(_) => fs::read(place).is_ok_and(|text| text.starts_with(MARK.as_bytes())),
    };
    match is_ours || replace == Replace::Any {
        true => Ok(()),
        false => Err(foreign(place)),
    }
}

/// The fault of a file that is not raylet's.
fn foreign(path: &Path) -> Fault {
    let found = match path.is_symlink() {
        true => "a symbolic link, which raylet did not make",
        false => "a file that raylet did not write, or that was changed since",
    };
    let fault = Fault::of_file(path, found, "a new name, or leave to overwrite");
    fault.hint("--overwrite replaces it (in Python, overwrite=True)")
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use crate::file::storage::own_file::{OwnFile, Replace, is_within};

    fn write(path: &Path, replace: Replace, content: &str) -> Result<(), String> {
        let file = OwnFile::claim(path, replace).map_err(|fault| fault.to_string())?;
        let written = file.write(content.as_bytes());
        written.map_err(|fault| fault.to_string())
    }

    #[test]
    fn files_of_others_are_left_alone() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("phase.npy");
        fs::write(&path, "mine").unwrap();
        let message = write(&path, Replace::Own, "ours").unwrap_err();
        assert!(message.contains("did not write") && message.contains("--overwrite"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
        assert_eq!(fs::read_dir(room.path()).unwrap().count(), 1);

        // Allowed once it is raylet's, until somebody changes it.
        write(&path, Replace::Any, "ours").unwrap();
        write(&path, Replace::Own, "newer").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "newer");
        fs::write(&path, "Newer").unwrap();
        assert!(write(&path, Replace::Own, "ours").is_err());
        fs::remove_file(&path).unwrap();
        write(&path, Replace::Own, "ours").unwrap();

        // What came while the run went on is not replaced either.
        let file = OwnFile::claim(&path, Replace::Own).unwrap();
        fs::write(&path, "mine").unwrap();
        assert!(file.write(b"ours").is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
    }

    #[test]
    fn whichever_content_a_killed_run_leaves_is_its_own() {
        // Killed after the record was written, and before or after the file was; a third content is nobody's.
        for (left, is_own) in [("older", true), ("newer", true), ("other", false)] {
            let room = tempfile::tempdir().unwrap();
            let path = room.path().join("phase.npy");
            write(&path, Replace::Own, "older").unwrap();
            write(&path, Replace::Own, "newer").unwrap();
            fs::write(&path, left).unwrap();
            assert_eq!(write(&path, Replace::Own, "newest").is_ok(), is_own);
            let now = if is_own { "newest" } else { left };
            assert_eq!(fs::read_to_string(&path).unwrap(), now);
        }
    }

    #[test]
    fn the_record_takes_no_place_of_another() {
        let room = tempfile::tempdir().unwrap();
        let (path, record) = (room.path().join("a.npy"), room.path().join(".a.npy.raylet"));
        fs::write(&record, "mine").unwrap();
        let message = write(&path, Replace::Own, "ours").unwrap_err();
        assert!(message.contains(".a.npy.raylet"), "{message}");
        assert_eq!(fs::read_to_string(record).unwrap(), "mine");
        assert!(!path.exists());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_not_followed() {
        let room = tempfile::tempdir().unwrap();
        let (path, real) = (room.path().join("phase.npy"), room.path().join("real.npy"));
        fs::write(&real, "mine").unwrap();
        std::os::unix::fs::symlink("real.npy", &path).unwrap();
        let message = write(&path, Replace::Own, "ours").unwrap_err();
        assert!(message.contains("a symbolic link"), "{message}");
        write(&path, Replace::Any, "ours").unwrap();
        assert_eq!(fs::read_to_string(&real).unwrap(), "mine");
        assert!(!path.is_symlink());
    }

    #[test]
    fn paths_lead_inside_or_not() {
        let room = tempfile::tempdir().unwrap();
        let folder = room.path().join("scenes");
        fs::create_dir(&folder).unwrap();
        for (path, inside) in [
            ("scenes/a.npy", true),
            ("scenes/new/a.npy", true),
            ("scenes/../a.npy", false),
            ("scenes/../scenes/a.npy", true),
            ("scenes/new/../../a.npy", false),
            ("scenes2/a.npy", false),
            ("a.npy", false),
        ] {
            assert_eq!(
                is_within(&room.path().join(path), &folder),
                inside,
                "{path}"
            );
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(room.path(), folder.join("up")).unwrap();
            assert!(!is_within(&folder.join("up/a.npy"), &folder));
        }
    }
}
