//! The field on the sensor as a .npz file, written and read.
//!
//! Arrays: `field` complex128 [channel, y, x], `x_mm`, `y_mm` (pixel centres) and `wavelength_um`, float64.

use std::io::{self, Seek, Write};
use std::path::Path;

use ndarray::{Array, Array1, Array2, Array3, Dimension, Ix1, Ix3};
use ndarray_npy::{NpzWriter, ReadNpyExt, ReadableElement};
use num_complex::Complex64;

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npy_header::{Header, plain};
use crate::file::arrays::regular_file;
use crate::file::arrays::zip_archive::Archive;
use crate::file::decode::fault::Fault;
use crate::file::decode::quantity::LENGTH;
use crate::wave::grid::field::{LARGEST_AMPLITUDE, is_amplitude};

/// The fields of all channels on one grid of sample points.
#[derive(Clone, Debug, PartialEq)]
pub struct Fields {
    /// Complex amplitude, indexed [channel, y, x].
    pub field: Array3<Complex64>,
    /// Positions of the columns in mm, ascending.
    pub x_mm: Array1<f64>,
    /// Positions of the rows in mm, ascending.
    pub y_mm: Array1<f64>,
    /// Vacuum wavelength of each channel in micrometres.
    pub wavelength_um: Array1<f64>,
}

impl Fields {
    /// The sum of the intensities of all channels, [y, x].
    pub fn total_intensity(&self) -> Array2<f64> {
        let (_, ny, nx) = self.field.dim();
        let mut sum = Array2::zeros((ny, nx));
        for field in self.field.outer_iter() {
            sum.zip_mut_with(&field, |sum, u| *sum += u.norm_sqr());
        }
        sum
    }

    /// Writes a .npz file without a copy of the arrays. Equal fields give equal bytes.
    ///
    /// # Errors
    /// An error of the file system, or an array that cannot be encoded.
    pub fn write_npz(&self, file: impl Write + Seek) -> io::Result<()> {
        let pack = || -> Result<(), ndarray_npy::WriteNpzError> {
            let mut writer = NpzWriter::new(file);
            writer.add_array("field", &self.field)?;
            writer.add_array("x_mm", &self.x_mm)?;
            writer.add_array("y_mm", &self.y_mm)?;
            writer.add_array("wavelength_um", &self.wavelength_um)?;
            writer.finish()?;
            Ok(())
        };
        pack().map_err(io::Error::other)
    }

    /// Reads a file that [`Fields::write_npz`] or a program with the same arrays wrote.
    ///
    /// # Errors
    /// A file that cannot be read, a missing array, an array of another kind, arrays beyond the limit, axes that do
    /// not fit the field, or values that are not finite.
    pub(crate) fn read(path: &Path, limit: MemoryLimit) -> Result<Self, Fault> {
        let file = regular_file::open(path)
            .map_err(|found| Fault::of_file(path, found, "a field.npz that can be read"))?;
        let mut members = Members {
            archive: Archive::open(file)
                .map_err(|found| Fault::of_file(path, found, "an archive made by numpy.savez"))?,
            path,
            left: limit,
        };
        let field = members.array::<Complex64, Ix3>(
            "field",
            "c16",
            "complex128 of three axes [channel, y, x]",
        )?;
        let mut axis = |name: &str| members.array::<f64, Ix1>(name, "f8", "float64 of one axis");
        let fields = Self {
            x_mm: axis("x_mm")?,
            y_mm: axis("y_mm")?,
            wavelength_um: axis("wavelength_um")?,
            field,
        };
        fields.check_for(path)?;
        Ok(fields)
    }

    /// Refuses fields that a file of this name could not hold and give back: axes that do not fit, values that are
    /// not finite or larger than any light.
    ///
    /// # Errors
    /// The first of these.
    pub fn check_for(&self, path: &Path) -> Result<(), Fault> {
        self.check()
            .map_err(|(found, expected)| Fault::of_file(path, found, expected))
    }

    /// The memory that the arrays take, in bytes.
    pub fn bytes(&self) -> u64 {
        let axes = self.x_mm.len() + self.y_mm.len() + self.wavelength_um.len();
        16 * self.field.len() as u64 + 8 * axes as u64
    }

    /// Refuses axes that do not fit and values that are not finite, as (found, expected).
    fn check(&self) -> Result<(), (String, String)> {
        let (channels, ny, nx) = self.field.dim();
        let lengths = [self.wavelength_um.len(), self.y_mm.len(), self.x_mm.len()];
        if lengths != [channels, ny, nx] || self.field.is_empty() {
            return Err((
                format!("`field` of shape {:?}", self.field.shape()),
                format!("{lengths:?}, as wavelength_um, y_mm and x_mm say, and not empty"),
            ));
        }
        for (name, axis) in [("x_mm", &self.x_mm), ("y_mm", &self.y_mm)] {
            let rising = axis.iter().zip(axis.iter().skip(1)).all(|(a, b)| a < b);
            if !rising || axis.iter().any(|v| v.is_nan() || v.abs() > LENGTH) {
                return Err((
                    format!("`{name}` that does not rise, or has no finite values"),
                    format!("finite ascending positions of magnitude up to {LENGTH:e} mm"),
                ));
            }
        }
        for wavelength in &self.wavelength_um {
            if !(wavelength.is_finite() && *wavelength > 0.0) {
                return Err((
                    format!("{wavelength} in `wavelength_um`"),
                    String::from("finite wavelengths above zero"),
                ));
            }
        }

        // Squares of intensities and their sums stay finite.
        if let Some((at, value)) = self.field.indexed_iter().find(|(_, u)| !is_amplitude(**u)) {
            return Err((
                format!("{value} at {at:?} of `field`"),
                format!("finite values below {LARGEST_AMPLITUDE:e}"),
            ));
        }
        Ok(())
    }
}

