//! The arrays of an HDF5 file, read within a limit on memory.

use std::io::Read;
use std::path::{Path, PathBuf};

use hdf5_pure::{CompoundMember, DType, Dataset, Datatype, DatatypeByteOrder, Error, File};
use num_complex::Complex64;

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;

/// The most bytes that a byte of a file can become where it is packed.
const MOST_UNPACKED: u64 = 2000;

/// Bytes that a chunk may have, however small the array is.
const LARGEST_CHUNK: u64 = 16 << 20;

/// The most axes of an array.
const MOST_AXES: usize = 32;

/// The attributes that name a unit.
const UNITS: [&str; 2] = ["units", "unit"];

/// An HDF5 file that is open to be read.
pub(crate) struct Hdf5 {
    path: PathBuf,
    length: u64,
    /// What is left of the memory beside the file.
    limit: MemoryLimit,
    file: File,
}

/// An array as it is stored.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stored {
    /// Lengths of the axes; the last one runs fastest.
    pub(crate) shape: Vec<usize>,
    /// The numbers.
    pub(crate) numbers: Numbers,
    /// The unit, where an attribute names one.
    pub(crate) unit: Option<String>,
}

/// Numbers of an array.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Numbers {
    /// Real ones, from any of the usual types.
    Real(Vec<f64>),
    /// Complex ones, from pairs with the names that h5py and MATLAB use.
    Complex(Vec<Complex64>),
}

impl Hdf5 {
    /// Opens a file. It is held as a whole, so that lengths in it cannot take more memory than it has itself.
    ///
    /// # Errors
    /// A file that cannot be read, that does not fit into the limit, or that is no HDF5 file.
    pub(crate) fn open(path: &Path, limit: MemoryLimit) -> Result<Self, Fault> {
        let refuse = |found: String| Fault::of_file(path, found, "an HDF5 file that can be read");
        let file = regular_file::open(path).map_err(refuse)?;
        let length = file.metadata().map_or(0, |metadata| metadata.len());
        limit
            .check("a file", length)
            .map_err(|(found, expected)| Fault::of_file(path, found, expected))?;
        let mut bytes = Vec::with_capacity(length as usize);
        let got = file.take(length).read_to_end(&mut bytes);
        got.map_err(|error| refuse(error.to_string()))?;
        let file = File::from_bytes(bytes).map_err(|error| refuse(error.to_string()))?;
        Ok(Self {
            path: path.to_path_buf(),
            length,
            limit: limit.without(length),
            file,
        })
    }

    /// The names of the arrays that are not in a group.
    ///
    /// # Errors
    /// A damaged file.
    pub(crate) fn names(&self) -> Result<Vec<String>, Fault> {
        let names = self.file.root().datasets();
        let mut names = names.map_err(|error| self.refuse("the names of its arrays", &error))?;
        names.sort();
        Ok(names)
    }

    /// The lengths of the axes of an array; the last one runs fastest.
    ///
    /// # Errors
    /// No such array, or a damaged file.
    pub(crate) fn shape(&self, name: &str) -> Result<Vec<usize>, Fault> {
        let array = self.array(name)?;
        self.shape_of(name, &array)
    }

    /// Reads an array; in groups it has a name such as `measurement/height`.
    ///
    /// # Errors
    /// No such array, one of other things than numbers, one that does not fit into the limit, or a damaged file.
    pub(crate) fn read(&self, name: &str) -> Result<Stored, Fault> {
        let broken = |error: Error| self.refuse(name, &error);
        let array = self.array(name)?;
        let shape = self.shape_of(name, &array)?;
        let kind = array.datatype().map_err(broken)?;

        // The size is known before memory is taken. Packed data cannot become any number of bytes.
        let count = shape
            .iter()
            .fold(1, |n: u64, length| n.saturating_mul(*length as u64));
        let stored = count.saturating_mul(array.element_size().map_err(broken)?);
        if stored > self.length.saturating_mul(MOST_UNPACKED) {
            let found = format!("`{name}` of {stored} bytes in a file of {}", self.length);
            return Err(Fault::of_file(
                &self.path,
                found,
                "no more than it can hold",
            ));
        }
        let kept = count.saturating_mul(16);
        self.check_chunks(name, &array, stored)?;
        self.limit
            .check(format!("`{name}`"), stored.saturating_add(kept))
            .map_err(|(found, expected)| Fault::of_file(&self.path, found, expected))?;
        let numbers = match parts(&kind) {
            Some([re, im]) => {
                let bytes = array.read_raw().map_err(broken)?;
                Numbers::Complex(pairs(&bytes, kind.type_size() as usize, [re, im]))
            }
            None if is_real(&array.dtype().map_err(broken)?) => {
                Numbers::Real(array.read_f64().map_err(broken)?)
            }
            None => {
                let found = format!("`{name}` of another type than numbers");
                let expected = "real numbers, or pairs (r, i) of them";
                return Err(Fault::of_file(&self.path, found, expected));
            }
        };
        let got = match &numbers {
            Numbers::Real(numbers) => numbers.len(),
            Numbers::Complex(numbers) => numbers.len(),
        };
        if got as u64 != count {
            let found = format!("`{name}` with {got} numbers");
            return Err(Fault::of_file(&self.path, found, format!("{count}")));
        }
        let attributes = array.attrs().map_err(broken)?;
        let unit = UNITS
            .iter()
            .find_map(|unit| attributes.get(*unit)?.as_str().map(str::to_owned));
        Ok(Stored {
            shape,
            numbers,
            unit,
        })
    }

