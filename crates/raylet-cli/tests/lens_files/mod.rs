//! Lens files that are written, and lists of lenses.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `export_lens` | `raylet export` of lens files |
//! | `lens_lists` | `raylet lenses` |

mod export_lens;
mod lens_lists;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs raylet in a folder.
pub(crate) fn run(room: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_raylet"))
        .current_dir(room)
        .args(arguments)
        .output()
        .unwrap()
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// The folder of scenes.
pub(crate) fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}
