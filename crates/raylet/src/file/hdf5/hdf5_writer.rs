//! Arrays with units as an HDF5 file.

use std::io::{self, Write};

use hdf5_pure::{AttrValue, CompoundTypeBuilder, Error, FileBuilder, make_f64_type};
use num_complex::Complex64;

/// Arrays that become a file.
pub(crate) struct Hdf5File(FileBuilder);

impl Hdf5File {
    /// A file with a text that says what it holds.
    pub(crate) fn new(title: &str) -> Self {
        let mut file = FileBuilder::new();
        file.set_attr("title", AttrValue::VarLenString(title.to_owned()));
        Self(file)
    }

    /// Adds real numbers of one axis.
    pub(crate) fn axis(&mut self, name: &str, numbers: &[f64], unit: &str) {
        let array = self.0.create_dataset(name);
        array.with_f64_data(numbers);
        array.set_attr("units", AttrValue::VarLenString(unit.to_owned()));
    }

    /// Adds complex numbers, as pairs (r, i) that h5py reads as complex128. Their axes have these names.
    ///
    /// # Errors
    /// Pairs that cannot be described.
    pub(crate) fn complex<'a>(
        &mut self,
        name: &str,
        axes: &[(&str, usize)],
        numbers: impl Iterator<Item = &'a Complex64>,
    ) -> io::Result<()> {
        let pair = CompoundTypeBuilder::with_size(16)
            .field("r", 0, make_f64_type())
            .field("i", 8, make_f64_type())
            .build()
            .map_err(io::Error::other)?;
        let mut bytes = Vec::new();
        for number in numbers {
            bytes.extend(number.re.to_le_bytes());
            bytes.extend(number.im.to_le_bytes());
        }
        let count = bytes.len() as u64 / 16;
        let shape: Vec<u64> = axes.iter().map(|(_, length)| *length as u64).collect();
        let names: Vec<String> = axes.iter().map(|(name, _)| (*name).to_owned()).collect();
        let array = self.0.create_dataset(name);
        array.with_raw_data(pair, bytes, count);
        array.with_shape(&shape);
        array.set_attr("axes", AttrValue::VarLenStringArray(names));
        Ok(())
    }

    /// Writes the file.
    ///
    /// # Errors
    /// What cannot be written.
    pub(crate) fn write(self, out: &mut impl Write) -> io::Result<()> {
        self.0.finish_to(out).map_err(|error| match error {
            Error::Io(error) => error,
            error => io::Error::other(error),
        })
    }
}
