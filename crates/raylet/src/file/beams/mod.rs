//! Beam files: fields in the format of Zemax OpticStudio (.zbf).
//!
//! | file | what it holds |
//! | --- | --- |
//! | `zbf_header` | The header of a beam file: samples, unit, pilot beam, wavelength |
//! | `zbf_reader` | Beam files, read within a limit on memory |
//! | `zbf_fields` | A beam as raylet's field: axes, scale, phase |
//! | `zbf_writer` | A field as a beam file: zeros around it, the pilot beam, the report |
//! | `zbf_test` | Tests: beam files byte by byte, and fields that are written and read back |
//! | `zbf_mutations_test` | Tests: altered beam files give a field or an error |

pub mod zbf_fields;
pub(crate) mod zbf_header;
#[cfg(test)]
mod zbf_mutations_test;
pub(crate) mod zbf_reader;
#[cfg(test)]
mod zbf_test;
pub(crate) mod zbf_writer;
