//! What every study of the paper shares: how much of it is done, and what it found.

use std::path::Path;

use raylet::optics::system::System;
use raylet_paper::posed::posed;

use crate::failure::Failure;

/// How much of a study is done.
#[derive(Clone, Copy)]
pub(crate) struct Effort<'a> {
    /// Everything small.
    pub(crate) quick: bool,
    /// Where the parts of long runs are kept.
    pub(crate) keep: Option<&'a Path>,
    /// Most parts of a run.
    pub(crate) most: usize,
}

/// What a study found.
#[derive(Default)]
pub(crate) struct Study {
    /// For standard output.
    pub(crate) text: String,
    /// The same as a document: a table.
    pub(crate) document: serde_json::Value,
    /// Names and contents of its pictures, and of the scenes that pose its systems.
    pub(crate) pictures: Vec<(String, Vec<u8>)>,
}

impl Study {
    /// Adds a system as a scene with its arrays, for `raylet simulate`.
    pub(crate) fn pose(&mut self, system: &System, stem: &str, title: &str) -> Result<(), Failure> {
        let files = posed(system, stem, title)?;
        self.pictures.extend(files.into_iter().flatten());
        Ok(())
    }
}
