//! The field on the sensor as a .npz file, written and read.
//!
//! Arrays: `field` complex128 [channel, y, x], `x_mm`, `y_mm` (pixel centres) and `wavelength_um`, float64.

use std::fs::File;
use std::io::{BufReader, Cursor};
use std::path::Path;

use ndarray::{Array1, Array3, Ix1, Ix3};
use ndarray_npy::{NpzReader, NpzWriter, ReadNpzError};
use num_complex::Complex64;

use crate::file::fault::Fault;

/// Parts of amplitudes lie below it.
const LARGEST: f64 = 1e100;

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
    /// The bytes of a .npz file. Equal fields give equal bytes.
    ///
    /// # Errors
    /// What the packing said.
    pub fn to_npz(&self) -> Result<Vec<u8>, Fault> {
        let pack = || -> Result<Vec<u8>, ndarray_npy::WriteNpzError> {
            let mut writer = NpzWriter::new(Cursor::new(Vec::new()));
            writer.add_array("field", &self.field)?;
            writer.add_array("x_mm", &self.x_mm)?;
            writer.add_array("y_mm", &self.y_mm)?;
            writer.add_array("wavelength_um", &self.wavelength_um)?;
            Ok(writer.finish()?.into_inner())
        };
        pack().map_err(|error| {
            Fault::of_file(
                Path::new("field.npz"),
                error.to_string(),
                "arrays that can be packed",
            )
        })
    }

    /// Reads a file that [`Fields::to_npz`] or a program with the same arrays wrote.
    ///
    /// # Errors
    /// A file that cannot be read, a missing array, an array of another kind, axes that do not fit the
    /// field, or values that are not finite.
    pub fn read(path: &Path) -> Result<Self, Fault> {
        let file = File::open(path).map_err(|error| {
            Fault::of_file(path, error.to_string(), "a field.npz that can be read")
        })?;
        let mut archive = NpzReader::new(BufReader::new(file)).map_err(|error| {
            Fault::of_file(path, plain(&error), "an archive made by numpy.savez")
        })?;
        let refuse = |name: &str, error: ReadNpzError, expected: &str| {
            Fault::of_file(path, format!("array `{name}`: {}", plain(&error)), expected)
        };
        let field = archive
            .by_name::<ndarray::OwnedRepr<Complex64>, Ix3>("field")
            .map_err(|error| refuse("field", error, "complex128 of three axes [channel, y, x]"))?;
        let mut axis = |name: &str| {
            archive
                .by_name::<ndarray::OwnedRepr<f64>, Ix1>(name)
                .map_err(|error| refuse(name, error, "float64 of one axis"))
        };
        let fields = Self {
            x_mm: axis("x_mm")?,
            y_mm: axis("y_mm")?,
            wavelength_um: axis("wavelength_um")?,
            field,
        };
        fields
            .check()
            .map_err(|(found, expected)| Fault::of_file(path, found, expected))?;
        Ok(fields)
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
            let rising = axis.windows(2).into_iter().all(|pair| pair[0] < pair[1]);
            if !rising || axis.iter().any(|v| !v.is_finite()) {
                return Err((
                    format!("`{name}` that does not rise"),
                    String::from("finite ascending positions"),
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

        // Squares and their sums stay finite.
        let usable = |u: &Complex64| u.re.abs() < LARGEST && u.im.abs() < LARGEST;
        if let Some((at, value)) = self.field.indexed_iter().find(|(_, u)| !usable(u)) {
            return Err((
                format!("{value} at {at:?} of `field`"),
                format!("finite values below {LARGEST:e}"),
            ));
        }
        Ok(())
    }
}

/// What went wrong, without the names of the readers it went through.
fn plain(error: &ReadNpzError) -> String {
    match error {
        ReadNpzError::Zip(error) => error.to_string(),
        ReadNpzError::Npy(error) => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array1, Array3};
    use num_complex::Complex64;

    use crate::file::npz::Fields;

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

    #[test]
    fn written_fields_read_back_the_same() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("field.npz");
        std::fs::write(&path, fields().to_npz().unwrap()).unwrap();
        assert_eq!(Fields::read(&path).unwrap(), fields());
        assert_eq!(fields().to_npz().unwrap(), fields().to_npz().unwrap());
    }

    #[test]
    fn misfits_are_refused() {
        let room = tempfile::tempdir().unwrap();
        let path = room.path().join("field.npz");
        let told = |fields: &Fields| {
            std::fs::write(&path, fields.to_npz().unwrap()).unwrap();
            Fields::read(&path).unwrap_err().to_string()
        };
        let mut short = fields();
        short.x_mm = Array1::linspace(-1.0, 1.0, 3);
        assert!(told(&short).contains("[2, 3, 4]"), "{}", told(&short));
        let mut falling = fields();
        falling.y_mm = Array1::linspace(1.0, -1.0, 3);
        assert!(told(&falling).contains("y_mm"));
        let mut broken = fields();
        for value in [f64::NAN, f64::INFINITY, -1e200] {
            broken.field[[1, 2, 3]].im = value;
            assert!(told(&broken).contains("(1, 2, 3)"));
        }
        for value in [f64::NAN, 0.0, -0.5] {
            let mut colourless = fields();
            colourless.wavelength_um[1] = value;
            assert!(told(&colourless).contains("`wavelength_um`"));
        }

        // Not an archive, and none at all.
        std::fs::write(&path, "text").unwrap();
        assert!(Fields::read(&path).is_err());
        assert!(Fields::read(&room.path().join("none.npz")).is_err());
    }
}