    /// Refuses chunks that are much larger than the array: each one is unpacked as a whole.
    fn check_chunks(&self, name: &str, array: &Dataset, stored: u64) -> Result<(), Fault> {
        let broken = |error: Error| self.refuse(name, &error);
        let Some(chunk) = array.chunk_shape().map_err(broken)? else {
            return Ok(());
        };
        let each = array.element_size().map_err(broken)?;
        let bytes = chunk
            .iter()
            .fold(each, |n, length| n.saturating_mul(*length));
        let most = LARGEST_CHUNK.max(stored.saturating_mul(2));
        if bytes <= most {
            return Ok(());
        }
        let found = format!("`{name}` in chunks of {bytes} bytes");
        Err(Fault::of_file(
            &self.path,
            found,
            format!("chunks of at most {most} bytes"),
        ))
    }

    fn array(&self, name: &str) -> Result<Dataset, Fault> {
        self.file.dataset(name).map_err(|error| {
            let names = self.names().unwrap_or_default().join(", ");
            let expected = format!("the name of an array; outside of groups there are: {names}");
            Fault::of_file(&self.path, format!("`{name}`: {error}"), expected)
        })
    }

    fn shape_of(&self, name: &str, array: &Dataset) -> Result<Vec<usize>, Fault> {
        let shape = array.shape().map_err(|error| self.refuse(name, &error))?;
        if shape.len() > MOST_AXES {
            let found = format!("`{name}` of {} axes", shape.len());
            return Err(Fault::of_file(
                &self.path,
                found,
                format!("at most {MOST_AXES}"),
            ));
        }
        let lengths = shape.iter().map(|length| usize::try_from(*length).ok());
        lengths.collect::<Option<_>>().ok_or_else(|| {
            let found = format!("`{name}` of shape {shape:?}");
            Fault::of_file(&self.path, found, "lengths that this machine can count")
        })
    }

    fn refuse(&self, what: &str, error: &Error) -> Fault {
        let expected = "an HDF5 file that is whole";
        Fault::of_file(&self.path, format!("{what}: {error}"), expected)
    }
}

/// Whether numbers of a type become numbers of 64 bits.
fn is_real(kind: &DType) -> bool {
    matches!(
        kind,
        DType::F32
            | DType::F64
            | DType::I8
            | DType::I16
            | DType::I32
            | DType::I64
            | DType::U8
            | DType::U16
            | DType::U32
            | DType::U64
    )
}

/// A part of a complex number: where it begins, and how it is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
struct NumberPart {
    at: usize,
    wide: bool,
    big_endian: bool,
}

/// Real and imaginary part of a type with the names that h5py, MATLAB and others give them.
fn parts(kind: &Datatype) -> Option<[NumberPart; 2]> {
    let Datatype::Compound { members, .. } = kind else {
        return None;
    };
    let [re, im] = members.as_slice() else {
        return None;
    };
    let names = [re.name.as_str(), im.name.as_str()];
    let known = [["r", "i"], ["real", "imag"], ["re", "im"]];
    match known.contains(&names) {
        true => Some([part(re)?, part(im)?]),
        false => None,
    }
}

fn part(member: &CompoundMember) -> Option<NumberPart> {
    match &member.datatype {
        Datatype::FloatingPoint {
            size: size @ (4 | 8),
            byte_order: order @ (DatatypeByteOrder::LittleEndian | DatatypeByteOrder::BigEndian),
            ..
        } => Some(NumberPart {
            at: usize::try_from(member.byte_offset).ok()?,
            wide: *size == 8,
            big_endian: *order == DatatypeByteOrder::BigEndian,
        }),
        _ => None,
    }
}

impl NumberPart {
    /// The number in the bytes of an element.
    fn of(&self, element: &[u8]) -> f64 {
        let bytes = element.get(self.at..).unwrap_or_default();
        let wide = bytes.first_chunk::<8>().filter(|_| self.wide);
        match (wide, bytes.first_chunk::<4>()) {
            (Some(bytes), _) if self.big_endian => f64::from_be_bytes(*bytes),
            (Some(bytes), _) => f64::from_le_bytes(*bytes),
            (None, Some(bytes)) if self.big_endian => f32::from_be_bytes(*bytes).into(),
            (None, Some(bytes)) => f32::from_le_bytes(*bytes).into(),
            (None, None) => f64::NAN,
        }
    }
}

/// Complex numbers in elements of so many bytes.
fn pairs(bytes: &[u8], width: usize, [re, im]: [NumberPart; 2]) -> Vec<Complex64> {
    let elements = bytes.chunks_exact(width.max(1));
    elements
        .map(|element| Complex64::new(re.of(element), im.of(element)))
        .collect()
}
