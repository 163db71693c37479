//! Reading archives (.npz) whose list of members is short.
//!
//! A list may name millions of members in a small file, and what it says of its length may be wrong. So members are read
//! one by one, up to a limit.

use std::fs::File;
use std::io::Read;

use flate2::read::DeflateDecoder;
use rawzip::{
    CompressionMethod, FileReader, RECOMMENDED_BUFFER_SIZE, ZipArchive, ZipArchiveEntryWayfinder,
};

/// Bytes of the longest list of members: thousands of them.
const LONGEST_LIST: usize = 1_000_000;

/// Bytes of a member in the list, beside its name.
const MEMBER_BYTES: usize = 46;

/// An archive that is open to be read.
pub(crate) struct Archive {
    archive: ZipArchive<FileReader>,
    members: Vec<Member>,
}

/// One file in an archive.
struct Member {
    name: String,
    method: CompressionMethod,
    is_encrypted: bool,
    place: ZipArchiveEntryWayfinder,
}

impl Archive {
    /// Opens an archive and reads its list of members.
    ///
    /// # Errors
    /// Anything that is not an archive, and one with too long a list of members, in words.
    pub(crate) fn open(file: File) -> Result<Self, String> {
        let words = |error: rawzip::Error| error.to_string();
        let mut buffer = vec![0; RECOMMENDED_BUFFER_SIZE];
        let archive = ZipArchive::from_file(file, &mut buffer).map_err(words)?;
        let (mut members, mut bytes) = (Vec::new(), 0);
        let mut list = archive.entries(&mut buffer);
        while let Some(member) = list.next_entry().map_err(words)? {
            let path = member.file_path();
            bytes += MEMBER_BYTES + path.as_bytes().len();
            if bytes > LONGEST_LIST {
                return Err(format!(
                    "a list of members longer than {LONGEST_LIST} bytes"
                ));
            }
            members.push(Member {
                name: String::from_utf8_lossy(path.as_bytes()).into_owned(),
                method: member.compression_method(),
                is_encrypted: member.flags().is_encrypted(),
                place: member.wayfinder(),
            });
        }
        Ok(Self { archive, members })
    }

    /// The names of all members, as they stand in the list.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.members.iter().map(|member| member.name.as_str())
    }

    /// The content of the last member of this name. Its length and its checksum are compared with the list at its end.
    ///
    /// # Errors
    /// No such member, or one that is packed by a method that NumPy does not use, in words.
    pub(crate) fn member(&self, name: &str) -> Result<Box<dyn Read + '_>, String> {
        let found = self.members.iter().rfind(|member| member.name == name);
        let member = found.ok_or_else(|| format!("no member `{name}`"))?;
        if member.is_encrypted {
            return Err(format!("the encrypted member `{name}`"));
        }
        let entry = self.archive.get_entry(member.place);
        let entry = entry.map_err(|error| error.to_string())?;
        let packed = entry.reader();
        match member.method {
            CompressionMethod::STORE => Ok(Box::new(entry.verifying_reader(packed))),
            CompressionMethod::DEFLATE => {
                let unpacked = DeflateDecoder::new(packed);
                Ok(Box::new(entry.verifying_reader(unpacked)))
            }
            other => Err(format!("the member `{name}`, packed by {other:?}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs::{self, File};
    use std::io::{Read, Write};
    use std::path::Path;

    use zip::write::SimpleFileOptions;
    use zip::{CompressionMethod, ZipWriter};

    use crate::file::arrays::zip_archive::Archive;

    fn write(path: &Path, count: usize, method: CompressionMethod) {
        let mut writer = ZipWriter::new(File::create(path).unwrap());
        for number in 0..count {
            let options = SimpleFileOptions::default().compression_method(method);
            writer.start_file(format!("{number}.npy"), options).unwrap();
            write!(writer, "content of {number}").unwrap();
        }
        writer.finish().unwrap();
    }

    #[test]
    fn members_come_back_and_damage_is_an_error() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("few.npz");
        for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
            write(&path, 3, method);
            let archive = Archive::open(File::open(&path).unwrap()).unwrap();
            assert!(archive.names().eq(["0.npy", "1.npy", "2.npy"]));
            let mut text = String::new();
            let read = archive.member("1.npy").unwrap().read_to_string(&mut text);
            assert_eq!((read.unwrap(), text.as_str()), (12, "content of 1"));
            assert!(archive.member("7.npy").is_err());
        }
        write(&path, 1, CompressionMethod::Stored);
        let bytes = fs::read(&path).unwrap();
        let at = bytes.windows(7).position(|part| part == b"content");
        let mut damaged = bytes.clone();
        damaged[at.unwrap()] = b'k';
        fs::write(&path, damaged).unwrap();
        let archive = Archive::open(File::open(&path).unwrap()).unwrap();
        let mut text = String::new();
        let read = archive.member("0.npy").unwrap().read_to_string(&mut text);
        assert!(read.is_err());
        fs::write(&path, &bytes[..bytes.len() - 30]).unwrap();
        assert!(Archive::open(File::open(&path).unwrap()).is_err());
    }

    #[test]
    fn long_lists_of_members_are_refused() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("many.npz");
        for (count, is_open) in [(1000, true), (20_000, false)] {
            write(&path, count, CompressionMethod::Stored);
            let opened = Archive::open(File::open(&path).unwrap());
            assert_eq!(opened.is_ok(), is_open, "{count}");
            if let Err(found) = opened {
                assert!(found.contains("a list of members"), "{found}");
            }
        }
    }
}
