//! A NumPy file (.npy) row by row: of an array of any size, one row is in memory.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::file::arrays::array::Array;
use crate::file::arrays::memory::MachineMemory;
use crate::file::arrays::npy_header::Header;
use crate::file::arrays::regular_file;
use crate::file::decode::fault::Fault;
use crate::file::fabrication::cell_rows::{BorrowedRows, CellRows, Part};

/// How the bytes of a number become the number.
#[derive(Clone, Copy)]
enum Number {
    /// One real number.
    Real(fn([u8; 8]) -> f64),
    /// Two, one after another.
    Complex(fn([u8; 8]) -> f64),
}

/// The rows of an array in a file.
pub(crate) struct NpyRows {
    path: PathBuf,
    file: BufReader<File>,
    size: [usize; 2],
    /// Where the first row begins, and the row that comes next.
    start: u64,
    next: usize,
    number: Number,
    /// Bytes of one real number, and whether the highest comes first.
    width: usize,
    big_endian: bool,
    /// The bytes of a row.
    bytes: Vec<u8>,
    /// What is taken of complex numbers, and a factor.
    part: Part,
    scale: f64,
}

/// An array that is read whole, because its columns lie in one piece.
struct WholeRows {
    array: Array,
    part: Part,
    scale: f64,
}

impl CellRows for WholeRows {
    fn size(&self) -> [usize; 2] {
        let [ny, nx] = self.array.borrowed().shape();
        [nx, ny]
    }

    fn row(&mut self, y: usize, values: &mut [f64]) -> Result<(), Fault> {
        let array = self.array.borrowed();
        let mut rows = BorrowedRows {
            array,
            part: self.part,
            scale: self.scale,
        };
        rows.row(y, values)
    }
}

/// What is in a file of an array.
pub(crate) struct NpyFile {
    /// Its rows.
    pub rows: Box<dyn CellRows>,
    /// Whether its numbers are complex.
    pub is_complex: bool,
}

/// The rows of an array file: of a .npy file one at a time, of a .npz file, or of an array in columns, from memory.
///
/// # Errors
/// A file that cannot be read, or that holds no 2-D array of numbers.
pub(crate) fn npy_rows(
    path: &Path,
    key: Option<(&str, Option<&str>)>,
    part: Part,
    scale: f64,
) -> Result<NpyFile, Fault> {
    let extension = path.extension().and_then(|end| end.to_str()).unwrap_or("");
    let (usual, key) = key.unwrap_or(("phase", None));
    if extension.eq_ignore_ascii_case("npy") && key.is_none() {
        let rows = NpyRows::open(path, part, scale)?;
        if let Some(rows) = rows {
            let is_complex = matches!(rows.number, Number::Complex(_));
            return Ok(NpyFile {
                rows: Box::new(rows),
                is_complex,
            });
        }
    }
    let array = Array::read(path, key, usual, MachineMemory::now().usual_limit())?;
    let is_complex = matches!(array, Array::Complex(_));
    let rows = Box::new(WholeRows { array, part, scale });
    Ok(NpyFile { rows, is_complex })
}