/// The arrays of an archive while they are read.
struct Members<'a> {
    archive: Archive,
    path: &'a Path,
    /// What is left of the memory.
    left: MemoryLimit,
}

impl Members<'_> {
    /// The array of this name, of the element type that NumPy calls `kind`.
    fn array<T: ReadableElement + Clone, D: Dimension>(
        &mut self,
        name: &str,
        kind: &str,
        expected: &str,
    ) -> Result<Array<T, D>, Fault> {
        let path = self.path;
        let refuse = |found: String, expected: &str| {
            Fault::of_file(path, format!("array `{name}`: {found}"), expected)
        };
        let mut member = self
            .archive
            .member(&format!("{name}.npy"))
            .map_err(|found| refuse(found, expected))?;

        // The size is known before memory is taken; columns in one piece are turned into rows.
        let header = Header::read(&mut member).map_err(|found| refuse(found, expected))?;
        if header.kind() != kind || Some(header.shape.len()) != D::NDIM {
            let (found, axes) = (header.kind(), header.shape.len());
            let found = format!("elements of NumPy type `{found}` on {axes} axes");
            return Err(refuse(found, expected));
        }
        let bytes = header.data_bytes();
        let turned = if header.columns_first { bytes } else { 0 };
        self.left
            .check("values", bytes.saturating_add(turned))
            .map_err(|(found, expected)| refuse(found, &expected))?;
        self.left = self.left.without(bytes);
        let array = Array::<T, D>::read_npy(header.before(member))
            .map_err(|error| refuse(plain(&error), expected))?;
        Ok(match array.is_standard_layout() {
            true => array,
            false => array.as_standard_layout().into_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::path::Path;

    use ndarray::{Array1, Array3};
    use num_complex::Complex64;

    use crate::file::arrays::memory::MemoryLimit;
    use crate::file::arrays::npz::Fields;

    const LIMIT: MemoryLimit = MemoryLimit {
        bytes: 10_000,
        set_by: "--limit",
    };

    fn fields() -> Fields {
        Fields {
            field: Array3::from_shape_fn((2, 3, 4), |(c, y, x)| {
                Complex64::new(c as f64 + 0.1 * y as f64, x as f64)
            }),
            x_mm: Array1::linspace(-1.5, 1.5, 4),
            y_mm: Array1::linspace(-1.0, 1.0, 3),
            wavelength_um: Array1::from(vec![0.5, 0.6]),
        }
    }

    fn write(path: &Path, fields: &Fields) {
        fields.write_npz(File::create(path).unwrap()).unwrap();
    }

    #[test]
    fn written_fields_read_back_the_same() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("field.npz");
        write(&path, &fields());
        assert_eq!(Fields::read(&path, LIMIT).unwrap(), fields());
        let again = room.path().join("again.npz");
        write(&again, &fields());
        assert_eq!(
            std::fs::read(&path).unwrap(),
            std::fs::read(&again).unwrap()
        );
    }

    #[test]
    fn wrong_files_are_refused() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("field.npz");
        let refusal = |fields: &Fields| {
            write(&path, fields);
            Fields::read(&path, LIMIT).unwrap_err().to_string()
        };
        let mut short = fields();
        short.x_mm = Array1::linspace(-1.0, 1.0, 3);
        assert!(refusal(&short).contains("[2, 3, 4]"), "{}", refusal(&short));
        let mut falling = fields();
        falling.y_mm = Array1::linspace(1.0, -1.0, 3);
        assert!(refusal(&falling).contains("y_mm"));
        let mut broken = fields();
        for value in [f64::NAN, f64::INFINITY, -1e200] {
            broken.field[[1, 2, 3]].im = value;
            assert!(refusal(&broken).contains("(1, 2, 3)"));
        }
        for value in [f64::NAN, 0.0, -0.5] {
            let mut colourless = fields();
            colourless.wavelength_um[1] = value;
            assert!(refusal(&colourless).contains("`wavelength_um`"));
        }

        // Not an archive, and none at all.
        std::fs::write(&path, "text").unwrap();
        assert!(Fields::read(&path, LIMIT).is_err());
        assert!(Fields::read(&room.path().join("none.npz"), LIMIT).is_err());
    }

    #[test]
    fn sizes_are_held_to_the_limit() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("field.npz");
        write(&path, &fields());
        assert_eq!(fields().bytes(), 16 * 24 + 8 * 9);
        let within = |bytes| Fields::read(&path, MemoryLimit { bytes, ..LIMIT });
        assert!(within(fields().bytes()).is_ok());
        let message = within(fields().bytes() - 1).unwrap_err().to_string();
        assert!(
            message.contains("--limit") && message.contains("MB"),
            "{message}"
        );
    }
}
