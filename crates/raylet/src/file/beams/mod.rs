//! Fields in files: the format of Zemax OpticStudio (.zbf), FITS, HDF5.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `zbf_header` | The header of a beam file: samples, unit, pilot beam, wavelength |
//! | `zbf_reader` | Beam files, read within a limit on memory |
//! | `zbf_fields` | A beam as raylet's field: axes, scale, phase |
//! | `zbf_writer` | A field as a beam file: zeros around it, the pilot beam, the report |
//! | `field_file` | Fields in files that keep every digit: .npz, FITS, HDF5 |
//! | `fits_fields` | Fields as FITS files |
//! | `hdf5_fields` | Fields as HDF5 files |
//! | `fields_test` | Tests: fields that are written and read back, and altered files |
//! | `zbf_test` | Tests: beam files byte by byte, and fields that are written and read back |
//! | `zbf_mutations_test` | Tests: altered beam files give a field or an error |

pub(crate) mod field_file;
#[cfg(test)]
mod fields_test;
pub(crate) mod fits_fields;
pub(crate) mod hdf5_fields;
pub mod zbf_fields;
pub(crate) mod zbf_header;
#[cfg(test)]
mod zbf_mutations_test;
pub(crate) mod zbf_reader;
#[cfg(test)]
mod zbf_test;
pub(crate) mod zbf_writer;
