//! `raylet schema`: the JSON Schema of scene files.

use clap::Args;
use raylet::file::scene::scene_file::schema;

use crate::failure::Failure;
use crate::say::say;

/// Prints the JSON Schema of scene files, with which editors complete and check them.
#[derive(Args)]
pub(crate) struct Schema {}

impl Schema {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        say(&format!("{:#}\n", schema()))
    }
}