impl NpyRows {
    /// Opens a file; nothing where its columns lie in one piece.
    fn open(path: &Path, part: Part, scale: f64) -> Result<Option<Self>, Fault> {
        let refuse = |found: String, expected: &str| Fault::of_file(path, found, expected);
        let file = regular_file::open(path).map_err(|found| refuse(found, "a readable file"))?;
        let length = file.metadata().map_or(0, |known| known.len());
        let mut file = BufReader::with_capacity(1 << 18, file);
        let header = Header::read(&mut file)
            .map_err(|found| refuse(found, "a NumPy array as numpy.save writes it"))?;
        let [ny, nx] = match *header.shape.as_slice() {
            [ny, nx] if ny > 0 && nx > 0 => [ny, nx],
            _ => {
                let shape: Vec<usize> = header.shape.iter().copied().take(20).collect();
                let found = format!("an array of shape {shape:?}");
                return Err(refuse(found, "two axes, [y, x], none of them empty"));
            }
        };
        let Some((number, width)) = number(header.kind()) else {
            let kind: String = header.kind().chars().take(40).collect();
            let found = format!("elements of NumPy type `{kind}`");
            return Err(refuse(
                found,
                "float32, float64, complex64, complex128, integers or bool",
            ));
        };
        if header.columns_first {
            return Ok(None);
        }

        // What the header promises must be there, before memory is taken for a row.
        let start =
            (file.stream_position()).map_err(|error| refuse(error.to_string(), "a file"))?;
        let promised = start.saturating_add(header.data_bytes());
        if length != promised {
            let found = format!("a file of {length} bytes");
            let expected = format!("{promised} bytes, as its header says");
            return Err(refuse(found, &expected));
        }
        let each = match number {
            Number::Real(_) => width,
            Number::Complex(_) => 2 * width,
        };
        Ok(Some(Self {
            path: path.to_path_buf(),
            file,
            size: [nx, ny],
            start,
            next: 0,
            number,
            width,
            big_endian: header.is_big_endian(),
            bytes: vec![0; nx * each],
            part,
            scale,
        }))
    }

    /// Reads the bytes of a row.
    fn fetch(&mut self, y: usize) -> io::Result<()> {
        if y != self.next {
            let at = self.start + y as u64 * self.bytes.len() as u64;
            self.file.seek(SeekFrom::Start(at))?;
        }
        self.file.read_exact(&mut self.bytes)?;
        self.next = y + 1;
        Ok(())
    }
}

impl CellRows for NpyRows {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn row(&mut self, y: usize, values: &mut [f64]) -> Result<(), Fault> {
        self.fetch(y).map_err(|error| {
            Fault::of_file(&self.path, error.to_string(), "a file that can be read")
        })?;
        let (width, big_endian, scale) = (self.width, self.big_endian, self.scale);
        let eight = |bytes: &[u8]| {
            // The lowest byte comes first, zeros behind the highest.
            let mut all = [0; 8];
            match big_endian {
                true => (all.iter_mut().zip(bytes.iter().rev())).for_each(|(to, from)| *to = *from),
                false => (all.iter_mut().zip(bytes)).for_each(|(to, from)| *to = *from),
            }
            all
        };
        match self.number {
            Number::Real(read) => {
                let numbers = self.bytes.chunks_exact(width);
                for (value, bytes) in values.iter_mut().zip(numbers) {
                    *value = scale * read(eight(bytes));
                }
            }
            Number::Complex(read) => {
                let numbers = self.bytes.chunks_exact(2 * width);
                for (value, bytes) in values.iter_mut().zip(numbers) {
                    let (re, im) = bytes.split_at_checked(width).unwrap_or_default();
                    *value = scale * self.part.of(read(eight(re)), read(eight(im)));
                }
            }
        }
        Ok(())
    }
}

