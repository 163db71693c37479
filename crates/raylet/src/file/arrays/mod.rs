//! Arrays and pictures of users: NumPy files and PNG.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `array` | One 2-D array of a NumPy file (.npy, .npz) |
//! | `npy_header` | The header of a NumPy array, read before its data |
//! | `npz` | The field on the sensor as a .npz file, written and read |
//! | `zip_archive` | Reading archives (.npz) whose list of members is short |
//! | `image` | Plain pictures: reading and writing PNG, and changing their number of pixels |
//! | `phase_file` | The .npy files that a scene names for the results of a search: phases, amplitudes, heights |
//! | `memory` | The limit on memory, checked before any memory is taken |
//! | `regular_file` | Files opened to read: regular ones only |

pub mod array;
pub mod image;
pub mod memory;
pub(crate) mod npy_header;
pub mod npz;
pub mod phase_file;
pub(crate) mod regular_file;
pub(crate) mod zip_archive;
