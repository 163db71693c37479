//! Files: scenes, arrays and results, read and written.
//!
//! | folder | what it holds |
//! | --- | --- |
//! | [`decode`] | From TOML text to Rust values, and where a fault is |
//! | [`arrays`] | Arrays and pictures of users: NumPy files and PNG |
//! | [`storage`] | How results reach the disk: whole, under locks, and only over what raylet wrote |
//! | [`scene`] | The content of a scene file |
//! | [`model`] | From a scene to the system, hologram or design that it describes |
//! | [`prescription`] | Prescriptions of other programs for lens design, read into scenes |
//! | [`fabrication`] | Files that foundries and other programs take of an element |
//! | [`maps`] | Measured maps: heights, phases and fields in the formats of instruments and other programs |
//! | `fits` | FITS files: headers of cards and arrays of big-endian numbers |
//! | `hdf5` | HDF5 files: arrays of numbers with their units |
//! | [`beams`] | Fields in files: the format of Zemax OpticStudio, FITS, HDF5 |
//! | [`result`] | What a run leaves behind: its document, its fields, and how alike two of them are |

pub mod arrays;
pub mod beams;
pub mod decode;
pub mod fabrication;
pub(crate) mod fits;
pub(crate) mod hdf5;
pub mod maps;
pub mod model;
pub mod prescription;
pub mod result;
pub mod scene;
pub mod storage;
