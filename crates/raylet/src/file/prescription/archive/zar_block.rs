//! Blocks of an archive of OpticStudio (.zar): a header of fixed length, then the bytes of one file, until the archive ends.
//!
//! | version | header | name | packed length | unpacked length |
//! | --- | --- | --- | --- | --- |
//! | 1002 | 332 bytes | at 32, one byte a character | at 12, 32 bits | |
//! | 1004 | 648 bytes | at 48, UTF-16 | at 16, 64 bits | at 24, 64 bits |
//!
//! The version is the first whole number of 32 bits; all numbers are little-endian. A name that ends with `.LZW` is that of a
//! compressed file. The maker does not describe the format: the layout was found by others, and in public archives.

use crate::file::decode::fault::shortened;

/// Bytes of the header in version 1002.
const EARLIER: usize = 332;

/// Bytes of the header in version 1004.
pub(crate) const LONGEST: usize = 648;

/// The ending of the names of compressed files.
const COMPRESSED: &str = ".LZW";

/// What a header says of its file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Block {
    /// The name of the file, without folders and without the ending of compressed files.
    pub name: String,
    /// Whether its bytes are compressed.
    pub compressed: bool,
    /// Bytes of the header.
    pub header: u64,
    /// Bytes of the file in the archive.
    pub packed: u64,
    /// Bytes of the file itself, where the header states them.
    pub unpacked: Option<u64>,
}

/// What was found and what was expected.
type Refusal = (String, String);

impl Block {
    /// The block that begins with these bytes, which are fewer than the longest header only at the end of the archive.
    ///
    /// # Errors
    /// Bytes that are no header.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, Refusal> {
        let version = whole(bytes, 0, 4);
        let header = match version {
            Some(1002) => EARLIER,
            Some(1004) => LONGEST,
            _ => return Err(no_header(bytes)),
        };
        let Some(bytes) = bytes.get(..header) else {
            let found = format!("a header of {} bytes", bytes.len());
            return Err((found, format!("{header} bytes, as the version has them")));
        };
        let (name, packed, unpacked) = if header == EARLIER {
            let name = bytes.get(32..).unwrap_or_default().iter();
            let name = name
                .map(|byte| char::from(*byte))
                .take_while(|c| *c != '\0');
            (name.collect(), whole(bytes, 12, 4), None)
        } else {
            let pairs = bytes.get(48..).unwrap_or_default().as_chunks().0.iter();
            let units: Vec<u16> = pairs
                .map(|pair| u16::from_le_bytes(*pair))
                .take_while(|unit| *unit != 0)
                .collect();
            let name = String::from_utf16_lossy(&units);
            (name, whole(bytes, 16, 8), whole(bytes, 24, 8))
        };
        let (name, compressed) = plain_name(&name);
        if name.is_empty() {
            let found = "a file without a name".to_owned();
            return Err((found, "its name in the header".to_owned()));
        }
        Ok(Self {
            name,
            compressed,
            header: header as u64,
            packed: packed.unwrap_or(0),
            unpacked,
        })
    }
}

/// The little-endian number of so many bytes, at most 8, at a place.
fn whole(bytes: &[u8], at: usize, count: usize) -> Option<u64> {
    let part = bytes.get(at..at + count)?;
    Some(
        part.iter()
            .rev()
            .fold(0, |sum, byte| sum << 8 | u64::from(*byte)),
    )
}

/// What stands where a header should.
fn no_header(bytes: &[u8]) -> Refusal {
    let start = bytes.trim_ascii_start();
    let found = match start {
        // Shops that ask for a login send a page in place of the file.
        [b'<', ..] => "a web page (HTML)".to_owned(),
        [b'P', b'K', 3, 4, ..] => "a ZIP file".to_owned(),
        _ => match whole(bytes, 0, 4) {
            Some(version) => format!("a header of version {version}"),
            None => format!("{} bytes", bytes.len()),
        },
    };
    let expected = "an archive of OpticStudio, with headers of version 1002 or 1004";
    (found, expected.to_owned())
}

/// A name without folders, without characters that do not print, and without the ending of compressed files; whether it had that.
fn plain_name(name: &str) -> (String, bool) {
    let last = name.rsplit(['/', '\\', ':']).next().unwrap_or_default();
    let printed: String = last
        .chars()
        .map(|c| if c.is_control() { '\u{fffd}' } else { c })
        .collect();
    let end = printed.len().saturating_sub(COMPRESSED.len());
    match printed.split_at_checked(end) {
        Some((stem, end)) if end.eq_ignore_ascii_case(COMPRESSED) => (shortened(stem), true),
        _ => (shortened(&printed), false),
    }
}
