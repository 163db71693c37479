//! Mask files in the format OASIS (SEMI P39), which are written and not read.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `oasis_record` | Numbers and texts of an OASIS file |
//! | `oasis_writer` | Mask files in the format OASIS |
//! | `oasis_test` | Tests: the bytes of a file are decoded again |

pub(crate) mod oasis_record;
#[cfg(test)]
mod oasis_test;
pub(crate) mod oasis_writer;
