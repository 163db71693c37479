//! The images of a FITS file, found without their data and read one by one.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;
use crate::file::fits::fits_header::{BLOCK, Header};

/// The most headers of a file.
const MOST_PARTS: usize = 1000;

/// A FITS file that is open to be read.
#[derive(Debug)]
pub(crate) struct Fits {
    path: PathBuf,
    file: BufReader<File>,
    /// Headers of all parts and where their data begin.
    pub(crate) parts: Vec<Part>,
}

/// A header and where its data are.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    /// The header.
    pub(crate) header: Header,
    /// Byte at which the data begin.
    data: u64,
}

impl Part {
    /// Whether the data are an image: the first part, or an extension of this kind.
    pub(crate) fn is_image(&self) -> bool {
        matches!(self.header.text("XTENSION"), None | Some("IMAGE"))
    }

    /// The name of an extension; none for the first part, as a rule.
    pub(crate) fn name(&self) -> &str {
        self.header.text("EXTNAME").unwrap_or_default()
    }
}

impl Fits {
    /// Opens a file and reads its headers. Each must have its data within the file.
    ///
    /// # Errors
    /// A file that cannot be read, that is no FITS file, or that ends too soon.
    pub(crate) fn open(path: &Path) -> Result<Self, Fault> {
        let file = regular_file::open(path)
            .map_err(|found| Fault::of_file(path, found, "a FITS file that can be read"))?;
        let length = file.metadata().map_or(0, |metadata| metadata.len());
        let mut fits = Self {
            path: path.to_path_buf(),
            file: BufReader::new(file),
            parts: Vec::new(),
        };
        let parts = headers(&mut fits.file, length);
        fits.parts = parts.map_err(|(found, expected)| Fault::of_file(path, found, expected))?;
        Ok(fits)
    }

    /// The numbers of an image as they are meant: BZERO + BSCALE times what is stored. BLANK becomes NaN.
    ///
    /// # Errors
    /// More numbers than the limit on memory allows, or an error of the file system.
    pub(crate) fn numbers(&mut self, part: &Part, limit: MemoryLimit) -> Result<Vec<f64>, Fault> {
        let path = self.path.clone();
        let refuse = |(found, expected): (String, String)| Fault::of_file(&path, found, expected);
        let header = &part.header;
        let bits = header.bits().map_err(refuse)?;
        let bytes = header.data_bytes().map_err(refuse)?;
        let width = bits.unsigned_abs() / 8;
        let count = bytes / width;
        let taken = count.saturating_mul(8).saturating_add(bytes);
        limit
            .check(format!("{count} numbers"), taken)
            .map_err(refuse)?;
        let scale = Scale::of(header).map_err(refuse)?;

        // Blocks of whole numbers of each width; the length of the file was checked before.
        let broken = |error: std::io::Error| refuse((error.to_string(), String::from("data")));
        self.file.seek(SeekFrom::Start(part.data)).map_err(broken)?;
        let mut numbers = Vec::with_capacity(count as usize);
        let mut left = bytes;
        let mut block = Vec::new();
        while left > 0 {
            let now = left.min(BLOCK * 64);
            block.clear();
            let got = self.file.by_ref().take(now).read_to_end(&mut block);
            if got.map_err(broken)? as u64 != now {
                let found = format!("{left} bytes too few");
                return Err(refuse((found, format!("{bytes} bytes of data"))));
            }
            scale.extend(&mut numbers, &block, bits);
            left -= now;
        }
        Ok(numbers)
    }
}

/// What stored numbers mean.
struct Scale {
    zero: f64,
    factor: f64,
    blank: Option<i64>,
}

impl Scale {
    fn of(header: &Header) -> Result<Self, (String, String)> {
        Ok(Self {
            zero: header.number("BZERO")?.unwrap_or(0.0),
            factor: header.number("BSCALE")?.unwrap_or(1.0),
            blank: header.whole("BLANK")?,
        })
    }

    /// Adds the numbers of some bytes.
    fn extend(&self, numbers: &mut Vec<f64>, bytes: &[u8], bits: i64) {
        let whole = |stored: i64| match self.blank {
            Some(blank) if blank == stored => f64::NAN,
            _ => self.zero + self.factor * stored as f64,
        };
        let real = |stored: f64| match (self.zero, self.factor) {
            (0.0, 1.0) => stored,
            (zero, factor) => zero + factor * stored,
        };
        match bits {
            8 => numbers.extend(bytes.iter().map(|b| whole((*b).into()))),
            16 => numbers.extend(of(bytes).map(|b| whole(i16::from_be_bytes(b).into()))),
            32 => numbers.extend(of(bytes).map(|b| whole(i32::from_be_bytes(b).into()))),
            64 => numbers.extend(of(bytes).map(|b| whole(i64::from_be_bytes(b)))),
            -32 => numbers.extend(of(bytes).map(|b| real(f32::from_be_bytes(b).into()))),
            _ => numbers.extend(of(bytes).map(|b| real(f64::from_be_bytes(b)))),
        }
    }
}

/// The bytes of numbers of one width.
fn of<const N: usize>(bytes: &[u8]) -> impl Iterator<Item = [u8; N]> {
    bytes.as_chunks::<N>().0.iter().copied()
}

/// The headers of a file of this length, as (found, expected) where it is none.
fn headers(file: &mut BufReader<File>, length: u64) -> Result<Vec<Part>, (String, String)> {
    let fits = || String::from("a FITS file");
    let mut parts = Vec::new();
    let mut at = 0;
    while at < length {
        if parts.len() >= MOST_PARTS {
            return Err((format!("more than {MOST_PARTS} headers"), fits()));
        }
        let sought = file.seek(SeekFrom::Start(at));
        sought.map_err(|error| (error.to_string(), fits()))?;

        // Each header begins with a keyword that says so.
        let mut start = Vec::new();
        let got = file.by_ref().take(9).read_to_end(&mut start);
        got.map_err(|error| (error.to_string(), fits()))?;
        let expected: &[u8] = if at == 0 { b"SIMPLE  =" } else { b"XTENSION=" };
        if start != expected {
            let found = String::from_utf8_lossy(&start).into_owned();
            return Err((
                format!("`{}` at byte {at}", found.escape_debug()),
                format!("a FITS file: `{}` there", String::from_utf8_lossy(expected)),
            ));
        }
        file.seek_relative(-(start.len() as i64))
            .map_err(|error| (error.to_string(), fits()))?;
        let header = Header::read(file).map_err(|found| (found, fits()))?;
        let bytes = header.data_bytes()?;
        let data = at + header.bytes;
        if bytes > length.saturating_sub(data) {
            return Err((
                format!("{} bytes behind byte {data}", length.saturating_sub(data)),
                format!("{bytes} bytes of data as the header says"),
            ));
        }
        at = data + bytes.div_ceil(BLOCK) * BLOCK;
        parts.push(Part { header, data });
    }
    match parts.is_empty() {
        true => Err((String::from("an empty file"), fits())),
        false => Ok(parts),
    }
}
