//! Opening files to read: regular ones only, so that no pipe hangs a run and no device fills the memory.

use std::fs::{File, FileType, Metadata, OpenOptions};
use std::io::{self, Read};
use std::path::Path;

/// Opens a regular file, or one that a link leads to.
///
/// # Errors
/// What was found instead, in words.
pub(crate) fn open(path: &Path) -> Result<File, String> {
    // The kind comes first: opening a pipe waits until somebody writes into it.
    let known = std::fs::metadata(path).map_err(|error| error.to_string())?;
    check(&known)?;
    let file = open_at_once(path).map_err(|error| error.to_string())?;
    check(&file.metadata().map_err(|error| error.to_string())?)?;
    Ok(file)
}

/// Opens a file so that no read waits for more: some files of /proc are regular, and never end.
#[cfg(unix)]
fn open_at_once(path: &Path) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let flags = rustix::fs::OFlags::NONBLOCK.bits().cast_signed();
    OpenOptions::new().read(true).custom_flags(flags).open(path)
}

/// Opens a file.
#[cfg(not(unix))]
fn open_at_once(path: &Path) -> io::Result<File> {
    OpenOptions::new().read(true).open(path)
}

/// The text of a regular file of at most so many bytes.
///
/// # Errors
/// What was found instead, in words.
pub(crate) fn read_text(path: &Path, most: u64) -> Result<String, String> {
    let file = open(path)?;
    let length = file.metadata().map_or(0, |metadata| metadata.len());
    let too_large = |bytes: u64| {
        let megabytes = most / 1_000_000;
        format!("a text of {bytes} bytes, larger than {megabytes} MB")
    };
    if length > most {
        return Err(too_large(length));
    }

    // Some regular files, such as those of /proc, do not say how long they are.
    let mut bytes = Vec::new();
    let read = file.take(most + 1).read_to_end(&mut bytes);
    read.map_err(|error| error.to_string())?;
    if bytes.len() as u64 > most {
        return Err(too_large(bytes.len() as u64));
    }
    String::from_utf8(bytes).map_err(|error| error.to_string())
}

fn check(metadata: &Metadata) -> Result<(), String> {
    match metadata.is_file() {
        true => Ok(()),
        false => Err(format!(
            "{}, not a regular file",
            kind(metadata.file_type())
        )),
    }
}

/// What a file is that is not regular.
#[cfg(unix)]
fn kind(file: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match file {
        file if file.is_dir() => "a folder",
        file if file.is_fifo() => "a named pipe",
        file if file.is_socket() => "a socket",
        _ => "a device",
    }
}

/// What a file is that is not regular.
#[cfg(not(unix))]
fn kind(file: FileType) -> &'static str {
    match file.is_dir() {
        true => "a folder",
        false => "a device",
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::path::Path;

    use crate::file::arrays::regular_file::{open, read_text};

    #[test]
    fn only_regular_files_are_read() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("text");
        std::fs::write(&path, "words").unwrap();
        assert_eq!(read_text(&path, 5).unwrap(), "words");
        assert!(read_text(&path, 4).is_err());
        assert!(open(room.path()).unwrap_err().contains("a folder"));
        #[cfg(unix)]
        {
            let link = room.path().join("link");
            std::os::unix::fs::symlink(&path, &link).unwrap();
            assert_eq!(read_text(&link, 5).unwrap(), "words");
            for endless in ["/dev/zero", "/dev/urandom"] {
                let found = open(Path::new(endless)).unwrap_err();
                assert_eq!(found, "a device, not a regular file");
            }
        }
    }

    #[test]
    fn large_texts_are_refused_before_they_are_read() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("text");
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        let found = read_text(&path, 64_000_000).unwrap_err();
        assert!(found.contains("64 MB"), "{found}");
    }
}
