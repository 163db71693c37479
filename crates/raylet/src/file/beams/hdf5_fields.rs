//! Fields as HDF5 files: `field` of pairs (r, i) that h5py reads as complex128 [wavelength, y, x], and its axes `x_mm`,
//! `y_mm` and `wavelength_um`, each with its unit in the attribute `units`.

use std::io::{self, Write};
use std::path::Path;

use ndarray::{Array1, Array3};

use crate::file::arrays::memory::MemoryLimit;
use crate::file::arrays::npz::Fields;
use crate::file::decode::fault::Fault;
use crate::file::hdf5::hdf5_reader::{Hdf5, Numbers};
use crate::file::hdf5::hdf5_writer::Hdf5File;

/// Names of positions and wavelengths, with their units.
const AXES: [(&str, &str); 3] = [("x_mm", "mm"), ("y_mm", "mm"), ("wavelength_um", "um")];

/// Writes fields.
///
/// # Errors
/// An error of the file system.
pub(crate) fn write_hdf5(fields: &Fields, out: &mut impl Write) -> io::Result<()> {
    let (count, ny, nx) = fields.field.dim();
    let mut file = Hdf5File::new("complex amplitudes, exp(+ikz), [wavelength, y, x]");
    let axes = [("wavelength_um", count), ("y_mm", ny), ("x_mm", nx)];
    file.complex("field", &axes, fields.field.iter())?;
    let values = [&fields.x_mm, &fields.y_mm, &fields.wavelength_um];
    for ((name, unit), values) in AXES.into_iter().zip(values) {
        file.axis(name, &values.to_vec(), unit);
    }
    file.write(out)
}

/// Reads fields.
///
/// # Errors
/// A file that cannot be read, without one of the arrays, with values that no field has, or beyond the limit.
pub(crate) fn read_hdf5_fields(path: &Path, limit: MemoryLimit) -> Result<Fields, Fault> {
    let refuse = |found: String, expected: &str| Fault::of_file(path, found, expected);
    let file = Hdf5::open(path, limit)?;
    let stored = file.read("field")?;
    let size = match *stored.shape.as_slice() {
        [count, ny, nx] => (count, ny, nx),
        [ny, nx] => (1, ny, nx),
        _ => {
            let found = format!("`field` of shape {:?}", stored.shape);
            return Err(refuse(found, "[wavelength, y, x]"));
        }
    };
    let Numbers::Complex(numbers) = stored.numbers else {
        return Err(refuse(
            String::from("`field` of real numbers"),
            "complex numbers: pairs (r, i)",
        ));
    };
    let field = Array3::from_shape_vec(size, numbers)
        .map_err(|error| refuse(format!("`field`: {error}"), "[wavelength, y, x]"))?;
    let axis = |(name, unit): (&str, &str)| -> Result<Array1<f64>, Fault> {
        let stored = file.read(name)?;
        if let Some(other) = stored.unit.filter(|other| other != unit) {
            let found = format!("`{name}` in `{other}`");
            return Err(refuse(found, unit));
        }
        match stored.numbers {
            Numbers::Real(numbers) => Ok(numbers.into()),
            Numbers::Complex(_) => Err(refuse(format!("complex `{name}`"), "real numbers")),
        }
    };
    let [x, y, waves] = AXES;
    let fields = Fields {
        x_mm: axis(x)?,
        y_mm: axis(y)?,
        wavelength_um: axis(waves)?,
        field,
    };
    fields.check_for(path)?;
    Ok(fields)
}
