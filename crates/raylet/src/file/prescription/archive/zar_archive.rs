//! The files of an archive of OpticStudio. raylet unpacks only the files that it needs, and writes none of them to the disk.

use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::file::decode::fault::Fault;
use crate::file::prescription::archive::lzw::unpacked;
use crate::file::prescription::archive::zar_block::{Block, LONGEST};
use crate::file::prescription::lens_file::LARGEST;

/// Most files of an archive.
const MOST_FILES: usize = 10_000;

/// Most bytes that all files together are unpacked to.
const MOST_BYTES: u64 = 5 * LARGEST;

/// An archive, and where its files stand.
#[derive(Debug)]
pub(crate) struct Archive<R> {
    source: R,
    path: PathBuf,
    files: Vec<(u64, Block)>,
    /// Bytes that may still be unpacked.
    left: u64,
}

impl<R: Read + Seek> Archive<R> {
    /// The archive of bytes that faults name as `path`.
    ///
    /// # Errors
    /// Bytes that are no archive, or one with more than 10,000 files.
    pub(crate) fn open(mut source: R, path: &Path) -> Result<Self, Fault> {
        let failed = |error: std::io::Error| Fault::of_file(path, error.to_string(), READABLE);
        let length = source.seek(SeekFrom::End(0)).map_err(failed)?;
        let (mut files, mut at) = (Vec::new(), 0);
        while at < length || files.is_empty() {
            let refuse = |(found, expected): (String, String)| {
                let place = if at == 0 {
                    String::new()
                } else {
                    format!(", at byte {at}")
                };
                Fault::of_file(path, format!("{found}{place}"), expected)
            };
            let mut start = Vec::with_capacity(LONGEST);
            source.seek(SeekFrom::Start(at)).map_err(failed)?;
            let header = source.by_ref().take(LONGEST as u64).read_to_end(&mut start);
            header.map_err(failed)?;
            let block = Block::parse(&start).map_err(refuse)?;

            // The sizes in a header are compared with what there is.
            let begin = at + block.header;
            let rest = length.saturating_sub(begin);
            if block.packed > rest {
                let found = format!(
                    "{} of {} bytes where {rest} are left",
                    block.name, block.packed
                );
                return Err(refuse((found, "an archive that is whole".to_owned())));
            }
            if files.len() >= MOST_FILES {
                let found = format!("more than {MOST_FILES} files");
                return Err(refuse((found, "fewer".to_owned())));
            }
            at = begin + block.packed;
            files.push((begin, block));
        }
        Ok(Self {
            source,
            path: path.to_path_buf(),
            files,
            left: MOST_BYTES,
        })
    }

    /// The names of its files, in their order.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.files.iter().map(|(_, block)| block.name.as_str())
    }

    /// The file of a number, from 0: how faults name it, and its bytes.
    ///
    /// # Errors
    /// A file that cannot be unpacked, is larger than 20 MB, or has not the length that its header states; more than 100 MB of all
    /// files.
    pub(crate) fn file(&mut self, number: usize) -> Result<(PathBuf, Vec<u8>), Fault> {
        let Some((begin, block)) = self.files.get(number).cloned() else {
            let found = format!("{} files", self.files.len());
            return Err(Fault::of_file(&self.path, found, "one more"));
        };
        let path = self.path.join(&block.name);
        let refuse = |found: String, expected: &str| Fault::of_file(&path, found, expected);
        let most = LARGEST.min(self.left);
        if block.packed > most || block.unpacked.is_some_and(|length| length > most) {
            let found = format!("a file larger than {} MB", most / 1_000_000);
            return Err(refuse(found, "a smaller one"));
        }
        let mut bytes = Vec::new();
        let read = self.source.seek(SeekFrom::Start(begin)).and_then(|_| {
            let part = self.source.by_ref().take(block.packed);
            { part }.read_to_end(&mut bytes)
        });
        read.map_err(|error| refuse(error.to_string(), READABLE))?;
        if block.compressed {
            let most = usize::try_from(most).unwrap_or(usize::MAX);
            let text = unpacked(&bytes, most);
            bytes = text.map_err(|(found, expected)| refuse(found, &expected))?;
        }
        let length = bytes.len() as u64;
        if let Some(stated) = block.unpacked.filter(|stated| *stated != length) {
            let expected = format!("{stated} bytes, as its header states");
            return Err(refuse(format!("{length} bytes"), &expected));
        }
        self.left -= length;
        Ok((path, bytes))
    }
}

/// What an archive should be.
pub(crate) const READABLE: &str = "a readable archive of OpticStudio (.zar)";
