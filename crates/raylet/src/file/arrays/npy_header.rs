//! The header of a NumPy array, read before its data so that kind, shape and size can be refused in plain words
//! before any memory is taken.
//!
//! The reader of the data gets a new header, made from the checked values, and no more bytes than that header
//! states. So repeated keys of a header, or bytes behind the data, cannot take memory.

use std::io::{Chain, Cursor, Read, Take};

use ndarray_npy::ReadNpyError;

/// The longest header that is read, in bytes.
const LONGEST: usize = 65_536;

/// What the header of a NumPy array says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Header {
    /// NumPy's name of the element type with its byte order, such as "<f8"; "a structure" for what has no name.
    descriptor: String,
    /// Whether columns lie in one piece instead of rows.
    pub(crate) columns_first: bool,
    /// Lengths along the axes.
    pub(crate) shape: Vec<usize>,
}

/// The data of an array behind a header that says what was checked.
pub(crate) type Checked<R> = Chain<Cursor<Vec<u8>>, Take<R>>;

impl Header {
    /// Reads magic, version and header text.
    ///
    /// # Errors
    /// What was found instead, in words.
    pub(crate) fn read(stream: &mut impl Read) -> Result<Self, String> {
        let mut head = Vec::new();
        let mut take = |count: usize, head: &mut Vec<u8>| -> Result<(), String> {
            let got = stream.take(count as u64).read_to_end(head);
            match got {
                Ok(got) if got == count => Ok(()),
                Ok(_) => Err("a file that ends within its header".to_owned()),
                Err(error) => Err(error.to_string()),
            }
        };
        take(8, &mut head)?;
        if !head.starts_with(b"\x93NUMPY") {
            return Err("a file without NumPy's mark at its start".to_owned());
        }

        // The length of the header has 2 bytes in version 1 and 4 bytes later.
        let width = if head.get(6) == Some(&1) { 2 } else { 4 };
        let mut digits = Vec::new();
        take(width, &mut digits)?;
        let bytes = digits.iter().rev();
        let length = bytes.fold(0, |n, &byte| n * 256 + usize::from(byte));
        if length > LONGEST {
            return Err(format!("a header of {length} bytes"));
        }
        let mut text = Vec::new();
        take(length, &mut text)?;
        let text = String::from_utf8_lossy(&text);
        parse(&text).ok_or_else(|| {
            let shown: String = text.trim().chars().take(200).collect();
            format!("the header {shown}")
        })
    }

    /// NumPy's name of the element type, without byte order, such as "f8".
    pub(crate) fn kind(&self) -> &str {
        self.descriptor.trim_start_matches(['<', '>', '|', '='])
    }

    /// Whether the highest byte of a number comes first.
    pub(crate) fn is_big_endian(&self) -> bool {
        self.descriptor.starts_with('>')
    }

    /// Number of elements; the largest number where there are more.
    pub(crate) fn count(&self) -> u64 {
        let lengths = self.shape.iter().map(|length| *length as u64);
        lengths.fold(1, u64::saturating_mul)
    }

    /// Bytes of an element, as the name of its type says.
    fn element_bytes(&self) -> u64 {
        self.kind()
            .trim_start_matches(char::is_alphabetic)
            .parse()
            .unwrap_or(1)
    }

    /// Bytes of the data.
    pub(crate) fn data_bytes(&self) -> u64 {
        self.count().saturating_mul(self.element_bytes())
    }

    /// The data that follows, behind a header of what was checked. One byte more than it promises can be read, by
    /// which a reader sees that there are more.
    pub(crate) fn before<R: Read>(&self, data: R) -> Checked<R> {
        let lengths: String = self
            .shape
            .iter()
            .map(|length| format!("{length}, "))
            .collect();
        let order = if self.columns_first { "True" } else { "False" };
        let text = format!(
            "{{'descr': '{}', 'fortran_order': {order}, 'shape': ({lengths}), }}\n",
            self.descriptor
        );
        let mut head = b"\x93NUMPY\x02\x00".to_vec();
        head.extend((text.len() as u32).to_le_bytes());
        head.extend(text.bytes());
        Cursor::new(head).chain(data.take(self.data_bytes().saturating_add(1)))
    }
}

/// What went wrong with the data, without the names of the readers it went through.
pub(crate) fn plain(error: &ReadNpyError) -> String {
    match error {
        ReadNpyError::Io(error) => error.to_string(),
        other => other.to_string(),
    }
}

/// The parts of a header such as `{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }`.
fn parse(text: &str) -> Option<Header> {
    let after = |key: &str| text.split_once(key).map(|(_, rest)| rest.trim_start());
    let descriptor = after("'descr':")?;
    // A structured type is a list; the message has it as written.
    let descriptor = match descriptor.strip_prefix('\'') {
        Some(rest) => rest.split('\'').next()?,
        None => "a structure",
    };
    let inside = after("'shape':")?.strip_prefix('(')?.split(')').next()?;
    let lengths = inside.split(',').map(str::trim).filter(|s| !s.is_empty());
    let shape = lengths
        .map(|length| length.trim_end_matches('L').parse().ok())
        .collect::<Option<Vec<usize>>>()?;
    Some(Header {
        descriptor: descriptor.to_owned(),
        columns_first: after("'fortran_order':")?.starts_with("True"),
        shape,
    })
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use ndarray::array;
    use ndarray_npy::WriteNpyExt;

    use crate::file::arrays::npy_header::Header;

    #[test]
    fn a_header_is_written_anew_as_it_was_read() {
        let mut file = Vec::new();
        array![[1.0f32, 2.0, 3.0]].write_npy(&mut file).unwrap();
        let stream = &mut file.as_slice();
        let header = Header::read(stream).unwrap();
        assert_eq!(
            (header.kind(), header.shape.as_slice()),
            ("f4", &[1, 3][..])
        );
        assert_eq!((header.count(), header.data_bytes()), (3, 12));

        // What was read again is the same, and the data are cut where they should end.
        let endless = stream.chain(std::io::repeat(7));
        let mut again = Vec::new();
        header.before(endless).read_to_end(&mut again).unwrap();
        let rest = &mut again.as_slice();
        assert_eq!(Header::read(rest).unwrap(), header);
        assert_eq!(rest.len(), 13);
    }

    #[test]
    fn what_a_header_says_twice_counts_once() {
        let text =
            "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2), 'shape': (99, 99), }\n";
        let head = [
            b"\x93NUMPY\x01\x00",
            &[text.len() as u8, 0][..],
            text.as_bytes(),
        ]
        .concat();
        let header = Header::read(&mut head.as_slice()).unwrap();
        let mut again = Vec::new();
        header.before(&[0; 16][..]).read_to_end(&mut again).unwrap();
        let read = <ndarray::Array2<f64> as ndarray_npy::ReadNpyExt>::read_npy(again.as_slice());
        assert_eq!(read.unwrap(), array![[0.0, 0.0]]);
    }
}
