//! How far a run has come: a bar on a terminal, plain lines elsewhere. Both go to standard error.

use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use raylet::engine::chain::outcome::Progress;

use crate::say::complain;

/// Time between lines where there is no bar.
const PATIENCE: Duration = Duration::from_secs(60);

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
    /// How far it was then.
    before: f64,
    /// When the last line was written.
    last_line: Instant,
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
        let attempt = progress.attempt_note();
        let label = format!("{run}hop {} of {hops} to '{to}'{attempt}", hop + 1);
        if now.as_ref().is_none_or(|shown| shown.label != label) {
            *now = Some(self.begin(label, progress));
        }
        let Some(shown) = now.as_mut().filter(|shown| !shown.finished) else {
            return;
        };
        if let Some(bar) = &shown.bar {
            bar.set_position((progress.done * shown.steps) as u64);
        }
        if shown.bar.is_none() && shown.last_line.elapsed() > PATIENCE {
            shown.last_line = Instant::now();
            complain(&shown.line(progress));
        }
        if progress.done >= 1.0 {
            match &shown.bar {
                Some(bar) => bar.finish_and_clear(),
                None => {
                    let seconds = shown.start.elapsed().as_secs_f64();
                    complain(&format!("{}: {seconds:.2} s", shown.label));
                }
            }
            shown.finished = true;
        }
    }

    fn begin(&self, label: String, Progress { done, rays, .. }: Progress) -> Shown {
        let steps = if rays >= 1.0 { rays } else { STEPS };
        let bar = self.terminal.then(|| {
            let rate = if rays >= 1.0 { "{rays}" } else { "" };
            let bar = ProgressBar::new(steps as u64);
            dress(
                &bar,
                &format!("{{prefix}} [{{bar:30}}] {{percent:>3}} %  {rate}{{left}}"),
            );
            bar.set_prefix(label.clone());
            bar
        });
        Shown {
            label,
            bar,
            steps,
            start: Instant::now(),
            before: done,
            last_line: Instant::now(),
            finished: false,
        }
    }
}

impl Shown {
    /// How far it is, as a line.
    fn line(&self, Progress { done, rays, .. }: Progress) -> String {
        let seconds = self.start.elapsed().as_secs_f64();
        let since = (done - self.before).max(1e-6);
        let left = Duration::from_secs_f64((seconds * (1.0 - done) / since).max(0.0));
        let rate = match rays >= 1.0 {
            true => format!(", {:.2e} rays/s", rays * since / seconds),
            false => String::new(),
        };
        format!(
            "{}: {:.0} %{rate}, {:#} left",
            self.label,
            100.0 * done,
            HumanDuration(left)
        )
    }
}

/// Gives a bar its looks. `{rays}` and `{left}` stay empty until a rate is known.
pub(crate) fn dress(bar: &ProgressBar, template: &str) {
    let known = |state: &ProgressState| state.pos() > 0 && state.per_sec() > 0.0;
    let rays = move |state: &ProgressState, line: &mut dyn Write| {
        if known(state) {
            let _ = write!(line, "{:.0} rays/s  ", state.per_sec());
        }
    };
    let left = move |state: &ProgressState, line: &mut dyn Write| {
        if known(state) {
            let _ = write!(line, "{:#} left", HumanDuration(state.eta()));
        }
    };
    if let Ok(style) = ProgressStyle::with_template(template) {
        let style = style.with_key("rays", rays).with_key("left", left);
        bar.set_style(style.progress_chars("=> "));
    }
}
