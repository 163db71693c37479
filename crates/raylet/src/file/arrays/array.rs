//! One 2-D array of a NumPy file (.npy, .npz).

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use ndarray::{Array2, ArrayD, ArrayView2, Ix2};
use ndarray_npy::{ReadNpyError, ReadNpyExt, ReadableElement};
use num_complex::{Complex32, Complex64};

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npy_header::{Header, plain};
use crate::file::arrays::regular_file;
use crate::file::arrays::zip_archive::Archive;
use crate::file::decode::fault::Fault;
use crate::file::decode::quantity::Quantity;

/// A 2-D array indexed [y, x]; every value is finite.
#[derive(Clone, Debug, PartialEq)]
pub enum Array {
    /// From float32, float64, any integer or bool.
    Real(Array2<f64>),
    /// From complex64 or complex128.
    Complex(Array2<Complex64>),
}

/// A 2-D array indexed [y, x] that somebody else holds. Values need not be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BorrowedArray<'a> {
    /// Real numbers.
    Real(ArrayView2<'a, f64>),
    /// Complex numbers.
    Complex(ArrayView2<'a, Complex64>),
}

impl<'a> BorrowedArray<'a> {
    /// The same for a shorter while.
    pub(crate) fn shorter<'b>(self) -> BorrowedArray<'b>
    where
        'a: 'b,
    {
        match self {
            BorrowedArray::Real(values) => BorrowedArray::Real(values.reborrow()),
            BorrowedArray::Complex(values) => BorrowedArray::Complex(values.reborrow()),
        }
    }

    /// Rows and columns: [ny, nx].
    pub fn shape(&self) -> [usize; 2] {
        match self {
            BorrowedArray::Real(values) => [values.nrows(), values.ncols()],
            BorrowedArray::Complex(values) => [values.nrows(), values.ncols()],
        }
    }

    /// Refuses an empty array, and the first value that is not finite or exceeds the magnitude of what the key
    /// measures that holds the array, as (found, expected).
    pub(crate) fn check(&self, key: &str) -> Result<(), (String, String)> {
        if self.shape().contains(&0) {
            let found = String::from("an empty array");
            return Err((found, String::from("at least one value")));
        }
        let quantity = Quantity::of_key(key);
        let good = |x: f64| x.abs() <= quantity.largest;
        let bad = match self {
            BorrowedArray::Real(values) => values
                .indexed_iter()
                .find(|(_, x)| !good(**x))
                .map(|(at, x)| (at, x.to_string())),
            BorrowedArray::Complex(values) => values
                .indexed_iter()
                .find(|(_, z)| !(good(z.re) && good(z.im)))
                .map(|(at, z)| (at, z.to_string())),
        };
        match bad {
            Some(((y, x), value)) => Err((
                format!("{value} at [{y}, {x}]"),
                format!("finite values only, each {quantity}"),
            )),
            None => Ok(()),
        }
    }
}

impl Array {
    /// The values, for a while.
    pub(crate) fn borrowed(&self) -> BorrowedArray<'_> {
        match self {
            Array::Real(values) => BorrowedArray::Real(values.view()),
            Array::Complex(values) => BorrowedArray::Complex(values.view()),
        }
    }

    /// The memory it takes, in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Array::Real(values) => values.len() as u64 * 8,
            Array::Complex(values) => values.len() as u64 * 16,
        }
    }

    /// Reads a .npy file, or one array of a .npz file: the one named `key`, or else the one named `usual`, or else the only
    /// one. Takes at most `limit` bytes for the array.
    ///
    /// # Errors
    /// A file that cannot be read, another format, no such array, an array that is not 2-D, is empty, has
    /// elements that are no numbers, is larger than the limit, cut short, or not finite.
    pub(crate) fn read(
        path: &Path,
        key: Option<&str>,
        usual: &str,
        limit: u64,
    ) -> Result<Self, Fault> {
        if path.file_name().is_none() {
            return Err(Fault::of_file(path, "no file name", "a .npy or .npz file"));
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        let file = regular_file::open(path)
            .map_err(|found| Fault::of_file(path, found, "a readable array file"))?;
        let expected = Expected {
            path,
            field: usual,
            limit: MemoryLimit::of_settings(limit),
        };
        match extension.to_ascii_lowercase().as_str() {
            "npy" => match key {
                Some(key) => Err(Fault::of_file(
                    path,
                    format!("the key `{key}` for a .npy file"),
                    "no key: such a file holds one array",
                )),
                None => expected.array(io::BufReader::new(file)),
            },
            "npz" => expected.member(file, key),
            _ => Err(Fault::of_file(
                path,
                format!("a file of type `{extension}`"),
                "a .npy or .npz file",
            )),
        }
    }
}

