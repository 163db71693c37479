//! From TOML text to Rust values, and where a fault is.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `from_toml` | From TOML text to Rust values, through serde, without losing the address of anything |
//! | `decode_error` | What goes wrong while a TOML value is turned into a Rust one |
//! | `origin` | The text that something was read from, so that later findings can still point into it |
//! | `fault` | A fault in something the user gave: where it is, what was found there, what was expected |
//! | `place` | A part of a scene file under inspection |
//! | `number` | Numbers of a scene file with the ranges they must keep, checked while they are read |
//! | `quantity` | What a value of a scene measures, by the end of its key, and the magnitude or length it keeps |
//! | `shared_keys` | Keys that several tables of a scene file share, written once |

pub(crate) mod decode_error;
pub mod fault;
pub(crate) mod from_toml;
pub(crate) mod number;
pub mod origin;
pub(crate) mod place;
pub(crate) mod quantity;
pub(crate) mod shared_keys;
