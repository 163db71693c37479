//! How far a search has come, iteration by iteration: a bar on a terminal, a line now and then elsewhere.

use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget};
use raylet_paper::progress_display::SearchDisplay;

use crate::progress::dress;
use crate::say::complain;

/// Time between lines where there is no bar.
const PATIENCE: Duration = Duration::from_secs(20);

/// The iterations of one search.
pub(crate) struct Steps {
    name: String,
    total: usize,
    /// Iterations that were done before.
    before: usize,
    bar: ProgressBar,
    start: Instant,
    last_line: Instant,
}

impl Steps {
    pub(crate) fn new(name: &str, before: usize, total: usize) -> Self {
        let bar = ProgressBar::new(total as u64);
        if !std::io::IsTerminal::is_terminal(&std::io::stderr()) {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        dress(&bar, "{prefix} [{bar:30}] {pos}/{len}  {msg}  {left}");
        bar.set_prefix(name.to_owned());
        Self {
            name: name.to_owned(),
            total,
            before,
            bar,
            start: Instant::now(),
            last_line: Instant::now(),
        }
    }
}

impl SearchDisplay for Steps {
    fn note(&mut self, done: usize, line: &str) {
        self.bar.set_position(done as u64);
        self.bar.set_message(line.to_owned());
        if self.bar.is_hidden() && self.last_line.elapsed() > PATIENCE {
            self.last_line = Instant::now();
            let here = done.saturating_sub(self.before).max(1) as f64;
            let share = self.total.saturating_sub(done) as f64 / here;
            let left = HumanDuration(self.start.elapsed().mul_f64(share));
            complain(&format!(
                "{}, iteration {done}: {line}, {left:#} left",
                self.name
            ));
        }
    }

    fn end(&self) {
        self.bar.finish_and_clear();
    }
}