/// The array that a file is to hold.
#[derive(Clone, Copy)]
struct Expected<'a> {
    path: &'a Path,
    /// The key of the scene that names the file.
    field: &'a str,
    limit: MemoryLimit,
}

impl Expected<'_> {
    /// One array of a .npz file, which is a zip archive of .npy files.
    fn member(&self, file: File, key: Option<&str>) -> Result<Array, Fault> {
        let broken =
            |found: String| Fault::of_file(self.path, found, "an archive made by numpy.savez");
        let archive = Archive::open(file).map_err(broken)?;
        let names: Vec<String> = archive
            .names()
            .map(|name| name.trim_end_matches(".npy").to_owned())
            .collect();

        // Choose the array by name; without a name there must be no doubt.
        let has = |key: &str| names.iter().any(|name| name == key);
        let known = format!("one of its arrays: {}", names.join(", "));
        let chosen = match (key, names.as_slice()) {
            (Some(key), _) if has(key) => key,
            (Some(key), _) => {
                return Err(Fault::of_file(
                    self.path,
                    format!("no array `{key}`"),
                    known,
                ));
            }
            (None, _) if has(self.field) => self.field,
            (None, [only]) => only.as_str(),
            (None, _) => {
                let found = "no `key` to choose an array";
                return Err(Fault::of_file(self.path, found, known));
            }
        };
        let member = archive.member(&format!("{chosen}.npy")).map_err(broken)?;
        self.array(member)
    }

    /// The array of a .npy stream.
    fn array(&self, mut stream: impl Read) -> Result<Array, Fault> {
        let refuse =
            |(found, expected): (String, String)| Fault::of_file(self.path, found, expected);
        let header = Header::read(&mut stream).map_err(|found| {
            Fault::of_file(self.path, found, "a NumPy array as numpy.save writes it")
        })?;
        check_header(&header, self.limit).map_err(refuse)?;
        let data = header.before(stream);
        let array = match header.kind() {
            "c8" => complex::<Complex32>(data, |z| Complex64::new(z.re.into(), z.im.into())),
            "c16" => whole::<Complex64>(data).map(Array::Complex),
            "f8" => whole::<f64>(data).map(Array::Real),
            "f4" => real::<f32>(data, f64::from),
            "i1" => real::<i8>(data, f64::from),
            "i2" => real::<i16>(data, f64::from),
            "i4" => real::<i32>(data, f64::from),
            "i8" => real::<i64>(data, |x| x as f64),
            "u1" => real::<u8>(data, f64::from),
            "u2" => real::<u16>(data, f64::from),
            "u4" => real::<u32>(data, f64::from),
            "u8" => real::<u64>(data, |x| x as f64),
            _ => real::<bool>(data, |open| f64::from(u8::from(open))),
        };
        let array = array.map_err(|error| {
            let expected = "all the data its header promises, and no more";
            Fault::of_file(self.path, plain(&error), expected)
        })?;
        array.borrowed().check(self.field).map_err(refuse)?;
        Ok(array)
    }
}

