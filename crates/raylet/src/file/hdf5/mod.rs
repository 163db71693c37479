//! HDF5 files: arrays of numbers with their units, read and written.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `hdf5_reader` | The arrays of an HDF5 file, read within a limit on memory |
//! | `hdf5_writer` | Arrays with units as an HDF5 file |

pub(crate) mod hdf5_reader;
pub(crate) mod hdf5_writer;
