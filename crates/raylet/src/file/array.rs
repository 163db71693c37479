//! One 2-D array of a NumPy file (.npy, .npz).
//!
//! The header is read before the data, so that kind, shape and size can be refused in plain words before
//! any memory is taken.

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::Path;

use ndarray::{Array2, ArrayD, ArrayView2, Ix2};
use ndarray_npy::{ReadNpyError, ReadNpyExt, ReadableElement};
use num_complex::{Complex32, Complex64};

use crate::file::fault::Fault;

/// A 2-D array indexed [y, x]; every value is finite.
#[derive(Clone, Debug, PartialEq)]
pub enum Array {
    /// From float32, float64, any integer or bool.
    Real(Array2<f64>),
    /// From complex64 or complex128.
    Complex(Array2<Complex64>),
}

/// What the header of a NumPy array says.
struct Header {
    /// NumPy's name of the element type, without byte order, such as "f8".
    kind: String,
    shape: Vec<usize>,
}

/// A 2-D array indexed [y, x] that somebody else holds. Values need not be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArrayLook<'a> {
    /// Real numbers.
    Real(ArrayView2<'a, f64>),
    /// Complex numbers.
    Complex(ArrayView2<'a, Complex64>),
}

impl<'a> ArrayLook<'a> {
    /// The same for a shorter while.
    pub fn shorter<'b>(self) -> ArrayLook<'b>
    where
        'a: 'b,
    {
        match self {
            ArrayLook::Real(values) => ArrayLook::Real(values.reborrow()),
            ArrayLook::Complex(values) => ArrayLook::Complex(values.reborrow()),
        }
    }

    /// Rows and columns: [ny, nx].
    pub fn shape(&self) -> [usize; 2] {
        match self {
            ArrayLook::Real(values) => [values.nrows(), values.ncols()],
            ArrayLook::Complex(values) => [values.nrows(), values.ncols()],
        }
    }

    /// Tells the first value that is not finite, or that there is none at all.
    pub(crate) fn check(&self) -> Result<(), String> {
        if self.shape().contains(&0) {
            return Err(String::from("an empty array"));
        }
        let bad = match self {
            ArrayLook::Real(values) => values
                .indexed_iter()
                .find(|(_, x)| !x.is_finite())
                .map(|(at, x)| (at, x.to_string())),
            ArrayLook::Complex(values) => values
                .indexed_iter()
                .find(|(_, z)| !z.is_finite())
                .map(|(at, z)| (at, z.to_string())),
        };
        match bad {
            Some(((y, x), value)) => Err(format!("{value} at [{y}, {x}]")),
            None => Ok(()),
        }
    }
}

impl Array {
    /// The values, for a while.
    pub fn look(&self) -> ArrayLook<'_> {
        match self {
            Array::Real(values) => ArrayLook::Real(values.view()),
            Array::Complex(values) => ArrayLook::Complex(values.view()),
        }
    }

    /// Rows and columns: [ny, nx].
    pub fn shape(&self) -> [usize; 2] {
        match self {
            Array::Real(values) => [values.nrows(), values.ncols()],
            Array::Complex(values) => [values.nrows(), values.ncols()],
        }
    }

    /// The memory it takes, in bytes.
    pub fn bytes(&self) -> u64 {
        match self {
            Array::Real(values) => values.len() as u64 * 8,
            Array::Complex(values) => values.len() as u64 * 16,
        }
    }

    /// Reads a .npy file, or one array of a .npz file: the one named `key`, or else the one named
    /// `usual`, or else the only one. Takes at most `limit` bytes for the array.
    ///
    /// # Errors
    /// A file that cannot be read, another format, no such array, an array that is not 2-D, is empty, has
    /// elements that are no numbers, is larger than the limit, cut short, or not finite.
    pub fn read(path: &Path, key: Option<&str>, usual: &str, limit: u64) -> Result<Self, Fault> {
        if path.file_name().is_none() {
            return Err(Fault::of_file(path, "no file name", "a .npy or .npz file"));
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        let file = File::open(path)
            .map_err(|error| Fault::of_file(path, error.to_string(), "a readable array file"))?;
        match extension.to_ascii_lowercase().as_str() {
            "npy" => match key {
                Some(key) => Err(Fault::of_file(
                    path,
                    format!("the key `{key}` for a .npy file"),
                    "no key: such a file holds one array",
                )),
                None => read_array(io::BufReader::new(file), path, limit),
            },
            "npz" => read_member(file, path, key, usual, limit),
            _ => Err(Fault::of_file(
                path,
                format!("a file of type `{extension}`"),
                "a .npy or .npz file",
            )),
        }
    }
}

/// One array of a .npz file, which is a zip archive of .npy files.
fn read_member(
    file: File,
    path: &Path,
    key: Option<&str>,
    usual: &str,
    limit: u64,
) -> Result<Array, Fault> {
    let broken = |error: zip::result::ZipError| {
        Fault::of_file(path, error.to_string(), "an archive made by numpy.savez")
    };
    let mut archive = zip::ZipArchive::new(io::BufReader::new(file)).map_err(broken)?;
    let names: Vec<String> = archive
        .file_names()
        .map(|name| name.trim_end_matches(".npy").to_owned())
        .collect();

    // Choose the array by name; without a name there must be no doubt.
    let has = |wanted: &str| names.iter().any(|name| name == wanted);
    let known = format!("one of its arrays: {}", names.join(", "));
    let chosen = match (key, names.as_slice()) {
        (Some(key), _) if has(key) => key,
        (Some(key), _) => {
            return Err(Fault::of_file(path, format!("no array `{key}`"), known));
        }
        (None, _) if has(usual) => usual,
        (None, [only]) => only.as_str(),
        (None, _) => {
            return Err(Fault::of_file(path, "no `key` to choose an array", known));
        }
    };
    let member = archive.by_name(&format!("{chosen}.npy")).map_err(broken)?;
    read_array(member, path, limit)
}

/// A .npy stream.
fn read_array(mut stream: impl Read, path: &Path, limit: u64) -> Result<Array, Fault> {
    let mut head = Vec::new();
    let header = read_header(&mut stream, &mut head)
        .map_err(|found| Fault::of_file(path, found, "a NumPy array as numpy.save writes it"))?;
    check_header(&header, limit)
        .map_err(|(found, expected)| Fault::of_file(path, found, expected))?;

    // The stream is given on with the header in front again.
    let whole = Cursor::new(head).chain(stream);
    let array = match header.kind.as_str() {
        "c8" => complex::<Complex32>(whole, |z| Complex64::new(z.re.into(), z.im.into())),
        "c16" => complex::<Complex64>(whole, |z| z),
        "f8" => real::<f64>(whole, |x| x),
        "f4" => real::<f32>(whole, f64::from),
        "i1" => real::<i8>(whole, f64::from),
        "i2" => real::<i16>(whole, f64::from),
        "i4" => real::<i32>(whole, f64::from),
        "i8" => real::<i64>(whole, |x| x as f64),
        "u1" => real::<u8>(whole, f64::from),
        "u2" => real::<u16>(whole, f64::from),
        "u4" => real::<u32>(whole, f64::from),
        "u8" => real::<u64>(whole, |x| x as f64),
        _ => real::<bool>(whole, |open| f64::from(u8::from(open))),
    };
    let array = array.map_err(|error| {
        Fault::of_file(path, error.to_string(), "all the data its header promises")
    })?;
    array
        .look()
        .check()
        .map_err(|found| Fault::of_file(path, found, "finite values only"))?;
    Ok(array)
}

/// Reads the data of a real array.
fn real<T: ReadableElement + Copy>(
    stream: impl Read,
    number: impl Fn(T) -> f64,
) -> Result<Array, ReadNpyError> {
    Ok(Array::Real(
        flat(ArrayD::<T>::read_npy(stream)?)?.mapv(number),
    ))
}

/// Reads the data of a complex array.
fn complex<T: ReadableElement + Copy>(
    stream: impl Read,
    number: impl Fn(T) -> Complex64,
) -> Result<Array, ReadNpyError> {
    Ok(Array::Complex(
        flat(ArrayD::<T>::read_npy(stream)?)?.mapv(number),
    ))
}

/// The array with two axes and rows in memory order, whatever order the file had.
fn flat<T: Copy>(array: ArrayD<T>) -> Result<Array2<T>, ReadNpyError> {
    let axes = array.ndim();
    let array = array
        .into_dimensionality::<Ix2>()
        .map_err(|_| ReadNpyError::WrongNdim(Some(2), axes))?;
    Ok(array.as_standard_layout().into_owned())
}

/// Reads magic, version and header text into `head` and tells what they say.
fn read_header(stream: &mut impl Read, head: &mut Vec<u8>) -> Result<Header, String> {
    let mut take = |count: usize, head: &mut Vec<u8>| -> Result<(), String> {
        let got = stream.take(count as u64).read_to_end(head);
        match got {
            Ok(got) if got == count => Ok(()),
            Ok(_) => Err("a file that ends within its header".to_owned()),
            Err(error) => Err(error.to_string()),
        }
    };
    take(8, head)?;
    if &head[..6] != b"\x93NUMPY" {
        return Err("a file without NumPy's mark at its start".to_owned());
    }

    // The length of the header has 2 bytes in version 1 and 4 bytes later.
    let width = if head[6] == 1 { 2 } else { 4 };
    take(width, head)?;
    let length = head[8..]
        .iter()
        .rev()
        .fold(0, |n, &b| n * 256 + usize::from(b));
    if length > 65_536 {
        return Err(format!("a header of {length} bytes"));
    }
    take(length, head)?;
    let text = String::from_utf8_lossy(&head[8 + width..]);
    parse_header(&text).ok_or_else(|| format!("the header {}", text.trim()))
}

/// The element type and shape of a header such as
/// `{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }`.
fn parse_header(text: &str) -> Option<Header> {
    let after = |key: &str| text.split_once(key).map(|(_, rest)| rest.trim_start());
    let descr = after("'descr':")?;
    // A structured type is a list; it is told as it stands.
    let kind = match descr.strip_prefix('\'') {
        Some(rest) => rest
            .split('\'')
            .next()?
            .trim_start_matches(['<', '>', '|', '=']),
        None => "a structure",
    };
    let inside = after("'shape':")?.strip_prefix('(')?.split(')').next()?;
    let lengths = inside.split(',').map(str::trim).filter(|s| !s.is_empty());
    let shape = lengths
        .map(|length| length.trim_end_matches('L').parse().ok())
        .collect::<Option<Vec<usize>>>()?;
    Some(Header {
        kind: kind.to_owned(),
        shape,
    })
}

/// Refuses what cannot be a grid of numbers, as (found, expected).
fn check_header(header: &Header, limit: u64) -> Result<(), (String, String)> {
    let kinds = [
        "f8", "f4", "c16", "c8", "b1", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8",
    ];
    if !kinds.contains(&header.kind.as_str()) {
        return Err((
            format!("elements of NumPy type `{}`", header.kind),
            "float32, float64, complex64, complex128, integers or bool".to_owned(),
        ));
    }
    let (ny, nx) = match *header.shape.as_slice() {
        [ny, nx] if ny > 0 && nx > 0 => (ny as u64, nx as u64),
        [_, _] => return Err(("an empty array".to_owned(), "at least one pixel".to_owned())),
        _ => {
            return Err((
                format!(
                    "an array of {} axes, shape {:?}",
                    header.shape.len(),
                    header.shape
                ),
                "two axes: [y, x]".to_owned(),
            ));
        }
    };
    let each = if header.kind.starts_with('c') { 16 } else { 8 };
    let bytes = ny.saturating_mul(nx).saturating_mul(each);
    if bytes > limit {
        return Err((
            format!(
                "{ny} x {nx} values that take {} MB",
                bytes.div_ceil(1_000_000)
            ),
            format!(
                "at most {} MB (settings.memory_limit_mb)",
                limit / 1_000_000
            ),
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use ndarray::{Array1, Array2, ShapeBuilder, array};
    use ndarray_npy::{NpzWriter, write_npy};
    use num_complex::{Complex32, Complex64};

    use crate::file::array::Array;

    const LIMIT: u64 = 1 << 20;

    fn folder() -> tempfile::TempDir {
        tempfile::tempdir().expect("a temporary folder")
    }

    fn refusal(path: &Path, key: Option<&str>, limit: u64) -> String {
        match Array::read(path, key, "phase", limit) {
            Ok(array) => panic!("{} was read: {array:?}", path.display()),
            Err(fault) => fault.to_string(),
        }
    }

    fn npz(folder: &Path, names: &[&str]) -> PathBuf {
        let path = folder.join("several.npz");
        let file = std::fs::File::create(&path).expect("a file");
        let mut writer = NpzWriter::new_compressed(file);
        for (i, name) in names.iter().enumerate() {
            let values = Array2::from_elem((1, 2), i as f64);
            writer.add_array(*name, &values).expect("an array");
        }
        writer.finish().expect("an archive");
        path
    }

    #[test]
    fn every_kind_is_read() {
        let folder = folder();
        let path = folder.path().join("a.npy");
        let expected = Array::Real(array![[0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]);
        macro_rules! check {
            ($convert:expr) => {
                let values = array![[0u8, 1], [1, 0], [1, 1]].mapv($convert);
                write_npy(&path, &values).expect("written");
                assert_eq!(
                    Array::read(&path, None, "phase", LIMIT),
                    Ok(expected.clone())
                );
            };
        }
        check!(f64::from);
        check!(f32::from);
        check!(i64::from);
        check!(i32::from);
        check!(i16::from);
        check!(u16::from);
        check!(u64::from);
        check!(|x| x as i8);
        check!(|x| x != 0);
    }

    #[test]
    fn complex_and_column_order_are_read() {
        let folder = folder();
        let path = folder.path().join("a.npy");
        let double = array![[Complex64::new(1.0, 2.0), Complex64::new(-0.5, 0.25)]];
        let single = double.mapv(|z| Complex32::new(z.re as f32, z.im as f32));
        for written in [write_npy(&path, &double), write_npy(&path, &single)] {
            written.expect("written");
            let read = Array::read(&path, None, "phase", LIMIT);
            assert_eq!(read, Ok(Array::Complex(double.clone())));
        }
        let columns = Array2::from_shape_fn((3, 2).f(), |(y, x)| (10 * y + x) as f64);
        write_npy(&path, &columns).expect("written");
        match Array::read(&path, None, "phase", LIMIT) {
            Ok(Array::Real(values)) => {
                assert!(values.is_standard_layout());
                assert_eq!(values[[2, 1]], 21.0);
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn archives_are_searched_by_name() {
        let folder = folder();
        let path = npz(folder.path(), &["amplitude", "phase"]);
        let first = |key| match Array::read(&path, key, "phase", LIMIT) {
            Ok(Array::Real(values)) => values[[0, 0]],
            other => panic!("{other:?}"),
        };
        assert_eq!((first(None), first(Some("amplitude"))), (1.0, 0.0));
        let fault = refusal(&path, Some("phse"), LIMIT);
        assert!(
            fault.contains("no array `phse`") && fault.contains("amplitude"),
            "{fault}"
        );
        npz(folder.path(), &["only"]);
        assert_eq!(first(None), 0.0);
        npz(folder.path(), &["one", "two"]);
        assert!(refusal(&path, None, LIMIT).contains("no `key`"));
    }

    #[test]
    fn refusals_are_plain() {
        let folder = folder();
        let path = folder.path().join("a.npy");
        let told = |words: &str, limit| {
            let fault = refusal(&path, None, limit);
            assert!(fault.contains(words), "{fault}");
        };
        told("No such file", LIMIT);
        std::fs::write(&path, b"PK\x03\x04 not an array").expect("written");
        told("without NumPy's mark", LIMIT);
        std::fs::write(&path, b"\x93NUMPY\x01\x00").expect("written");
        told("ends within its header", LIMIT);
        write_npy(&path, &Array1::from(vec![1.0, 2.0])).expect("written");
        told("an array of 1 axes, shape [2]", LIMIT);
        write_npy(&path, &Array2::<f64>::zeros((0, 3))).expect("written");
        told("an empty array", LIMIT);
        write_npy(&path, &array![[0.0, 1.0], [f64::NAN, 2.0]]).expect("written");
        told("NaN at [1, 0]", LIMIT);
        write_npy(&path, &array![[Complex64::new(0.0, f64::INFINITY)]]).expect("written");
        told("at [0, 0]", LIMIT);
        write_npy(&path, &Array2::<f32>::zeros((1000, 1000))).expect("written");
        told("1000 x 1000 values that take 8 MB", 7_999_999);
        let bytes = std::fs::read(&path).expect("read");
        std::fs::write(&path, &bytes[..bytes.len() - 4]).expect("written");
        told("all the data its header promises", 8_000_000);
        let half = String::from_utf8_lossy(&bytes[..128]).replace("<f4", "<f2");
        assert!(half.contains("<f2"));
        std::fs::write(
            &path,
            [b"\x93", &bytes[1..10], &half.as_bytes()[12..]].concat(),
        )
        .expect("written");
        told("elements of NumPy type `f2`", LIMIT);
    }
}
