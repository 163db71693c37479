//! How far runs have come: a bar for each on a terminal, plain lines elsewhere. Both go to standard error.

use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, MultiProgress, ProgressBar, ProgressState, ProgressStyle};
use raylet::engine::chain::outcome::Progress;

use crate::say::complain;

/// Time between lines where there is no bar.
const PATIENCE: Duration = Duration::from_secs(60);

/// Steps of a bar without rays.
const STEPS: f64 = 1000.0;

/// Shows the progress of runs, some of which are under way side by side.
pub(crate) struct Meter {
    /// The bars, on a terminal.
    bars: Option<MultiProgress>,
    now: Mutex<Now>,
}

/// What is being shown.
struct Now {
    /// The hop of each run; nothing before its first.
    runs: Vec<Option<Shown>>,
    /// The bar below them, of several runs together.
    total: Option<ProgressBar>,
}

/// The hop of a run that is being shown.
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
    /// The largest share of the whole run that was done.
    of_run: f64,
}

impl Meter {
    /// The progress of so many runs.
    pub(crate) fn new(runs: usize) -> Self {
        let bars = std::io::stderr().is_terminal().then(MultiProgress::new);
        let together = bars.as_ref().filter(|_| runs > 1);
        let total = together.map(|bars| {
            let bar = bars.add(ProgressBar::new((runs as f64 * STEPS) as u64));
            dress(&bar, "{prefix} [{bar:30}] {percent:>3} %  {left}");
            bar.set_prefix(format!("{runs} runs"));
            bar
        });
        let runs = (0..runs).map(|_| None).collect();
        let now = Mutex::new(Now { runs, total });
        Self { bars, now }
    }

    /// Notes the progress of a run, given with its number, that is called `name` ("" where there is only one).
    pub(crate) fn note(&self, run: usize, name: &str, progress: Progress) {
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        let Progress { hop, hops, to, .. } = progress;
        let attempt = progress.attempt_note();
        let label = format!("{name}hop {} of {hops} to '{to}'{attempt}", hop + 1);
        let Some(place) = now.runs.get_mut(run) else {
            return;
        };
        let of_run = place.as_ref().map_or(0.0, |shown| shown.of_run);
        let shown = match place {
            Some(shown) if shown.label == label => shown,
            _ => place.insert(self.begin(label, progress)),
        };
        shown.of_run = of_run.max((hop as f64 + progress.done) / hops.max(1) as f64);
        shown.note(progress);
        now.show_total();
    }

    fn begin(&self, label: String, Progress { done, rays, .. }: Progress) -> Shown {
        let steps = if rays >= 1.0 { rays } else { STEPS };
        let bar = self.bars.as_ref().map(|bars| {
            let rate = if rays >= 1.0 { "{rays}" } else { "" };
            let bar = bars.insert(0, ProgressBar::new(steps as u64));
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
            of_run: 0.0,
        }
    }
}

impl Now {
    /// Moves the bar of all runs.
    fn show_total(&self) {
        if let Some(total) = &self.total {
            let done: f64 = self.runs.iter().flatten().map(|shown| shown.of_run).sum();
            total.set_position((done * STEPS) as u64);
        }
    }
}

impl Drop for Meter {
    /// Nothing stays on the terminal.
    fn drop(&mut self) {
        let now = self.now.get_mut().unwrap_or_else(PoisonError::into_inner);
        if let Some(total) = &now.total {
            total.finish_and_clear();
        }
    }
}

impl Shown {
    /// Shows how far the hop has come.
    fn note(&mut self, progress: Progress) {
        if self.finished {
            return;
        }
        if let Some(bar) = &self.bar {
            bar.set_position((progress.done * self.steps) as u64);
        }
        if self.bar.is_none() && self.last_line.elapsed() > PATIENCE {
            self.last_line = Instant::now();
            complain(&self.line(progress));
        }
        if progress.done >= 1.0 {
            match &self.bar {
                Some(bar) => bar.finish_and_clear(),
                None => {
                    let seconds = self.start.elapsed().as_secs_f64();
                    complain(&format!("{}: {seconds:.2} s", self.label));
                }
            }
            self.finished = true;
        }
    }

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
