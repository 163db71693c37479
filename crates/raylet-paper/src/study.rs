//! What every study of the paper shares: how much of it is done, and what it found.

#![expect(
    clippy::indexing_slicing,
    reason = "a document of a study is a table, in which a key that is not there is made"
)]

use std::path::Path;

use raylet::file::storage::folder::OutputFolder;
use raylet::optics::system::System;

use crate::progress_display::ProgressDisplay;
use crate::scene_export::scene_files;
use crate::study_error::StudyError;

/// The file by which the folder of a study is known.
pub const STUDY_FILE: &str = "paper.json";

/// The size of a study, and the display of its progress.
#[derive(Clone, Copy)]
pub struct Effort<'a> {
    /// Whether the study runs at a small size.
    pub quick: bool,
    /// Folder in which the parts of long runs are kept.
    pub keep: Option<&'a Path>,
    /// Largest number of parts of a run.
    pub most: usize,
    /// Shows how far it is.
    pub display: &'a dyn ProgressDisplay,
}

/// The results of a study.
#[derive(Default)]
pub struct Study {
    /// Text for standard output.
    pub text: String,
    /// The results as a JSON document: a table.
    pub document: serde_json::Value,
    /// Names and contents of its pictures, and of the scenes of its systems.
    pub pictures: Vec<(String, Vec<u8>)>,
}

impl Study {
    /// Adds a system as a scene with its arrays, for `raylet simulate`.
    pub(crate) fn export_scene(
        &mut self,
        system: &System,
        stem: &str,
        title: &str,
    ) -> Result<(), StudyError> {
        let files = scene_files(system, stem, title)?;
        self.pictures.extend(files.into_iter().flatten());
        Ok(())
    }

    /// Writes the document, the pictures and the scenes as a folder.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn publish(&self, target: &OutputFolder) -> Result<(), StudyError> {
        let mut draft = target.draft()?;
        for (name, picture) in &self.pictures {
            draft.write(name, picture)?;
        }
        let names: Vec<&String> = self.pictures.iter().map(|(name, _)| name).collect();
        let mut document = self.document.clone();
        document["files"] = serde_json::json!(names);
        draft.publish(&serde_json::to_string_pretty(&document)?)?;
        Ok(())
    }
}