/// Reads the data of a real array.
fn real<T: ReadableElement + Copy>(
    stream: impl Read,
    number: impl Fn(T) -> f64,
) -> Result<Array, ReadNpyError> {
    Ok(Array::Real(whole::<T>(stream)?.mapv(number)))
}

/// Reads the data of a complex array.
fn complex<T: ReadableElement + Copy>(
    stream: impl Read,
    number: impl Fn(T) -> Complex64,
) -> Result<Array, ReadNpyError> {
    Ok(Array::Complex(whole::<T>(stream)?.mapv(number)))
}

/// The array with two axes and rows in memory order, whatever order the file had.
fn whole<T: ReadableElement + Copy>(stream: impl Read) -> Result<Array2<T>, ReadNpyError> {
    let array = ArrayD::<T>::read_npy(stream)?;
    let axes = array.ndim();
    let array = array
        .into_dimensionality::<Ix2>()
        .map_err(|_| ReadNpyError::WrongNdim(Some(2), axes))?;
    Ok(match array.is_standard_layout() {
        true => array,
        false => array.as_standard_layout().into_owned(),
    })
}

/// Refuses what cannot be a grid of numbers, as (found, expected).
fn check_header(header: &Header, limit: MemoryLimit) -> Result<(), (String, String)> {
    let kinds = [
        "f8", "f4", "c16", "c8", "b1", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8",
    ];
    if !kinds.contains(&header.kind()) {
        let kind: String = header.kind().chars().take(WIDEST_KIND).collect();
        return Err((
            format!("elements of NumPy type `{kind}`"),
            "float32, float64, complex64, complex128, integers or bool".to_owned(),
        ));
    }
    let (ny, nx) = match *header.shape.as_slice() {
        [ny, nx] if ny > 0 && nx > 0 => (ny, nx),
        [_, _] => return Err(("an empty array".to_owned(), "at least one pixel".to_owned())),
        _ => {
            let axes = header.shape.len();
            let shape: Vec<usize> = header.shape.iter().copied().take(MOST_AXES).collect();
            return Err((
                format!("an array of {axes} axes, shape {shape:?}"),
                "two axes: [y, x]".to_owned(),
            ));
        }
    };

    // What is kept, and what is converted into it.
    let each = if header.kind().starts_with('c') {
        16
    } else {
        8
    };
    let kept = header.count().saturating_mul(each);
    let converted = match header.data_bytes() {
        same if same == kept && !header.columns_first => 0,
        other => other,
    };
    let bytes = kept.saturating_add(converted);
    limit.check(format!("{ny} x {nx} values"), bytes)
}