/// How a NumPy type is read, and the bytes of one of its real numbers.
fn number(kind: &str) -> Option<(Number, usize)> {
    fn low4(bytes: [u8; 8]) -> [u8; 4] {
        let [a, b, c, d, ..] = bytes;
        [a, b, c, d]
    }
    fn low2(bytes: [u8; 8]) -> [u8; 2] {
        let [a, b, ..] = bytes;
        [a, b]
    }
    let f8: fn([u8; 8]) -> f64 = f64::from_le_bytes;
    let f4: fn([u8; 8]) -> f64 = |bytes| f64::from(f32::from_le_bytes(low4(bytes)));
    let unsigned: fn([u8; 8]) -> f64 = |bytes| u64::from_le_bytes(bytes) as f64;
    Some(match kind {
        "f8" => (Number::Real(f8), 8),
        "f4" => (Number::Real(f4), 4),
        "c16" => (Number::Complex(f8), 8),
        "c8" => (Number::Complex(f4), 4),
        "u1" => (Number::Real(unsigned), 1),
        "u2" => (Number::Real(unsigned), 2),
        "u4" => (Number::Real(unsigned), 4),
        "u8" => (Number::Real(unsigned), 8),
        "b1" => (
            Number::Real(|bytes| f64::from(u8::from(bytes != [0; 8]))),
            1,
        ),
        "i1" => (
            Number::Real(|[low, ..]| f64::from(i8::from_le_bytes([low]))),
            1,
        ),
        "i2" => (
            Number::Real(|bytes| f64::from(i16::from_le_bytes(low2(bytes)))),
            2,
        ),
        "i4" => (
            Number::Real(|bytes| f64::from(i32::from_le_bytes(low4(bytes)))),
            4,
        ),
        "i8" => (Number::Real(|bytes| i64::from_le_bytes(bytes) as f64), 8),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, ShapeBuilder, array};
    use ndarray_npy::write_npy;
    use num_complex::{Complex32, Complex64};

    use crate::file::fabrication::cell_rows::{CellRows, Part};
    use crate::file::fabrication::npy_rows::npy_rows;

    fn all(rows: &mut dyn CellRows) -> Array2<f64> {
        let [nx, ny] = rows.size();
        let mut values = Array2::zeros((ny, nx));
        let mut row = vec![0.0; nx];
        // Rows are read from the last to the first, so that each is sought.
        for y in (0..ny).rev() {
            rows.row(y, &mut row).unwrap();
            values.row_mut(y).assign(&ndarray::ArrayView1::from(&row));
        }
        values
    }

    #[test]
    fn rows_are_those_of_the_array() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("a.npy");
        let expected = array![[1.0, -2.0, 3.0], [4.0, 5.0, -6.0]];
        let read = |scale| {
            let file = npy_rows(&path, None, Part::Amplitude, scale).unwrap();
            (file.is_complex, all(&mut *{ file.rows }))
        };
        macro_rules! check {
            ($convert:expr) => {
                write_npy(&path, &expected.mapv($convert)).unwrap();
                assert_eq!(read(2.0), (false, 2.0 * &expected));
            };
        }
        check!(|x| x);
        check!(|x| x as f32);
        check!(|x| x as i8);
        check!(|x| x as i16);
        check!(|x| x as i32);
        check!(|x| x as i64);
        write_npy(&path, &expected.mapv(|x: f64| x.abs() as u16)).unwrap();
        assert_eq!(read(1.0), (false, expected.mapv(f64::abs)));

        // Complex numbers, an array in columns, and one with the highest byte first.
        write_npy(&path, &expected.mapv(|x| Complex64::new(0.0, x))).unwrap();
        assert_eq!(read(1.0), (true, expected.mapv(f64::abs)));
        write_npy(&path, &expected.mapv(|x| Complex32::new(x as f32, 0.0))).unwrap();
        assert_eq!(read(1.0), (true, expected.mapv(f64::abs)));
        let columns = Array2::from_shape_fn((2, 3).f(), |at| expected[at]);
        write_npy(&path, &columns).unwrap();
        assert_eq!(read(1.0), (false, expected.clone()));
        write_npy(&path, &expected).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        let start = bytes.len() - 48;
        bytes[start..].chunks_exact_mut(8).for_each(<[u8]>::reverse);
        let sign = bytes.iter().position(|byte| *byte == b'<').unwrap();
        bytes[sign] = b'>';
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(read(1.0), (false, expected));
    }

    #[test]
    fn what_a_header_promises_must_be_there() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("a.npy");
        let refusal = || {
            let file = npy_rows(&path, None, Part::Phase, 1.0);
            file.err().expect("a fault").to_string()
        };
        write_npy(&path, &Array2::<f64>::zeros((4, 4))).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
        assert!(refusal().contains("as its header says"));
        let mut larger = bytes.clone();
        let at = bytes.windows(6).position(|six| six == b"(4, 4)").unwrap();
        larger[at..at + 20].copy_from_slice(b"(4, 4000000000000),}");
        std::fs::write(&path, larger).unwrap();
        assert!(refusal().contains("bytes, as its header says"));
        write_npy(&path, &ndarray::Array3::<f64>::zeros((1, 2, 3))).unwrap();
        assert!(refusal().contains("[1, 2, 3]"));
    }
}
