//! How far a run has come: a bar on a terminal, plain lines elsewhere. Both go to standard error.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use raylet::engine::simulate::Progress;

/// Steps of a bar without rays.
const STEPS: f64 = 1000.0;

/// Shows the progress of one run after another.
pub(crate) struct Meter {
    terminal: bool,
    now: Mutex<Option<Shown>>,
}

/// The hop that is being shown.
struct Shown {
    label: String,
    bar: Option<ProgressBar>,
    steps: f64,
    start: Instant,
    finished: bool,
}

impl Meter {
    pub(crate) fn new() -> Self {
        Self {
            terminal: std::io::stderr().is_terminal(),
            now: Mutex::new(None),
        }
    }

    /// Notes the progress of a run that is called `run` ("" where there is only one).
    pub(crate) fn note(&self, run: &str, progress: Progress) {
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        let Progress { hop, hops, to, .. } = progress;
        let label = format!("{run}hop {} of {hops} to '{to}'", hop + 1);
        if now.as_ref().is_none_or(|shown| shown.label != label) {
            *now = Some(self.begin(label, progress.rays));
        }
        let Some(shown) = now.as_mut().filter(|shown| !shown.finished) else {
            return;
        };
        if let Some(bar) = &shown.bar {
            bar.set_position((progress.done * shown.steps) as u64);
        }
        if progress.done >= 1.0 {
            match &shown.bar {
                Some(bar) => bar.finish_and_clear(),
                None => {
                    let seconds = shown.start.elapsed().as_secs_f64();
                    eprintln!("{}: {seconds:.2} s", shown.label);
                }
            }
            shown.finished = true;
        }
    }

    fn begin(&self, label: String, rays: f64) -> Shown {
        let steps = if rays >= 1.0 { rays } else { STEPS };
        let bar = self.terminal.then(|| {
            let rate = if rays >= 1.0 { "{per_sec} rays" } else { "" };
            let template =
                format!("{{prefix}} [{{bar:30}}] {{percent:>3}} %  {rate}  {{eta}} left");
            let bar = ProgressBar::new(steps as u64);
            if let Ok(style) = ProgressStyle::with_template(&template) {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_prefix(label.clone());
            bar
        });
        Shown {
            label,
            bar,
            steps,
            start: Instant::now(),
            finished: false,
        }
    }
}