/// How many characters of the name of a type, and lengths of axes, a message shows at most.
const WIDEST_KIND: usize = 40;
const MOST_AXES: usize = 20;

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::path::{Path, PathBuf};

    use ndarray::{Array1, Array2, ShapeBuilder, array};
    use ndarray_npy::{NpzWriter, write_npy};
    use num_complex::{Complex32, Complex64};

    use crate::file::arrays::array::Array;

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

    /// All kinds of elements that `check_header` lets through.
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
        check!(|x| x);
        check!(u16::from);
        check!(u32::from);
        check!(u64::from);
        check!(|x| x as i8);
        check!(|x| x != 0);

        // Two complex kinds, each read before the other takes its place.
        let read = || Array::read(&path, None, "phase", LIMIT);
        let complex = array![[Complex64::new(1.0, 2.0)], [Complex64::new(-0.5, 0.25)]];
        write_npy(&path, &complex).expect("written");
        assert_eq!(read(), Ok(Array::Complex(complex.clone())));
        let single = complex.mapv(|z| Complex32::new(z.re as f32, z.im as f32));
        write_npy(&path, &single).expect("written");
        assert_eq!(read(), Ok(Array::Complex(complex)));
    }

    #[test]
    fn column_order_is_read_into_rows() {
        let folder = folder();
        let path = folder.path().join("a.npy");
        let columns = Array2::from_shape_fn((3, 2).f(), |(y, x)| (10 * y + x) as f64);
        write_npy(&path, &columns).expect("written");
        let bytes = std::fs::read(&path).expect("read");
        assert!(String::from_utf8_lossy(&bytes).contains("'fortran_order': True"));
        match Array::read(&path, None, "phase", LIMIT) {
            Ok(Array::Real(values)) => {
                assert!(values.is_standard_layout());
                assert_eq!(values, columns);
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
        let refused = |words: &str, limit| {
            let fault = refusal(&path, None, limit);
            assert!(fault.contains(words), "{fault}");
        };
        refused("No such file", LIMIT);
        std::fs::write(&path, b"PK\x03\x04 not an array").expect("written");
        refused("without NumPy's mark", LIMIT);
        std::fs::write(&path, b"\x93NUMPY\x01\x00").expect("written");
        refused("ends within its header", LIMIT);
        write_npy(&path, &Array1::from(vec![1.0, 2.0])).expect("written");
        refused("an array of 1 axes, shape [2]", LIMIT);
        write_npy(&path, &Array2::<f64>::zeros((0, 3))).expect("written");
        refused("an empty array", LIMIT);
        write_npy(&path, &array![[0.0, 1.0], [f64::NAN, 2.0]]).expect("written");
        refused("NaN at [1, 0]", LIMIT);
        write_npy(&path, &array![[Complex64::new(0.0, f64::INFINITY)]]).expect("written");
        refused("at [0, 0]", LIMIT);
        write_npy(&path, &Array2::<f32>::zeros((1000, 1000))).expect("written");
        refused("1000 x 1000 values that take 12 MB", 11_999_999);
        let bytes = std::fs::read(&path).expect("read");
        std::fs::write(&path, &bytes[..bytes.len() - 4]).expect("written");
        refused("all the data its header promises", 12_000_000);
        let half = String::from_utf8_lossy(&bytes[..128]).replace("<f4", "<f2");
        assert!(half.contains("<f2"));
        std::fs::write(
            &path,
            [b"\x93", &bytes[1..10], &half.as_bytes()[12..]].concat(),
        )
        .expect("written");
        refused("elements of NumPy type `f2`", LIMIT);
    }

    /// An archive of 40 MB of zeros behind a header of four values; the reader once kept all that followed.
    #[test]
    fn compressed_data_behind_the_array_take_no_memory() {
        let folder = folder();
        let path = folder.path().join("bomb.npz");
        let mut writer = zip::ZipWriter::new(std::fs::File::create(&path).expect("a file"));
        let method = zip::CompressionMethod::Deflated;
        let options = zip::write::SimpleFileOptions::default().compression_method(method);
        writer.start_file("phase.npy", options).expect("a member");
        let mut head = Vec::new();
        let small = Array2::<f64>::zeros((2, 2));
        ndarray_npy::WriteNpyExt::write_npy(&small, &mut head).expect("a header");
        writer.write_all(&head).expect("written");
        for _ in 0..40 {
            writer.write_all(&[0; 1_000_000]).expect("written");
        }
        writer.finish().expect("an archive");
        // One byte is enough to know.
        let fault = refusal(&path, None, LIMIT);
        assert!(
            fault.contains("1 extra bytes") && fault.contains("and no more"),
            "{fault}"
        );
    }

    #[test]
    fn values_keep_the_magnitude_of_what_they_measure() {
        let folder = folder();
        let path = folder.path().join("a.npy");
        for (value, field, good) in [
            (1e12, "phase", true),
            (1e13, "phase", false),
            (-1e155, "amplitude", false),
            (1e15, "height_um", true),
            (1e308, "height_um", false),
        ] {
            write_npy(&path, &array![[0.0, value]]).expect("written");
            let read = Array::read(&path, None, field, LIMIT);
            assert_eq!(read.is_ok(), good, "{value:e} {field}");
        }
    }
}
