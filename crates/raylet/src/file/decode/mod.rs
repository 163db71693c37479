//! From TOML text, or values in memory, to Rust values, and where a fault is.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `tree` | A document as a tree of values: from TOML text, from Python or from a scene whose numbers change |
//! | `from_tree` | Reads each key of a TOML table into a field of a Rust value, through serde, without losing its address |
//! | `tagged` | Enums whose variant is chosen by the `kind` key of their table |
//! | `decode_error` | What goes wrong while a value of a tree is turned into a Rust one |
//! | `origin` | The text that something was read from, so that later findings can still point into it |
//! | `path_step` | The steps of an address in a document |
//! | `fault` | A fault in something the user gave: where it is, what was found there, what was expected |
//! | `place` | A part of a scene file that is being checked |
//! | `complex_number` | A complex number: a number where it is real, else `[re, im]` |
//! | `number` | Numbers of a scene file with the ranges they must keep, checked while they are read |
//! | `quantity` | What a value of a scene measures, by the end of its key, and the magnitude or length it keeps |
//! | `shared_keys` | Keys that several tables of a scene file share, written once |

pub mod complex_number;
pub(crate) mod decode_error;
pub mod fault;
pub(crate) mod from_tree;
pub(crate) mod number;
pub mod origin;
pub(crate) mod path_step;
pub(crate) mod place;
pub(crate) mod quantity;
pub(crate) mod shared_keys;
pub(crate) mod tagged;
pub mod tree;
