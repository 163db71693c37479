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
//! | [`beams`] | Beam files: fields in the format of Zemax OpticStudio |
//! | [`result`] | What a run leaves behind: its document, its fields, and how alike two of them are |

pub mod arrays;
pub mod beams;
pub mod decode;
pub mod fabrication;
pub mod model;
pub mod prescription;
pub mod result;
pub mod scene;
pub mod storage;
