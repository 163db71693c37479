//! What the user allows for the files that a scene names.

use std::path::Path;

use clap::Args;
use raylet::file::arrays::phase_file::Allowed;
use raylet::file::storage::own_file::Replace;

/// Where arrays may go, and what they may replace.
#[derive(Args)]
pub(crate) struct Outputs {
    /// Replaces files that raylet did not write, or that were changed since.
    #[arg(long)]
    overwrite: bool,
    /// Lets arrays that the scene names be written outside of its folder.
    #[arg(long)]
    allow_outside: bool,
}

impl Outputs {
    /// Which files may be replaced.
    pub(crate) fn replace(&self) -> Replace {
        Replace::any_if(self.overwrite)
    }

    /// The same for files that a scene names, which may be in this folder too.
    pub(crate) fn allowed<'a>(&self, out: Option<&'a Path>) -> Allowed<'a> {
        Allowed {
            replace: self.replace(),
            outside: self.allow_outside,
            out,
        }
    }
}
