//! How the progress of a study is shown.

use raylet::engine::chain::outcome::Progress;

/// Shows the progress of runs, each by its name.
pub type RunDisplay<'a> = Box<dyn Fn(&str, Progress) + Sync + 'a>;

/// Shows the progress of a study.
pub trait ProgressDisplay {
    /// Begins to show runs of light.
    fn run(&self) -> RunDisplay<'_>;

    /// Begins to show a search of so many iterations in `total`, of which `before` are done.
    fn search(&self, name: &str, before: usize, total: usize) -> Box<dyn SearchDisplay + '_>;
}

/// Shows the iterations of one search.
pub trait SearchDisplay {
    /// Notes that so many iterations are done, and how the search stands.
    fn note(&mut self, done: usize, line: &str);

    /// The search has ended.
    fn end(&self);
}
