//! Locks that end with their process, however it ends: the kernel holds them, and a file says by whom.

use std::fmt;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use crate::file::storage::unfinished::{Trace, unfinished};

/// The first word of every lock file.
const MARK: &str = "raylet";

/// A lock that is held this long after the first attempt to take it belongs to another run; a shorter one to a process that
/// looks for stale locks.
const TRIES: u32 = 10;
const WAIT: Duration = Duration::from_millis(20);

/// Lock files are shorter.
const LONGEST: u64 = 4096;

/// A lock file that this process holds, removed when dropped.
#[derive(Debug)]
pub(crate) struct Lock {
    path: PathBuf,
    /// Closing it releases the lock.
    _file: File,
}

/// Why there is no lock.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LockError {
    /// Another run holds it.
    #[error("{0}")]
    Held(Holder),
    /// It cannot be written.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// The process that holds a lock, as far as its file says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Holder(Option<Process>);

/// A process on some machine.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Process {
    number: u32,
    host: String,
    /// Seconds from 1970 to when it took the lock.
    since: u64,
}

impl Lock {
    /// Takes the lock of this file, which is made. A file that was left by a process that has ended is taken over.
    ///
    /// # Errors
    /// Another run holds it, or the file cannot be written.
    pub(crate) fn take(path: &Path) -> Result<Self, LockError> {
        for attempt in 0..TRIES {
            if attempt > 0 {
                sleep(WAIT);
            }
            // Where the file system knows no locks, runs are not kept apart.
            if let Some(lock) = Self::attempt(path, true)? {
                return Ok(lock);
            }
        }
        Err(LockError::Held(Holder::of(path)))
    }

    /// Takes a lock that a process which has ended has left; none if another one holds it, or it is not certain that
    /// none does. The file goes on naming that process. If this one is killed, the file stays as it was.
    ///
    /// # Errors
    /// There is no such file, or it cannot be written.
    pub(crate) fn take_stale(path: &Path) -> io::Result<Option<Self>> {
        Self::attempt(path, false)
    }

    /// With `new`, a file that is not there is made, and names this process.
    fn attempt(path: &Path, new: bool) -> io::Result<Option<Self>> {
        // A process that is about to end removes its locks while it holds the list.
        let mut list = unfinished();
        let mut file = open(path, new)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::Error(_)) if new => {}
            Err(_) => return Ok(None),
        }
        // Whoever held it may have removed the file meanwhile.
        if !is_at(&file, path) {
            return Ok(None);
        }
        list.push(Trace::Lock(path.to_path_buf()));
        drop(list);
        let written = if new { write(&mut file) } else { Ok(()) };
        let lock = Self {
            path: path.to_path_buf(),
            _file: file,
        };
        written.map(|()| Some(lock))
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        let mut list = unfinished();
        let own = Trace::Lock(self.path.clone());
        if let Some(at) = list.iter().position(|trace| *trace == own) {
            list.remove(at).remove();
        }
    }
}

/// Opens a lock file, but nothing else that may have its name.
fn open(path: &Path, new: bool) -> io::Result<File> {
    let foreign = || io::Error::other("a file of that name which is no lock of raylet");
    match fs::symlink_metadata(path) {
        Ok(kind) if !kind.is_file() || kind.len() > LONGEST => return Err(foreign()),
        _ => {}
    }
    let mut options = OpenOptions::new();
    let mut file = options
        .read(true)
        .write(true)
        .create(new)
        .truncate(false)
        .open(path)?;

    // An empty one belongs to a process that is just about to write its name.
    let mut text = Vec::new();
    (&mut file).take(LONGEST).read_to_end(&mut text)?;
    let is_lock =
        |text: &str| Process::parse(text).is_some_and(|process| text == process.to_string());
    match str::from_utf8(&text) {
        Ok(text) if text.is_empty() || is_lock(text) => Ok(file),
        _ => Err(foreign()),
    }
}

/// Writes who this process is.
fn write(file: &mut File) -> io::Result<()> {
    let text = Process::this().to_string();
    file.rewind()?;
    file.set_len(0)?;
    file.write_all(text.as_bytes())
}

/// Whether an open file is the one at a path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), fs::symlink_metadata(path)) {
        (Ok(own), Ok(there)) => (own.dev(), own.ino()) == (there.dev(), there.ino()),
        _ => false,
    }
}

/// Elsewhere open files cannot be replaced.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

impl Holder {
    fn of(path: &Path) -> Self {
        let mut text = String::new();
        let file = File::open(path);
        let read = file.and_then(|file| file.take(LONGEST).read_to_string(&mut text));
        Self(read.ok().and_then(|_| Process::parse(&text)))
    }
}

impl Process {
    fn this() -> Self {
        Self {
            number: std::process::id(),
            host: host(),
            since: now(),
        }
    }

    fn parse(text: &str) -> Option<Self> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let [MARK, "process", number, "on", host, "since", since] = words[..] else {
            return None;
        };
        Some(Self {
            number: number.parse().ok()?,
            host: host.to_owned(),
            since: since.parse().ok()?,
        })
    }
}

/// What stands in a lock file.
impl fmt::Display for Process {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            number,
            host,
            since,
        } = self;
        writeln!(f, "{MARK} process {number} on {host} since {since}")
    }
}

/// What is reported of the holder.
impl fmt::Display for Holder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(process) = &self.0 else {
            return write!(f, "another process that writes it");
        };
        let seconds = now().saturating_sub(process.since);
        write!(
            f,
            "process {} on {} that has been writing it for {seconds} s",
            process.number, process.host
        )
    }
}

/// Seconds since 1970.
fn now() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |since| since.as_secs())
}

/// The machine's name, as one word.
fn host() -> String {
    #[cfg(unix)]
    let name = rustix::system::uname()
        .nodename()
        .to_string_lossy()
        .into_owned();
    #[cfg(not(unix))]
    let name = std::env::var("COMPUTERNAME").unwrap_or_default();
    let words: Vec<&str> = name.split_whitespace().collect();
    match words.is_empty() {
        true => String::from("localhost"),
        false => words.join("-"),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use crate::file::storage::lock::{Lock, LockError};

    #[test]
    fn one_holds_it_and_the_other_hears_who() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join(".raylet-out.lock");
        let lock = Lock::take(&path).unwrap();
        let message = Lock::take(&path).unwrap_err().to_string();
        let own = format!("process {} on ", std::process::id());
        assert!(
            message.starts_with(&own) && message.ends_with(" s"),
            "{message}"
        );
        drop(lock);
        assert_eq!(fs::read_dir(room.path()).unwrap().count(), 0);

        // One that a killed process has left is taken over.
        for left in ["", "raylet process 1 on moon since 12\n"] {
            fs::write(&path, left).unwrap();
            drop(Lock::take(&path).unwrap());
            assert!(!path.exists());
        }
    }

    #[test]
    fn other_files_of_that_name_are_left_alone() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("lock");
        let mine = [
            "diary",
            "raylet is good",
            "raylet process 1 on moon since 12",
            "raylet process 1 on moon since 12\nmore",
        ];
        for text in mine {
            fs::write(&path, text).unwrap();
            assert!(matches!(Lock::take(&path), Err(LockError::Io(_))));
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        #[cfg(unix)]
        {
            let link = room.path().join("link");
            std::os::unix::fs::symlink("diary", &link).unwrap();
            assert!(matches!(Lock::take(&link), Err(LockError::Io(_))));
        }
        let nowhere = room.path().join("none/lock");
        assert!(matches!(Lock::take(&nowhere), Err(LockError::Io(_))));
    }
}
