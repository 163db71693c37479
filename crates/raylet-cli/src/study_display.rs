//! How far a study of the paper has come, shown as the other verbs show it.

use raylet_paper::progress_display::{ProgressDisplay, RunDisplay, SearchDisplay};

use crate::progress::Meter;
use crate::steps::Steps;

/// Shows runs and searches on standard error.
pub(crate) struct StudyDisplay;

impl ProgressDisplay for StudyDisplay {
    fn run(&self) -> RunDisplay<'_> {
        // One run follows another.
        let meter = Meter::new(1);
        Box::new(move |run, progress| meter.note(0, run, progress))
    }

    fn search(&self, name: &str, before: usize, total: usize) -> Box<dyn SearchDisplay + '_> {
        Box::new(Steps::new(name, before, total))
    }
}
